"""Trained agents in other conditions than the one in which they learned."""
