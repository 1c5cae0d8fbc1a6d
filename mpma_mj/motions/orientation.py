"""A recording's unit, the axis that points up, and whether left and right are swapped."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mpma_mj.errors import MotionFileError
from mpma_mj.kinematics import SIDES
from mpma_mj.motions.body import ARM_POINTS, TORSO_POINTS, has_trunk, segments, trunk
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.mapping import TRUNK_OPTION, Groups, mapping_option
from mpma_mj.motions.options import ReadingOptions
from mpma_mj.motions.readers.recording import UNITS, UPS, Tracks, Up

__all__ = [
    "arm_length",
    "check_handedness",
    "check_sides",
    "find_unit",
    "find_up",
    "refuse_pictures",
    "turn_z_up",
]

Array = NDArray[np.float64]

_ARM = 0.55  # m: upper arm and forearm of an adult
_ARMS = (0.25, 0.9)  # m: of children and giants
# Acclaim skeletons count in inches divided by 0.45, which BVH files made of them keep.
_LENGTHS = {**UNITS, "inch/0.45": UNITS["inch"] / 0.45}
_USUAL = ("y", "z")  # axes that point up in nearly every file
_CLEAR = 0.7  # share of a direction along one axis from which it decides
_ENOUGH = 4096  # frames that show whether it is a picture
_FLAT = 0.02  # of a picture's width and height, under which there is no depth
# Lengths of segments vary by more than that of skin markers, and by far less with other scales of
# the axes: then these are not those of space (choices).
_VARIED = 0.05
_BETTER = 3.0  # times
_UNEVEN = 1.2  # largest scale by smallest
# Of left and right:
_MOSTLY = 0.5  # share of the time
_FORWARD = 0.2  # of a forearm's length that it has to point forward or backward to count
_MOSTLY_BACKWARD = 0.75  # share of the time
_PARTS = ("shoulder", "elbow", "wrist")
_OFTEN = 0.1  # share of the time in which forearms have to point anywhere


def arm_length(points: dict[str, Array]) -> float:
    """Return the usual length of upper arm and forearm, the longer side, in the file's unit."""
    length = {k: np.nanmedian(np.linalg.norm(v, axis=1)) for k, v in segments(points).items()}
    return float(
        max(
            length[f"{side} upper arm"] + length[f"{side} forearm"]
            for side in SIDES
            if f"{side} forearm" in length
        )
    )


def find_unit(
    arm: float, declared: float | None, given: float | None, report: ImportReport
) -> float | None:
    """Find the length of a recording's unit by the length of the arms.

    Args:
        arm: Length of an arm, in the unit.
        declared: Unit in the file, m.
        given: Unit that the user gives, m.
        report: Gets what is taken, and a warning if the file must be wrong.

    Returns:
        Length of the unit, m; None if no usual one fits arms. Postures do not depend on it.
    """
    if given is not None:
        report.note(f"unit {_name(given)}, as given")
        if not _ARMS[0] <= arm * given <= _ARMS[1]:
            report.warn(
                f"unit {_name(given)}, as given, makes arms of {arm * given:.3g} m; the motion is"
                " the same in any unit"
            )
        return given
    if declared is not None and _ARMS[0] <= arm * declared <= _ARMS[1]:
        report.note(f"unit {_name(declared)}, as the file declares")
        return declared
    best = min(_LENGTHS.values(), key=lambda unit: abs(np.log(arm * unit / _ARM)))
    fits = _ARMS[0] <= arm * best <= _ARMS[1]
    if declared is not None:
        report.warn(
            f"the file declares {_name(declared)}, which makes arms of {arm * declared:.3g} m;"
            f" {_name(best) + ' is used' if fits else 'no usual unit fits'}",
            remedy="{unit} overrides it",
        )
    elif fits:
        report.note(f"unit {_name(best)}, by the length of the arms")
    else:
        report.warn(
            f"arms are {arm:.3g} long, which fits no usual unit", remedy="set it with {unit}"
        )
    return best if fits else None


def find_up(
    points: dict[str, Array],
    declared: Up | None,
    given: Up | None,
    where: str,
    report: ImportReport,
    removed_trunk: Array | None = None,
    others: str = "",
) -> Up:
    """Find the axis that points up: by the trunk, the file, or hanging arms, in this order.

    Args:
        points: The points of `body.ARM_POINTS` and perhaps of `body.TORSO_POINTS`, each shape
            (T, 3), without gaps.
        declared: Axis in the file, or of its format.
        given: Axis that the user gives.
        where: What an error calls the recording.
        report: Gets what is taken.
        removed_trunk: Vectors from pelvis to neck, shape (N, 3), of frames in which both are seen,
            if they are seen too rarely to be among the points.
        others: Names in the file that are not recognised, among which the trunk may be.

    Raises:
        MotionFileError: None of these shows it.
    """
    if given is not None:
        report.note(f"{given} is up, as given")
        return given
    trunk_shown = has_trunk(points) or removed_trunk is not None
    how = "by the trunk" if trunk_shown else "by the hanging upper arms"
    shown = _shown_up(points, removed_trunk)
    if not trunk_shown and shown not in _USUAL:  # then it is rather the arms that do not hang
        shown = None
    if declared is not None and (shown in (declared, None) or not trunk_shown):
        report.note(f"{declared} is up, as the file or its format declares")
        return declared
    if shown is None and has_trunk(points):
        return "z"  # the trunk's direction is known in every frame, so that none else matters
    if shown is None:
        problem = (
            "the up axis is unknown: the file does not declare it, and the arms do not hang down"
        )
        remedy = "give the axis with {up}, such as {up=z}"
        if others:
            problem = f"no point of the trunk is recognised among {others}, and {problem}"
            remedy = f"name pelvis and neck with {TRUNK_OPTION}, or {remedy}"
        raise MotionFileError(f"{where}: {problem}", remedy=remedy)
    instead = f"; the file or its format declares {declared}" if declared is not None else ""
    report.note(f"{shown} is up, {how}{instead}")
    return shown


def _shown_up(points: dict[str, Array], removed_trunk: Array | None = None) -> Up | None:
    """Return the axis along which the trunk points, or else against which the upper arms hang."""
    if removed_trunk is not None:
        return _axis_of(removed_trunk)
    if has_trunk(points):
        return _axis_of(trunk(points))
    hanging = [-vectors for name, vectors in segments(points).items() if "upper" in name]
    return _axis_of(np.concatenate(hanging))


def refuse_pictures(points: dict[str, Array], where: str) -> None:
    """Refuse places in a picture, which pose estimators give in pixels or shares of its size.

    Args:
        points: Points as in the file, each shape (T, 3).
        where: What an error calls the recording.

    Raises:
        MotionFileError: x and y are shares, and y is vertical; or all points have one depth; or
            the axes have different scales.
    """
    places = np.concatenate([track[:: len(track) // _ENOUGH + 1] for track in points.values()])
    low, high = np.percentile(places, (5.0, 95.0), axis=0)
    is_share = (low[:2] >= 0.0).all() and (high[:2] <= 1.0).all()
    is_vertical = _shown_up(points) in ("y", "-y", None)
    has_depth = low[2] > 0.0 and high[2] > 1.0  # m from a camera
    width, height, depth = high - low
    if is_share and is_vertical and not has_depth:
        raise MotionFileError(
            f"{where}: x and y of all points are between 0 and 1, so they are shares of a picture's"
            " width and height, which keep no angles",
            remedy="export the pose estimator's world landmarks; if they are metres, say so with"
            " {unit=m}",
        )
    if depth < _FLAT * min(width, height):
        raise MotionFileError(
            f"{where}: z of all points varies by {depth:.3g}, x and y by {width:.3g} and"
            f" {height:.3g}: these are places in a picture, without depth",
            remedy="export places in space, such as the pose estimator's world landmarks; a motion"
            " within one plane is read with {unit=m}",
        )
    scales, varied, left = _scales_of_axes(points)
    if varied > _VARIED and left * _BETTER < varied and max(scales) > _UNEVEN * min(scales):
        raise MotionFileError(
            f"{where}: lengths of segments vary by {100 * varied:.0f} %, but by {100 * left:.0f} %"
            f" if x, y and z are stretched as {' : '.join(f'{s:.3g}' for s in scales)}: these are"
            " places in a picture, which keep no angles",
            remedy="export places in space, such as the pose estimator's world landmarks; {unit=m}"
            " reads them as they are",
        )


def _scales_of_axes(points: dict[str, Array]) -> tuple[tuple[float, ...], float, float]:
    """Find scales of y and z, that of x being 1, with which segments vary least in length.

    A squared length is linear in the squared scales, so that these follow by least squares.

    Returns:
        The scales of x, y and z; and by what share of their root mean square lengths vary, as
        they are and with the scales.
    """
    lines = list(segments(points).values())
    if has_trunk(points):
        lines.append(trunk(points))
    squares = [line[:: len(line) // _ENOUGH + 1] ** 2 for line in lines]
    squares = [square / square.sum(axis=1).mean() for square in squares]
    change = np.concatenate([square - square.mean(axis=0) for square in squares])
    found, *_ = np.linalg.lstsq(change[:, 1:], -change[:, 0])
    if not (found > 0.0).all():
        found = np.ones(2)
    weights = np.array([1.0, *found])

    def varied(weights: Array) -> float:
        lengths = np.concatenate(
            [square @ weights / (square @ weights).mean() for square in squares]
        )
        return float(lengths.std() / 2.0)  # of the squares, which vary by twice as much

    return tuple(np.sqrt(weights)), varied(np.ones(3)), varied(weights)


def turn_z_up(track: Array, up: Up) -> Array:
    """Turn a trajectory, shape (T, 3), so that its up axis is z."""
    axis = "xyz".index(up[-1])
    turned = track[:, [(axis + 1) % 3, (axis + 2) % 3, axis]]
    return turned * [1.0, -1.0, -1.0] if up.startswith("-") else turned


def _axis_of(vectors: Array) -> Up | None:
    """Return the axis along which vectors, shape (N, 3), mostly point, if there is a clear one."""
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    mean = np.mean(vectors / np.maximum(length, np.finfo(float).tiny), axis=0)
    axis = int(np.argmax(np.abs(mean)))
    if abs(mean[axis]) < _CLEAR:
        return None
    name = f"{'-' if mean[axis] < 0 else ''}{'xyz'[axis]}"
    return next(up for up in UPS if up == name)


def _name(unit: float) -> str:
    return next((n for n, length in _LENGTHS.items() if length == unit), f"of {unit:g} m")


def check_sides(
    points: dict[str, Array], posture: Array, groups: Groups, report: ImportReport
) -> None:
    """Warn of a file in which left and right seem to be swapped.

    Args:
        points: The points of `body.ARM_POINTS`, each shape (T, 3).
        posture: Postures, shape (T', 12).
        groups: Which markers show which point, for what mends it.
        report: Gets the warning.
    """
    across = points["left_shoulder"] - points["right_shoulder"]
    middle = 0.5 * (points["left_shoulder"] + points["right_shoulder"])
    crossed = {
        side: np.sum((points[f"{side}_elbow"] - middle) * across, axis=1) * sign < 0
        for side, sign in (("left", 1.0), ("right", -1.0))
    }
    share = float(np.mean(crossed["left"] & crossed["right"]))
    if share > _MOSTLY:
        report.warn(
            f"both elbows are beyond the body's midline in {100 * share:.0f} % of the frames: left"
            " and right look swapped",
            remedy=f"{_swapped(groups, ('elbow', 'wrist'))} corrects that",
        )
        return
    vectors = posture.reshape(-1, 4, 3)
    # An elbow bends its forearm forwards; with left and right swapped, front is taken for back.
    bent = vectors[:, 1::2, 0] - vectors[:, 0::2, 0]
    # Only below the shoulder: over the head a bent elbow may point either way.
    clear = (np.abs(bent) > _FORWARD) & (vectors[:, 0::2, 2] < 0.0)
    backward = float(np.mean(bent[clear] < 0)) if clear.any() else 0.0
    if backward > _MOSTLY_BACKWARD and clear.mean() > _OFTEN:
        report.warn(
            f"forearms point backwards in {100 * backward:.0f} % of the frames in which they are"
            " bent: the file's axes look left-handed, as in Unity, or left and right are swapped,"
            " or up and down",
            remedy=f"{{left_handed}} corrects the first, {_swapped(groups, _PARTS)} the second,"
            " {up} the third",
        )


def check_handedness(
    tracks: Tracks, groups: Groups, facing: Groups, options: ReadingOptions, report: ImportReport
) -> bool:
    """Warn of a file whose front, left and up are those of left-handed axes.

    Args:
        tracks: Trajectories by marker, as in the file, each shape (T, 3).
        groups: Which markers show which point of the body.
        facing: Which are at its "front" and "back".
        options: Whether the file will be mirrored.
        report: Gets the warning.

    Returns:
        Whether there is a warning.
    """
    if not facing["front"] or not groups.keys() >= {*ARM_POINTS, *TORSO_POINTS}:
        return False
    points = {
        point: np.mean([tracks[name] for name in group], axis=0)
        for point, group in (groups | facing).items()
    }
    across = points["left_shoulder"] - points["right_shoulder"]
    forward = np.cross(across, trunk(points))
    shown = np.sum(forward * (points["front"] - points["back"]), axis=1)
    shown = shown[np.isfinite(shown)] * (-1.0 if options.left_handed else 1.0)
    doubted = len(shown) > 0 and bool(np.mean(shown < 0.0) > _MOSTLY_BACKWARD)
    if doubted and options.left_handed:
        report.warn(
            "mirrored, left and right are swapped: the file's axes are right-handed",
            remedy="leave out {left_handed}",
        )
    elif doubted:
        seen = f"{'+'.join(facing['front'])} in front of {'+'.join(facing['back'])}"
        report.warn(
            f"with {seen}, the file's axes look left-handed, as in Unity, or left and right are"
            " swapped",
            remedy=f"{{left_handed}} corrects the first, {_swapped(groups, _PARTS)} the second",
        )
    return doubted


def _swapped(groups: Groups, parts: Sequence[str]) -> str:
    """Return the option with which some points change sides."""
    other = {f"{a}_{p}": groups[f"{b}_{p}"] for p in parts for a, b in (SIDES, SIDES[::-1])}
    return mapping_option(groups | other)
