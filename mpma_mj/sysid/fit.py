"""The parameters with which simulated arms do what a log shows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from mpma_mj.sysid.misfit import Misfit
from mpma_mj.sysid.uncertainty import evidence

__all__ = ["FARTHEST", "Fit", "fit", "refit", "robust_loss"]

Array = NDArray[np.float64]

FARTHEST = float(np.log(4.0))
"""How far a parameter may be from the model's, as a logarithm (choice)."""

_FINEST = 1e-5  # rad; what simulations of the same are apart, and least scale (choice)
_COARSE, _FINE = 1e-3, 1e-4  # relative changes at which a search ends
_INSIDE = 0.999 * FARTHEST  # where a search may begin
_MOST, _FEW = 30, 5  # evaluations of a search, and of one that begins near (choice)
_HOPS, _DRAWS = 2, 40  # searches after random steps, and steps before each (choice)
_LONGEST_STEP = 0.05  # of such a step, as a logarithm (choice)
_NEAR = 3  # physics steps of latency that are looked at to both sides (choice)


@dataclass(frozen=True, eq=False)
class Fit:
    """What was found.

    Attributes:
        logs: Logarithms of the factors on the P parameters, shape (P,).
        latency: Physics steps until a command acts.
        scale: Residual, rad, beyond which an entry counts less.
    """

    logs: Array
    latency: int
    scale: float


def fit(coarse: Misfit, fine: Misfit, parameters: int, longest: int) -> Fit:
    """Find parameters and latency.

    Latency is searched over whole physics steps, the parameters by least squares with a robust
    loss (soft L1): first with the model's own parameters, then in turns.

    Args:
        coarse: Some windows of the log, for the search.
        fine: All windows.
        parameters: Number P of parameters.
        longest: Longest latency, physics steps.
    """
    logs = np.zeros(parameters)
    latency = _best_latency(coarse, logs, range(longest + 1))
    seen: set[int] = set()
    while latency not in seen:
        seen.add(latency)
        logs = _search(coarse, logs, latency, _scale(coarse, logs, latency), _COARSE)
        near = range(max(0, latency - _NEAR), min(longest, latency + _NEAR) + 1)
        latency = _best_latency(coarse, logs, near)
    for tolerance in (_COARSE, _FINE):  # each with the scale that the one before leads to
        scale = _scale(fine, logs, latency)
        logs = _search(fine, logs, latency, scale, tolerance)
    for _ in range(_HOPS if scale > _FINEST else 0):  # else nothing is left to be found
        logs = _hop(fine, logs, latency, scale)
    return Fit(logs, latency, scale)


def _hop(misfit: Misfit, logs: Array, latency: int, scale: float) -> Array:
    """Return what fits best after random steps of the size of what is uncertain, and a search.

    Where the simulated movement jumps, as `Misfit.jacobian` says, a search ends too early.
    """

    def loss(tried: Array) -> float:
        return float(robust_loss(misfit.residual(tried, latency), scale).sum())

    said = evidence(misfit, logs, latency, scale).covariance()
    sizes, ways = np.linalg.eigh(np.nan_to_num(said, posinf=1.0))
    steps = ways * np.minimum(np.sqrt(np.maximum(sizes, 0.0)), _LONGEST_STEP)
    best, least = logs, loss(logs)
    for draw in np.random.default_rng(0).standard_normal((_DRAWS, len(logs))):
        tried = np.clip(best + steps @ draw, -_INSIDE, _INSIDE)
        if (now := loss(tried)) < least:
            best, least = tried, now
    found = _search(misfit, best, latency, scale, _FINE, most=_FEW)
    return found if loss(found) < least else best


def refit(misfit: Misfit, found: Fit, latency: int) -> Array:
    """Return the logarithms that fit best with another latency, starting from what was found."""
    return _search(misfit, found.logs, latency, found.scale, _COARSE, most=_FEW)


def robust_loss(residual: Array, scale: float) -> Array:
    """Return the loss of residuals, any shape: their squares, but beyond a scale their size.

    ρ = 2 s² (√(1 + (r / s)²) - 1)
    """
    return 2.0 * scale**2 * (np.sqrt(1.0 + (residual / scale) ** 2) - 1.0)


def _scale(misfit: Misfit, logs: Array, latency: int) -> float:
    """Return the residuals' standard deviation as their median size tells it."""
    sizes = np.abs(misfit.residual(logs, latency))
    return max(1.4826 * float(np.median(sizes)), _FINEST)


def _best_latency(misfit: Misfit, logs: Array, latencies: range) -> int:
    return min(latencies, key=lambda steps: float(np.abs(misfit.residual(logs, steps)).mean()))


def _search(
    misfit: Misfit,
    logs: Array,
    latency: int,
    scale: float,
    tolerance: float,
    *,
    most: int = _MOST,
) -> Array:
    def residual(tried: Array) -> Array:
        return misfit.residual(tried, latency).ravel()

    def jacobian(tried: Array) -> Array:
        return misfit.jacobian(tried, latency)

    found = least_squares(
        residual,
        logs,
        jac=jacobian,
        bounds=(-FARTHEST, FARTHEST),
        loss="soft_l1",
        f_scale=scale,
        xtol=tolerance,
        ftol=tolerance,
        max_nfev=most,
    )
    return found.x
