"""Postures from points of the body: directions of the arms' segments in the torso frame."""

from __future__ import annotations

from collections.abc import Container

import numpy as np
from numpy.typing import NDArray

from mpma_mj.errors import MotionFileError
from mpma_mj.kinematics import SIDES

__all__ = [
    "ARM_POINTS",
    "TORSO_POINTS",
    "check_segments",
    "forward",
    "has_trunk",
    "posture_from_points",
    "segments",
    "trunk",
]

Array = NDArray[np.float64]

ARM_POINTS = tuple(f"{side}_{point}" for side in SIDES for point in ("shoulder", "elbow", "wrist"))
TORSO_POINTS = ("pelvis", "neck")

# A segment under this share of its usual length is a tracking fault, not an arm. Skin markers
# slide by a tenth, so the share is far from what a body can do.
_SHORTEST = 0.05


def posture_from_points(points: dict[str, Array]) -> Array:
    """Compute the directions of upper arms and forearms in the frame of the torso.

    z points along the trunk, from pelvis to neck, or up where these are not known, y from the
    right to the left shoulder, made perpendicular to it, and x = y × z forward: turning, walking
    or (with a trunk) bending does not move the robot's arms. The directions are unit vectors, so
    that the person's proportions do not matter.

    Args:
        points: The points of `ARM_POINTS` and perhaps of `TORSO_POINTS`, each shape (T, 3), any
            unit, z up.

    Returns:
        Posture, shape (T, 12).
    """
    z_axis = _unit(trunk(points))
    y_axis = _unit(_across(points))
    to_torso = np.stack([np.cross(y_axis, z_axis), y_axis, z_axis], axis=1)  # (T, 3, 3)
    arms = segments(points).values()
    return np.concatenate([np.einsum("tij,tj->ti", to_torso, _unit(s)) for s in arms], axis=1)


def check_segments(points: dict[str, Array], where: str, first: int = 0) -> None:
    """Refuse points that are not those of arms.

    Args:
        points: As for `posture_from_points`, or those of one arm, frames as in the recording.
        where: What an error calls the recording.
        first: Index of the first frame in the file.

    Raises:
        MotionFileError: A segment has no length, or the shoulders are above each other; names
            the frame.
    """
    _check_lengths({"trunk": trunk(points)} | segments(points), where, first)
    if all(f"{side}_shoulder" in points for side in SIDES):
        across = {"line between the shoulders, seen from above,": _across(points)}
        _check_lengths(across, where, first)


def _check_lengths(lines: dict[str, Array], where: str, first: int) -> None:
    for name, vectors in lines.items():
        how = "above each other" if "shoulders" in name else "in one place"
        length = np.linalg.norm(vectors, axis=1)
        too_short = length <= _SHORTEST * np.median(length)
        if too_short.mean() > 0.5:
            raise MotionFileError(
                f"{where}: the {name} has no length in {too_short.sum()} of {len(length)} frames;"
                " its markers coincide there",
                remedy="name others with {map}",
            )
        if too_short.any():
            i = int(np.argmax(too_short))
            raise MotionFileError(
                f"{where}: the {name} has length {length[i]:.3g} at frame {first + i + 1} (median"
                f" {np.median(length):.3g}); two markers lie {how}",
                remedy="correct that frame, or cut it off with {start} and {end}",
            )


def has_trunk(points: Container[str]) -> bool:
    """Return whether points show the trunk, which needs pelvis and neck."""
    return all(point in points for point in TORSO_POINTS)


def trunk(points: dict[str, Array]) -> Array:
    """Return the way from pelvis to neck, or up where these are not known, shape (T, 3)."""
    if has_trunk(points):
        return points["neck"] - points["pelvis"]
    return np.broadcast_to([0.0, 0.0, 1.0], next(iter(points.values())).shape)


def segments(points: dict[str, Array]) -> dict[str, Array]:
    """Return the segments of the arms that are there by name, in a posture's order, (T, 3)."""
    ends = {"upper arm": ("shoulder", "elbow"), "forearm": ("elbow", "wrist")}
    return {
        f"{side} {name}": points[f"{side}_{end}"] - points[f"{side}_{start}"]
        for side in SIDES
        for name, (start, end) in ends.items()
        if f"{side}_{end}" in points
    }


def forward(points: dict[str, Array]) -> Array:
    """Return unit vectors to the front of the torso, shape (T, 3)."""
    return np.cross(_unit(_across(points)), _unit(trunk(points)))


def _across(points: dict[str, Array]) -> Array:
    """Return the way from the right to the left shoulder, perpendicular to the trunk, (T, 3)."""
    across = points["left_shoulder"] - points["right_shoulder"]
    up = _unit(trunk(points))
    return across - np.sum(across * up, axis=1, keepdims=True) * up


def _unit(vectors: Array) -> Array:
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
