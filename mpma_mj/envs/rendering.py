"""Pictures of the arms and of the demonstration's ghost."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np
from numpy.typing import NDArray

from mpma_mj.envs.cameras import check_camera
from mpma_mj.envs.gl_context import BoundContext
from mpma_mj.envs.physics import PhysicsArms
from mpma_mj.errors import BadOptionError
from mpma_mj.utils.validation import is_integer

__all__: list[str] = ["ArmRenderer", "add_ghost", "checked_mode", "make_renderer"]

Array = NDArray[np.float64]
Picture = NDArray[np.uint8]

_GHOST = np.array([0.10, 0.12, 0.18, 0.35], np.float32)  # rgba
_GHOST_LIMB, _GHOST_JOINT = 0.014, 0.058  # radii, m
_LARGEST = 8192  # width or height of a picture, pixels (choice)
_UPRIGHT = np.eye(3).ravel()


class ArmRenderer:
    """Draws one environment's arms; its OpenGL context is created at the first picture."""

    def __init__(
        self,
        physics: PhysicsArms,
        *,
        width: int = 640,
        height: int = 480,
        camera: str | mujoco.MjvCamera = "front",
    ) -> None:
        """Prepare to draw.

        Args:
            physics: The arms.
            width: Width of pictures, pixels.
            height: Height of pictures, pixels.
            camera: Name of a camera of the model; ours has front, side and three_quarter. Or a
                free camera, which may move between pictures.

        Raises:
            BadOptionError: The model has no such camera, or a size is no whole number.
        """
        _check_size(width=width, height=height)
        if not isinstance(camera, mujoco.MjvCamera):
            check_camera(physics, camera)
        # Larger pictures than the model's buffer are refused by MuJoCo.
        buffer = physics.model.ptr.vis.global_
        buffer.offwidth, buffer.offheight = (
            max(buffer.offwidth, width),
            max(buffer.offheight, height),
        )
        self._physics = physics
        self._size = (height, width)
        self._camera = camera
        self._renderer: BoundContext[mujoco.Renderer] | None = None

    def picture(self, ghost: Array | None = None) -> Picture:
        """Draw the arms in their present state.

        Args:
            ghost: Demonstrated posture, shape (12,), drawn translucent at the size of the arms.

        Returns:
            Picture, shape (height, width, 3).

        Raises:
            RenderingError: OpenGL does not draw, as in a process that was forked from one that
                has drawn, or in another thread than the first picture.
        """
        if self._renderer is None:
            self._renderer = BoundContext(self._make, mujoco.Renderer.close)
        renderer = self._renderer.get()
        # Kinematic arms do not update cameras and lights, which a model may attach to its arms.
        mujoco.mj_camlight(self._physics.model.ptr, self._physics.data.ptr)
        renderer.update_scene(self._physics.data.ptr, self._camera)
        if ghost is not None:
            add_ghost(renderer.scene, self._physics, ghost)
        return renderer.render()

    def close(self) -> None:
        """Release the OpenGL context."""
        if self._renderer is not None:
            self._renderer.release()
            self._renderer = None

    def _make(self) -> mujoco.Renderer:
        return mujoco.Renderer(self._physics.model.ptr, *self._size)


def checked_mode(mode: object, modes: Sequence[str]) -> str | None:
    """Return a mode of rendering, or None for no pictures.

    Raises:
        BadOptionError: It is none of the modes that there are.
    """
    if mode is not None and not (isinstance(mode, str) and mode in modes):
        expected = f"{' or '.join(modes)}, or None for no pictures"
        raise BadOptionError(option="render_mode", value=mode, expected=expected)
    return mode


def make_renderer(
    physics: PhysicsArms, mode: str | None, *, width: int, height: int, camera: str
) -> ArmRenderer | None:
    """Check the view of an environment; return its renderer, or None if it returns no pictures.

    Args:
        physics: The arms.
        mode: "rgb_array" if there are to be pictures.
        width: Width of pictures, pixels.
        height: Height of pictures, pixels.
        camera: Name of a camera of the model; without pictures, "front" need not exist.

    Raises:
        BadOptionError: The model has no such camera, or a size is no whole number.
    """
    if mode == "rgb_array":
        return ArmRenderer(physics, width=width, height=height, camera=camera)
    _check_size(width=width, height=height)
    if not (isinstance(camera, str) and camera == "front"):  # an array is neither
        check_camera(physics, camera)
    return None


def _check_size(**sizes: object) -> None:
    for name, size in sizes.items():
        if not (is_integer(size) and 1 <= int(size) <= _LARGEST):
            expected = f"a whole number of pixels from 1 to {_LARGEST}"
            raise BadOptionError(option=name, value=size, expected=expected)


def add_ghost(scene: mujoco.MjvScene, physics: PhysicsArms, posture: Array) -> None:
    """Add a translucent posture to a scene, at the size and place of the arms.

    Args:
        scene: Scene of the arms.
        physics: The arms.
        posture: Demonstrated posture, shape (12,).
    """
    for shoulder, elbow, wrist in physics.site_positions(posture):
        for start, end in ((shoulder, elbow), (elbow, wrist)):
            limb = _new_geom(scene, mujoco.mjtGeom.mjGEOM_CAPSULE, _GHOST_LIMB, start)
            mujoco.mjv_connector(limb, mujoco.mjtGeom.mjGEOM_CAPSULE, _GHOST_LIMB, start, end)
        for joint in (elbow, wrist):
            _new_geom(scene, mujoco.mjtGeom.mjGEOM_SPHERE, _GHOST_JOINT, joint)


def _new_geom(
    scene: mujoco.MjvScene, kind: mujoco.mjtGeom, radius: float, position: Array
) -> mujoco.MjvGeom:
    geom = scene.geoms[scene.ngeom]
    mujoco.mjv_initGeom(geom, kind, np.full(3, radius), position, _UPRIGHT, _GHOST)
    scene.ngeom += 1
    return geom
