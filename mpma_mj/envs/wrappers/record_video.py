"""Videos of episodes, drawn while an agent acts."""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import Any

import dm_env
import mujoco
import numpy as np
from numpy.typing import NDArray

from mpma_mj.envs.frame_writer import WriteFrame, frame_writer
from mpma_mj.envs.rendering import ArmRenderer
from mpma_mj.envs.wrappers.base import Wrapper
from mpma_mj.errors import BadOptionError, StateError

__all__: list[str] = ["RecordVideo"]

Array = NDArray[np.float64]

_NUMBER = "{episode}"


class RecordVideo(Wrapper):
    """Draws every moment of every episode, arms and ghost, into a video that runs in real time.

    Frames are passed to the encoder one by one. A video is written to a temporary name and renamed
    when its episode ends, `reset` breaks it off, or `close` is called. An episode without a step
    has no video.
    """

    def __init__(self, env: dm_env.Environment, path: str | Path, camera: str = "front") -> None:
        """Wrap an environment.

        Args:
            env: Environment that `mpma_mj.load` returned, perhaps wrapped.
            path: The `.mp4` file; "{episode}" in it is replaced by the episode's number, from 0.
                Without it the video of an episode replaces that of the one before.
            camera: Name of a camera of the model: front, side or three_quarter.

        Raises:
            BadOptionError: The path does not end in .mp4, or the model has no such camera.
        """
        super().__init__(env)
        if not isinstance(path, str | Path) or Path(path).suffix != ".mp4":
            raise BadOptionError(
                option="path", value=str(path), expected="a file name that ends in .mp4"
            )
        if "{" in str(path).replace(_NUMBER, ""):
            expected = f"no braces but those of {_NUMBER}"
            raise BadOptionError(option="path", value=str(path), expected=expected)
        self._path = str(path)
        self._renderer = ArmRenderer(env.physics, camera=camera)
        self._video = contextlib.ExitStack()
        self._write: WriteFrame | None = None
        self._ghost: Array | None = None
        self._episode = -1

    def __getstate__(self) -> dict[str, Any]:
        """Refuse to be pickled or copied, as an OpenGL context cannot be."""
        raise StateError("RecordVideo cannot be pickled or copied; copy the environment inside")

    def reset(self) -> dm_env.TimeStep:
        """Begin an episode; finish the video of the one before."""
        self._finish()
        return super().reset()

    def step(self, action: Array) -> dm_env.TimeStep:
        """Act; draw the moment before and, where the episode ends, the one after.

        Args:
            action: Action, shape (8,), in [-1, 1].

        Raises:
            RenderingError: OpenGL does not draw.
            VideoError: The encoder is missing, or fails; the episode continues without a video.
            RunFolderError: The video's folder cannot be written.
        """
        if self._ghost is not None:
            self._draw()
        return super().step(action)

    def close(self) -> None:
        """Finish the video, release the OpenGL context, close the environment inside."""
        try:
            self._finish()
        finally:
            self._renderer.close()
            super().close()

    def _on_begin(self, timestep: dm_env.TimeStep) -> None:
        self._episode += 1
        self._ghost = timestep.observation["reference"].copy()

    def _on_step(self, timestep: dm_env.TimeStep) -> None:
        self._ghost = timestep.observation["reference"].copy()
        if timestep.last():
            self._draw()
            self._finish()

    def _draw(self) -> None:
        """Draw the arms; a video that cannot be written is given up."""
        physics = self._env.physics
        try:
            # An environment need not bring positions up to date after a step.
            mujoco.mj_kinematics(physics.model.ptr, physics.data.ptr)
            picture = self._renderer.picture(ghost=self._ghost)
            if self._write is None:
                self._write = self._open(picture.shape[:2])
            self._write(picture)
        except BaseException as error:
            self._ghost = self._write = None
            self._video.__exit__(type(error), error, error.__traceback__)
            raise

    def _open(self, size: tuple[int, int]) -> WriteFrame:
        path = Path(self._path.replace(_NUMBER, str(self._episode)))
        rate = 1.0 / self._env.control_timestep()
        return self._video.enter_context(frame_writer(path, size, rate))

    def _finish(self) -> None:
        self._ghost = self._write = None
        self._video.close()
