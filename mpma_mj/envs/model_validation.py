"""Validation of user-supplied MJCF models: joints, actuators, sites, bodies and geometry."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

import mujoco
import numpy as np

from mpma_mj.errors import BadOptionError
from mpma_mj.kinematics import JOINT_NAMES, SEGMENT_NAMES, SIDES
from mpma_mj.robots.assembly import HANDS
from mpma_mj.robots.geometry import POINTS
from mpma_mj.utils.text import listing, shell_word

if TYPE_CHECKING:
    from mpma_mj.envs.physics import PhysicsArms

__all__: list[str] = [
    "check_actuators",
    "check_complete",
    "check_finite",
    "check_geometry",
]


_LISTED = 6  # missing elements
_SITES = tuple(f"{side}_{point}" for side in SIDES for point in POINTS)
_TOLERANCE = 1e-3  # on unit vectors
_DERIVED = re.compile(r"(?!qpos).*0|.*_(aabb|rbound|subtreemass)")  # names of what is computed
_OF_VELOCITY = (
    mujoco.mjtDyn.mjDYN_NONE,
    mujoco.mjtGain.mjGAIN_FIXED,
    mujoco.mjtBias.mjBIAS_AFFINE,
)


def check_complete(path: Path, spec: mujoco.MjSpec, *, hands: bool) -> None:
    """Check that a model has all elements that arms need.

    Args:
        path: File of the model.
        spec: The model.
        hands: Whether the bodies of the hands are needed.

    Raises:
        BadOptionError: Elements are missing; names the first of them.
    """
    needed = {"joint": JOINT_NAMES, "actuator": JOINT_NAMES, "site": _SITES}
    if hands:
        needed["body"] = HANDS
    missing = [
        f"{kind} {name}"
        for kind, names in needed.items()
        for name in names
        if getattr(spec, kind)(name) is None
    ]
    if missing:
        raise BadOptionError(
            f"{path}: lacks {listing(missing, _LISTED)}",
            remedy=f"mpma robot {shell_word(path)} writes the robot file of any other robot; or add"
            " them",
        )
    for name in JOINT_NAMES:
        if spec.joint(name).type != mujoco.mjtJoint.mjJNT_HINGE:
            raise BadOptionError(f"{path}: joint {name} is not a hinge; arms can have hinges only")


def check_finite(path: Path, model: mujoco.MjModel) -> None:
    """Check that the numbers of a model are finite; a range may have no end.

    Args:
        path: File of the model.
        model: The model.

    Raises:
        BadOptionError: One is not; names MuJoCo's array, and the element.
    """
    for owner in (model, model.opt):
        for name in filter(lambda name: not _DERIVED.fullmatch(name), dir(owner)):
            array = np.atleast_1d(getattr(owner, name))
            if array.dtype.kind != "f":
                continue
            bad = np.isnan(array) if name.endswith("range") else ~np.isfinite(array)
            for row, *column in np.argwhere(bad).tolist():
                kind = name.partition("_")[0]
                number = int(model.dof_jntid[row]) if kind == "dof" else row
                element = getattr(model, "jnt" if kind == "dof" else kind, None)
                which = element(number).name if callable(element) else ""
                raise BadOptionError(
                    f"{path}: {name} of {which or f'element {number}'} is"
                    f" {array[row, *column]}; give a finite number"
                )


def check_actuators(path: Path, model: mujoco.MjModel, *, forces: bool) -> None:
    """Check that each joint is moved by a velocity actuator of its name.

    Args:
        path: File of the model.
        model: The model.
        forces: Whether the actuators need force limits.

    Raises:
        BadOptionError: An actuator is of another kind; names it.
    """
    for name in JOINT_NAMES:
        actuator = model.actuator(name)
        moves_joint = actuator.trntype[0] == mujoco.mjtTrn.mjTRN_JOINT
        if not moves_joint or model.joint(int(actuator.trnid[0])).name != name:
            raise BadOptionError(
                f"{path}: actuator {name} does not move joint {name}; correct its transmission"
            )
        gain = actuator.gainprm[0]
        kinds = (actuator.dyntype[0], actuator.gaintype[0], actuator.biastype[0])
        of_velocity = gain > 0 and np.array_equal(actuator.biasprm[:3], [0.0, 0.0, -gain])
        if kinds != _OF_VELOCITY or not of_velocity or actuator.gear[0] != 1.0:
            raise BadOptionError(
                f"{path}: actuator {name} is not a <velocity> with kv above 0 and gear 1; make it"
                " one"
            )
        if model.opt.disableactuator & (1 << int(actuator.group[0])):
            raise BadOptionError(f"{path}: actuator {name} is in a disabled group; enable it")
        low, high = actuator.ctrlrange
        if not actuator.ctrllimited[0] or not high == -low > 0:
            raise BadOptionError(
                f"{path}: actuator {name} has no ctrlrange from -v to v; v is the velocity, rad/s,"
                " that action 1 commands"
            )
        if forces and not actuator.forcelimited[0]:
            raise BadOptionError(
                f"{path}: actuator {name} has no forcerange",
                remedy="add one, or leave {actuator_strength} out",
            )


def check_geometry(path: Path, arms: PhysicsArms) -> None:
    """Check that joint angles lead to the postures that the arms' kinematics computes.

    Args:
        path: File of the model.
        arms: The arms.

    Raises:
        BadOptionError: A posture differs; names the first joint that turns otherwise.
    """
    for segment, length in zip(SEGMENT_NAMES, arms.segment_lengths, strict=True):
        if length < _TOLERANCE:
            raise BadOptionError(f"{path}: {segment} has no length; move the site at its end")
    poses = {"at zero joint angles": np.zeros(8)}
    for joint in reversed(range(8)):  # outermost first, which moves nothing else
        pose = np.zeros(8)
        pose[joint // 4 * 4 + 3] = 1.0  # or rotation would not show
        pose[joint] += 0.5
        poses[f"where {arms.kinematics.joint_names[joint]} turns"] = pose
    poses |= {"where all joints turn (order of axes?)": np.tile([0.4, 0.5, 0.6, 0.7], 2)}
    for moment, pose in poses.items():
        with arms.reset_context():
            arms.set_joint_state(pose, np.zeros(8))
        off = np.abs(arms.posture() - arms.kinematics.posture(pose))
        if not off.max() <= _TOLERANCE:
            raise BadOptionError(
                f"{path}: {SEGMENT_NAMES[int(off.argmax()) // 3]} does not point where the joint"
                f" angles should put it, {moment}; use the joint axes of the package's two_arm.xml"
            )
