"""Scenes of episodes, for a window, a video or a page."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpma_mj.arm_kinematics import TWO_ARMS, ArmKinematics
from mpma_mj.context import active_label
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.envs.soundtrack import Soundtrack
from mpma_mj.errors import BadOptionError
from mpma_mj.motions import Motion
from mpma_mj.trace import Trace

__all__ = ["ORBIT", "Scene", "ideal_scene"]

Array = NDArray[np.float64]

ORBIT = "orbit"
"""Name of the camera that goes around the arms once, in the length of a video."""


@dataclass(frozen=True, eq=False, repr=False)
class Scene:
    """What a window, a video or a page shows of an episode.

    Attributes:
        trace: Trace of the T steps that are shown.
        motion: The motion that was imitated.
        options: Options of the environment, whose arms are shown; the defaults if None.
        times: Time of each moment as it is displayed, shape (T + 1,), s; from 0 if None.
        sound: Sound of these steps.
        camera: Name of a camera of the model, or `ORBIT`.
        captions: Whether labels and responsibilities are shown.
        size: Width and height of frames, pixels, with the strip of responsibilities; None for
            640 x 480 above that strip.
        fps: Frames per second, Hz; one for each control step if None.
    """

    trace: Trace
    motion: Motion
    options: EnvironmentOptions | None = None
    times: Array | None = None
    sound: Soundtrack | None = None
    camera: str = "front"
    captions: bool = True
    size: tuple[int, int] | None = None
    fps: float | None = None

    def cut(self, start: float, end: float) -> Scene:
        """Return the scene of the steps that begin from `start` to before `end`, s of the episode.

        Raises:
            BadOptionError: No step begins there.
        """
        begins = np.arange(len(self.trace)) / self.motion.rate
        if start > begins[-1]:
            expected = f"less, as the episode lasts {len(begins) / self.motion.rate:.2f} s"
            raise BadOptionError(option="start", value=start, expected=expected)
        shown = np.flatnonzero((begins >= start) & (begins < end))
        if not len(shown):
            raise BadOptionError(f"no step from {start:g} to {end:g} s; give a longer time")
        first, last = int(shown[0]), int(shown[-1]) + 1
        duration = (last - first) / self.motion.rate
        return replace(
            self,
            trace=self.trace.cut(first, last),
            times=self.displayed_times[first : last + 1],
            sound=self.sound and self.sound.cut(first / self.motion.rate, duration),
        )

    @property
    def displayed_times(self) -> Array:
        """Time of each moment as it is displayed, shape (T + 1,), s."""
        steps = np.arange(len(self.trace) + 1)
        return steps / self.motion.rate if self.times is None else self.times

    @property
    def rate(self) -> float:
        """Frames per second, Hz."""
        return self.fps or self.motion.rate

    @property
    def moments(self) -> Array:
        """Moment of each frame, shape (N,), in control steps: from 0 to less than T."""
        frames = math.ceil(len(self.trace) * self.rate / self.motion.rate - 1e-6)
        return np.arange(max(frames, 1), dtype=np.float64) * self.motion.rate / self.rate

    @property
    def labels(self) -> list[str]:
        """Active label at each moment, T + 1 of them; "" where there is none."""
        active = active_label(self.trace.context)
        return ["" if label < 0 else self.motion.labels[label] for label in active]

    @property
    def shares(self) -> tuple[Array, tuple[str, ...]]:
        """Responsibilities λ, shape (T, M), and names of modules; of labels without modules."""
        if self.trace.modules is not None:
            responsibility = self.trace.modules.responsibility
            return responsibility, tuple(f"module {i + 1}" for i in range(responsibility.shape[1]))
        context = self.trace.context[:-1]
        total: Array = np.maximum(context.sum(axis=1, keepdims=True), 1.0)
        return context / total, self.motion.labels


def ideal_scene(
    motion: Motion,
    audio: str | None = None,
    times: Array | None = None,
    options: EnvironmentOptions | None = None,
    kinematics: ArmKinematics = TWO_ARMS,
) -> Scene:
    """Return the scene of arms in the demonstrated postures, or as close as a robot's come.

    Args:
        motion: The motion; for other arms than `two_arm` feasible for them.
        audio: Sound file of the music to which the motion belongs.
        times: Time of each posture as it is displayed, shape (T + 1,), s; from 0 if not given.
        options: Options of the environment, whose arms are shown; the defaults if None.
        kinematics: Kinematics of the arms.
    """
    steps = len(motion) - 1
    exact = kinematics == TWO_ARMS
    trace = Trace(
        posture=motion.posture if exact else kinematics.posture(motion.joint_angles),
        reference=motion.posture,
        context=motion.context,
        joint_angles=motion.joint_angles,
        joint_velocities=np.zeros_like(motion.joint_angles),
        action=np.zeros((steps, 8)),
        reward=np.zeros(steps),
    )
    path = None if audio is None else Path(audio)
    return Scene(trace, motion, options, times=times, sound=Soundtrack.of(path, motion, steps, 1))
