"""Guesses of what is up for a torso, and which of two arms is the left one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from mpma_mj.robots.limbs import Limb, hinge_name
from mpma_mj.robots.surface import bodies_below

__all__ = ["UPS", "guess_up", "is_left"]

Array = NDArray[np.float64]
Direction = tuple[float, float, float]

UPS: dict[str, Direction] = {
    f"{sign}{letter}": tuple(factor * float(i == axis) for i in range(3))  # type: ignore[misc]
    for axis, letter in enumerate("xyz")
    for sign, factor in (("", 1.0), ("-", -1.0))
}
"""Directions of a model's frame by their names, such as -x."""

_CLEAR = 0.5  # cosine from which a direction is clear (choice)
_FAR = 0.5  # of an arm's length, from which shoulders are clearly off a trunk's middle (choice)


def guess_up(
    model: mujoco.MjModel, data: mujoco.MjData, arms: tuple[Limb, Limb], points: Array
) -> tuple[Direction, str]:
    """Guess what is up for the torso of a model.

    Up is against gravity, unless the shoulders are along it, or clearly elsewhere from the middle
    of the trunk, head and legs: up is then the axis that leads from there to the shoulders.

    Args:
        model: The model.
        data: Its simulation.
        arms: Four hinges of each arm.
        points: Their points, shape (2, 3, 3), m.

    Returns:
        The direction in the model's frame, and from what it was guessed.
    """
    across = points[0, 0] - points[1, 0]
    across /= np.linalg.norm(across)
    away = _from_trunk(model, data, arms, points[:, 0].mean(axis=0))
    away -= across * (across @ away)
    gravity: Any = -model.opt.gravity if model.opt.gravity.any() else UPS["z"]
    level = {name: up for name, up in UPS.items() if abs(np.dot(up, across)) < _CLEAR}
    against = max(UPS, key=lambda name: np.dot(UPS[name], gravity))
    distance = float(np.linalg.norm(away))
    length = np.linalg.norm(np.diff(points, axis=1), axis=-1).sum(axis=1).mean()
    clear = abs(np.dot(UPS[against], away)) >= _CLEAR * distance
    if against in level and (clear or distance < _FAR * length):
        return UPS[against], f"{against} is up, against gravity"
    name = max(level, key=lambda name: np.dot(level[name], away))
    return UPS[name], f"{name} is up, from the middle of the trunk to the shoulders"


def is_left(
    model: mujoco.MjModel, arms: tuple[Limb, Limb], points: Array, up: Sequence[float]
) -> tuple[bool | None, str]:
    """Return whether the first of two arms is the left one, and from what that was guessed.

    That is so where its names have an l where the others have an r; else where it is on the left
    of a model that looks along x, or along the axis that follows the one that is up.

    Args:
        model: The model.
        arms: Four hinges of each arm.
        points: Their points, shape (2, 3, 3), m.
        up: Direction in the model's frame that is up for the torso.

    Returns:
        None where neither holds.
    """
    for hinges in zip(*arms, strict=True):
        names = (hinge_name(model, hinge).lower() for hinge in hinges)
        differing = [pair for pair in zip(*names, strict=False) if len(set(pair)) > 1]
        if differing and set(differing[0]) == {"l", "r"}:
            return differing[0][0] == "l", "left and right by their names"
    axis = (int(np.argmax(np.abs(up))) + 1) % 3
    across = points[0, 0] - points[1, 0]
    left = float(np.cross(up, np.eye(3)[axis]) @ across)
    if abs(left) < _CLEAR * np.linalg.norm(across):
        return None, ""
    return left > 0.0, f"left and right by their place, as if it looks along {'xyz'[axis]}"


def _from_trunk(
    model: mujoco.MjModel, data: mujoco.MjData, arms: tuple[Limb, Limb], point: Array
) -> Array:
    """Return the vector to a point from the centre of mass of all but the arms, shape (3,), m."""
    below = {b for arm in arms for b in bodies_below(model, int(model.jnt_bodyid[arm[0]]))}
    trunk = [body for body in range(1, model.nbody) if body not in below]
    masses = model.body_mass[trunk]
    if not masses.sum() > 0.0:
        return np.zeros(3)
    centre: Array = masses @ data.xipos[trunk] / masses.sum()
    return point - centre
