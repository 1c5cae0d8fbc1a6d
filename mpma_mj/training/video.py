"""The video of a trained run."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

import imageio.v2 as imageio
import mujoco
import numpy as np
from numpy.typing import NDArray

from mpma_mj.envs.physics import PhysicsArms
from mpma_mj.envs.rendering import ArmRenderer
from mpma_mj.files import write_whole
from mpma_mj.motions import Motion
from mpma_mj.training.strip import Strip

__all__ = ["dance_frames", "write_video"]

Array = NDArray[np.float64]
Picture = NDArray[np.uint8]
Progress = Callable[[range], Iterable[int]]


def write_video(
    path: Path,
    trace: dict[str, Array],
    motion: Motion,
    *,
    camera: str = "front",
    bands: tuple[str, ...] = (),
    progress: Progress = iter,
) -> None:
    """Draw the kept epoch: arms, ghost, letters, responsibilities.

    Frames go to the encoder one by one; the video plays as fast as the dance.

    Args:
        path: The `.mp4` file.
        trace: Signals of the epoch.
        motion: The movement that was imitated.
        camera: Camera of the model.
        bands: Names of the bands below; the modules' numbers if not given.
        progress: Wraps the range of frames, to show how far it is.

    Raises:
        RenderingError: OpenGL does not draw.
    """

    def encode(temporary: Path) -> None:
        with imageio.get_writer(temporary, fps=motion.rate, codec="libx264", quality=7) as writer:
            frames = dance_frames(trace, motion, camera=camera, bands=bands, progress=progress)
            for frame in frames:
                writer.append_data(frame)  # type: ignore[attr-defined] # of its stubs

    write_whole(path, encode)


def dance_frames(
    trace: dict[str, Array],
    motion: Motion,
    *,
    camera: str = "front",
    bands: tuple[str, ...] = (),
    progress: Progress = iter,
) -> Iterator[Picture]:
    """Draw an epoch frame by frame, one a control step.

    Args:
        trace: Signals of the epoch.
        motion: The movement that was imitated.
        camera: Camera of the model.
        bands: Names of the bands below; the modules' numbers if not given.
        progress: Wraps the range of frames.

    Yields:
        Pictures, shape (576, 640, 3).
    """
    strip = Strip(trace["responsibility"], trace["context"][:-1], motion.labels, bands=bands)
    physics = PhysicsArms.make()
    with contextlib.closing(ArmRenderer(physics, camera=camera)) as renderer:
        for step in progress(range(len(trace["action"]))):
            physics.data.qpos[:] = trace["joint_angles"][step]
            mujoco.mj_kinematics(physics.model.ptr, physics.data.ptr)
            yield strip.under(renderer.picture(ghost=trace["reference"][step]), step)
