"""Physical values that a model states of its joints, which are no maker's."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from xml.etree import ElementTree

import mujoco
import numpy as np
from numpy.typing import NDArray

from mpma_mj.robots.robot import JointValues

__all__ = ["stated_values", "values_to_check"]

Array = NDArray[np.float64]

_ALSO = "not compared with a data sheet"
_KV = "choice: an error of 1 rad/s asks for the whole force"


def stated_values(
    path: Path, model: mujoco.MjModel, joints: Sequence[str]
) -> dict[str, JointValues]:
    """Return speed and force where a model states limits, and kv where there is a force.

    Speeds are `velocity` of a URDF's <limit>, or the `ctrlrange` of velocity actuators; forces are
    `effort`, or what limits actuators and joints. Of both arms, the lower value is taken.

    Args:
        path: The model's file, read before.
        model: The same, compiled.
        joints: Names of the eight joints.
    """
    if path.suffix.lower() == ".urdf":
        limits = _urdf_limits(path)
        stated = {
            "speed": ("velocity in <limit>", [limits.get((j, "velocity"), 0.0) for j in joints]),
            "force": ("effort in <limit>", [limits.get((j, "effort"), 0.0) for j in joints]),
        }
    else:
        indices = [model.joint(joint).id for joint in joints]
        stated = {
            "speed": ("ctrlrange of its actuators", [_speed(model, joint) for joint in indices]),
            "force": ("limits of its actuators", [_force(model, joint) for joint in indices]),
        }
    found = {}
    for quantity, (place, values) in stated.items():
        lower = np.reshape(values, (2, 4)).min(axis=0)
        if np.all(np.isfinite(lower) & (lower > 0.0)):
            source = f"{path.name}: {place}; {_ALSO}"
            found[quantity] = JointValues(tuple(map(_rounded, lower)), source)
    if "force" in found:
        found["kv"] = JointValues(found["force"].values, _KV)
    return found


def values_to_check(model: mujoco.MjModel, joints: Sequence[str]) -> dict[str, str]:
    """Return armature and damping of the left arm as text, which models mostly invent."""
    found = {}
    for quantity, values in (("armature", model.dof_armature), ("damping", model.dof_damping)):
        four = [float(values[model.joint(joint).dofadr[0]]) for joint in joints[:4]]
        found[quantity] = ", ".join(f"{value:.4g}" for value in four)
    return found


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


def _rounded(value: float) -> float:
    return float(f"{value:.6g}")
