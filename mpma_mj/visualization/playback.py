"""Playback in a window, of a trained run or of arms that follow a recording ideally."""

from __future__ import annotations

import contextlib
import queue
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpma_mj.context import active_label
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.envs.physics import PhysicsArms
from mpma_mj.envs.viewer import ArmViewer
from mpma_mj.motions import Motion
from mpma_mj.trace import Trace

__all__ = ["KEYS", "LEFT", "RIGHT", "SPACE", "Dance", "Player", "play"]

Array = NDArray[np.float64]

SPACE, RIGHT, LEFT = 32, 262, 263
"""Codes of the keys in GLFW."""

KEYS = {"space": "pause, go on", "right": "a step on", "left": "a step back"}
"""Action of each key, displayed to the user."""


@dataclass(frozen=True, eq=False)
class Dance:
    """Robot, demonstration and label at each of T steps.

    Attributes:
        joint_angles: Joint angles of the robot, shape (T, 8), rad.
        reference: Demonstrated postures, shape (T, 12).
        times: Displayed times, shape (T,), s.
        labels: Active label of each step, T names; "" where there is none.
        rate: Steps per second, Hz.
        options: Options of the environment, whose arms are shown; the defaults if None.
    """

    joint_angles: Array
    reference: Array
    times: Array
    labels: tuple[str, ...]
    rate: float
    options: EnvironmentOptions | None = None

    @classmethod
    def of_run(
        cls, trace: Trace, motion: Motion, options: EnvironmentOptions | None = None
    ) -> Dance:
        """Return the best epoch of a run, given its trace and the motion that was imitated."""
        return cls(
            joint_angles=trace.true_joint_angles(),
            reference=trace.reference,
            times=np.arange(len(trace.joint_angles)) / motion.rate,
            labels=_names(trace.context, motion),
            rate=motion.rate,
            options=options,
        )

    @classmethod
    def of_motion(cls, motion: Motion, times: Array) -> Dance:
        """Return the robot in exactly the demonstrated postures, at times of shape (T,), s."""
        return cls(
            joint_angles=motion.joint_angles,
            reference=motion.posture,
            times=times,
            labels=_names(motion.context, motion),
            rate=motion.rate,
        )


@dataclass
class Player:
    """Position in a loop over steps.

    Attributes:
        steps: Number of steps.
        step: Current step, from 0.
        paused: Whether playback is paused.
    """

    steps: int
    step: int = 0
    paused: bool = False

    def advance(self) -> None:
        """Move to the next step, unless paused."""
        if not self.paused:
            self._move(1)

    def press(self, key: int) -> None:
        """Handle a key: the space bar pauses or continues, an arrow pauses and moves by a step.

        Args:
            key: Code of the key in GLFW; other keys have no effect.
        """
        if key == SPACE:
            self.paused = not self.paused
        elif key in (RIGHT, LEFT):
            self.paused = True
            self._move(1 if key == RIGHT else -1)

    def _move(self, steps: int) -> None:
        self.step = (self.step + steps) % self.steps


def play(dance: Dance, *, instead: str, on_open: Callable[[], None]) -> None:
    """Play in a loop until the user closes the window.

    Args:
        dance: Robot and demonstration, played at their rate.
        instead: Remedy for the error message where no window can be opened.
        on_open: Called once, when the window is open.

    Raises:
        BadOptionError: The environment's model cannot be read.
        RenderingError: There is no display, or OpenGL does not draw.
    """
    physics = PhysicsArms.make(dance.options)
    player = Player(len(dance.joint_angles))
    pressed: queue.SimpleQueue[int] = queue.SimpleQueue()  # keys come from the window's thread
    viewer = ArmViewer(physics, 1.0 / dance.rate, instead=instead, on_key=pressed.put)
    with contextlib.closing(viewer):
        on_open()
        while viewer.is_open:
            physics.set_joint_state(dance.joint_angles[player.step], np.zeros(8))
            overlay = _overlay(dance, player)
            viewer.show(dance.reference[player.step], above=overlay, below=KEYS)
            # Before the next step: an arrow key counts from the step that is displayed.
            while not pressed.empty():
                player.press(pressed.get())
            player.advance()


def _overlay(dance: Dance, player: Player) -> dict[str, str]:
    """Return the text of the window: time, step and label."""
    return {
        "time": f"{dance.times[player.step]:.2f} s",
        "step": f"{player.step} / {player.steps - 1}" + ", paused" * player.paused,
        "label": dance.labels[player.step],
    }


def _names(context: Array, motion: Motion) -> tuple[str, ...]:
    """Return the active label of each step; "" where there is none."""
    return tuple("" if i < 0 else motion.labels[i] for i in active_label(context))
