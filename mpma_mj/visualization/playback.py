"""Playback of an episode in a window."""

from __future__ import annotations

import contextlib
import queue
from collections.abc import Callable
from dataclasses import dataclass

from mpma_mj.envs.viewer import ArmViewer
from mpma_mj.visualization.episode import EpisodeArms
from mpma_mj.visualization.scene import Scene

__all__ = ["KEYS", "LEFT", "RIGHT", "SPACE", "Player", "play"]

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


def play(scene: Scene, *, instead: str, on_open: Callable[[], None]) -> None:
    """Play a scene in a loop, a control step at a time, until the user closes the window.

    Args:
        scene: What is shown; the window has a size of its own.
        instead: Remedy for the error message where no window can be opened.
        on_open: Called once, when the window is open.

    Raises:
        BadOptionError: The environment's model cannot be read, or has no such camera.
        RenderingError: There is no display, or OpenGL does not draw.
    """
    arms = EpisodeArms(scene.trace, scene.options, scene.motion.angles_of)
    times, labels = scene.displayed_times, scene.labels
    player = Player(len(times))
    pressed: queue.SimpleQueue[int] = queue.SimpleQueue()  # keys come from the window's thread
    viewer = ArmViewer(
        arms.physics,
        1.0 / scene.motion.rate,
        camera=scene.camera,
        instead=instead,
        on_key=pressed.put,
    )
    with contextlib.closing(viewer):
        on_open()
        while viewer.is_open:
            step = player.step
            ghost = arms.pose(step)
            overlay = {
                "time": f"{times[step]:.2f} s",
                "step": f"{step} / {player.steps - 1}" + ", paused" * player.paused,
                "label": labels[step],
            }
            captions = {"above": overlay, "below": KEYS} if scene.captions else {}
            viewer.show(ghost, **captions)
            # Before the next step: an arrow key counts from the step that is displayed.
            while not pressed.empty():
                player.press(pressed.get())
            player.advance()
