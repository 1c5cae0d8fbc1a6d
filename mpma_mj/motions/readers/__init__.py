"""Readers of recordings, one a file format; formats are recognised by content, not by name."""
