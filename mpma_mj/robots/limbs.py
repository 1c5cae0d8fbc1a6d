"""Limbs of a model: pairs of paths of hinges from the torso outward."""

from __future__ import annotations

import itertools
import re

import mujoco
import numpy as np
from numpy.typing import NDArray

__all__ = [
    "Limb",
    "are_alike",
    "are_called_otherwise",
    "are_mirrored",
    "hinge_name",
    "limb_pairs",
    "lone_limb",
    "turning_about_shoulder",
]

Array = NDArray[np.float64]
Limb = tuple[int, ...]
"""Indices of hinges, from the torso outward."""

_HINGE = mujoco.mjtJoint.mjJNT_HINGE
_NEAR = 0.1  # of a limb's length, by which hinges of the other may be elsewhere (choice)
_ABOUT = 0.3  # of a limb's length, within which hinges turn about its first two (choice)

# In names: what arms are not called, unless they are called arms, too.
_NO_ARM = re.compile(
    r"leg|hip|thigh|calf|knee|ankle|foot|toe|femur|tibia|finger|thumb|index|middle|ring|pinky"
    r"|wheel|gripper|neck|head",
    re.IGNORECASE,
)
_ARM = re.compile(r"arm|shoulder|clavic|humer|elbow|wrist", re.IGNORECASE)


def limb_pairs(model: mujoco.MjModel) -> list[tuple[Limb, Limb]]:
    """Return pairs of paths that have equally many hinges and begin where they part.

    What both share, as a waist, belongs to neither. There is a pair for any two hinges, as their
    ends.
    """
    pairs = []
    for one, other in itertools.combinations(_paths(model), 2):
        shared = sum(a == b for a, b in zip(one, other, strict=False))
        if len(one) == len(other) > shared:
            pairs.append((one[shared:], other[shared:]))
    return pairs


def lone_limb(model: mujoco.MjModel) -> Limb:
    """Return the longest path of hinges that are not called legs, fingers or the like."""
    paths = (path for path in _paths(model) if not are_called_otherwise(model, path[-4:]))
    return max(paths, key=len, default=())


def hinge_name(model: mujoco.MjModel, hinge: int) -> str:
    """Return the name of a hinge, or what to call it where it has none."""
    body = model.body(int(model.jnt_bodyid[hinge])).name
    return str(model.joint(hinge).name) or f"an unnamed joint of {body or 'an unnamed body'}"


def are_called_otherwise(model: mujoco.MjModel, hinges: Limb) -> bool:
    """Return whether hinges are called legs, fingers or the like."""
    names = [hinge_name(model, hinge) for hinge in hinges]
    return any(_NO_ARM.search(name) and not _ARM.search(name) for name in names)


def are_mirrored(data: mujoco.MjData, limbs: tuple[Limb, Limb]) -> bool:
    """Return whether the hinges of a limb are at mirror images of those of the other."""
    one, other = (data.xanchor[list(limb)] for limb in limbs)
    across = (one - other).sum(axis=0)
    apart = float(np.linalg.norm(across))
    if apart == 0.0:
        return False
    across /= apart
    middle = 0.5 * (one + other).mean(axis=0)
    image = other - 2.0 * ((other - middle) @ across)[:, None] * across
    return bool(np.abs(one - image).max() <= _NEAR * np.abs(one - one[:, None]).max())


def are_alike(data: mujoco.MjData, limbs: tuple[Limb, Limb]) -> bool:
    """Return whether hinges of a limb follow one another as far apart as those of the other."""
    one, other = (
        np.linalg.norm(np.diff(data.xanchor[list(limb)], axis=0), axis=1) for limb in limbs
    )
    return bool((np.abs(one - other) <= _NEAR * one.sum()).all())


def turning_about_shoulder(data: mujoco.MjData, limb: Limb) -> int:
    """Return how many of the first hinges of a limb turn about one place."""
    anchors, axes = data.xanchor[list(limb)], data.xaxis[list(limb)]
    near = _ABOUT * np.linalg.norm(anchors[-1] - anchors[0])
    off = np.linalg.norm(np.cross(anchors[0] - anchors, axes), axis=1)
    return int(np.argmin([*(off <= near), False]))


def _paths(model: mujoco.MjModel) -> list[Limb]:
    """Return for each hinge the path of hinges that ends with it, from the world outward."""
    hinges = [joint for joint in range(model.njnt) if model.jnt_type[joint] == _HINGE]
    paths = []
    for hinge in hinges:
        above = [int(model.jnt_bodyid[hinge])]
        while above[-1]:
            above.append(int(model.body_parentid[above[-1]]))
        paths.append(tuple(h for h in hinges if h <= hinge and model.jnt_bodyid[h] in above))
    return paths
