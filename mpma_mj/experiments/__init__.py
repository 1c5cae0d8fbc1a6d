"""Studies over many runs: each declares its jobs, its table and its figure."""
