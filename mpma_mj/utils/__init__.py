"""General helpers, independent of motions, arms and agents."""
