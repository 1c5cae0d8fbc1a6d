"""Writer of videos, frame by frame."""

from __future__ import annotations

import contextlib
import os
import re
import signal
import subprocess
import threading
from collections.abc import Callable, Iterator
from fractions import Fraction
from pathlib import Path

import imageio_ffmpeg
import numpy as np
from numpy.typing import NDArray

from mpma_mj.envs.soundtrack import Soundtrack
from mpma_mj.errors import VideoError
from mpma_mj.utils.atomic_files import atomic_write
from mpma_mj.utils.input_files import file_problem

__all__: list[str] = ["EVEN_SIZED", "SOUND_CODECS", "VIDEO_FORMATS", "WriteFrame", "frame_writer"]

Picture = NDArray[np.uint8]
WriteFrame = Callable[[Picture], None]

# Options of ffmpeg by the ending of the file. Rate factors: from 0, the best, to 51 or 63 (choice).
_ENCODERS = {
    ".mp4": ["-vcodec", "libx264", "-pix_fmt", "yuv420p", "-crf", "15"],
    ".webm": [
        *("-vcodec", "libvpx-vp9", "-pix_fmt", "yuv420p", "-crf", "32", "-b:v", "0"),
        *("-deadline", "good", "-cpu-used", "4", "-row-mt", "1"),
    ],
    ".gif": ["-vf", "split[a][b];[a]palettegen[p];[b][p]paletteuse=dither=none"],
    ".webp": ["-vcodec", "libwebp_anim", "-quality", "90", "-loop", "0"],
}
VIDEO_FORMATS = tuple(_ENCODERS)
"""Endings of the files that can be written; `.gif` and `.webp` repeat for ever."""

SOUND_CODECS = {".mp4": ("aac", "192k"), ".webm": ("libopus", "128k")}
"""Encoder and bits per second of the sound, by the ending of the files that have sound."""

EVEN_SIZED = (".mp4", ".webm")
"""Endings of the videos whose width and height are even."""

_NO_SOUND = ("Invalid data found", "matches no streams")  # what ffmpeg reports of such files
_PART = re.compile(r"^\[[^]]*\] ")  # the part of ffmpeg that reports: "[out#0/mp4 @ 0x55e9] "


@contextlib.contextmanager
def frame_writer(
    path: Path, size: tuple[int, int], rate: float, sound: Soundtrack | None = None
) -> Iterator[WriteFrame]:
    """Open a video, which replaces a file of its name once the encoder has succeeded.

    Args:
        path: The file, whose ending is one of `VIDEO_FORMATS`; missing folders are created.
        size: Height and width of frames, pixels; even where `EVEN_SIZED` has the ending.
        rate: Frames per second, Hz.
        sound: Sound, for the formats of `SOUND_CODECS`; the others have none.

    Yields:
        Function that writes a frame, shape (height, width, 3).

    Raises:
        VideoError: The encoder is missing, or fails.
        RunFolderError: The folder cannot be written.
    """
    with atomic_write(path) as temporary:
        temporary.touch()  # a folder that cannot be written is reported before ffmpeg fails
        temporary.unlink()
        encoder = _Encoder(path, temporary, size, rate, sound)
        process = os.getpid()
        try:
            yield encoder.write
        except BaseException:
            if os.getpid() == process:  # not in one forked meanwhile: the encoder is the parent's
                encoder.kill()
            raise
        if os.getpid() == process:
            encoder.finish()


class _Encoder:
    """A process of ffmpeg whose exit code is checked, which imageio's writers do not."""

    def __init__(
        self,
        path: Path,
        temporary: Path,
        size: tuple[int, int],
        rate: float,
        sound: Soundtrack | None,
    ) -> None:
        self._path = path
        self._sound: Path | None = None
        height, width = size
        frames = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}"]
        frames += ["-r", str(Fraction(rate).limit_denominator()), "-i", "-"]
        audio = ["-an"]
        if sound is not None and path.suffix in SOUND_CODECS:
            if problem := file_problem(sound.path):
                raise self._error(f"{sound.path}: {problem}")
            self._sound = sound.path
            # "file:" keeps names with a colon from being addresses.
            frames += ["-i", f"file:{sound.path.absolute()}"]
            audio = ["-filter_complex", sound.filters, "-map", "0:v", "-map", "[sound]"]
            codec, bits = SOUND_CODECS[path.suffix]
            audio += ["-acodec", codec, "-b:a", bits]
        video = [*audio, *_ENCODERS[path.suffix], str(temporary)]
        try:
            program = imageio_ffmpeg.get_ffmpeg_exe()
            self._process = subprocess.Popen(
                [program, "-v", "error", "-y", *frames, *video],
                stdin=subprocess.PIPE,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.PIPE,
                start_new_session=True,  # Ctrl-C does not reach it, and `kill` ends it
            )
        except RuntimeError:
            raise self._error(
                "ffmpeg was not found; install it, or set IMAGEIO_FFMPEG_EXE to its path"
            ) from None
        except OSError as error:
            raise self._error(
                f"{program} cannot be started ({error.strerror}); set IMAGEIO_FFMPEG_EXE to an"
                " ffmpeg that works, or unset it"
            ) from None
        assert self._process.stdin is not None
        assert self._process.stderr is not None
        self._frames, self._stderr = self._process.stdin, self._process.stderr
        self._lines: list[bytes] = []
        # Read in parallel, since ffmpeg blocks while its output is full.
        self._reader = threading.Thread(target=self._lines.extend, args=[self._stderr], daemon=True)
        self._reader.start()

    def write(self, frame: Picture) -> None:
        """Encode a frame."""
        try:
            self._frames.write(np.ascontiguousarray(frame).data)
        except OSError:  # the process has ended
            raise self._failure(self._end()) from None

    def finish(self) -> None:
        """Encode the remaining frames and check the exit code."""
        code = self._end()
        if code != 0:
            raise self._failure(code)

    def kill(self) -> None:
        """End the process at once."""
        self._process.kill()
        self._end()

    def _end(self) -> int:
        """Wait for the end and return the exit code."""
        with contextlib.suppress(OSError):  # the process has ended, as its exit code shows
            self._frames.close()
        code = self._process.wait()
        self._reader.join()
        self._stderr.close()
        return code

    def _failure(self, code: int) -> VideoError:
        how = f"was stopped: {signal.strsignal(-code)}" if code < 0 else f"failed: exit code {code}"
        if self._lines:
            line = _PART.sub("", self._lines[0].decode(errors="replace").strip())
            if self._sound is not None and any(text in line for text in _NO_SOUND):
                return self._error(f"{self._sound} has no sound that ffmpeg reads; give another")
            how += f" ({line})"
        return self._error(f"ffmpeg {how}; fix that, perhaps by freeing disk space, and try again")

    def _error(self, why: str) -> VideoError:
        return VideoError(f"{self._path}: the video was not written: {why}")
