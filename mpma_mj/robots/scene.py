"""The scene of two_arm.xml around a robot: light, sky, floor and cameras, as large as it needs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

__all__ = ["TWO_ARM_MODEL", "add_scene"]

Array = NDArray[np.float64]

TWO_ARM_MODEL = Path(__file__).parent.parent / "assets" / "two_arm.xml"
"""Model of the package's own arms."""

_PREFIX = "scene_"  # of names that a robot may have, too
_REACH = 0.19 + 0.2817 + 0.2689 + 0.148  # m, from the middle of its shoulders to a fingertip
_TEXTURE = ("type", "builtin", "rgb1", "rgb2", "width", "height")
_MATERIAL = ("specular", "shininess", "reflectance", "emission", "rgba")
_LIGHT = ("name", "type", "dir", "ambient", "diffuse", "specular", "castshadow")
_GEOM = ("name", "type", "contype", "conaffinity", "group", "rgba")


def add_scene(spec: mujoco.MjSpec, shoulders: Array, reach: float) -> None:
    """Add the scene to a robot, which stands on the floor at z = 0 and looks along x.

    What is drawn, gravity and the integrator become those of two_arm.xml. Cameras see the shoulders
    as they do there, with pictures as wide as the arms.

    Args:
        spec: The robot, without lights and cameras.
        shoulders: Middle of the shoulders, shape (3,), m.
        reach: Distance from there to the farthest fingertip, m.
    """
    own = mujoco.MjSpec.from_file(str(TWO_ARM_MODEL))
    model, middle, scale = own.compile(), own.body("torso").pos, reach / _REACH
    empty = mujoco.MjSpec()  # whose defaults are MuJoCo's, not the robot's own
    spec.option, spec.visual, spec.stat = own.option, own.visual, empty.stat
    for texture in list(spec.textures):
        if texture.type == mujoco.mjtTexture.mjTEXTURE_SKYBOX:
            spec.delete(texture)
    for texture in own.textures:
        spec.add_texture(
            empty.default, name=_PREFIX + texture.name, **_attributes(texture, _TEXTURE)
        )
    world = spec.worldbody
    for light in own.worldbody.lights:
        world.add_light(empty.default, pos=scale * light.pos, **_attributes(light, _LIGHT))
    for camera in own.worldbody.cameras:
        world.add_camera(
            empty.default,
            name=camera.name,
            pos=shoulders + scale * (camera.pos - middle),
            quat=model.camera(camera.name).quat,
            fovy=camera.fovy,
        )
    for geom in own.worldbody.geoms:
        if (namesake := spec.geom(geom.name)) is not None:
            namesake.name = f"{geom.name}_of_robot"
        look = own.material(geom.material)
        material = spec.add_material(
            empty.default, name=_PREFIX + look.name, **_attributes(look, _MATERIAL)
        )
        material.textures = [name and _PREFIX + name for name in look.textures]
        world.add_geom(
            empty.default,
            pos=scale * geom.pos,
            size=scale * geom.size,
            material=material.name,
            **_attributes(geom, _GEOM),
        )


def _attributes(element: Any, names: tuple[str, ...]) -> dict[str, Any]:
    return {name: getattr(element, name) for name in names}
