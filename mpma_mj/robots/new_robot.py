"""Description of a robot from its model alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

import mujoco

from mpma_mj.errors import BadOptionError, one_line
from mpma_mj.kinematics import JOINT_NAMES, SIDES
from mpma_mj.robots.arm_checks import check_joints
from mpma_mj.robots.finder import describe_arms, find_arms
from mpma_mj.robots.geometry import POINTS
from mpma_mj.robots.model_file import read_model_file
from mpma_mj.robots.robot import UNKNOWN, Robot
from mpma_mj.robots.robot_file import TIP
from mpma_mj.robots.stated_values import stated_values
from mpma_mj.robots.urdf import unread_meshes

__all__ = ["NewRobot", "describe_model"]

_FOUR = "four joints, from the shoulder outward: three of the shoulder, then the elbow"
_TWO = f"the joints at the ends of the left and the right forearm, or {TIP}"
_SITES = [f"{side}_{point}" for side in SIDES for point in POINTS]


class NewRobot(NamedTuple):
    """A robot that has no file yet.

    Attributes:
        robot: The robot; messages name its model, as it has no file.
        guesses: What was guessed, and from what.
        comments: Comments on physical values by their quantity.
        unread: Files of meshes that are left out, as MuJoCo does not read them.
    """

    robot: Robot
    guesses: tuple[str, ...] = ()
    comments: Mapping[str, str] = MappingProxyType({})
    unread: tuple[str, ...] = ()


def describe_model(
    path: Path,
    *,
    name: str,
    left: Sequence[str] = (),
    right: Sequence[str] = (),
    wrist: Sequence[str] = (),
    up: Sequence[float] | None = None,
) -> NewRobot:
    """Describe the robot that a model is, as far as the model says.

    Args:
        path: MJCF or URDF file.
        name: Name of the robot.
        left: Joints of the left arm, from the shoulder outward; found if none are given.
        right: Those of the right arm.
        wrist: Joints at the ends of the forearms, or `TIP`; found if not given.
        up: Direction in the model's frame that is up for the torso; guessed if None.

    Raises:
        BadOptionError: The model cannot be read, there are no such joints, or no arms are found.
    """
    _check_numbers(left, right, wrist)
    model = _compiled(path)
    if not left and _is_complete(model):
        whole = Robot(name, name, UNKNOWN, path, path, complete=True)
        return NewRobot(whole)
    robot = Robot(name, name, UNKNOWN, path, path)
    if left:
        robot = replace(robot, joints=(*left, *right))
        check_joints(robot, model)
    try:
        if left:
            found = describe_arms(model, [model.joint(name).id for name in robot.joints], up)
        else:
            found = find_arms(model, up)
    except BadOptionError as error:
        raise error.with_context(path) from None
    physical, comments = stated_values(path, model, found.joints)
    robot = replace(
        robot,
        joints=found.joints,
        up=found.up,
        wrists=None if tuple(wrist) == (TIP,) else tuple(wrist) or found.wrists,
        physical=physical,
    )
    check_joints(robot, model)
    return NewRobot(robot, found.guesses, comments, unread_meshes(path))


def _compiled(path: Path) -> mujoco.MjModel:
    try:
        spec = read_model_file(path)
        spec.compiler.fusestatic = False
        return spec.compile()
    except (ValueError, mujoco.FatalError) as error:
        if isinstance(error, BadOptionError):
            raise
        raise BadOptionError(f"{path}: {one_line(error)}") from None


def _is_complete(model: mujoco.MjModel) -> bool:
    """Return whether a model has the joints and sites of `two_arm.xml`."""
    joint, site = mujoco.mjtObj.mjOBJ_JOINT, mujoco.mjtObj.mjOBJ_SITE
    named = [*((joint, name) for name in JOINT_NAMES), *((site, name) for name in _SITES)]
    return all(mujoco.mj_name2id(model, kind, name) >= 0 for kind, name in named)


def _check_numbers(left: Sequence[str], right: Sequence[str], wrist: Sequence[str]) -> None:
    """Check how many joints are given; raises a BadOptionError."""
    for option, names, other in (("left", left, right), ("right", right, left)):
        if len(names) != 4 and (names or other):
            have = f"has {len(names)} joints ({', '.join(names)})" if names else "is missing"
            raise BadOptionError(f"{have}; expected {_FOUR}", option=option)
    if wrist and tuple(wrist) != (TIP,) and len(wrist) != 2:
        raise BadOptionError(option="wrist", value=tuple(wrist), expected=_TWO)
