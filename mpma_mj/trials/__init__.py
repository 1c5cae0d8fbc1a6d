"""Trained agents in other worlds than the one in which they learned."""
