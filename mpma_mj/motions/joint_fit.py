"""Fit of joint angles to directions of segments, within ranges and speeds of the joints.

For any chain of joints; the unknowns are all joint angles of a motion at once:

    minimise  Σ_t |d(q_t) - d*_t|² + w Σ_t |Δq_t / s|²        subject to |Δq_t| ≤ s, lo ≤ q_t ≤ hi

with s the largest step. By an augmented Lagrangian (Nocedal & Wright 2006, chapter 17): with z the
constrained quantities, scaled so that |z| ≤ 1 is allowed,

    ρ Σ max(|z| - 1 + μ/ρ, 0)²        μ ← max(μ + ρ (|z| - 1), 0)

is added, and each sum of squares is minimised by Gauss-Newton steps. As only neighbours in time
are coupled, the matrix is banded, and a step costs time in proportion to the length of the motion.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solveh_banded

__all__ = ["Jacobian", "Seam", "StepLimits", "fit_joint_angles"]

Array = NDArray[np.float64]

Jacobian = Callable[[Array], tuple[Array, Array]]
"""Directions of segments, (T, K), and their derivatives, (T, K, n), at joint angles, (T, n)."""

# Choices; the fit of a motion takes 5 to 20 rounds, with up to 10 steps each.
_SMOOTHNESS = 1e-4  # w
_FIRST_PENALTY, _LARGEST_PENALTY, _FACTOR = 3.0, 1e4, 3.0  # ρ
_FALLS = 0.3  # share to which a round should reduce the violation, else ρ grows
_TOLERANCE = 1e-3  # of |z|
_ROUNDS, _STEPS = 25, 30
_ENOUGH = 1e-5  # relative decrease at which a minimum counts as reached
_FIRST_DAMPING, _LARGEST_DAMPING, _LEAST_DAMPING = 1e-4, 1e8, 1e-9  # Levenberg's λ


@dataclass(frozen=True, eq=False)
class StepLimits:
    """Limits of a chain of n joints, per step of time.

    Attributes:
        step: Largest change from one step to the next, shape (n,), rad.
        lowest: Lowest angles, shape (n,), rad, -inf where there is none.
        highest: Highest angles, shape (n,), rad, inf where there is none.
    """

    step: Array
    lowest: Array
    highest: Array


class Seam(NamedTuple):
    """How a cyclic motion goes on after its end: with joint angles sign · q_0 + offset.

    Attributes:
        sign: 1 or -1, shape (n,).
        offset: Offset, shape (n,), rad, such as a whole turn.
    """

    sign: Array
    offset: Array


@dataclass(eq=False)
class _Problem:
    """One sum of squares: the distance, and the penalties of the constraints."""

    target: Array
    jacobian: Jacobian
    limits: StepLimits
    seam: Seam | None
    penalty: float = _FIRST_PENALTY

    def __post_init__(self) -> None:
        frames, joints = len(self.target), len(self.limits.step)
        low, high = self.limits.lowest, self.limits.highest
        limited = np.isfinite(low) & np.isfinite(high)
        self.half, self.middle = np.full(joints, np.inf), np.zeros(joints)
        self.half[limited] = 0.5 * (high[limited] - low[limited])
        self.middle[limited] = 0.5 * (high[limited] + low[limited])
        # One multiplier a constraint, of steps and of ranges.
        steps = frames - 1 if self.seam is None else frames
        self.multipliers = [np.zeros((steps, joints)), np.zeros((frames, joints))]

    def scaled(self, angles: Array) -> list[Array]:
        """Return z of steps and of ranges."""
        after = angles[1:]
        if self.seam is not None:
            after = np.concatenate([after, self.seam.sign * angles[:1] + self.seam.offset])
        return [
            (after - angles[: len(after)]) / self.limits.step,
            (angles - self.middle) / self.half,
        ]

    def beyond(self, scaled: list[Array]) -> list[Array]:
        """Return max(|z| - 1 + μ/ρ, 0) with the sign of z."""
        return [
            np.sign(z) * np.maximum(np.abs(z) - 1.0 + mu / self.penalty, 0.0)
            for z, mu in zip(scaled, self.multipliers, strict=True)
        ]

    def value(self, angles: Array) -> float:
        """Return the sum that is minimised."""
        scaled = self.scaled(angles)
        penalties = sum(float(np.sum(b * b)) for b in self.beyond(scaled))
        errors = self.jacobian(angles)[0] - self.target
        smoothness = _SMOOTHNESS * float(np.sum(scaled[0] ** 2))
        return float(np.sum(errors * errors)) + smoothness + self.penalty * penalties

    def violation(self, angles: Array) -> float:
        """Return by how much |z| exceeds 1 at most."""
        return max(float(np.max(np.abs(z))) for z in self.scaled(angles)) - 1.0

    def normal_equations(self, angles: Array) -> tuple[Array, Array, Array]:
        """Return half of gradient and Hessian of Gauss and Newton.

        Returns:
            Gradient, shape (T, n); the Hessian's blocks on the diagonal, (T, n, n); and the
            couplings with the next step, shape (T or T - 1, n), which are minus its others.
        """
        directions, derivatives = self.jacobian(angles)
        scaled = self.scaled(angles)
        step, place = self.beyond(scaled)
        gradient = np.einsum("tkn,tk->tn", derivatives, directions - self.target)
        gradient += self.penalty * place / self.half
        pull = (_SMOOTHNESS * scaled[0] + self.penalty * step) / self.limits.step
        coupling = (_SMOOTHNESS + self.penalty * (step != 0.0)) / self.limits.step**2
        blocks = np.einsum("tki,tkj->tij", derivatives, derivatives)
        diagonal = np.einsum("tii->ti", blocks)  # a view
        diagonal += self.penalty * (place != 0.0) / self.half**2
        inner = len(angles) - 1  # steps without the seam
        gradient[: len(pull)] -= pull
        gradient[1:] += pull[:inner]
        diagonal[: len(coupling)] += coupling
        diagonal[1:] += coupling[:inner]
        if self.seam is not None:
            gradient[0] += self.seam.sign * pull[-1]
            diagonal[0] += coupling[-1]
        return gradient, blocks, coupling


def fit_joint_angles(
    target: Array, jacobian: Jacobian, start: Array, limits: StepLimits, seam: Seam | None = None
) -> tuple[Array, float]:
    """Fit joint angles to directions, within limits.

    Args:
        target: Directions d*, shape (T, K).
        jacobian: Directions and derivatives of the chain.
        start: Joint angles from which the fit starts, shape (T, n), rad; may be beyond limits.
        limits: Limits of the joints.
        seam: How a cyclic motion goes on after its end; None for one that does not.

    Returns:
        Joint angles, shape (T, n), rad, within the ranges, with steps up to 0.1 % beyond the
        largest; and the sum of squared distances.
    """
    problem = _Problem(target, jacobian, limits, seam)
    angles, last = start, np.inf
    for _ in range(_ROUNDS):
        angles = _minimised(problem, angles)
        violation = problem.violation(angles)
        if violation < _TOLERANCE:
            break
        for z, mu in zip(problem.scaled(angles), problem.multipliers, strict=True):
            mu[:] = np.maximum(mu + problem.penalty * (np.abs(z) - 1.0), 0.0)
        if violation > _FALLS * last:
            problem.penalty = min(_FACTOR * problem.penalty, _LARGEST_PENALTY)
        last = violation
    angles = np.clip(angles, limits.lowest, limits.highest)
    return angles, float(np.sum((jacobian(angles)[0] - target) ** 2))


def _minimised(problem: _Problem, angles: Array) -> Array:
    """Return joint angles, shape (T, n), at which a problem's sum of squares is smallest."""
    value, damping = problem.value(angles), _FIRST_DAMPING
    for _ in range(_STEPS):
        equations = problem.normal_equations(angles)
        while damping < _LARGEST_DAMPING:
            tried = angles + _newton_step(*equations, damping, problem.seam)
            reached = problem.value(tried)
            if reached < value:
                break
            damping *= 4.0
        else:
            return angles
        angles, decrease, value = tried, value - reached, reached
        damping = max(0.25 * damping, _LEAST_DAMPING)
        if decrease < _ENOUGH * value:
            return angles
    return angles


def _newton_step(
    gradient: Array, blocks: Array, coupling: Array, damping: float, seam: Seam | None
) -> Array:
    """Solve (H + λ I) x = -g, shape (T, n), with a Hessian given as by `normal_equations`.

    The corner of a cyclic Hessian is taken out, H = B - C with B banded, and put back by the
    formula of Sherman, Morrison and Woodbury.
    """
    frames, joints = gradient.shape
    banded = np.zeros((joints + 1, frames * joints))  # upper form: [n + i - j, j] = H[i, j]
    for i in range(joints):
        for j in range(i, joints):
            banded[joints - (j - i), j::joints] = blocks[:, i, j]
    banded[joints] += damping
    banded[0, joints:] = -coupling[: frames - 1].ravel()
    if seam is None:
        return solveh_banded(banded, -gradient.ravel(), check_finite=False).reshape(frames, joints)
    # The coupling of last and first step is v vᵀ with v = √c (sign e_first - e_last) a joint.
    corner = np.zeros((frames * joints, joints))
    root = np.diag(np.sqrt(coupling[-1]))
    corner[:joints], corner[-joints:] = seam.sign * root, -root
    banded[joints, :joints] -= coupling[-1]
    banded[joints, -joints:] -= coupling[-1]
    sides = np.concatenate([-gradient.reshape(-1, 1), corner], axis=1)
    solved = solveh_banded(banded, sides, check_finite=False)
    step, across = solved[:, 0], solved[:, 1:]
    inner = np.eye(joints) + corner.T @ across
    step = step - across @ np.linalg.solve(inner, corner.T @ step)
    return step.reshape(frames, joints)
