"""Rotations of vectors about fixed axes, and the angles of those that bring them to a place."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["about", "across", "between", "circle", "frame", "rotated", "turned"]

Array = NDArray[np.float64]

_PARALLEL = 1e-150  # length of a cross product whose square underflows


def rotated(vector: Array, axis: Array, angle: Array) -> Array:
    """Return vectors, shape (..., 3), rotated about a unit vector, (3,), by angles (...), rad."""
    missing = max(0, angle.ndim - vector.ndim + 1)
    vector = np.moveaxis(vector.reshape(*(1,) * missing, *vector.shape), -1, 0)
    return np.moveaxis(turned(vector, axis, np.cos(angle), np.sin(angle)), 0, -1)


def turned(vector: Array, axis: Array, cosine: Array, sine: Array) -> Array:
    """Return vectors, shape (3, ...), rotated about a unit vector, (3,).

    (a · v) a + cos θ (v - (a · v) a) + sin θ (a × v)        (Rodrigues)
    """
    x, y, z = axis
    products = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0], *np.outer(axis, axis)])
    both = (products @ vector.reshape(3, -1)).reshape(6, *vector.shape[1:])
    across, along = both[:3], both[3:]
    return along + cosine * (vector - along) + sine * across


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
    parallel = length < _PARALLEL
    normal = np.where(parallel, across(upper_arm), normal / np.where(parallel, 1.0, length))
    return np.stack([upper_arm, np.cross(normal, upper_arm), normal], axis=-1)


def across(vector: Array) -> Array:
    """Return a unit vector across each unit vector, shape (..., 3)."""
    least = np.eye(3)[np.argmin(np.abs(vector), axis=-1)]
    normal = np.cross(vector, least)
    return normal / np.linalg.norm(normal, axis=-1, keepdims=True)
