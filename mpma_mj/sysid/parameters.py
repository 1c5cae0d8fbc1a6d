"""The free parameters of the arms' model, and how they change it."""

from __future__ import annotations

from collections.abc import Mapping

import mujoco
import numpy as np
from numpy.typing import NDArray

from mpma_mj.kinematics import JOINT_NAMES, SIDES

__all__ = ["LATENCY", "UNITS", "changed", "parts", "values"]

Array = NDArray[np.float64]

_KINDS = tuple(name.removeprefix("left_") for name in JOINT_NAMES if name.startswith("left_"))

UNITS = {
    **{f"kv_{kind}": "N m s/rad" for kind in _KINDS},
    **{f"damping_{kind}": "N m s/rad" for kind in _KINDS},
    "armature": "kg m²",
    "upper_arm_mass": "kg",
    "forearm_mass": "kg",
}
"""Unit of each parameter that is a factor on the model's own values, in the order of the fit."""

LATENCY = "latency"
"""Name of the parameter that is none of the model's: seconds until a command acts."""


def parts(model: mujoco.MjModel) -> dict[str, list[int]]:
    """Return which elements of a model each parameter changes.

    What both arms have in common is one parameter. The masses are those of all bodies from the
    first shoulder joint down to the elbow, and from the elbow down: the hand does not move on the
    forearm, so that only both together show. Inertias go with masses.

    Args:
        model: A model that has the arms' joints and actuators.

    Returns:
        Numbers of actuators for kv, of degrees of freedom for damping and armature, of bodies for
        masses.
    """
    found: dict[str, list[int]] = {}
    for kind in _KINDS:
        names = [f"{side}_{kind}" for side in SIDES]
        found[f"kv_{kind}"] = [int(model.actuator(name).id) for name in names]
        found[f"damping_{kind}"] = [int(model.joint(name).dofadr[0]) for name in names]
    whole, forearm = _below(model, "shoulder_abduction"), _below(model, "elbow")
    return found | {
        "armature": [int(model.joint(name).dofadr[0]) for name in JOINT_NAMES],
        "upper_arm_mass": [body for body in whole if body not in forearm],
        "forearm_mass": forearm,
    }


def _below(model: mujoco.MjModel, kind: str) -> list[int]:
    """Return the bodies that a joint moves, of both arms."""
    first = {int(model.joint(f"{side}_{kind}").bodyid[0]) for side in SIDES}
    moved: list[int] = []
    for body in range(1, model.nbody):  # parents come first
        if body in first or model.body_parentid[body] in moved:
            moved.append(body)
    return moved


def values(model: mujoco.MjModel) -> dict[str, Array]:
    """Return the values that each parameter has in a model.

    A mass is one number, the mean of both arms'; the others have one for each joint.
    """
    found = {}
    for name, indices in parts(model).items():
        if name.startswith("kv"):
            found[name] = model.actuator_gainprm[indices, 0].copy()
        elif name.startswith("damping"):
            found[name] = model.dof_damping[indices].copy()
        elif name == "armature":
            found[name] = model.dof_armature[indices].copy()
        else:
            found[name] = np.array([model.body_mass[indices].sum() / len(SIDES)])
    return found


def changed(model: mujoco.MjModel, factors: Mapping[str, float]) -> mujoco.MjModel:
    """Return a copy of a model whose parameters are multiplied by factors.

    Args:
        model: The model, which stays as it is.
        factors: Factor on each parameter, by name; 1 where there is none.
    """
    copy = mujoco.MjModel.__copy__(model)
    for name, indices in parts(model).items():
        factor = factors.get(name, 1.0)
        if name.startswith("kv"):
            copy.actuator_gainprm[indices, 0] *= factor
            copy.actuator_biasprm[indices, 2] *= factor
        elif name.startswith("damping"):
            copy.dof_damping[indices] *= factor
            copy.dof_dampingpoly[indices] *= factor
        elif name == "armature":
            copy.dof_armature[indices] *= factor
        else:
            copy.body_mass[indices] *= factor
            copy.body_inertia[indices] *= factor
    mujoco.mj_setConst(copy, mujoco.MjData(copy))  # what MuJoCo keeps that follows from these
    return copy
