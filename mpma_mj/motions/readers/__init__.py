"""One reader a file format; what a file is, is told by its content, not by its name."""

from mpma_mj.motions.readers.recognise import open_recording

__all__ = ["open_recording"]
