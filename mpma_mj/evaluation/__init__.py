"""Evaluation of trained agents under given conditions, and statistics over runs."""
