"""Reach of a robot: postures that its joints' ranges allow, and those that its speeds leave.

Two measures that are never to be mixed: *reachable* is said of each posture alone, whatever the
speed; *feasible* of the postures of a whole motion, after it is fitted to ranges and speeds.
"""

from __future__ import annotations

import bisect
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mpma_mj.motions.feasibility import JointLimits, turned
from mpma_mj.motions.fitted_motion import fitted
from mpma_mj.motions.motion import Motion
from mpma_mj.motions.transforms import at_rate
from mpma_mj.robots.branches import nearest_branch
from mpma_mj.robots.chain import Chain
from mpma_mj.robots.chain_arms import ChainArms
from mpma_mj.robots.reachability import REACHED, deviation

__all__ = ["Reach", "close_tempo", "reach_lines", "reach_of", "slower_tempo"]

Array = NDArray[np.float64]

# Axes of the left and the right arm of `two_arm` at zero joint angles, where arms hang; see
# `kinematics`.
_AXES = np.array(
    [
        [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]],
        [[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [0.0, -1.0, 0.0]],
    ]
)
_DOWN = np.array([0.0, 0.0, -1.0])

# Choices.
_TEMPI = [number / 20.0 for number in range(5, 21)]  # that are tried
_SLOWER = (0.5, 0.25)  # that are tried where nobody asked
_NEARLY = 0.05  # share of steps that do not count
_TOO_SLOW = 0.1  # share of steps that are reachable, but not feasible


class Reach(NamedTuple):
    """How much of a motion a robot can do.

    Attributes:
        reachable: Share of the postures within 5° of one that the joints' ranges allow.
        feasible: Share of the postures within 5° of the feasible motion.
        unavoidable: Posture error of the feasible motion, which no controller can avoid, percent.
    """

    reachable: float
    feasible: float
    unavoidable: float


def reach_of(motion: Motion, limits: JointLimits) -> Reach:
    """Return how much of a motion a robot can do.

    Args:
        motion: The motion, feasible for the robot (`fitted`).
        limits: Limits of the robot's joints.
    """
    # Here, as it takes longer to import than most motions to read.
    from mpma_mj.metrics import posture_error_percent

    angles, feasible_ones = motion.joint_angles, _are_feasible(motion, limits)
    missed = []
    for arm, chain in enumerate(_chains(limits)):
        directions = motion.posture[:, 6 * arm : 6 * arm + 6]
        nearest = nearest_branch(chain, directions, angles[:, 4 * arm : 4 * arm + 4])
        missed.append(deviation(chain, nearest, directions))
    reachable = (np.max(missed, axis=0) <= REACHED) | feasible_ones
    shown = limits.kinematics.posture(angles)
    return Reach(
        float(np.mean(reachable)),
        float(np.mean(feasible_ones)),
        posture_error_percent(shown, motion.posture),
    )


def close_tempo(read: Callable[[float], Motion], limits: JointLimits) -> tuple[float, float]:
    """Return the tempo up to which a robot does nearly all of a motion that it can do at all.

    What it cannot do at a quarter of the tempo is not for lack of speed: ranges do not allow it, or
    to go on it would have to change the branch.

    Args:
        read: Reads the motion at a tempo.
        limits: Limits of the robot's joints.

    Returns:
        The tempo, in steps of 0.05 from 0.25 to 1, and the share of the postures that is feasible
        there: at most 0.05 less than at 0.25.
    """

    def share(tempo: float) -> float:
        return _share(read(tempo), limits)

    enough = share(_TEMPI[0]) - _NEARLY
    last = bisect.bisect_right(_TEMPI[1:], 0.0, key=lambda tempo: max(enough - share(tempo), 0.0))
    return _TEMPI[last], share(_TEMPI[last])


def slower_tempo(motion: Motion, limits: JointLimits) -> str:
    """Return a tempo at which a robot that is too slow for a motion can do more of it, as a remedy.

    Args:
        motion: The motion, feasible for the robot.
        limits: Limits of the robot's joints.

    Returns:
        Text with a place for the option `tempo`; empty where the robot is fast enough.
    """
    reach = reach_of(motion, limits)
    if reach.reachable - reach.feasible <= _TOO_SLOW:
        return ""
    for tempo in _SLOWER:
        share = _share(at_rate(motion, motion.rate, tempo), limits)
        if reach.reachable - share <= _TOO_SLOW:
            break
    if share - reach.feasible <= _TOO_SLOW:
        return ""
    return (
        f"{{tempo={motion.tempo * tempo:.3g}}} leaves {100 * share:.0f} % of the steps within"
        f" {REACHED:g}°, this one {100 * reach.feasible:.0f} %"
    )


def reach_lines(
    reach: Reach, read: Callable[[float], Motion] | None, limits: JointLimits
) -> list[str]:
    """Describe how much of a motion a robot can do, in lines of text.

    Args:
        reach: What it can do.
        read: Reads the motion at a tempo, relative to the present one; None where the tempo was
            looked for.
        limits: Limits of the robot's joints.
    """
    lines = [
        f"reachable: {100 * reach.reachable:.1f} % of the postures, each alone: within {REACHED:g}°"
        " of one that the joints' ranges allow",
        f"feasible: {100 * reach.feasible:.1f} % of them in the whole motion: within {REACHED:g}°"
        " of the closest one at the joints' speeds, which has an error of"
        f" {reach.unavoidable:.2f} % that no controller can avoid",
    ]
    if reach.feasible == 1.0 or read is None:
        return lines
    tempo, share = close_tempo(read, limits)
    if tempo == 1.0:
        return [*lines, "a slower tempo hardly changes that"]
    part = "all" if share == 1.0 else f"{100 * share:.1f} %"
    return [*lines, f"at {tempo:g} of this tempo {part} of it is feasible"]


def _share(motion: Motion, limits: JointLimits) -> float:
    """Return the share of the postures of a motion that are feasible."""
    return float(np.mean(_are_feasible(fitted(motion, limits)[0], limits)))


def _are_feasible(motion: Motion, limits: JointLimits) -> NDArray[np.bool_]:
    """Return of which postures no segment is turned by more than 5° in a feasible motion, (T,)."""
    return turned(motion, limits.kinematics).max(axis=1) <= REACHED


def _chains(limits: JointLimits) -> tuple[Chain, ...]:
    """Return the left and the right arm."""
    if isinstance(limits.kinematics, ChainArms):
        return limits.kinematics.chains
    return tuple(
        Chain(axes, _DOWN, _DOWN, limits.lowest[own], limits.highest[own])
        for axes, own in zip(_AXES, (slice(0, 4), slice(4, 8)), strict=True)
    )
