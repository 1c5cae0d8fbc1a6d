"""Checks of a robot's file against its model: joints with their order and ranges, and points."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import mujoco
import numpy as np
from numpy.typing import NDArray

from mpma_mj.errors import BadOptionError
from mpma_mj.kinematics import SIDES
from mpma_mj.robots.geometry import is_shoulder
from mpma_mj.robots.robot import Robot
from mpma_mj.robots.surface import bodies_below
from mpma_mj.utils.text import did_you_mean, listing

__all__ = ["check_joints", "check_points", "check_shoulders"]

Array = NDArray[np.float64]

# Choices.
_RANGE = (0.1, 25.0)  # rad, between lowest and highest angle
_SHORTEST = 0.02  # m, of a segment, and between shoulders
_LONGEST = 10.0  # m, of a segment
_ALONG = 0.5  # cosine between up and the line of the shoulders, which are level
_LISTED = 20

_HINGE, _SLIDE = int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE)


def check_joints(robot: Robot, model: mujoco.MjModel) -> None:
    """Check that the joints that the file names exist, and are those of two arms.

    Args:
        robot: The robot.
        model: Its model as it is.

    Raises:
        BadOptionError: A joint does not exist, is no hinge, comes in the wrong order or on the
            wrong side, or has a range that nobody means.
    """
    arms = dict(zip(SIDES, (robot.joints[:4], robot.joints[4:]), strict=True))
    for key, names in (
        *arms.items(),
        ("wrist", robot.wrists or ()),
        ("rest", robot.rest),
        ("range", robot.ranges),
    ):
        for name in names:
            _check_exists(robot, model, key, name)
    for name in set(robot.joints[:4]) & set(robot.joints[4:]):
        raise BadOptionError(f"{robot.path}: joint {name} is in both arms; give each its own four")
    for key, names in arms.items():
        for name in names:
            if model.joint(name).type[0] != _HINGE:
                raise BadOptionError(
                    f"{robot.path}: {key}: joint {name} is not a hinge; arms can have hinges only"
                )
        for inner, outer in itertools.pairwise(names):
            _check_order(robot, model, key, inner, outer)
        for name in names:
            _check_range(robot, model, name)
    if all(_are_exchanged(*pair) for pair in zip(*arms.values(), strict=True)):
        raise BadOptionError(
            f"{robot.path}: left names the joints of the right arm ({robot.joints[0]}), and right"
            f" those of the left ({robot.joints[4]}); exchange them"
        )
    for wrist, elbow in zip(robot.wrists or (), robot.joints[3::4], strict=False):
        below = bodies_below(model, int(model.joint(elbow).bodyid[0]))
        if model.joint(wrist).bodyid[0] not in below or wrist in robot.joints:
            raise BadOptionError(
                f"{robot.path}: wrist: joint {wrist} does not hang on {elbow}; give the joint at"
                " the end of that forearm, the left one first"
            )
    for name in robot.ranges:
        if name not in robot.joints:
            raise BadOptionError(f"{robot.path}: range: joint {name} is of no arm; leave it out")
    for name in robot.rest:
        if name in robot.joints or model.joint(name).type[0] not in (_HINGE, _SLIDE):
            what = "one of an arm" if name in robot.joints else "neither a hinge nor a slide"
            raise BadOptionError(f"{robot.path}: rest: joint {name} is {what}; leave it out")


def check_points(robot: Robot, points: Array) -> None:
    """Check the points of the arms.

    Args:
        robot: The robot.
        points: Shoulder, elbow and wrist of the left and the right arm, shape (2, 3, 3), m, in the
            model's frame.

    Raises:
        BadOptionError: A segment has no length, or `up` points along the line of the shoulders.
    """
    lengths = np.linalg.norm(np.diff(points, axis=1), axis=-1)
    for side, (upper_arm, forearm), elbow in zip(SIDES, lengths, robot.joints[3::4], strict=True):
        if upper_arm < _SHORTEST:
            raise BadOptionError(
                f"{robot.path}: {side}: the elbow {elbow} is at the shoulder; give four joints, of"
                " which the last bends the elbow"
            )
        if max(upper_arm, forearm) > _LONGEST:
            raise BadOptionError(
                f"{robot.model}: the {side} arm has segments of {upper_arm:g} and {forearm:g} m;"
                " are they millimetres? scale the model to metres"
            )
        if forearm < _SHORTEST:
            end = robot.wrists[SIDES.index(side)] if robot.wrists else "nothing below it"
            raise BadOptionError(
                f"{robot.path}: the {side} forearm has no end: {end} is away from {elbow}; give"
                " wrist = [the joint at the end of the left forearm, that of the right]"
            )
    across, up = points[0, 0] - points[1, 0], np.asarray(robot.up)
    apart = float(np.linalg.norm(across))
    if apart < _SHORTEST:
        raise BadOptionError(
            f"{robot.path}: both shoulders are at one point; correct left or right"
        )
    if abs(across @ up) > _ALONG * apart * np.linalg.norm(up):
        line = np.round(across / apart, 2).tolist()
        raise BadOptionError(
            f"{robot.path}: up is {list(robot.up)}, along the line of the shoulders, {line}; give"
            " the direction from pelvis to head in the model's frame"
        )


def check_shoulders(
    robot: Robot, data: mujoco.MjData, joints: Sequence[int], points: Array
) -> None:
    """Check that the first three joints of each arm turn about its shoulder.

    Args:
        robot: The robot.
        data: Simulation of its model at rest.
        joints: Indices of the eight joints.
        points: Shoulder, elbow and wrist of both arms, shape (2, 3, 3), m.

    Raises:
        BadOptionError: They do not, as where a shoulder has two hinges.
    """
    for arm, side in enumerate(SIDES):
        if not is_shoulder(data, joints[4 * arm : 4 * arm + 4], points[arm]):
            three = ", ".join(robot.joints[4 * arm : 4 * arm + 3])
            raise BadOptionError(
                f"{robot.path}: {side}: {three} do not turn about one shoulder; an arm needs three"
                " hinges there and one in the elbow"
            )


def _check_exists(robot: Robot, model: mujoco.MjModel, key: str, name: str) -> None:
    names = [model.joint(index).name for index in range(model.njnt)]
    if name not in names:
        known = f"it has {listing(list(filter(None, names)), _LISTED) or 'none'}"
        raise BadOptionError(
            f"{robot.path}: {key}: {robot.model.name} has no joint {name};"
            f" {did_you_mean(name, names) or known}"
        )


def _check_order(robot: Robot, model: mujoco.MjModel, key: str, inner: str, outer: str) -> None:
    """Check that the outer joint hangs on the inner one."""
    first, then = model.joint(inner), model.joint(outer)
    of_elbow = outer in robot.joints[3::4]
    if first.bodyid[0] == then.bodyid[0]:
        hangs = first.id < then.id and not of_elbow
    else:
        hangs = then.bodyid[0] in bodies_below(model, int(first.bodyid[0]))
    if not hangs:
        raise BadOptionError(
            f"{robot.path}: {key}: joint {outer} does not hang on {inner}; give four joints of one"
            " arm in order, from the shoulder outward"
        )


def _check_range(robot: Robot, model: mujoco.MjModel, name: str) -> None:
    joint, own = model.joint(name), robot.ranges.get(name)
    low, high = joint.range if own is None else own
    least, most = _RANGE
    if (joint.limited[0] or own) and not least <= high - low <= most:
        path, or_else = (robot.path, "") if own else (robot.model, ", or <compiler angle=…>")
        raise BadOptionError(
            f"{path}: the range of joint {name} is {low:.4g} to {high:.4g} rad; are degrees and"
            f" radians mixed up? correct it{or_else}"
        )


def _are_exchanged(left: str, right: str) -> bool:
    """Return whether the name of a left joint has an r where that of the right joint has an l."""
    differing = ((a, b) for a, b in zip(left.lower(), right.lower(), strict=False) if a != b)
    return next(differing, None) == ("r", "l")
