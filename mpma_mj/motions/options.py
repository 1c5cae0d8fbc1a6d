"""Options of reading a motion."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import PurePath
from typing import Annotated, Literal

from mpma_mj.errors import BadOptionError
from mpma_mj.motions.readers.recording import RATES, Unit, Up
from mpma_mj.utils.validation import Bounds, check_fields

__all__ = ["ContextName", "ReadingOptions", "given"]

ContextName = Literal["auto", "equal", "changes", "events", "bars", "sections"]
OtherArm = Literal["hang", "mirror"]
Depth = Literal["flat", "estimated"]

_PARTS = 4
_SECONDS = Bounds(0.0, 1e6, hint="s")
_TEMPO = Bounds(0.01, 100.0)  # beyond, a motion has hardly a sample, or fills the memory


@dataclass(frozen=True, kw_only=True)
class ReadingOptions:
    """Options of reading a motion; what is not given is found in the recording.

    Attributes:
        map: Which points show the body: "left_elbow=EPICl+EPICm,…", or a TOML file.
        skeleton: The ASF of an AMC, if it is in another folder, or the body model of an SMPL pose.
        unit: Unit of the file.
        up: Axis of the file that points up.
        left_handed: Mirror a file whose axes are left-handed, as Unity's and Unreal's are.
        rate_in: Frames per second of the file, Hz.
        start: Where to begin, in seconds of the recording.
        end: Where to end, in seconds of the recording.
        max_gap: Longest gap in a marker's trajectory that is bridged, in seconds.
        longest: Keep the longest stretch without longer gaps, instead of refusing the file.
        repair: Bridge single frames in which a marker jumps away and back.
        other_arm: What the other arm does in a recording of one arm: hang, or mirror that one.
        depth: Depth of what is seen in a video (experimental): "flat" leaves it out, so that arms
            move in the frontal plane; "estimated" is rough.
        cutoff: Cut-off frequency of the low-pass filter, Hz; from the data if not given.
        tempo: Speed relative to the original; 0.5 takes twice as long; "auto" is the fastest,
            up to 1, at which the arms can follow the motion as it is.
        strict: Refuse a motion that the arms cannot follow, instead of changing it as little as
            possible.
        loop: Bend the end of the motion so that it leads into its start.
        context: What labels the motion: equal parts, changes found in the motion, events in
            a C3D, bars or repeated sections of the audio. By default the labels or the bars if
            a file of them is given, else equal parts.
        segments: Number of equal parts, or of parts between changes.
        labels: CSV of start,end,label in seconds.
        audio: Audio file of the music to which the motion belongs.
    """

    map: str | None = None
    skeleton: str | None = None
    unit: Unit | None = None
    up: Up | None = None
    left_handed: bool = False
    rate_in: Annotated[float, Bounds(*RATES, hint="Hz")] | None = None
    start: Annotated[float, _SECONDS] | None = None
    end: Annotated[float, _SECONDS] | None = None
    max_gap: Annotated[float, _SECONDS] = 0.25
    longest: bool = False
    repair: bool = False
    other_arm: OtherArm | None = None
    depth: Depth = "flat"
    cutoff: Annotated[float, Bounds(0.0, 1e6, above=True, hint="Hz")] | None = None
    tempo: Annotated[float, _TEMPO] | Literal["auto"] = 1.0
    strict: bool = False
    loop: bool = False
    context: ContextName = "auto"
    segments: Annotated[int, Bounds(1, 1e6)] = _PARTS
    labels: str | None = None
    audio: str | None = None

    def check(self) -> None:
        """Check what can be checked without the recording.

        Raises:
            BadOptionError: An option is outside what it may be, or contradicts another.
        """
        check_fields(self)
        if self.map is not None and not isinstance(self.map, str | PurePath):
            expected = 'text such as "left_elbow=A+B", or a TOML file'
            raise BadOptionError(option="map", value=self.map, expected=expected)
        start = self.start or 0.0
        if self.end is not None and self.end <= start:
            expected = f"more than {start:g} s, where the motion begins"
            raise BadOptionError(option="end", value=self.end, expected=expected)
        self._check_context()

    @property
    def own_tempo(self) -> float:
        """The tempo as a number, 1 where it is found later."""
        return 1.0 if self.tempo == "auto" else self.tempo

    def _check_context(self) -> None:
        """Check that one thing only labels the motion."""
        from_audio = self.context in ("bars", "sections")
        if from_audio and self.audio is None:
            raise BadOptionError(
                f"context {self.context} needs audio", remedy="give it with {audio}"
            )
        if self.audio is not None and not (from_audio or self.context == "auto"):
            raise BadOptionError(
                f"audio has bars and sections, not {self.context}",
                remedy="leave out {audio} or {context}",
            )
        if self.segments != _PARTS and (
            from_audio or self.labels or self.audio or self.context == "events"
        ):
            raise BadOptionError(
                "segments divide a motion without labels",
                remedy="leave out {segments}, or the options that label it",
            )
        if self.labels is not None and (self.audio is not None or self.context != "auto"):
            raise BadOptionError(
                "labels already give the context",
                remedy="leave out {audio} and {context}, or {labels}",
            )


def given(options: ReadingOptions) -> set[str]:
    """Return the names of options that differ from their defaults."""
    return {f.name for f in fields(ReadingOptions) if getattr(options, f.name) != f.default}
