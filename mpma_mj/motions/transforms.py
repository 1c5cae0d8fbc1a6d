"""Motions made from motions: mirrored, at another rate, looped, repeated, joined."""

from __future__ import annotations

import dataclasses
import itertools
from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mpma_mj import joint_paths, kinematics
from mpma_mj.arm_kinematics import TWO_ARMS, ArmKinematics
from mpma_mj.context import one_hot
from mpma_mj.motions.cleaning.filtering import anti_alias, resample
from mpma_mj.motions.motion import Motion
from mpma_mj.options import TWO_ARM

__all__ = [
    "PEAK_SPEED",
    "at_rate",
    "close_loop",
    "join",
    "leads_on",
    "minimum_jerk",
    "mirrored",
    "move_between",
    "repeat",
    "with_context_of",
]

Array = NDArray[np.float64]

PEAK_SPEED = 15.0 / 8.0  # of a minimum-jerk move of distance 1 in time 1, reached half-way

_SIDEWAYS = np.array([1.0, -1.0, 1.0])  # y → -y
_BENT_SHARE = 0.25  # of a motion that is bent to close a loop ...
_LONGEST_BEND = 2.0  # ... at most so many seconds (choice)
# Share of the joints' top speed at which arms go from one motion to the next (choice).
_SPEED = 0.5
# A step is like those within so many seconds if it is up to so many times as long (choice).
_AROUND = 0.25
_LIKE = 1.2


def minimum_jerk(phase: Array) -> Array:
    """Return the share of a move that is done at phases τ of its time, any shape, in [0, 1].

        s(τ) = 10 τ³ - 15 τ⁴ + 6 τ⁵        Flash & Hogan 1985, J. Neuroscience 5(7)

    Before 0 and after 1 the move rests.
    """
    tau = np.clip(phase, 0.0, 1.0)
    return tau**3 * (10.0 - 15.0 * tau + 6.0 * tau**2)


def mirrored(motion: Motion) -> Motion:
    """Return a motion with left and right exchanged, and the same context."""
    arms = motion.posture.reshape(-1, 2, 2, 3)  # (T, arm, segment, xyz)
    posture = (arms[:, ::-1] * _SIDEWAYS).reshape(-1, 12)
    angles = motion.feasible_angles
    if angles is not None:  # equal angles of `two_arm` hold mirrored postures
        angles = np.roll(angles, 4, axis=1) if motion.angles_of == TWO_ARM else None
    return dataclasses.replace(motion, posture=posture, feasible_angles=angles)


def with_context_of(motion: Motion, other: Motion) -> Motion:
    """Return a motion with the context of another one, stretched or compressed to its length."""
    frames = len(motion)
    index = np.arange(frames) * len(other) // frames
    return dataclasses.replace(motion, context=other.context[index], labels=other.labels)


def at_rate(motion: Motion, rate: float, tempo: float) -> Motion:
    """Return a motion at another rate, Hz, and at a tempo relative to its own.

    It has no feasible angles: at another speed others are.
    """
    if rate == motion.rate and tempo == 1.0:
        return motion
    own_rate = motion.rate * tempo
    vectors = resample(anti_alias(motion.posture, own_rate, rate), own_rate, rate).reshape(-1, 4, 3)
    vectors = vectors / np.linalg.norm(vectors, axis=2, keepdims=True)
    nearest = np.round(np.arange(len(vectors)) * own_rate / rate).astype(int)
    return dataclasses.replace(
        motion,
        posture=vectors.reshape(-1, 12),
        context=motion.context[np.minimum(nearest, len(motion) - 1)],
        rate=rate,
        tempo=motion.tempo * tempo,
        feasible_angles=None,
    )


def close_loop(posture: Array, rate: float) -> Array:
    """Bend the last part of a motion so that repetitions join without a jump.

    The joint angles are shifted by a share of the difference between end and start that rises
    along a minimum-jerk curve from 0 to 1, one sample after the end. Elbows stay within their
    range in the motion, so that none is bent backwards.

    Args:
        posture: Postures, shape (T, 12).
        rate: Postures per second, Hz.

    Returns:
        Postures, shape (T, 12): the first ones as they were.
    """
    angles = joint_paths.continuous_angles(posture)
    count = max(1, min(round(_LONGEST_BEND * rate), int(_BENT_SHARE * len(posture))))
    # Where the motion would be one sample after its end, and where it should be.
    end = 2.0 * angles[-1] - angles[-2]
    way = kinematics.angles_from_posture(posture[0], near=end) - end
    share = minimum_jerk(np.arange(1, count + 1) / (count + 1))[:, None]
    elbows = angles[:, 3::4]  # a view
    least, most = elbows.min(axis=0), elbows.max(axis=0)
    angles[-count:] += share * way
    np.clip(elbows, least, most, out=elbows)
    return kinematics.posture_from_angles(angles)


class Repetitions(NamedTuple):
    """Repetitions of a motion, T' postures in all.

    Attributes:
        posture: Postures, shape (T', 12).
        context: Context, shape (T', C).
        angles: Feasible joint angles, shape (T', 8), rad; None for a motion without them.
    """

    posture: Array
    context: Array
    angles: Array | None


def repeat(
    motion: Motion, times: int, max_joint_speed: Array, arms: ArmKinematics = TWO_ARMS
) -> Repetitions:
    """Join repetitions of a motion.

    Where it ends elsewhere than it starts, the arms return by a minimum-jerk move at half the
    joints' top speed, with the context of the first posture. A motion whose end leads into its
    start within one sample, at rest or at the speed that it has there, is joined as it is. The
    postures of a move are those that the arms hold, also where they do not hold the motion's own.

    Args:
        motion: The motion, T postures.
        times: Number of repetitions.
        max_joint_speed: Largest speed of each joint, shape (8,), rad/s.
        arms: Kinematics of the arms.
    """
    way_back = np.empty((0, 8))
    if not leads_on(motion, arms):
        way_back = move_between(motion, motion, max_joint_speed, arms)
    back_context = np.repeat(motion.context[:1], len(way_back), axis=0)
    posture = [motion.posture, arms.posture(way_back)] * times
    context = [motion.context, back_context] * times
    angles = None
    if motion.feasible_angles is not None:
        angles = _continued(([motion.feasible_angles, way_back] * times)[:-1], arms)
    return Repetitions(np.concatenate(posture[:-1]), np.concatenate(context[:-1]), angles)


def leads_on(motion: Motion, arms: ArmKinematics = TWO_ARMS) -> bool:
    """Return whether the step from a motion's end to its start is like those around it.

    Args:
        motion: The motion.
        arms: Kinematics of the arms whose feasible angles it has, if any.
    """
    near = 1 + max(1, round(_AROUND * motion.rate))
    step = motion.posture[0] - motion.posture[-1]
    around = [np.diff(motion.posture[stretch], axis=0) for stretch in (np.s_[:near], np.s_[-near:])]
    if _longest(step) > _LIKE * max(map(_longest, around)):
        return False
    if motion.feasible_angles is None:
        return True
    angles = motion.feasible_angles
    back = np.abs(arms.step_to(angles[0], near=angles[-1]))
    return bool((back <= _LIKE * np.abs(np.diff(angles, axis=0)).max(axis=0)).all())


def _longest(steps: Array) -> float:
    return float(np.linalg.norm(steps.reshape(-1, 3), axis=1).max())


def move_between(
    motion: Motion, following: Motion, max_joint_speed: Array, arms: ArmKinematics = TWO_ARMS
) -> Array:
    """Return a minimum-jerk move from the end of a motion to the start of another.

    Args:
        motion: The motion.
        following: The motion to which the move leads.
        max_joint_speed: Largest speed of each joint, shape (8,), rad/s.
        arms: Kinematics of the arms.

    Returns:
        The joint angles in between, shape (N, 8), rad; N is 0 if one sample is enough.
    """
    end = motion.joint_angles[-1]
    if following.feasible_angles is not None:
        way = arms.step_to(following.feasible_angles[0], near=end)
    else:
        way = arms.angles(following.posture[0], near=end) - end
    time = PEAK_SPEED * np.max(np.abs(way) / max_joint_speed) / _SPEED  # s
    count = int(np.ceil(time * motion.rate))
    if count <= 1:
        return np.empty((0, 8))
    share = minimum_jerk(np.arange(1, count) / count)[:, None]
    return end + share * way


def join(
    motions: Sequence[Motion], max_joint_speed: Array, arms: ArmKinematics = TWO_ARMS
) -> Motion:
    """Join motions into one, in which each has one label: its name.

    A minimum-jerk move leads from the end of each to the start of the next, whose label it has.

    Args:
        motions: The motions, of one rate.
        max_joint_speed: Largest speed of each joint, shape (8,), rad/s.
        arms: Kinematics of the arms.
    """
    names = _distinct([motion.name for motion in motions])
    postures, angles = [motions[0].posture], [motions[0].joint_angles]
    labels = [0] * len(motions[0])
    for number, (before, motion) in enumerate(itertools.pairwise(motions), start=1):
        way = move_between(before, motion, max_joint_speed, arms)
        postures += [arms.posture(way), motion.posture]
        angles += [way, motion.joint_angles]
        labels += [number] * (len(way) + len(motion))
    changed = any(motion.feasible_angles is not None for motion in motions)
    return Motion(
        np.concatenate(postures),
        one_hot(np.array(labels), len(motions)),
        names,
        motions[0].rate,
        "repertoire",
        "; ".join(motion.source for motion in motions),
        motions[0].tempo,
        feasible_angles=_continued(angles, arms) if changed else None,
        angles_of=motions[0].angles_of,
    )


def _continued(parts: Sequence[Array], arms: ArmKinematics) -> Array:
    """Join joint angles, each part on the branch and turn on which the part before ends."""
    joined = [parts[0]]
    for part in parts[1:]:
        if len(part):
            sign, offset = arms.continuation(part[0], near=joined[-1][-1])
            joined.append(sign * part + offset)
    return np.concatenate(joined)


def _distinct(names: Sequence[str]) -> tuple[str, ...]:
    """Return names, numbered where they are not unique."""
    counts, distinct = Counter(names), list[str]()
    for name in names:
        numbered = (f"{name} {i}" for i in itertools.count(1))
        taken = {*names, *distinct}
        distinct.append(next(n for n in numbered if n not in taken) if counts[name] > 1 else name)
    return tuple(distinct)
