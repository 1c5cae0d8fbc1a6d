"""A stand-in for MuJoCo's window, for machines without a display."""

import warnings
from collections.abc import Callable
from typing import Any

import mujoco


class Window:
    """What is used of MuJoCo's window."""

    def __init__(
        self,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        *,
        key_callback: Callable[[int], None] | None,
        show_left_ui: bool,
        show_right_ui: bool,
    ) -> None:
        mujoco.mj_forward(model, data)  # as the true one does
        self.model, self.data = model, data
        self.press = key_callback
        self.cam = mujoco.MjvCamera()
        self.user_scn = mujoco.MjvScene(model, 100)
        self.texts: list[Any] = []
        self.open = True
        self.synced = 0

    def is_running(self) -> bool:
        return self.open

    def lock(self) -> Any:
        return warnings.catch_warnings()  # any context

    def set_texts(self, texts: list[Any]) -> None:
        self.texts = texts

    def sync(self) -> None:
        self.synced += 1

    def close(self) -> None:
        self.open = False
