"""Sound of a video: that of a motion, at its tempo and as often as it is repeated."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

from mpma_mj.motions import Motion

__all__ = ["Soundtrack"]

_RATE = 48_000  # Hz


@dataclass(frozen=True)
class Soundtrack:
    """Sound of an episode, or of a part of it.

    Attributes:
        path: Sound file, whose time is that of the recording.
        start: Time in the file at which the motion begins, s.
        tempo: How much faster than the recording the motion is.
        motion_duration: Duration of the motion, s; silence follows until the next repetition.
        period: Time from one repetition to the next, s.
        duration: Duration of the sound, s.
        begin: Time in the episode at which it begins, s.
    """

    path: Path
    start: float
    tempo: float
    motion_duration: float
    period: float
    duration: float
    begin: float = 0.0

    @classmethod
    def of(cls, path: Path | None, motion: Motion, steps: int, repeats: int) -> Soundtrack | None:
        """Return the sound of an episode.

        Args:
            path: Sound file; there is none if None.
            motion: The motion.
            steps: Steps of the episode.
            repeats: Repetitions of the motion in it.
        """
        if path is None:
            return None
        # Postures of all return moves; none where the episode ended early.
        between = max(0, steps + 1 - repeats * len(motion))
        period = len(motion) + between // max(repeats - 1, 1)
        seconds = (count / motion.rate for count in (len(motion), period, steps))
        return cls(path, motion.start, motion.tempo, *seconds)

    def cut(self, begin: float, duration: float) -> Soundtrack:
        """Return the sound from a time of the episode, s, for a duration, s."""
        return replace(self, begin=begin, duration=duration)

    @property
    def filters(self) -> str:
        """Filters of ffmpeg: from the first sound of its second input to its output "[sound]".

        What is cut out is stretched without a change of its pitch, filled with silence to a
        period, and repeated.
        """
        samples = round(self.period * _RATE)
        begin, end = self.start, self.start + self.motion_duration * self.tempo
        steps = [f"atrim=start={begin}:end={end}", "asetpts=PTS-STARTPTS"]
        steps.append(f"aresample={_RATE}")
        if self.tempo != 1.0:
            steps.append(f"rubberband=tempo={self.tempo}")
        # Silence follows the sound, also where it ends before the motion begins.
        steps += [f"apad=whole_len={samples}", f"atrim=end_sample={samples}"]
        repeats = math.ceil((self.begin + self.duration) / self.period)
        steps.append(f"aloop=loop={repeats}:size={samples}")
        steps += [f"atrim=start={self.begin}:duration={self.duration}", "asetpts=PTS-STARTPTS"]
        return f"[1:a:0]{','.join(steps)}[sound]"
