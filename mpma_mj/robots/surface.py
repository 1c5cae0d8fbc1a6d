"""Surfaces of geoms: which are seen, how far they reach, and what is farthest from a point."""

from __future__ import annotations

import functools
from collections.abc import Iterable

import mujoco
import numpy as np
from numpy.typing import NDArray

__all__ = ["bodies_below", "lowest_point", "middle_of_farthest", "reach", "seen_geoms"]

Array = NDArray[np.float64]

_GROUPS = 3  # number of groups of geoms that MuJoCo draws by default
_DIRECTIONS = 500  # in which a surface without vertices is sampled (choice)
_TIP = 0.1  # part of the farthest distance, at its end, whose middle is taken (choice)


def bodies_below(model: mujoco.MjModel, body: int) -> list[int]:
    """Return a body and all that hang on it, in MuJoCo's order, parents first."""
    found = [body]
    for other in range(body + 1, model.nbody):
        if int(model.body_parentid[other]) in found:
            found.append(other)
    return found


def seen_geoms(model: mujoco.MjModel, below: int = 0) -> list[int]:
    """Return the geoms that are drawn, of a body and all that hang on it; all where none is.

    Args:
        model: The model.
        below: Index of the body; 0 is the world.
    """
    bodies = bodies_below(model, below)
    geoms = [geom for geom in range(model.ngeom) if int(model.geom_bodyid[geom]) in bodies]
    return [geom for geom in geoms if _is_seen(model, geom)] or geoms


def _is_seen(model: mujoco.MjModel, geom: int) -> bool:
    material = int(model.geom_matid[geom])
    alpha = model.geom_rgba[geom, 3] * (model.mat_rgba[material, 3] if material >= 0 else 1.0)
    return bool(model.geom_group[geom] < _GROUPS and alpha > 0.0)


def lowest_point(
    model: mujoco.MjModel, data: mujoco.MjData, geoms: Iterable[int], up: Array
) -> float:
    """Return how high the lowest point of geoms is, m, along a unit vector; inf where none is."""
    heights = _surfaces(model, data, geoms, -up[None]) @ up
    return float(heights.min(initial=np.inf))


def reach(model: mujoco.MjModel, data: mujoco.MjData, geoms: Iterable[int], point: Array) -> float:
    """Return the distance, m, from a point, shape (3,), to the farthest point of geoms."""
    points = _surfaces(model, data, geoms, _all_directions())
    return float(np.linalg.norm(points - point, axis=1).max(initial=0.0))


def middle_of_farthest(
    model: mujoco.MjModel, data: mujoco.MjData, geoms: Iterable[int], point: Array
) -> Array:
    """Return the mean of the vertices that are farthest from a point: in a tenth of the distance.

    Args:
        model: The model.
        data: Its simulation.
        geoms: Indices of the geoms.
        point: The point, shape (3,), m, in the world frame.

    Returns:
        Their mean, shape (3,), m; the point itself where there are none.
    """
    points = _surfaces(model, data, geoms, _all_directions())
    distances = np.linalg.norm(points - point, axis=1)
    far = points[distances >= (1.0 - _TIP) * distances.max(initial=0.0)]
    return far.mean(axis=0) if len(far) else point.copy()


def _surfaces(
    model: mujoco.MjModel, data: mujoco.MjData, geoms: Iterable[int], directions: Array
) -> Array:
    each = [_surface(model, data, geom, directions) for geom in geoms]
    return np.concatenate([np.empty((0, 3)), *each])


def _surface(model: mujoco.MjModel, data: mujoco.MjData, geom: int, directions: Array) -> Array:
    """Return the vertices of a mesh, or the points of a geom that are farthest in some directions.

    Args:
        model: The model.
        data: Its simulation.
        geom: Index of the geom.
        directions: Unit vectors, shape (N, 3), in the world frame.

    Returns:
        Points, shape (P, 3), m, in the world frame; none of a kind that has no such surface.
    """
    rotation = data.geom_xmat[geom].reshape(3, 3)
    own, size = directions @ rotation, model.geom_size[geom]
    shape = mujoco.mjtGeom
    match int(model.geom_type[geom]):
        case shape.mjGEOM_MESH:
            mesh = int(model.geom_dataid[geom])
            start = int(model.mesh_vertadr[mesh])
            points = model.mesh_vert[start : start + int(model.mesh_vertnum[mesh])]
        case shape.mjGEOM_SPHERE:
            points = size[0] * own
        case shape.mjGEOM_CAPSULE:
            points = size[0] * own
            points[:, 2] += size[1] * np.sign(own[:, 2])
        case shape.mjGEOM_ELLIPSOID:
            points = size**2 * own / np.linalg.norm(size * own, axis=1, keepdims=True)
        case shape.mjGEOM_CYLINDER:
            across = np.maximum(np.hypot(own[:, :1], own[:, 1:2]), 1e-12)
            points = np.hstack([size[0] * own[:, :2] / across, size[1] * np.sign(own[:, 2:])])
        case shape.mjGEOM_BOX:
            points = size * np.sign(own)
        case _:
            return np.empty((0, 3))
    return data.geom_xpos[geom] + points @ rotation.T


@functools.cache
def _all_directions() -> Array:
    """Return unit vectors that cover the sphere evenly, shape (N, 3): a spiral of Fibonacci."""
    index = np.arange(_DIRECTIONS) + 0.5
    z, angle = 1.0 - 2.0 * index / _DIRECTIONS, np.pi * (1.0 + 5.0**0.5) * index
    across = np.sqrt(1.0 - z * z)
    return np.stack([across * np.cos(angle), across * np.sin(angle), z], axis=1)
