"""Free parameters of the arms' model, as factors on its own values."""

from __future__ import annotations

from collections.abc import Mapping
from types import EllipsisType

import mujoco
import numpy as np
from numpy.typing import NDArray

from mpma_mj.kinematics import JOINT_NAMES, SIDES

__all__ = ["LATENCY", "REFERENCE", "UNITS", "scaled", "values"]

Array = NDArray[np.float64]

_KINDS = tuple(name.removeprefix("left_") for name in JOINT_NAMES if name.startswith("left_"))

UNITS = {
    **{f"kv_{kind}": "N m s/rad" for kind in _KINDS},
    **{f"damping_{kind}": "N m s/rad" for kind in _KINDS},
    "armature": "kg m²",
    "upper_arm_mass": "kg",
    "forearm_mass": "kg",
}
"""Unit of each parameter, in the order of the fit; both arms share each."""

REFERENCE = "forearm_mass"
"""Denominator of ratios where only these are determined: a forearm can be weighed."""

LATENCY = "latency"
"""Name of the parameter that is not the model's: time from a command to its effect."""

_FIELDS: dict[str, tuple[tuple[str, int | EllipsisType], ...]] = {
    "kv": (("actuator_gainprm", 0), ("actuator_biasprm", 2)),
    "damping": (("dof_damping", ...), ("dof_dampingpoly", ...)),
    "armature": (("dof_armature", ...),),
    "mass": (("body_mass", ...), ("body_inertia", ...)),
}
"""Arrays of a model, with a column, that each kind of parameter multiplies."""


def values(model: mujoco.MjModel) -> dict[str, Array]:
    """Return the value of each parameter: one for each joint, or the mean mass of both arms."""
    found = {}
    for name, (kind, indices) in _elements(model).items():
        field, column = _FIELDS[kind][0]
        own = np.array(getattr(model, field)[indices, column])
        found[name] = own.sum(keepdims=True) / len(SIDES) if kind == "mass" else own
    return found


def scaled(model: mujoco.MjModel, factors: Mapping[str, float]) -> mujoco.MjModel:
    """Return a copy of a model with parameters multiplied by factors.

    Args:
        model: Model with the arms' joints and actuators; not changed.
        factors: Factor on each parameter, by name; 1 for parameters not named.
    """
    copy = mujoco.MjModel.__copy__(model)
    for name, (kind, indices) in _elements(model).items():
        for field, column in _FIELDS[kind]:
            getattr(copy, field)[indices, column] *= factors.get(name, 1.0)
    mujoco.mj_setConst(copy, mujoco.MjData(copy))  # recompute constants that depend on these
    return copy


def _elements(model: mujoco.MjModel) -> dict[str, tuple[str, list[int]]]:
    """Return the kind of each parameter, and the actuators, dofs or bodies that it scales.

    Masses are those of all bodies from the first shoulder joint to the elbow, and from the elbow
    on: the hand does not move on the forearm, so only their sum shows.
    """
    dofs = {name: int(model.joint(name).dofadr[0]) for name in JOINT_NAMES}
    found: dict[str, tuple[str, list[int]]] = {"armature": ("armature", list(dofs.values()))}
    for kind in _KINDS:
        names = [f"{side}_{kind}" for side in SIDES]
        found[f"kv_{kind}"] = "kv", [int(model.actuator(name).id) for name in names]
        found[f"damping_{kind}"] = "damping", [dofs[name] for name in names]
    arm, forearm = _bodies_below(model, "shoulder_abduction"), _bodies_below(model, "elbow")
    found["upper_arm_mass"] = "mass", [body for body in arm if body not in forearm]
    found["forearm_mass"] = "mass", forearm
    return {name: found[name] for name in UNITS}


def _bodies_below(model: mujoco.MjModel, kind: str) -> list[int]:
    """Return the bodies of both arms that a joint moves."""
    roots = {int(model.joint(f"{side}_{kind}").bodyid[0]) for side in SIDES}
    moved: list[int] = []
    for body in range(1, model.nbody):  # parents come first
        if body in roots or model.body_parentid[body] in moved:
            moved.append(body)
    return moved
