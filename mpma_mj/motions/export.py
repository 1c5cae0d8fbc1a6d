"""Export of motions to files of animation (BVH), biomechanics (TRC) and robots (CSV)."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpma_mj.errors import BadOptionError
from mpma_mj.joint_paths import unwound
from mpma_mj.kinematics import JOINT_NAMES, SIDES, angles_from_posture, wrap
from mpma_mj.motions.feasibility import JointLimits
from mpma_mj.motions.motion import Motion, save_motion
from mpma_mj.options import TWO_ARM
from mpma_mj.utils.atomic_files import atomic_write
from mpma_mj.utils.text import printable

__all__ = ["MOTION_FORMATS", "export_motion", "write_joint_angles"]

Array = NDArray[np.float64]

# Proportions of the package's arms and their torso, m.
_UPPER_ARM, _FOREARM, _HAND = 0.2817, 0.2689, 0.12
_SHOULDER = 0.19  # from the middle
_PELVIS, _CHEST, _SHOULDERS, _NECK = 0.66, 1.05, 1.15, 1.2  # above the floor

# Skeleton of a BVH in T-pose: parent and offset of each joint, x left, y up, z forward, m; and the
# ends of its bones.
_LEFT: dict[str, tuple[str, tuple[float, float, float]]] = {
    "LeftShoulder": ("Chest", (0.05, _SHOULDERS - _CHEST, 0.0)),
    "LeftArm": ("LeftShoulder", (_SHOULDER - 0.05, 0.0, 0.0)),
    "LeftForeArm": ("LeftArm", (_UPPER_ARM, 0.0, 0.0)),
    "LeftHand": ("LeftForeArm", (_FOREARM, 0.0, 0.0)),
}
_RIGHT = {
    name.replace("Left", "Right"): (parent.replace("Left", "Right"), (-x, y, z))
    for name, (parent, (x, y, z)) in _LEFT.items()
}
_BONES = {
    "Hips": ("", (0.0, 0.0, 0.0)),
    "Spine": ("Hips", (0.0, 0.17, 0.0)),
    "Chest": ("Spine", (0.0, _CHEST - _PELVIS - 0.17, 0.0)),
    "Neck": ("Chest", (0.0, _NECK - _CHEST, 0.0)),
    "Head": ("Neck", (0.0, 0.1, 0.0)),
    **_LEFT,
    **_RIGHT,
}
_ENDS = {"Head": (0.0, 0.2, 0.0), "LeftHand": (_HAND, 0.0, 0.0), "RightHand": (-_HAND, 0.0, 0.0)}
_CENTIMETRES = 100.0  # a metre's, the unit of a BVH


def export_motion(path: str | Path, motion: Motion, limits: JointLimits | None = None) -> None:
    """Write a motion, at its own rate and tempo, to a file for other programs.

    The ending of the name decides: `.csv` has columns of time, s, and of the motion's joint angles,
    rad, less whole turns (`joint_paths.unwound`) where a joint has no range, titled by the joints;
    `.bvh` has a skeleton of the upper body that turns to the postures, cm and y up; `.trc` has
    shoulders, elbows, wrists, pelvis and neck, mm and y up; `.npz` has the motion itself, with its
    context.

    Args:
        path: The file; an existing one is replaced.
        motion: The motion.
        limits: Limits of the robot whose joint angles the motion has, as `arm_limits` returns them;
            `.bvh` and `.trc` then have its postures. Those of the package's arms need not be given.

    Raises:
        BadOptionError: The name has another ending, or the joint angles are of another robot.
        RunFolderError: The file cannot be written.
    """
    path = Path(path)
    if path.suffix not in _WRITERS:
        expected = f"a file name that ends in {' or '.join(MOTION_FORMATS)}"
        raise BadOptionError(option="path", value=str(path), expected=expected)
    of_limits = TWO_ARM if limits is None else limits.kinematics.name
    if path.suffix != ".npz" and motion.angles_of != of_limits:
        problem = f"{motion.name} has joint angles of {motion.angles_of}, not of {of_limits}"
        raise BadOptionError(problem, remedy="give {limits} of the robot for which it was read")
    if limits is None or of_limits == TWO_ARM or path.suffix == ".npz":
        _WRITERS[path.suffix](path, motion)
    elif path.suffix == ".csv":
        write_joint_angles(path, motion.joint_angles, motion.rate, limits=limits)
    else:
        posture = limits.kinematics.posture(motion.joint_angles)
        shown = dataclasses.replace(
            motion, posture=posture, feasible_angles=None, angles_of=TWO_ARM
        )
        _WRITERS[path.suffix](path, shown)


def write_joint_angles(
    path: Path,
    joint_angles: Array,
    rate: float,
    commands: Array | None = None,
    limits: JointLimits | None = None,
) -> None:
    """Write joint angles, and perhaps the commands that followed them, as CSV.

    Args:
        path: The file.
        joint_angles: Joint angles, shape (T, 8), rad.
        rate: Rows per second, Hz.
        commands: Joint velocities commanded from each row's time until the next, shape (T, 8),
            rad/s.
        limits: Limits of the arms, whose joints title the columns and, where they have no range,
            lose whole turns; if not given, joints of the package's arms, whose angles stay.

    Raises:
        RunFolderError: The file cannot be written.
    """
    names = JOINT_NAMES
    if limits is not None:
        names, free = limits.kinematics.joint_names, limits.highest - limits.lowest == np.inf
        joint_angles = np.where(free, unwound(joint_angles), joint_angles)
    titles = ["time", *(f"{joint}_rad" for joint in names)]
    columns = [_times(joint_angles, rate), joint_angles]
    if commands is not None:
        titles += (f"{joint}_command_rad/s" for joint in names)
        columns.append(commands)
    _write(path, [",".join(titles)], np.column_stack(columns), "%.9f", ",")


def _write_csv(path: Path, motion: Motion) -> None:
    write_joint_angles(path, unwound(motion.joint_angles), motion.rate)


def _write_bvh(path: Path, motion: Motion) -> None:
    """Write a skeleton whose channels are joint angles.

    From the T-pose, in which abduction is π/2, an upper arm turns by R Rx(-π/2) = Rx(a - π/2)
    Rz(-b) Ry(-c), with R and the angles a, b, c, e of `kinematics`, and a forearm by Rz(-e); the
    right arm is the mirror image. In the axes of the file these are turns about z, y, x and y,
    which are continuous up to a turn; what is beyond is less whole turns.
    """
    joint_angles = angles_from_posture(motion.posture, near=unwound(motion.joint_angles))
    names = list(_BONES)
    channels = np.zeros((len(motion), len(names), 3))  # turns about z, y and x
    for side, angles in zip(SIDES, np.split(joint_angles, 2, axis=1), strict=True):
        a, b, c, e = np.degrees(angles).T
        mirror = 1.0 if side == "left" else -1.0
        arm, forearm = (names.index(f"{side.title()}{name}") for name in ("Arm", "ForeArm"))
        channels[:, arm] = np.stack([mirror * (a - 90.0), -mirror * b, -c], axis=1)
        channels[:, forearm, 1] = -mirror * e
    channels = np.where(np.abs(channels) > 360.0, np.degrees(wrap(np.radians(channels))), channels)
    place = np.tile([0.0, _CENTIMETRES * _PELVIS, 0.0], (len(motion), 1))
    header = [
        "HIERARCHY",
        *_joint("Hips", ""),
        "MOTION",
        f"Frames: {len(motion)}",
        f"Frame Time: {1.0 / motion.rate:.9f}",
    ]
    _write(path, header, np.column_stack([place, channels.reshape(len(motion), -1)]), "%.6f", " ")


def _joint(name: str, indent: str) -> Iterator[str]:
    """Yield the lines of a joint and of all that hang on it."""
    parent, offset = _BONES[name]
    inner = f"{indent}\t"
    turns = "Zrotation Yrotation Xrotation"
    yield from (f"{indent}{'JOINT' if parent else 'ROOT'} {name}", f"{indent}{{")
    yield f"{inner}{_offset(offset)}"
    yield (
        f"{inner}CHANNELS 3 {turns}"
        if parent
        else f"{inner}CHANNELS 6 Xposition Yposition Zposition {turns}"
    )
    for child, (its_parent, _) in _BONES.items():
        if its_parent == name:
            yield from _joint(child, inner)
    if name in _ENDS:
        yield from (
            f"{inner}End Site",
            f"{inner}{{",
            f"{inner}\t{_offset(_ENDS[name])}",
            f"{inner}}}",
        )
    yield f"{indent}}}"


def _offset(offset: Sequence[float]) -> str:
    return "OFFSET " + " ".join(f"{_CENTIMETRES * way:.6f}" for way in offset)


def _write_trc(path: Path, motion: Motion) -> None:
    """Write points of a body that stands and faces x, with y up, as OpenSim has it."""
    points = _points(motion.posture)
    count, frames = len(points), len(motion)
    header = [
        f"PathFileType\t4\t(X/Y/Z)\t{printable(path.name)}",
        "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame"
        "\tOrigNumFrames",
        f"{motion.rate:.9g}\t{motion.rate:.9g}\t{frames}\t{count}\tmm\t{motion.rate:.9g}\t1\t{frames}",
        "Frame#\tTime\t" + "\t\t\t".join(points),
        "\t\t" + "\t".join(f"{axis}{i + 1}" for i in range(count) for axis in "XYZ"),
        "",
    ]
    places = [1000.0 * track[:, [0, 2, 1]] * [1.0, 1.0, -1.0] for track in points.values()]
    number = np.arange(1, frames + 1)
    rows = np.column_stack([number, _times(motion.posture, motion.rate), *places])
    _write(path, header, rows, ["%d", *["%.9f"] * (rows.shape[1] - 1)], "\t")


def _points(posture: Array) -> dict[str, Array]:
    """Return points of a body in these postures, shape (T, 12), each (T, 3), z up, m."""
    standing = np.ones((len(posture), 1))
    points = {"pelvis": standing * [0.0, 0.0, _PELVIS], "neck": standing * [0.0, 0.0, _NECK]}
    for i, side in enumerate(SIDES):
        upper_arm, forearm = posture.reshape(-1, 2, 2, 3)[:, i].swapaxes(0, 1)
        points[f"{side}_shoulder"] = standing * [0.0, (_SHOULDER, -_SHOULDER)[i], _SHOULDERS]
        points[f"{side}_elbow"] = points[f"{side}_shoulder"] + _UPPER_ARM * upper_arm
        points[f"{side}_wrist"] = points[f"{side}_elbow"] + _FOREARM * forearm
    return points


def _times(rows: Array, rate: float) -> Array:
    return np.arange(len(rows)) / rate


def _write(
    path: Path, header: Sequence[str], rows: Array, form: str | Sequence[str], separator: str
) -> None:
    """Write lines of a header, and rows of numbers."""
    with (
        atomic_write(path) as temporary,
        temporary.open("w", encoding="utf-8", newline="\n") as file,
    ):
        file.writelines(f"{line}\n" for line in header)
        np.savetxt(file, rows + 0.0, fmt=form, delimiter=separator)  # + 0.0: no -0


_WRITERS: dict[str, Callable[[Path, Motion], None]] = {
    ".bvh": _write_bvh,
    ".csv": _write_csv,
    ".npz": save_motion,
    ".trc": _write_trc,
}
MOTION_FORMATS = tuple(_WRITERS)
"""Endings of the names of files that a motion can be written to."""
