"""Figure with a face in arm poses, drawn for a detector of people: dm_control's humanoid."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from mpma_mj.envs.frame_writer import frame_writer

Array = NDArray[np.float64]
Picture = NDArray[np.uint8]

_SEGMENTS = [
    (f"{side}{start}", f"{side}{end}")
    for side in "lr"
    for start, end in (("humerus", "radius"), ("radius", "hand"))
]
_SKIN, _HAIR, _LIP = (0.82, 0.62, 0.5, 1.0), (0.12, 0.08, 0.05, 1.0), (0.6, 0.2, 0.2, 1.0)
# Ellipsoids of a head: place (x to the left ear, y up, z forward) and half axes, m; colour.
_HEAD: list[tuple[tuple[float, ...], tuple[float, ...], tuple[float, ...]]] = [
    ((0.0, 0.1, 0.02), (0.078, 0.115, 0.095), _SKIN),
    ((0.0, 0.135, 0.002), (0.084, 0.095, 0.098), _HAIR),
    ((0.0, 0.085, 0.118), (0.013, 0.024, 0.018), (0.75, 0.52, 0.42, 1.0)),
    ((0.0, 0.04, 0.103), (0.028, 0.008, 0.012), _LIP),
]
for _x in (-1.0, 1.0):
    _HEAD += [
        ((0.031 * _x, 0.112, 0.103), (0.017, 0.009, 0.012), (1.0, 1.0, 1.0, 1.0)),
        ((0.031 * _x, 0.112, 0.112), (0.007, 0.008, 0.006), _HAIR),
        ((0.031 * _x, 0.132, 0.105), (0.02, 0.005, 0.01), _HAIR),
        ((0.079 * _x, 0.095, 0.02), (0.012, 0.03, 0.02), _SKIN),
    ]
_EASE = 0.02  # weight of small joint angles, against 1 of directions (choice)


class Figure:
    """People who stand side by side and hold the same pose.

    Attributes:
        posture: Directions of the arms' segments, shape (12,), as in `Motion.posture`.
    """

    def __init__(
        self, people: Sequence[float] = (0.0,), *, hidden: str = "", size: int = 384
    ) -> None:
        """Build them.

        Args:
            people: Where each stands, m to the right in the picture.
            hidden: Arms that are not drawn: "", "l", "r" or "lr".
            size: Width and height of pictures, pixels.
        """
        from dm_control import mjcf
        from dm_control.locomotion.soccer import Humanoid
        from dm_control.mujoco.engine import MovableCamera

        arena = mjcf.RootElement()
        arena.compiler.angle = "radian"  # as the walker's
        arena.visual.headlight.ambient = [0.45] * 3
        getattr(arena.visual, "global").offwidth = size
        getattr(arena.visual, "global").offheight = size
        sky = {"type": "skybox", "builtin": "gradient", "width": 64, "height": 64}
        arena.asset.add("texture", rgb1=[0.6, 0.7, 0.85], rgb2=[0.8, 0.85, 0.95], **sky)
        arena.worldbody.add("geom", type="plane", size=[8, 8, 0.1], rgba=[0.4, 0.52, 0.4, 1])
        light = {"pos": [2, -3, 5], "dir": [-0.3, 0.5, -0.8], "diffuse": [0.6] * 3}
        arena.worldbody.add("light", directional=True, **light)
        jersey = Humanoid.Visual.JERSEY
        for number, across in enumerate(people):
            walker = Humanoid(
                jersey, [1.0, 0.0, 0.0, 1.0], walker_id=number, name=f"person{number}"
            )
            head = walker.mjcf_model.find("body", "head")
            for place, axes, colour in _HEAD:
                shape = {"type": "ellipsoid", "pos": place, "size": axes, "rgba": colour}
                head.add("geom", mass=0, contype=0, conaffinity=0, **shape)
            for side in hidden:
                for part in ("humerus", "radius", "wrist", "hand", "fingers", "thumb"):
                    for geom in walker.mjcf_model.find("body", side + part).find_all(
                        "geom", immediate_children_only=True
                    ):
                        geom.rgba = [0, 0, 0, 0]
            site = arena.worldbody.add(
                "site", pos=[across, 0, 1.05], quat=[0.5**0.5, 0.5**0.5, 0, 0]
            )
            site.attach(walker.mjcf_model)
        physics = mjcf.Physics.from_mjcf_model(arena)
        self._physics: Any = physics  # which owns model and data
        self._model, self._data = physics.model.ptr, physics.data.ptr
        model, data = self._model, self._data
        mujoco.mj_forward(model, data)
        self._camera = MovableCamera(physics, size, size)
        self._people = [self._joints(f"person{number}/") for number in range(len(people))]
        body = self._bodies("person0/")
        up = data.xpos[body["thorax"]] - data.xpos[body["root"]]
        left = data.xpos[body["lhumerus"]] - data.xpos[body["rhumerus"]]
        left, up = left / np.linalg.norm(left), up / np.linalg.norm(up)
        self._torso = np.stack([np.cross(left, up), left, up])  # forward, left, up

    def _bodies(self, prefix: str) -> dict[str, int]:
        names = [self._model.body(i).name for i in range(self._model.nbody)]
        return {name[len(prefix) :]: i for i, name in enumerate(names) if name.startswith(prefix)}

    def _joints(self, prefix: str) -> list[int]:
        model = self._model
        names = [model.joint(i).name for i in range(model.njnt)]
        arms = ("humerus", "radius", "wrist")
        return [
            i for i, n in enumerate(names) if n.startswith(prefix) and any(a in n for a in arms)
        ]

    @property
    def posture(self) -> Array:
        """Directions of upper arm and forearm, left and right, (forward, left, up), shape (12,)."""
        body, places = self._bodies("person0/"), self._data.xpos
        ways = np.array([places[body[end]] - places[body[start]] for start, end in _SEGMENTS])
        return (ways / np.linalg.norm(ways, axis=1, keepdims=True) @ self._torso.T).ravel()

    def pose(self, posture: Array) -> None:
        """Bring the arms as close to a posture, shape (12,), as their joints allow."""
        model, data = self._model, self._data
        joints = self._people[0]
        places, low = model.jnt_qposadr[joints], model.jnt_range[joints, 0]
        high = model.jnt_range[joints, 1]

        def off(angles: Array) -> Array:
            data.qpos[places] = angles
            mujoco.mj_kinematics(model, data)
            return np.concatenate([self.posture - posture, _EASE * angles])

        rng = np.random.default_rng(0)
        starts = [data.qpos[places], *rng.normal(0.0, 0.4, (3, len(places)))]
        best = None
        for start in starts:
            found = least_squares(off, np.clip(start, low + 1e-3, high - 1e-3), bounds=(low, high))
            if best is None or found.cost < best.cost:
                best = found
            if best.cost < 0.02:
                break
        assert best is not None
        for joints in self._people:
            data.qpos[model.jnt_qposadr[joints]] = best.x
        mujoco.mj_forward(model, data)

    def draw(self, *, turn: float = 0.0, distance: float = 3.2) -> Picture:
        """Draw them, shape (size, size, 3).

        Args:
            turn: How far they face away from the camera, degrees.
            distance: From the camera, m.
        """
        forward = self._torso[0]
        azimuth = np.degrees(np.arctan2(-forward[1], -forward[0])) + turn
        self._camera.set_pose([0.0, 0.0, 1.2], distance, azimuth, -5.0)
        return self._camera.render().copy()


def posture_of(angles: Sequence[float], forward: Sequence[float] = (0.0,) * 4) -> Array:
    """Return the posture of arms, shape (12,), by angles in degrees.

    Args:
        angles: Of each segment in the frontal plane: 0 down, 90 outwards, 180 up.
        forward: Of each segment out of that plane.
    """
    outwards = np.array([1.0, 1.0, -1.0, -1.0])
    a, f = np.radians(angles), np.radians(forward)
    across, up = outwards * np.sin(a) * np.cos(f), -np.cos(a) * np.cos(f)
    return np.stack([np.sin(f), across, up], axis=1).ravel()


def write_clip(path: Path, pictures: Iterable[Picture], rate: float = 20.0) -> Path:
    """Write pictures as a video, of a format by its ending."""
    pictures = list(pictures)
    with frame_writer(path, pictures[0].shape[:2], rate) as write:
        for picture in pictures:
            write(picture)
    return path
