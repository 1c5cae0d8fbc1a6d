"""From points on a dancer to postures: directions of the arms' segments in the torso frame."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mpma_mj.arm import SIDES
from mpma_mj.errors import MotionFileError

__all__ = ["ARM_POINTS", "check_segments", "posture_from_points"]

Array = NDArray[np.float64]

ARM_POINTS = tuple(f"{side}_{point}" for side in SIDES for point in ("shoulder", "elbow", "wrist"))

# A segment under this share of its usual length is a tracking fault, not an arm. Skin markers
# slide by a tenth, so the share is far from what a body can do.
_SHORTEST = 0.05


def posture_from_points(points: dict[str, Array]) -> Array:
    """Compute the directions of upper arms and forearms as the dancer's torso sees them.

    The torso frame has y from the right to the left shoulder, made horizontal, and z up, so
    that a dancer who turns or walks does not move the robot's arms. Dividing by the segments'
    lengths removes the dancer's proportions.

    Args:
        points: The points of `ARM_POINTS`, each shape (T, 3), any unit, z up.

    Returns:
        Posture, shape (T, 12).
    """
    y_axis = _unit(_across(points))
    z_axis = np.broadcast_to([0.0, 0.0, 1.0], y_axis.shape)
    to_torso = np.stack([np.cross(y_axis, z_axis), y_axis, z_axis], axis=1)  # (T, 3, 3)
    segments = _segments(points).values()
    return np.concatenate([np.einsum("tij,tj->ti", to_torso, _unit(s)) for s in segments], axis=1)


def check_segments(points: dict[str, Array], where: str) -> None:
    """Refuse points that show no arms.

    Args:
        points: The points of `ARM_POINTS`, each shape (T, 3), frames as in the recording.
        where: What an error calls the recording.

    Raises:
        MotionFileError: A segment has no length, or the shoulders are above each other; names
            the frame.
    """
    shoulders = {"line between the shoulders, seen from above,": _across(points)}
    for name, vectors in (shoulders | _segments(points)).items():
        length = np.linalg.norm(vectors, axis=1)
        too_short = length <= _SHORTEST * np.median(length)
        if too_short.any():
            frame = int(np.argmax(too_short))
            raise MotionFileError(
                f"{where}: the {name} has length {length[frame]:.3g} at frame {frame + 1} (median"
                f" {np.median(length):.3g}); two markers lie in one place, so mend or cut that"
                " frame"
            )


def _across(points: dict[str, Array]) -> Array:
    """Return the way from the right to the left shoulder, made horizontal, (T, 3)."""
    return (points["left_shoulder"] - points["right_shoulder"]) * [1.0, 1.0, 0.0]


def _segments(points: dict[str, Array]) -> dict[str, Array]:
    """Return the segments' vectors by name, in the order of a posture, each (T, 3)."""
    ends = {"upper arm": ("shoulder", "elbow"), "forearm": ("elbow", "wrist")}
    return {
        f"{side} {name}": points[f"{side}_{end}"] - points[f"{side}_{start}"]
        for side in SIDES
        for name, (start, end) in ends.items()
    }


def _unit(vectors: Array) -> Array:
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
