"""Small helpers without knowledge of motions, arms or agents."""
