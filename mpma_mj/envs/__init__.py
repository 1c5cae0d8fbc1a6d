"""Environments: two arms that imitate, simulated or kinematic, behind one interface."""
