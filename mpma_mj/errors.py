"""Everything that can go wrong and that a user can mend.

Each message is one line: where (file, row, joint, option), what was expected, and what to
do about it. `exit_code` is what the command line returns: 2 for input that has to be mended,
1 for a run that failed.
"""

from __future__ import annotations

__all__ = [
    "BadOptionError",
    "CheckpointError",
    "DivergedError",
    "MotionFileError",
    "MotionReachError",
    "MpmaError",
    "RecordingWarning",
    "RenderingError",
    "RobotLogError",
    "RunFolderError",
    "UnknownMotionError",
    "VideoError",
    "WorkerError",
]


class MpmaError(Exception):
    """Base of all errors that this package raises on purpose."""

    exit_code = 2


class BadOptionError(MpmaError, ValueError):
    """An option or argument is outside what it may be."""


class UnknownMotionError(MpmaError):
    """Neither a built-in motion nor a file that exists."""


class MotionFileError(MpmaError):
    """A recording cannot be read, or not as the movement of two arms."""


class MotionReachError(MpmaError):
    """A demonstration asks for more speed or bend than the arms have."""


class RobotLogError(MpmaError):
    """A robot's log cannot be read, or does not show what is to be found out."""


class RunFolderError(MpmaError):
    """A run folder cannot be written, or must not be overwritten."""


class CheckpointError(MpmaError):
    """A checkpoint is damaged, or belongs to something else."""


class DivergedError(MpmaError):
    """A simulation no longer holds finite numbers."""

    exit_code = 1


class RenderingError(MpmaError):
    """No OpenGL backend can draw."""

    exit_code = 1


class VideoError(MpmaError):
    """A video cannot be encoded."""

    exit_code = 1


class WorkerError(MpmaError):
    """Processes that train runs died, or are not like the one that sent them work."""

    exit_code = 1


class RecordingWarning(UserWarning):
    """Something about a recording may be wrong; says what was used instead."""
