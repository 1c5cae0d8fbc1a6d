"""Figures, videos and windows of runs and motions."""
