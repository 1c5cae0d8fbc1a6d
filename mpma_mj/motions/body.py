"""From points on a dancer to postures: directions of the arms' segments in the torso frame."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mpma_mj.arm import SIDES
from mpma_mj.errors import MotionFileError

__all__ = ["ARM_POINTS", "posture_from_points"]

Array = NDArray[np.float64]

ARM_POINTS = tuple(f"{side}_{point}" for side in SIDES for point in ("shoulder", "elbow", "wrist"))

# A segment under this share of its usual length is a tracking fault, not an arm. Skin markers
# slide by a tenth, so the share is far from what a body can do.
_SHORTEST = 0.05


def posture_from_points(points: dict[str, Array], where: str) -> Array:
    """Compute the directions of upper arms and forearms as the dancer's torso sees them.

    The torso frame has y from the right to the left shoulder, made horizontal, and z up, so
    that a dancer who turns or walks does not move the robot's arms. Dividing by the segments'
    lengths removes the dancer's proportions.

    Args:
        points: The points of `ARM_POINTS`, each shape (T, 3), any unit, z up.
        where: What an error calls the recording.

    Returns:
        Posture, shape (T, 12).

    Raises:
        MotionFileError: A segment has no length, or the shoulders are above each other.
    """
    across = points["left_shoulder"] - points["right_shoulder"]
    across = across * [1.0, 1.0, 0.0]
    y_axis = _directions(across, "line between the shoulders, seen from above,", where)
    z_axis = np.broadcast_to([0.0, 0.0, 1.0], y_axis.shape)
    to_torso = np.stack([np.cross(y_axis, z_axis), y_axis, z_axis], axis=1)  # (T, 3, 3)
    segments = []
    for side in SIDES:
        shoulder, elbow, wrist = (points[f"{side}_{p}"] for p in ("shoulder", "elbow", "wrist"))
        segments.append(_directions(elbow - shoulder, f"{side} upper arm", where))
        segments.append(_directions(wrist - elbow, f"{side} forearm", where))
    return np.concatenate([np.einsum("tij,tj->ti", to_torso, s) for s in segments], axis=1)


def _directions(vectors: Array, name: str, where: str) -> Array:
    length = np.linalg.norm(vectors, axis=1)
    too_short = length <= _SHORTEST * np.median(length)
    if too_short.any():
        frame = int(np.argmax(too_short))
        raise MotionFileError(
            f"{where}: the {name} has length {length[frame]:.3g} at frame {frame + 1} (median"
            f" {np.median(length):.3g}); two markers lie in one place, so mend or cut that frame"
        )
    return vectors / length[:, None]
