"""Reader for videos of one person, by a detector of poses (experimental)."""
