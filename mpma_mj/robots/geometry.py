"""Geometry of models with two arms: the points of each arm, and its chain of hinges."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np
from numpy.typing import NDArray

from mpma_mj.kinematics import SIDES
from mpma_mj.robots.chain import Chain
from mpma_mj.robots.surface import middle_of_farthest, seen_geoms

__all__ = ["POINTS", "arm_points", "chains", "torso_axes"]

Array = NDArray[np.float64]

# Of the upper arm: farther from an axis a point is no shoulder (choice; a dual Sawyer has 0.51).
_SHOULDER = 0.55

POINTS = ("shoulder", "elbow", "wrist")
"""Points of an arm, which sites mark: `left_shoulder` to `right_wrist`."""


def chains(model: mujoco.MjModel, joints: Sequence[str]) -> tuple[Chain, Chain]:
    """Return the left and the right arm of an assembled model, or of one that has its sites.

    Args:
        model: The model, whose world frame is that of the torso.
        joints: Names of the eight joints.

    Raises:
        BadOptionError: They are no arm of four hinges; see `Chain`.
    """
    data = mujoco.MjData(model)
    hinges = [model.joint(name) for name in joints]
    for hinge in hinges:
        data.qpos[hinge.qposadr] = 0.0
    mujoco.mj_kinematics(model, data)
    found = []
    for side, four in zip(SIDES, (hinges[:4], hinges[4:]), strict=True):
        shoulder, elbow, wrist = (data.site(f"{side}_{point}").xpos for point in POINTS)
        ranges = [h.range if h.limited else np.array([-np.inf, np.inf]) for h in four]
        lowest, highest = np.transpose(ranges)
        axes = data.xaxis[[hinge.id for hinge in four]]
        names = tuple(hinge.name for hinge in four)
        found.append(Chain(axes, elbow - shoulder, wrist - elbow, lowest, highest, names))
    left, right = found
    return left, right


def arm_points(
    model: mujoco.MjModel, data: mujoco.MjData, joints: Sequence[int], wrist: int | None
) -> Array:
    """Return shoulder, elbow and wrist of an arm, shape (3, 3), m, in the world frame.

    The shoulder is the point of axis 3 that is nearest to the middle of the shoulder, which lies on
    axis 2, nearest to axis 1; the elbow is the point of axis 4 that is nearest to axis 3. Both are
    fixed in the upper arm in any posture.

    Args:
        model: The model.
        data: Its simulation, in any posture.
        joints: Indices of the four joints.
        wrist: Index of the joint at the end of the forearm; None for the middle of the vertices
            that are farthest from the elbow.
    """
    anchors, axes = data.xanchor[list(joints)], data.xaxis[list(joints)]
    middle = _nearest(anchors[1], axes[1], anchors[0], axes[0])
    shoulder = anchors[2] + axes[2] * (axes[2] @ (middle - anchors[2]))
    elbow = _nearest(anchors[3], axes[3], anchors[2], axes[2])
    if wrist is not None:
        return np.stack([shoulder, elbow, data.xanchor[wrist]])
    forearm = seen_geoms(model, below=int(model.jnt_bodyid[joints[3]]))
    return np.stack([shoulder, elbow, middle_of_farthest(model, data, forearm, elbow)])


def torso_axes(points: Array, up: Sequence[float]) -> Array:
    """Return the torso's directions forward, left and up, in the rows of an array, shape (3, 3).

    Args:
        points: Points of the left and the right arm, shape (2, 3, 3), m.
        up: Direction that is up, of any length; left is what of the line of the shoulders is
            across it.
    """
    upright = np.asarray(up, float) / np.linalg.norm(up)
    across = points[0, 0] - points[1, 0]
    left = across - upright * (upright @ across)
    left /= np.linalg.norm(left)
    return np.stack([np.cross(left, upright), left, upright])


def is_shoulder(data: mujoco.MjData, joints: Sequence[int], points: Array) -> bool:
    """Return whether the first three axes of an arm pass its shoulder, near enough.

    Args:
        data: Simulation of the model.
        joints: Indices of the four joints.
        points: Shoulder, elbow and wrist, shape (3, 3), m.
    """
    shoulder, elbow, _ = points
    first = list(joints[:2])  # the third passes it by definition
    off = np.cross(shoulder - data.xanchor[first], data.xaxis[first])
    return bool(np.linalg.norm(off, axis=1).max() <= _SHOULDER * np.linalg.norm(elbow - shoulder))


def _nearest(point: Array, axis: Array, other_point: Array, other_axis: Array) -> Array:
    """Return the point of a line that is nearest to another line; `point` where all are."""
    normal = np.cross(axis, other_axis)
    square = float(normal @ normal)
    if square < 1e-12:
        return point
    return point + axis * (np.cross(other_point - point, other_axis) @ normal / square)
