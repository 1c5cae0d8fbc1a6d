"""What a player of a dance shows next, and what keys do to it."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["KEYS", "LEFT", "RIGHT", "SPACE", "Player"]

SPACE, RIGHT, LEFT = 32, 262, 263
"""GLFW's codes of the keys."""

KEYS = {"space": "pause, go on", "right": "a step on", "left": "a step back"}
"""What the keys do, for the user."""


@dataclass
class Player:
    """Goes round and round the steps of a dance.

    Attributes:
        steps: How many there are.
        step: The one that is shown, from 0.
        paused: Whether it stands still.
    """

    steps: int
    step: int = 0
    paused: bool = False

    def advance(self) -> None:
        """Go on by the time of one step."""
        if not self.paused:
            self._move(1)

    def press(self, key: int) -> None:
        """Do what a key asks for; an arrow pauses too, and other keys do nothing.

        Args:
            key: GLFW's code of the key.
        """
        if key == SPACE:
            self.paused = not self.paused
        elif key in (RIGHT, LEFT):
            self.paused = True
            self._move(1 if key == RIGHT else -1)

    def _move(self, steps: int) -> None:
        self.step = (self.step + steps) % self.steps
