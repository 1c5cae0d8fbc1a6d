"""Physical values of joints that a model states."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from xml.etree import ElementTree

import mujoco
import numpy as np
from numpy.typing import NDArray

from mpma_mj.robots.robot import FASTEST, JointValues

__all__ = ["stated_values"]

Array = NDArray[np.float64]

_KV = "choice: an error of 1 rad/s asks for the whole force"


def stated_values(
    path: Path, model: mujoco.MjModel, joints: Sequence[str]
) -> tuple[dict[str, JointValues], dict[str, str]]:
    """Return the physical values that a model states, of both arms the lower ones.

    Speed and force are `velocity` and `effort` in a URDF's <limit>, which makers write; speed is
    also the `ctrlrange` of velocity actuators. Forces of an MJCF, armature and damping are invented
    in most models: they are no more than comments.

    Args:
        path: The model's file, read before.
        model: The same, compiled.
        joints: Names of the eight joints.

    Returns:
        Values with their source, and comments, each by quantity.
    """
    indices = [model.joint(joint).id for joint in joints]
    dofs = model.jnt_dofadr[indices]
    comments = {"armature": model.dof_armature[dofs], "damping": model.dof_damping[dofs]}
    values = {"speed": ("ctrlrange of its actuators", [_speed(model, j) for j in indices])}
    if path.suffix.lower() == ".urdf":
        limits = _urdf_limits(path)
        for quantity, attribute in (("speed", "velocity"), ("force", "effort")):
            each = [limits.get((joint, attribute), 0.0) for joint in joints]
            values[quantity] = f"{attribute} in <limit>", each
    else:
        comments["force"] = np.array([_force(model, joint) for joint in indices])
    known = {
        quantity: JointValues(lower, f"{path.name}: {place}; compare it with a data sheet")
        for quantity, (place, each) in values.items()
        if min(lower := _lower(each)) > 0.0
    }
    if "speed" in known and max(known["speed"].values or ()) > FASTEST:  # a placeholder
        comments["speed"] = np.array(values["speed"][1])
        del known["speed"]
    if "force" in known:
        known["kv"] = JointValues(known["force"].values, _KV)
    stated = {quantity: _lower(each) for quantity, each in comments.items()}
    return known, {
        quantity: f"{path.name} has {', '.join(f'{value:g}' for value in lower)}; often invented"
        for quantity, lower in stated.items()
        if any(lower)
    }


def _lower(values: Sequence[float] | Array) -> tuple[float, ...]:
    """Return the lower of the values of both arms; 0 for all where one is not finite."""
    lower = np.reshape(np.asarray(values, float), (2, 4)).min(axis=0)
    if not np.isfinite(lower).all():
        return (0.0,) * 4
    return tuple(float(f"{value:.6g}") for value in lower)


def _urdf_limits(path: Path) -> dict[tuple[str, str], float]:
    """Return velocity and effort of a URDF's joints, by joint and attribute."""
    found = {}
    for joint in ElementTree.parse(path).getroot().iter("joint"):
        limit = joint.find("limit")
        for attribute in ("velocity", "effort") if limit is not None else ():
            try:
                value = float(limit.get(attribute, "0"))  # type: ignore[union-attr]
            except ValueError:
                continue
            found[joint.get("name", ""), attribute] = value
    return found


def _actuators(model: mujoco.MjModel, joint: int) -> list[int]:
    """Return the actuators that move a joint."""
    moves = (model.actuator_trnid[:, 0] == joint) & (
        model.actuator_trntype == mujoco.mjtTrn.mjTRN_JOINT
    )
    return [int(actuator) for actuator in np.flatnonzero(moves)]


def _speed(model: mujoco.MjModel, joint: int) -> float:
    """Return the highest velocity that a velocity actuator of a joint can be given; 0 if none."""
    for actuator in _actuators(model, joint):
        _, position, velocity = model.actuator_biasprm[actuator][:3]
        if position == 0.0 > velocity and model.actuator_ctrllimited[actuator]:
            gear = abs(float(model.actuator_gear[actuator][0]))
            highest = float(np.abs(model.actuator_ctrlrange[actuator]).min())
            return highest / gear if gear else 0.0
    return 0.0


def _force(model: mujoco.MjModel, joint: int) -> float:
    """Return what limits the force on a joint; 0 if nothing does."""
    limits = []
    for actuator in _actuators(model, joint):
        gear = abs(float(model.actuator_gear[actuator][0]))
        if model.actuator_forcelimited[actuator]:
            limits.append(gear * float(np.abs(model.actuator_forcerange[actuator]).min()))
        elif model.actuator_ctrllimited[actuator] and not model.actuator_biastype[actuator]:
            control = float(np.abs(model.actuator_ctrlrange[actuator]).min())
            limits.append(gear * control * abs(float(model.actuator_gainprm[actuator][0])))
    if model.jnt_actfrclimited[joint]:
        limits.append(float(np.abs(model.jnt_actfrcrange[joint]).min()))
    return min(limits, default=0.0)
