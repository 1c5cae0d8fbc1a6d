"""How a recording is to be read."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from numbers import Integral, Real
from pathlib import PurePath
from typing import Literal, get_args

from mpma_mj.errors import BadOptionError
from mpma_mj.motions.readers.recording import RATES, Unit, Up

__all__ = ["ContextName", "ReadingOptions", "given"]

ContextName = Literal["auto", "equal", "changes", "events", "bars", "sections"]

_PARTS = 4
_NUMBERS = ("rate_in", "start", "end", "max_gap", "cutoff", "tempo")
_TEMPO = (0.01, 100.0)  # beyond, a movement has hardly a sample, or fills the memory


@dataclass(frozen=True, kw_only=True)
class ReadingOptions:
    """How a recording is to be read; what is not given is found out.

    Attributes:
        map: Which points show the body: "left_elbow=EPICl+EPICm,…", or a TOML file.
        skeleton: The ASF of an AMC, where it is not beside it.
        unit: Unit of the file.
        up: Axis of the file that points up.
        rate_in: Frames per second of the file, Hz.
        start: Where to begin, in seconds of the recording.
        end: Where to end, in seconds of the recording.
        max_gap: Longest gap in a marker's trajectory that is bridged, in seconds.
        longest: Keep the longest stretch without longer gaps, instead of refusing the file.
        repair: Bridge single frames in which a marker jumps away and back.
        cutoff: Cut-off frequency of the low-pass filter, Hz; from the data if not given.
        tempo: Speed relative to the original; 0.5 takes twice as long.
        loop: Bend the end of the movement so that it leads into its start.
        context: What labels the movement: equal parts, changes found in the movement, events in
            a C3D, bars or repeated sections of the audio. By default the labels or the bars if
            a file of them is given, else equal parts.
        segments: Number of equal parts, or of parts between changes.
        labels: CSV of start,end,label in seconds.
        audio: Sound file of the music that is danced to.
    """

    map: str | None = None
    skeleton: str | None = None
    unit: Unit | None = None
    up: Up | None = None
    rate_in: float | None = None
    start: float | None = None
    end: float | None = None
    max_gap: float = 0.25
    longest: bool = False
    repair: bool = False
    cutoff: float | None = None
    tempo: float = 1.0
    loop: bool = False
    context: ContextName = "auto"
    segments: int = _PARTS
    labels: str | None = None
    audio: str | None = None

    def check(self) -> None:
        """Check what can be checked without the recording.

        Raises:
            BadOptionError: An option is outside what it may be, or contradicts another.
        """
        self._check_types()
        if not (math.isfinite(self.max_gap) and self.max_gap >= 0):
            raise _refused(self, "max_gap", "seconds, 0 or more")
        low, high = RATES
        if self.rate_in is not None and not low <= self.rate_in <= high:
            raise _refused(self, "rate_in", f"{low:g} to {high:g} Hz")
        for option in ("cutoff", "tempo"):
            number = getattr(self, option)
            if number is not None and not (math.isfinite(number) and number > 0):
                raise _refused(self, option, "a number above 0")
        if not _TEMPO[0] <= self.tempo <= _TEMPO[1]:
            raise _refused(self, "tempo", f"{_TEMPO[0]:g} to {_TEMPO[1]:g}")
        if self.segments < 1:
            raise _refused(self, "segments", "at least 1")
        start = 0.0 if self.start is None else self.start
        if not 0 <= start < math.inf:
            raise _refused(self, "start", "seconds, 0 or more")
        if self.end is not None and not self.end > start:
            raise _refused(self, "end", f"more than {start:g} s, where the movement begins")
        self._check_context()

    def _check_types(self) -> None:
        """Check what an option is, whatever its value."""
        for name in _NUMBERS:
            number = getattr(self, name)
            if number is not None and (isinstance(number, bool) or not isinstance(number, Real)):
                raise _refused(self, name, "a number")
        if not isinstance(self.segments, Integral):
            raise _refused(self, "segments", "a whole number")
        if self.map is not None and not isinstance(self.map, str | PurePath):
            raise _refused(self, "map", 'text such as "left_elbow=A+B", or a TOML file')
        for option, allowed in {"unit": Unit, "up": Up, "context": ContextName}.items():
            value = getattr(self, option)
            if value is not None and value not in get_args(allowed):
                raise _refused(self, option, f"one of {', '.join(get_args(allowed))}")

    def _check_context(self) -> None:
        """Check that one thing only labels the movement."""
        music = self.context in ("bars", "sections")
        if music and self.audio is None:
            raise BadOptionError(
                f"context {self.context} needs the music", remedy="give it with {audio}"
            )
        if self.audio is not None and not (music or self.context == "auto"):
            raise BadOptionError(
                f"audio gives bars or sections, not {self.context}",
                remedy="drop {audio} or {context}",
            )
        if self.segments != _PARTS and (
            music or self.labels or self.audio or self.context == "events"
        ):
            raise BadOptionError(
                "segments are parts of a movement without labels",
                remedy="drop {segments}, or what labels it",
            )
        if self.labels is not None and (self.audio is not None or self.context != "auto"):
            raise BadOptionError(
                "labels are the context", remedy="drop {audio} and {context}, or {labels}"
            )


def _refused(options: ReadingOptions, option: str, expected: str) -> BadOptionError:
    return BadOptionError(option=option, value=getattr(options, option), expected=expected)


def given(options: ReadingOptions) -> set[str]:
    """Return the names of the options that are not as they are without being given."""
    return {f.name for f in fields(ReadingOptions) if getattr(options, f.name) != f.default}
