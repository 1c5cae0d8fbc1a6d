"""Position of a player in the steps that it plays, and its keys."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["KEYS", "LEFT", "RIGHT", "SPACE", "Player"]

SPACE, RIGHT, LEFT = 32, 262, 263
"""Codes of the keys in GLFW."""

KEYS = {"space": "pause, go on", "right": "a step on", "left": "a step back"}
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
