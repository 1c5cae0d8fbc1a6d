"""Cameras: those of a model, a free one, and one in orbit around the arms."""

from __future__ import annotations

import math

import mujoco
import numpy as np

from mpma_mj.envs.physics import PhysicsArms
from mpma_mj.errors import BadOptionError
from mpma_mj.utils.text import did_you_mean

__all__ = ["check_camera", "free_camera", "orbit_camera"]

_FROM_ABOVE = 10.0  # degrees by which the camera in orbit looks down (choice)
_HANDS = 1.2  # arms with hands, relative to arms up to the wrists (choice)


def check_camera(physics: PhysicsArms, camera: object, *others: str) -> None:
    """Check the name of a camera.

    Args:
        physics: The arms.
        camera: The name.
        others: Names that are right besides those of the model's cameras.

    Raises:
        BadOptionError: The model has no such camera.
    """
    cameras = [physics.model.id2name(i, "camera") for i in range(physics.model.ncam)]
    if not (isinstance(camera, str) and camera in (*cameras, *others)):
        expected = f"one of the model's cameras: {', '.join(cameras) or 'none'}"
        expected += "".join(f", or {name}" for name in others)
        near = did_you_mean(camera, (*cameras, *others)) if isinstance(camera, str) else ""
        raise BadOptionError(option="camera", value=camera, expected=expected, remedy=near)


def free_camera(physics: PhysicsArms, camera: str) -> mujoco.MjvCamera:
    """Return a camera that looks as one of the model does, but can be moved.

    It turns about the point of its axis that is nearest to the shoulders. A model without "front"
    is seen as by `orbit_camera`.

    Args:
        physics: The arms.
        camera: Name of a camera of the model.

    Raises:
        BadOptionError: The model has no such camera.
    """
    number = mujoco.mj_name2id(physics.model.ptr, mujoco.mjtObj.mjOBJ_CAMERA, camera)
    middle = orbit_camera(physics)
    if number < 0:
        if camera != "front":
            check_camera(physics, camera)
        return middle
    mujoco.mj_camlight(physics.model.ptr, physics.data.ptr)
    place, ahead = physics.data.cam_xpos[number], -physics.data.cam_xmat[number].reshape(3, 3)[:, 2]
    free = mujoco.MjvCamera()
    free.distance = max(float(ahead @ (middle.lookat - place)), 0.1)
    free.lookat[:] = place + free.distance * ahead
    free.azimuth = math.degrees(math.atan2(ahead[1], ahead[0]))
    free.elevation = math.degrees(math.asin(max(-1.0, min(1.0, ahead[2]))))
    return free


def orbit_camera(physics: PhysicsArms, aspect: float = 1.0) -> mujoco.MjvCamera:
    """Return a camera that sees the arms in every posture, from the front; its azimuth turns it.

    Args:
        physics: The arms, of any model.
        aspect: Width of pictures relative to their height.
    """
    shoulders = physics.site_positions(np.zeros(12))[:, 0]
    lengths = physics.segment_lengths.reshape(2, 2)
    apart = float(np.linalg.norm(shoulders[0] - shoulders[1]))
    radius = apart / 2.0 + _HANDS * float(lengths.sum(axis=1).max())
    half = math.radians(float(physics.model.vis.global_.fovy)) / 2.0
    half = min(half, math.atan(aspect * math.tan(half)))
    camera = mujoco.MjvCamera()
    camera.lookat[:] = shoulders.mean(axis=0)
    camera.distance = radius / math.sin(half)
    camera.azimuth, camera.elevation = 180.0, -_FROM_ABOVE
    return camera
