"""Frames of a video file, one after the other, as ffmpeg decodes them."""

from __future__ import annotations

import contextlib
import logging
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import imageio_ffmpeg
import numpy as np
from numpy.typing import NDArray

from mpma_mj.errors import BadOptionError, MotionFileError, one_line

__all__ = ["Clip", "is_video", "open_clip"]

Picture = NDArray[np.uint8]

# Containers by their first bytes, at an offset.
_SIGNATURES = (
    *((4, kind) for kind in (b"ftyp", b"moov", b"mdat", b"wide", b"free")),  # MP4, MOV
    *((0, b"\x1a\x45\xdf\xa3"), (0, b"GIF8"), (8, b"AVI "), (0, b"OggS"), (0, b"FLV\x01")),
    *((0, b"\x00\x00\x01\xba"), (0, b"\x00\x00\x01\xb3"), (0, b"\x30\x26\xb2\x75\x8e\x66\xcf\x11")),
)
_SIDE = 640  # pixels of the longer side that are looked at; a detector needs 256 of a person
_LARGEST = 40_000_000  # pixels of a frame (choice)
_RATE = 30.0  # Hz at most: motions have 20 (choice)
_UNKNOWN_RATE = 25.0  # Hz, if the file declares none (choice)
_LONGEST = 600.0  # s that are read (choice)
_WHOLE = 0.95  # share of the declared frames (choice)
_PART = re.compile(r"^(\[[^]]*\] )+")  # the part of ffmpeg that reports
# Square pixels, upright as the file says, and no larger than needed.
_SCALE = rf"scale=w='if(gt(dar\,1)\,{_SIDE}\,{_SIDE}*dar)':h='if(gt(dar\,1)\,{_SIDE}/dar\,{_SIDE})'"


def is_video(head: bytes) -> bool:
    """Return whether the first bytes of a file are those of a video."""
    return any(head.startswith(sign, at) for at, sign in _SIGNATURES)


@dataclass(frozen=True)
class Clip:
    """A part of a video that can be decoded.

    Attributes:
        path: The file.
        rate: Frames per second that are read, Hz.
        start: Where reading begins, s.
        end: Where it ends, s; infinite for the end of the file.
        duration: Declared length of the file, s; 0 if it declares none.
    """

    path: Path
    rate: float
    start: float
    end: float
    duration: float

    @property
    def frames_before(self) -> int:
        """Number of frames before `start`."""
        return round(self.start * self.rate)

    @property
    def declared_frames(self) -> int:
        """Number of frames that the file declares in this part; 0 if it is unknown."""
        end = min(self.end, self.duration) if self.duration else self.end
        return int((end - self.start) * self.rate) if end < np.inf else 0

    def is_cut_short(self, frames: int) -> bool:
        """Return whether a number of frames is clearly less than what is declared."""
        return frames < _WHOLE * self.declared_frames - 2.0

    def frames(self) -> Iterator[Picture]:
        """Decode the frames, each shape (height, width, 3).

        Raises:
            MotionFileError: They cannot be decoded, or are too many.
        """
        most = int(_LONGEST * self.rate)
        last = (
            min(most, int((self.end - self.start) * self.rate) + 1) if self.end < np.inf else most
        )
        begin = ["-ss", f"{self.frames_before / self.rate:.6f}"] if self.frames_before else []
        output = ["-map", "0:v:0", "-vf", f"fps={self.rate:.6f},{_SCALE}"]
        with _ffmpeg(self.path, begin, output) as (meta, decoded):
            width, height = meta["size"]
            for number, frame in enumerate(decoded):
                if number >= last:
                    if last == most:
                        raise _too_long(self.path, f"more than {_LONGEST:g}")
                    return
                yield np.frombuffer(frame, np.uint8).reshape(height, width, 3)


def open_clip(path: Path, start: float | None, end: float | None) -> Clip:
    """Read the header of a video.

    Args:
        path: The file.
        start: Where to begin, s.
        end: Where to end, s.

    Raises:
        BadOptionError: The video is shorter than `start`.
        MotionFileError: It has no pictures, is damaged, or too long.
    """
    with _ffmpeg(path, [], ["-map", "0:v:0"]) as (meta, _):
        rate, duration = float(meta.get("fps") or 0.0), float(meta.get("duration") or 0.0)
    first, last = start or 0.0, np.inf if end is None else end
    if duration and first >= duration:
        expected = f"less, as {path} lasts {duration:.2f} s"
        raise BadOptionError(option="start", value=first, expected=expected)
    if min(last, duration) - first > _LONGEST:
        raise _too_long(path, f"{min(last, duration) - first:.0f}")
    return Clip(path, min(rate or _UNKNOWN_RATE, _RATE), first, last, duration)


def _too_long(path: Path, seconds: str) -> MotionFileError:
    return MotionFileError(
        f"{path}: has {seconds} s of video; at most {_LONGEST:g} s are read",
        remedy="choose a part with {start} and {end}",
    )


@contextlib.contextmanager
def _ffmpeg(
    path: Path, before: list[str], after: list[str]
) -> Iterator[tuple[dict[str, Any], Iterator[bytes]]]:
    """Run ffmpeg with options of its input and its output.

    Yields:
        What the file declares, and the frames.

    Raises:
        MotionFileError: There is no ffmpeg, or it fails.
    """
    logger = logging.getLogger("imageio_ffmpeg")
    logger.addFilter(_is_serious)
    safe = ["-protocol_whitelist", "file", "-max_pixels", str(_LARGEST)]
    try:
        # "file:" keeps names with a colon from being addresses.
        decoder = imageio_ffmpeg.read_frames(
            f"file:{path.absolute()}", input_params=[*safe, *before], output_params=after
        )
        with contextlib.closing(decoder):
            yield next(decoder), decoder
    except (OSError, RuntimeError, LookupError, ValueError, StopIteration) as error:
        if isinstance(error, OSError) and error.strerror:  # of the program, not of the file
            raise _no_ffmpeg(path, f"cannot be started ({error.strerror})") from None
        raise _failure(path, str(error)) from None
    finally:
        logger.removeFilter(_is_serious)


def _is_serious(record: logging.LogRecord) -> bool:
    """Return whether a message of the library reports more than another size of frames."""
    return "frame size" not in record.getMessage()


def _no_ffmpeg(path: Path, why: str) -> MotionFileError:
    return MotionFileError(
        f"{path}: ffmpeg, which decodes it, {why}; install it, or set IMAGEIO_FFMPEG_EXE to one"
        " that works"
    )


def _failure(path: Path, log: str) -> MotionFileError:
    """Return an error with the cause that a log of ffmpeg shows."""
    if "ffmpeg exe" in log:
        return _no_ffmpeg(path, "was not found")
    if "matches no streams" in log and "Audio:" in log:
        return MotionFileError(
            f"{path}: has sound, but no pictures",
            remedy="give a video or a recording, and sound with {audio}",
        )
    lines = [_PART.sub("", line.strip()) for line in log.splitlines() if line.startswith("[")]
    cause = f" ({one_line(lines[0])})" if lines else ""
    return MotionFileError(
        f"{path}: cannot be decoded as a video{cause}; it is damaged, cut short or of another kind:"
        " copy it again, or convert it to MP4"
    )
