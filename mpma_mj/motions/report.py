"""What a recording holds and asks for, in lines for a reader."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mpma_mj import kinematics
from mpma_mj.errors import MotionReachError, WriteOption, as_keyword
from mpma_mj.motions.feasibility import check_feasibility, joint_speeds
from mpma_mj.motions.reading import Reading

__all__ = ["near_singularity", "report_lines"]

Array = NDArray[np.float64]

# Leverage of a joint over its segment below which a pose counts as near a singularity: within
# 15° of straight forward or back, or an elbow straighter than that (choice).
_LITTLE = np.sin(np.radians(15.0))
_MOST_RUNS = 12  # labels that are listed


def report_lines(
    reading: Reading, max_joint_speed: Array, max_elbow: float, write: WriteOption = as_keyword
) -> list[str]:
    """Describe a recording and what it asks of the arms.

    Args:
        reading: What was read.
        max_joint_speed: Fastest that each joint can turn, shape (8,), rad/s.
        max_elbow: Farthest that an elbow bends, rad.
        write: Writes an option in the reader's language.
    """
    motion = reading.motion
    lines = [
        f"{motion.name}: {reading.format}, {reading.frames} frames at {reading.rate:g} Hz"
        f" ({reading.frames / reading.rate:.2f} s)"
        + (f", {len(reading.names)} points" if reading.names else "")
    ]
    lines += [f"  {point:<15} {' + '.join(group)}" for point, group in reading.groups.items()]
    lines += [f"  {step}" for step in reading.report.steps]
    labels = ", ".join(motion.labels[:_MOST_RUNS])
    more = f" and {len(motion.labels) - _MOST_RUNS} more" if len(motion.labels) > _MOST_RUNS else ""
    lines.append(
        f"movement: {len(motion)} postures at {motion.rate:g} Hz ({motion.duration:.2f} s),"
        f" labels {labels}{more}"
    )
    if reading.lengths:
        unit = "m" if reading.metric else "units of the file"
        lines.append(f"segments: mean length, {unit}, and how much it varies")
        lines += [
            f"  {name:<15} {mean:.3f}  ±{100 * spread / mean:.1f} %"
            for name, (mean, spread) in reading.lengths.items()
        ]
    lines.append("joints:                      range, rad      top speed of its limit, rad/s")
    angles = motion.joint_angles
    fastest = joint_speeds(motion).max(axis=0)
    for joint, name in enumerate(kinematics.JOINT_NAMES):
        low, high = angles[:, joint].min(), angles[:, joint].max()
        mark = "  too fast" if fastest[joint] > max_joint_speed[joint] else ""
        lines.append(
            f"  {name:<25} {low:6.2f} to {high:5.2f}   {fastest[joint]:6.1f} of"
            f" {max_joint_speed[joint]:g}{mark}"
        )
    forward, straight = near_singularity(angles)
    lines.append(
        f"near a singularity: an upper arm points straight forward or back {100 * forward:.0f} %"
        f" of the time, an elbow is straight {100 * straight:.0f} %"
    )
    try:
        check_feasibility(motion, max_joint_speed, max_elbow)
        lines.append("the arms can follow it")
    except MotionReachError as error:
        lines.append(f"the arms cannot follow it: {error.describe(write)}")
    return lines


def near_singularity(joint_angles: Array) -> tuple[float, float]:
    """Return how much of the time a pose is near a singularity.

    Args:
        joint_angles: Joint angles, shape (T, 8), rad.

    Returns:
        Share of the time in which an upper arm points within 15° of straight forward or back,
        and in which an elbow is within 15° of straight.
    """
    little = kinematics.segment_leverage(joint_angles) < _LITTLE
    return float(little[:, [0, 4]].any(axis=1).mean()), float(little[:, [2, 6]].any(axis=1).mean())
