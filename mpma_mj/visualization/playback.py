"""Playback of an episode in a window."""

from __future__ import annotations

import contextlib
import queue
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpma_mj.context import active_label
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.envs.viewer import ArmViewer
from mpma_mj.motions import Motion
from mpma_mj.trace import Trace
from mpma_mj.visualization.episode import EpisodeArms

__all__ = ["KEYS", "LEFT", "RIGHT", "SPACE", "Player", "play"]

Array = NDArray[np.float64]

SPACE, RIGHT, LEFT = 32, 262, 263
"""Codes of the keys in GLFW."""

KEYS = {"space": "pause, continue", "right": "a step forward", "left": "a step back"}
"""Action of each key, displayed to the user."""


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


def play(
    trace: Trace,
    motion: Motion,
    *,
    times: Array | None = None,
    options: EnvironmentOptions | None = None,
    instead: str,
    on_open: Callable[[], None],
) -> None:
    """Play an episode in a loop, in real time, until the user closes the window.

    Args:
        trace: Trace of the episode.
        motion: The motion that is imitated.
        times: Displayed times, shape (T + 1,), s; from 0 if not given.
        options: Options of the environment, whose arms are shown; the defaults if not given.
        instead: Remedy for the error message where no window can be opened.
        on_open: Called once, when the window is open.

    Raises:
        BadOptionError: The environment's model cannot be read.
        RenderingError: There is no display, or OpenGL does not draw.
    """
    arms = EpisodeArms(trace, options)
    if times is None:
        times = np.arange(len(trace.reference)) / motion.rate
    labels = ["" if i < 0 else motion.labels[i] for i in active_label(trace.context)]
    player = Player(len(times))
    pressed: queue.SimpleQueue[int] = queue.SimpleQueue()  # keys come from the window's thread
    viewer = ArmViewer(arms.physics, 1.0 / motion.rate, instead=instead, on_key=pressed.put)
    with contextlib.closing(viewer):
        on_open()
        while viewer.is_open:
            step = player.step
            arms.pose(step)
            overlay = {
                "time": f"{times[step]:.2f} s",
                "step": f"{step} / {player.steps - 1}" + ", paused" * player.paused,
                "label": labels[step],
            }
            viewer.show(trace.reference[step], above=overlay, below=KEYS)
            # Before the next step: an arrow key counts from the step that is displayed.
            while not pressed.empty():
                player.press(pressed.get())
            player.advance()
