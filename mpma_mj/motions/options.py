"""How a recording is to be read."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from numbers import Integral, Real
from pathlib import PurePath
from typing import Literal, get_args

from mpma_mj.errors import BadOptionError
from mpma_mj.motions.recording import RATES, Unit, Up

__all__ = ["ContextName", "ReadingOptions", "given", "option_name"]

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
        for name in _NUMBERS:
            number = getattr(self, name)
            if number is not None and (isinstance(number, bool) or not isinstance(number, Real)):
                raise BadOptionError(f"{option_name(name)} is {number!r}; expected a number")
        if not isinstance(self.segments, Integral):
            raise BadOptionError(f"segments is {self.segments!r}; expected a whole number")
        if self.map is not None and not isinstance(self.map, str | PurePath):
            raise BadOptionError(
                f'map is {self.map!r}; expected text such as "left_elbow=A+B", or a TOML file'
            )
        for option, allowed in {"unit": Unit, "up": Up, "context": ContextName}.items():
            value = getattr(self, option)
            if value is not None and value not in get_args(allowed):
                raise BadOptionError(
                    f"{option} is '{value}'; expected one of {', '.join(get_args(allowed))}"
                )
        if not (math.isfinite(self.max_gap) and self.max_gap >= 0):
            raise BadOptionError(f"max-gap is {self.max_gap:g}; expected seconds, 0 or more")
        low, high = RATES
        if self.rate_in is not None and not low <= self.rate_in <= high:
            raise BadOptionError(f"rate-in is {self.rate_in:g}; expected {low:g} to {high:g} Hz")
        above_0 = {"cutoff": self.cutoff, "tempo": self.tempo}
        for option, number in above_0.items():
            if number is not None and not (math.isfinite(number) and number > 0):
                raise BadOptionError(f"{option} is {number:g}; expected a number above 0")
        if not _TEMPO[0] <= self.tempo <= _TEMPO[1]:
            raise BadOptionError(
                f"tempo is {self.tempo:g}; expected {_TEMPO[0]:g} to {_TEMPO[1]:g}"
            )
        if self.segments < 1:
            raise BadOptionError(f"segments is {self.segments}; expected at least 1")
        start, end = self.start or 0.0, math.inf if self.end is None else self.end
        if not 0 <= start < end:
            raise BadOptionError(f"from is {start:g} and to is {end:g}; expected 0 <= from < to")
        music = self.context in ("bars", "sections")
        if music and self.audio is None:
            raise BadOptionError(f"context {self.context} needs the music; give it with --audio")
        if self.audio is not None and not (music or self.context == "auto"):
            raise BadOptionError(f"audio gives bars or sections, not {self.context}; drop one")
        if self.segments != _PARTS and (
            music or self.labels or self.audio or self.context == "events"
        ):
            raise BadOptionError(
                "segments are parts of a movement without labels; drop --segments, or what labels"
                " it"
            )
        if self.labels is not None and (self.audio is not None or self.context != "auto"):
            raise BadOptionError("labels are the context; drop --audio and --context, or --labels")


def given(options: ReadingOptions) -> set[str]:
    """Return the names of the options that are not as they are without being given."""
    return {f.name for f in fields(ReadingOptions) if getattr(options, f.name) != f.default}


def option_name(field: str) -> str:
    """Return what the command line calls an option."""
    return {"start": "from", "end": "to"}.get(field, field.replace("_", "-"))
