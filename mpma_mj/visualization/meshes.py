"""Triangle meshes of geoms and limbs, with faces that are seen from outside."""

from __future__ import annotations

import math

import mujoco
import numpy as np
from numpy.typing import NDArray

__all__ = ["Mesh", "geom_mesh", "limb_mesh"]

Array = NDArray[np.float64]
Mesh = tuple[Array, NDArray[np.int64]]
"""Vertices, shape (V, 3), m; faces as indices of three vertices, shape (F, 3)."""

_FACETS, _RINGS = 20, 8  # around, and from pole to pole (choice)
_PLANE = 5.0  # half a side of a plane without end, m
_LIMB, _JOINT = 0.014, 0.058  # radii of a limb and of the sphere at its end, m

_KINDS = mujoco.mjtGeom


def geom_mesh(model: mujoco.MjModel, geom: int) -> Mesh | None:
    """Return the mesh of a geom in its own frame; None for a kind that is not drawn.

    Args:
        model: Model of the geom.
        geom: Its index.
    """
    kind, size = int(model.geom_type[geom]), model.geom_size[geom]
    if kind == _KINDS.mjGEOM_MESH:
        return _stored_mesh(model, int(model.geom_dataid[geom]))
    if kind == _KINDS.mjGEOM_PLANE:
        return _box(np.array([size[0] or _PLANE, size[1] or _PLANE, 1e-4]))
    if kind == _KINDS.mjGEOM_BOX:
        return _box(size)
    if kind == _KINDS.mjGEOM_CYLINDER:
        return _cylinder(size[0], size[1])
    if kind in (_KINDS.mjGEOM_SPHERE, _KINDS.mjGEOM_ELLIPSOID, _KINDS.mjGEOM_CAPSULE):
        capsule = kind == _KINDS.mjGEOM_CAPSULE
        scale = size if kind == _KINDS.mjGEOM_ELLIPSOID else np.full(3, size[0])
        angle = np.linspace(0.0, math.pi, 2 * _RINGS)
        vertices, faces = _revolve(np.sin(angle), -np.cos(angle))
        vertices = vertices * scale
        if capsule:  # the halves apart
            vertices[:, 2] += np.where(vertices[:, 2] < 0.0, -size[1], size[1])
        return vertices, faces
    return None


def _revolve(radius: Array, z: Array) -> Mesh:
    """Return the surface of a profile, each shape (P,), m, that is turned about the z axis."""
    angle = 2.0 * math.pi * np.arange(_FACETS) / _FACETS
    around = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    vertices = np.empty((len(z), _FACETS, 3))
    vertices[..., :2] = radius[:, None, None] * around
    vertices[..., 2] = z[:, None]
    here = np.arange(len(z) * _FACETS).reshape(len(z), _FACETS)
    low, up = here[:-1], here[1:]
    low_next, up_next = np.roll(low, -1, axis=1), np.roll(up, -1, axis=1)
    faces = [
        np.stack(corners, axis=-1) for corners in ((low, low_next, up_next), (low, up_next, up))
    ]
    return vertices.reshape(-1, 3), np.concatenate(faces).reshape(-1, 3)


def _cylinder(radius: float, half_length: float) -> Mesh:
    """Return a cylinder along z; its edges are sharp, as vertices there are not shared."""
    ends = np.array([-1.0, -1.0, -1.0, 1.0, 1.0, 1.0])
    return _revolve(radius * np.array([0.0, 1.0, 1.0, 1.0, 1.0, 0.0]), half_length * ends)


def _box(half_sides: Array) -> Mesh:
    """Return a box; its edges are sharp, as each side has vertices of its own."""
    vertices: list[Array] = []
    faces: list[NDArray[np.int64]] = []
    square = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], np.float64)
    for axis in range(3):
        for end in (-1.0, 1.0):
            side = np.insert(square if end > 0 else square[::-1], 0, end, axis=1)
            faces.append(np.array([[0, 1, 2], [0, 2, 3]]) + 4 * len(vertices))
            vertices.append(np.roll(side, axis, axis=1) * half_sides)
    return np.concatenate(vertices), np.concatenate(faces)


def limb_mesh(length: float) -> Mesh:
    """Return a thin cylinder from the origin along z, with a sphere at its end.

    Args:
        length: From the origin to the middle of the sphere, m.
    """
    angle = np.linspace(math.asin(_LIMB / _JOINT), math.pi, 2 * _RINGS)
    radius = np.concatenate([[0.0, _LIMB, _LIMB], _JOINT * np.sin(angle)])
    end = length - _JOINT * np.cos(angle)
    return _revolve(radius, np.concatenate([[0.0, 0.0, end[0]], end]))


def _stored_mesh(model: mujoco.MjModel, mesh: int) -> Mesh:
    vertex, face = int(model.mesh_vertadr[mesh]), int(model.mesh_faceadr[mesh])
    vertices = model.mesh_vert[vertex : vertex + int(model.mesh_vertnum[mesh])]
    faces = model.mesh_face[face : face + int(model.mesh_facenum[mesh])]
    return vertices.astype(np.float64), faces.astype(np.int64)
