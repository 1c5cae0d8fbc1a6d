"""Speed, as ratios of what is timed in turn in one process; see `mpma bench`."""
