"""Rotations of vectors about fixed axes, and the angles of those that bring them to a place."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["about", "across", "between", "circle", "frame", "rotated"]

Array = NDArray[np.float64]


def rotated(vector: Array, axis: Array, angle: Array) -> Array:
    """Return vectors, shape (..., 3), rotated about a unit vector, (3,), by angles (...), rad.

    cos θ v + sin θ (a × v) + (1 - cos θ) (a · v) a        (Rodrigues)
    """
    cosine, sine = np.cos(angle)[..., None], np.sin(angle)[..., None]
    x, y, z = axis
    cross = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])  # v @ cross = a × v
    along = (vector @ axis)[..., None] * axis
    return along + cosine * (vector - along) + sine * (vector @ cross)


def circle(axis: Array, moved: Array, fixed: Array, angle: Array) -> Array:
    """Return both angles about an axis at which a vector has an angle θ to a fixed one.

    With α and β the angles of both vectors to the axis, and s = (α + β + θ) / 2,

        tan²(φ/2) = sin(s - α) sin(s - β) / (sin s sin(s - θ))        x = x_0 ± φ

    (half-angle formula of spherical trigonometry, exact also near φ = 0), with x_0 at which both
    vectors are on the same side of the axis.

    Args:
        axis: The axis, shape (3,).
        moved: The vector that turns, shape (..., 3).
        fixed: The fixed vector, shape (3,).
        angle: The angle θ, shape (...), rad; where it is not reached, the nearest is.

    Returns:
        Angles, shape (..., 2), rad.
    """
    alpha, beta = between(axis, fixed), between(axis, moved)
    s = 0.5 * (alpha + beta + angle)
    near = np.sqrt(np.maximum(np.sin(s - alpha) * np.sin(s - beta), 0.0))
    far = np.sqrt(np.maximum(np.sin(s) * np.sin(s - angle), 0.0))
    half = 2.0 * np.arctan2(near, far)
    same_side = about(axis, moved, fixed)
    return np.stack([same_side + half, same_side - half], axis=-1)


def about(axis: Array, vector: Array, goal: Array, together: bool = False) -> Array:
    """Return the angle about an axis that brings vectors nearest to others.

    Args:
        axis: The axis, shape (3,).
        vector: The vectors that turn, shape (..., 3).
        goal: Their goals, shape (..., 3).
        together: Whether the last axis but one holds vectors that turn together.

    Returns:
        Angles, rad, of all axes but the vectors' own.
    """
    quarter = np.cross(axis, vector)
    sine, cosine = np.vecdot(goal, quarter), np.vecdot(goal, np.cross(quarter, axis))
    if together:
        sine, cosine = sine.sum(axis=-1), cosine.sum(axis=-1)
    return np.arctan2(sine, cosine)


def between(one: Array, other: Array) -> Array:
    """Return the angle between vectors, shape (...), rad; exact also near 0 and π."""
    return np.arctan2(np.linalg.norm(np.cross(one, other), axis=-1), np.vecdot(one, other))


def frame(upper_arm: Array, forearm: Array) -> Array:
    """Return u, the unit vector across it towards f, and their cross product, in columns."""
    upper_arm, forearm = np.broadcast_arrays(upper_arm, forearm)
    normal = np.cross(upper_arm, forearm)
    length = np.linalg.norm(normal, axis=-1, keepdims=True)
    normal = np.where(length > 0.0, normal / np.where(length > 0.0, length, 1.0), across(upper_arm))
    return np.stack([upper_arm, np.cross(normal, upper_arm), normal], axis=-1)


def across(vector: Array) -> Array:
    """Return a unit vector across each unit vector, shape (..., 3)."""
    least = np.eye(3)[np.argmin(np.abs(vector), axis=-1)]
    normal = np.cross(vector, least)
    return normal / np.linalg.norm(normal, axis=-1, keepdims=True)
