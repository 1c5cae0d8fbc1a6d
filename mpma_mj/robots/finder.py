"""Search for the two arms of a model: four hinges each, ends of forearms, and what is up."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from mpma_mj.errors import BadOptionError
from mpma_mj.robots.chain import Chain
from mpma_mj.robots.geometry import arm_points, is_shoulder, torso_axes
from mpma_mj.robots.limbs import (
    Limb,
    are_alike,
    are_called_otherwise,
    are_mirrored,
    hinge_name,
    limb_pairs,
    lone_limb,
    turning_about_shoulder,
)
from mpma_mj.robots.reachability import MIRRORED, PROBES, reachable_share
from mpma_mj.robots.surface import bodies_below
from mpma_mj.robots.torso_guess import guess_up, is_left
from mpma_mj.utils.text import listing

__all__ = ["FoundArms", "describe_arms", "find_arms"]

Array = NDArray[np.float64]

# Choices.
_SHORTEST = 0.02  # m, of an upper arm or forearm
_UNEQUAL = 0.3  # share by which both arms' lengths may differ
_DOUBT = 0.5  # factor on the score of arms that are not mirrored
_BEYOND = 0.3  # of the upper arm, from the elbow to the wrist at least
_ALONG = 0.9  # cosine from which a hinge turns about the forearm and does not end it
_LEVEL = 0.5  # cosine between up and the line of the shoulders, which are level, at most
_LISTED = 7

_REMEDY = "where that is wrong, name the arms' joints with {left} and {right}"


@dataclass(frozen=True)
class FoundArms:
    """The arms of a model.

    Attributes:
        joints: Names of the eight joints, the left arm's first, each from the shoulder outward.
        wrists: Joints at the ends of the forearms; None where they end with what is farthest.
        up: Direction in the model's frame that is up for the torso.
        guesses: What was guessed, and from what.
    """

    joints: tuple[str, ...]
    wrists: tuple[str, ...] | None
    up: tuple[float, ...]
    guesses: tuple[str, ...] = ()


class _Pose(NamedTuple):
    """A model with all hinges at zero, in which arms are looked for, and what is up if known."""

    model: mujoco.MjModel
    data: mujoco.MjData
    up: tuple[float, ...] | None


class _Arms(NamedTuple):
    """Two arms: four hinges each, hinges at the wrists, and their points, shape (2, 3, 3), m."""

    hinges: tuple[Limb, Limb]
    wrists: tuple[int, int] | None
    points: Array

    @property
    def lengths(self) -> Array:
        """Lengths of upper arm and forearm of both arms, shape (2, 2), m."""
        return np.asarray(np.linalg.norm(np.diff(self.points, axis=1), axis=-1))

    def exchanged(self) -> _Arms:
        """Return the same with the other arm first."""
        wrists = self.wrists and (self.wrists[1], self.wrists[0])
        return _Arms((self.hinges[1], self.hinges[0]), wrists, self.points[::-1])


def find_arms(model: mujoco.MjModel, up: Sequence[float] | None = None) -> FoundArms:
    """Find two arms that have a shoulder of three hinges and an elbow of one.

    All pairs of four neighbouring hinges are compared by how many of `PROBES` they reach, how
    long the shorter one of upper arm and forearm is, and whether they are mirror images. Those
    that are called legs, fingers or the like are left out.

    Args:
        model: The model.
        up: Direction in its frame that is up for the torso; guessed if None.

    Raises:
        BadOptionError: There are no such arms; says which hinges there are.
    """
    pose = _pose(model, up)
    best, refusal = None, None
    for arms in _pairs(pose):
        try:
            score, found = _score(pose, arms)
        except BadOptionError as error:
            refusal = refusal or error
            continue
        if best is None or score > best[0]:
            best = score, found
    if best is None:
        raise refusal or _refusal(pose)
    names = [model.joint(joint).name for joint in range(model.njnt)]
    for name in best[1].joints:
        if name not in names:
            raise BadOptionError(f"{name} is one of an arm; give it a name in the model")
    return best[1]


def describe_arms(
    model: mujoco.MjModel, joints: Sequence[int], up: Sequence[float] | None = None
) -> FoundArms:
    """Find the ends of the forearms, and what is up, of arms that are known.

    Args:
        model: The model.
        joints: Indices of the eight joints, the left arm's first.
        up: As of `find_arms`.
    """
    pose = _pose(model, up)
    arms = _arms(pose, (tuple(joints[:4]), tuple(joints[4:])))
    return _found(pose, arms, *_up(pose, arms))


def _pose(model: mujoco.MjModel, up: Sequence[float] | None) -> _Pose:
    data = mujoco.MjData(model)
    hinges = model.jnt_type == mujoco.mjtJoint.mjJNT_HINGE
    data.qpos[model.jnt_qposadr[hinges]] = 0.0
    mujoco.mj_kinematics(model, data)
    return _Pose(model, data, None if up is None else tuple(map(float, up)))


def _pairs(pose: _Pose) -> Iterator[_Arms]:
    """Yield pairs of four neighbouring hinges that may be arms by their lengths and names."""
    for one, other in limb_pairs(pose.model):
        if len(one) < 4 or are_called_otherwise(pose.model, one[-4:] + other[-4:]):
            continue
        arms = _arms(pose, (one[-4:], other[-4:]))
        lengths = arms.lengths
        alike = np.abs(lengths[0] - lengths[1]) <= _UNEQUAL * lengths.max(axis=0)
        shoulders = (
            is_shoulder(pose.data, *arm) for arm in zip(arms.hinges, arms.points, strict=True)
        )
        if alike.all() and lengths.min() >= _SHORTEST and all(shoulders):
            yield arms


def _arms(pose: _Pose, hinges: tuple[Limb, Limb]) -> _Arms:
    """Find the ends of the forearms of two arms."""
    one, other = (_wrist(pose, arm) for arm in hinges)
    wrists = None if one is None or other is None else (one, other)
    points = [
        arm_points(pose.model, pose.data, arm, wrist)
        for arm, wrist in zip(hinges, wrists or (None, None), strict=True)
    ]
    return _Arms(hinges, wrists, np.stack(points))


def _wrist(pose: _Pose, arm: Limb) -> int | None:
    """Return the first hinge below the elbow that does not turn about the forearm."""
    model, data = pose.model, pose.data
    shoulder, elbow, _ = arm_points(model, data, arm, arm[3])
    below = bodies_below(model, int(model.jnt_bodyid[arm[3]]))[1:]
    for joint in range(arm[3] + 1, model.njnt):
        is_hinge = model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_HINGE
        if is_hinge and int(model.jnt_bodyid[joint]) in below and model.joint(joint).name:
            forearm = data.xanchor[joint] - elbow
            length = np.linalg.norm(forearm)
            far = length > _BEYOND * np.linalg.norm(elbow - shoulder)
            if far and abs(forearm @ data.xaxis[joint]) < _ALONG * length:
                return joint
    return None


def _score(pose: _Pose, arms: _Arms) -> tuple[float, FoundArms]:
    """Return how likely a pair is that of two arms, and what they are then."""
    up, why_up = _up(pose, arms)
    left, why = is_left(pose.model, arms.hinges, arms.points, up)
    ways = [arms] if left else [arms.exchanged()] if left is not None else [arms, arms.exchanged()]
    if left is None:
        why = "left and right by what the arms reach"
    reached, arms = max(((_reached(pose, way, up), way) for way in ways), key=lambda way: way[0])
    # The shorter segment tells arms from parts of them; 1 % for ranges of next to nothing.
    score = (0.01 + reached) * float(arms.lengths.min())
    score *= 1.0 if are_mirrored(pose.data, arms.hinges) else _DOUBT
    return score, _found(pose, arms, up, why_up, why)


def _up(pose: _Pose, arms: _Arms) -> tuple[tuple[float, ...], str]:
    """Return what is up for the torso, and from what it was guessed; "" where it is known."""
    if pose.up is not None:
        across = arms.points[0, 0] - arms.points[1, 0]
        if abs(np.dot(pose.up, across)) > _LEVEL * np.linalg.norm(across):
            raise BadOptionError(
                "points along the line of the shoulders; give the direction from pelvis to head",
                option="up",
            )
        return pose.up, ""
    return guess_up(pose.model, pose.data, arms.hinges, arms.points)


def _found(pose: _Pose, arms: _Arms, up: tuple[float, ...], *guesses: str) -> FoundArms:
    joints = tuple(hinge_name(pose.model, hinge) for arm in arms.hinges for hinge in arm)
    wrists = arms.wrists and tuple(hinge_name(pose.model, wrist) for wrist in arms.wrists)
    return FoundArms(joints, wrists, up, tuple(filter(None, guesses)))


def _reached(pose: _Pose, arms: _Arms, up: Sequence[float]) -> float:
    """Return the share of `PROBES` that two arms reach; raises a BadOptionError for no arm."""
    torso, model, shares = torso_axes(arms.points, up), pose.model, []
    both = np.ones(6), MIRRORED
    for arm, points, factors in zip(arms.hinges, arms.points, both, strict=True):
        joints = list(arm)
        limited = model.jnt_limited[joints].astype(bool)
        lowest, highest = np.where(limited, model.jnt_range[joints].T, [[-np.inf], [np.inf]])
        axes = pose.data.xaxis[joints] @ torso.T
        upper_arm, forearm = np.diff(points, axis=0) @ torso.T
        names = tuple(hinge_name(model, joint) for joint in arm)
        chain = Chain(axes, upper_arm, forearm, lowest, highest, names)
        shares.append(reachable_share(chain, PROBES * factors))
    return float(np.mean(shares))


def _refusal(pose: _Pose) -> BadOptionError:
    """Return the error for a model without arms, which says what it has."""
    model = pose.model

    def names(limb: Limb) -> str:
        return listing([hinge_name(model, hinge) for hinge in limb], _LISTED)

    pairs = [pair for pair in limb_pairs(model) if are_alike(pose.data, pair)]
    arms = [pair for pair in pairs if not are_called_otherwise(model, pair[0] + pair[1])]
    pair = max(arms, key=lambda pair: len(pair[0]), default=((), ()))
    lone = lone_limb(model)
    if len(lone) >= 4 and len(pair[0]) < 2:
        problem = f"has one arm only ({names(lone)}), or none like it"
    elif pair[0]:
        about, hinges = turning_about_shoulder(pose.data, pair[0]), len(pair[0])
        problem = (
            f"has limbs of {hinges} hinge{'s' * (hinges > 1)} ({names(pair[0])}), {about} of them"
            " about the shoulder; an arm needs three there and one in the elbow"
        )
    elif pairs:
        longest = max(pairs, key=lambda pair: len(pair[0]))
        problem = f"has no arms, but what is called legs, fingers or the like ({names(longest[0])})"
    else:
        problem = f"has no two arms; an arm needs four hinges, and it has {model.njnt} joints"
    if (model.jnt_type == mujoco.mjtJoint.mjJNT_BALL).any():
        problem += ", and not a ball joint"
    return BadOptionError(problem, remedy=_REMEDY)
