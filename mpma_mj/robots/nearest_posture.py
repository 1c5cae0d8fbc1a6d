"""Joint angles within ranges whose posture comes nearest to directions, for many at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mpma_mj.robots.chain import Chain

__all__ = ["nearest_posture"]

Array = NDArray[np.float64]

# Choices.
_STEPS = 60
_ENOUGH = 1e-9  # rad, longest step at which the minimum counts as reached
_FIRST_DAMPING, _LEAST_DAMPING, _LARGEST_DAMPING = 1e-3, 1e-9, 1e3


def nearest_posture(
    chain: Chain, directions: Array, start: Array, steps: int = _STEPS
) -> tuple[Array, Array]:
    """Minimise the distance |d(q) - d*|² within the joints' ranges.

    By the steps of Levenberg and Marquardt, without the joints that a step would drive out of
    their range; each posture has its own damping.

    Args:
        chain: The arm.
        directions: Unit vectors d*, u and f, shape (..., 6).
        start: Joint angles from which the search starts, shape (..., 4), rad.
        steps: Largest number of steps.

    Returns:
        Joint angles, shape (..., 4), rad, of a local minimum, and the squared distance, (...).
    """
    goal, shape = directions.reshape(-1, 6), start.shape
    angles = np.clip(start, chain.lowest, chain.highest).reshape(-1, 4)
    damping = np.full(len(angles), _FIRST_DAMPING)
    shown, jacobian = chain.jacobian(angles)
    error = shown - goal
    distance = np.vecdot(error, error)
    for _ in range(steps):
        gradient = np.einsum("nki,nk->ni", jacobian, error)
        blocked = ((angles <= chain.lowest) & (gradient > 0.0)) | (
            (angles >= chain.highest) & (gradient < 0.0)
        )
        free = ~blocked
        hessian = np.einsum("nki,nkj->nij", jacobian, jacobian) * free[:, :, None] * free[:, None]
        hessian += (damping[:, None] + blocked)[:, :, None] * np.eye(4)
        step = np.linalg.solve(hessian, (gradient * free)[..., None])[..., 0]
        tried = np.clip(angles - step, chain.lowest, chain.highest)
        shown, tried_jacobian = chain.jacobian(tried)
        tried_error = shown - goal
        reached = np.vecdot(tried_error, tried_error)
        better = reached < distance
        longest = np.abs(tried - angles).max(axis=1)
        angles = np.where(better[:, None], tried, angles)
        error = np.where(better[:, None], tried_error, error)
        jacobian = np.where(better[:, None, None], tried_jacobian, jacobian)
        distance = np.where(better, reached, distance)
        damping = np.where(
            better,
            np.maximum(damping / 4.0, _LEAST_DAMPING),
            np.minimum(damping * 6.0, _LARGEST_DAMPING),
        )
        if longest.max(initial=0.0) < _ENOUGH:
            break
    return angles.reshape(shape), distance.reshape(shape[:-1])
