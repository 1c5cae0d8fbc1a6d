"""Parts of URDF files that MuJoCo refuses, though arms do without them."""

from __future__ import annotations

import os
from pathlib import Path

import mujoco
import numpy as np
from numpy.typing import NDArray

__all__ = ["mend_urdf", "unread_meshes"]

Array = NDArray[np.float64]

_MESHES = (".stl", ".obj", ".msh")  # which MuJoCo reads
# Smallest mass and moments of inertia, which links of no mass get (choice: next to nothing).
_MASS, _INERTIA = 1e-6, 1e-9  # kg, kg m²
_LEAST = 1e-12  # kg m², which MuJoCo takes for a positive moment


def mend_urdf(spec: mujoco.MjSpec) -> None:
    """Change a model that was read from a URDF so that it compiles.

    Geoms of meshes in formats that MuJoCo does not read are left out; what is seen of the scene
    stays; links of impossible mass and inertia, such as mere frames, get possible ones. Links that
    have both as they should keep them.
    """
    compiler = spec.compiler
    compiler.discardvisual, compiler.balanceinertia = False, True
    compiler.boundmass, compiler.boundinertia = _MASS, _INERTIA
    left_out = {mesh.name for mesh in spec.meshes if not _is_read(mesh.file)}
    for geom in list(spec.geoms):
        if geom.meshname in left_out:
            spec.delete(geom)
    for mesh in list(spec.meshes):
        if mesh.name in left_out:
            spec.delete(mesh)
        else:
            mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL  # some have no volume
    for body in spec.bodies:
        if body.explicitinertial and not _moments(body.fullinertia)[0] > _LEAST:
            body.fullinertia, body.inertia = np.full(6, np.nan), np.full(3, _INERTIA)


def unread_meshes(path: Path) -> tuple[str, ...]:
    """Return the files that a URDF names and `mend_urdf` leaves out; none for an MJCF.

    Args:
        path: The model, which has been read before.
    """
    if path.suffix.lower() != ".urdf":
        return ()
    meshes = mujoco.MjSpec.from_file(os.fsencode(path)).meshes
    return tuple(mesh.file for mesh in meshes if not _is_read(mesh.file))


def _is_read(file: str) -> bool:
    return Path(file).suffix.lower() in _MESHES


def _moments(full: Array) -> Array:
    """Return the principal moments of inertia, ascending, from xx, yy, zz, xy, xz and yz."""
    matrix = np.nan_to_num(full)[[[0, 3, 4], [3, 1, 5], [4, 5, 2]]]
    return np.asarray(np.linalg.eigvalsh(matrix))
