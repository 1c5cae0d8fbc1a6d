"""How well a log determines what was found from it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpma_mj.identification.fit import Fit, refit, robust_loss
from mpma_mj.identification.misfit import Misfit

__all__ = ["Spread", "latency_interval", "spread"]

Array = NDArray[np.float64]

_NORMAL = 1.96  # standard deviations of a 95 % interval
_RESOLUTION = 1e-4  # rad; no log is taken to be more exact (choice)
_FARTHEST = 5  # physics steps of latency that are tried to each side (choice)


@dataclass(frozen=True, eq=False)
class Spread:
    """Half widths of 95 % intervals of logarithms.

    Attributes:
        alone: Of each parameter, shape (P,).
        ratio: Of each parameter over one of them, shape (P,); 0 for that one itself.
    """

    alone: Array
    ratio: Array


def spread(misfit: Misfit, found: Fit, reference: int) -> Spread:
    """Return intervals of the parameters at the latency that was found.

    From the Jacobian J at the optimum, and the sum of what each window says (Huber's sandwich with
    windows as clusters: errors of a window hang together, as all come from its start):

        cov = H⁻¹ (Σ_w g_w g_wᵀ + σ₀² H) H⁻¹        H = Jᵀ ρ'' J, g_w = J_wᵀ ρ'(r_w)

    σ₀ being the resolution that a log has at best.

    Args:
        misfit: All windows.
        found: What was found.
        reference: Number of the parameter over which ratios are.
    """
    residual = misfit.residual(found.logs, found.latency)
    jacobian = misfit.jacobian(found.logs, found.latency)
    weight = 1.0 / np.sqrt(1.0 + (residual.ravel() / found.scale) ** 2)
    curvature = (jacobian * weight[:, None] ** 3).T @ jacobian
    windows = len(residual)
    pull = (jacobian * (weight * residual.ravel())[:, None]).reshape(windows, -1, len(found.logs))
    pull = pull.sum(axis=1)  # (W, P)
    middle = pull.T @ pull * windows / (windows - 1) + _RESOLUTION**2 * curvature
    kept = np.arange(len(found.logs)) != reference
    ratio = np.zeros(len(kept))
    ratio[kept] = _half_widths(curvature[np.ix_(kept, kept)], middle[np.ix_(kept, kept)])
    return Spread(_half_widths(curvature, middle), ratio)


def _half_widths(curvature: Array, middle: Array) -> Array:
    """Return half widths of intervals; infinite where the log says nothing at all."""
    strength = np.sqrt(np.diag(curvature))
    silent = strength <= 0.0
    strength[silent] = 1.0
    scaled = curvature / np.outer(strength, strength)
    scaled[silent, silent] = 1.0
    inverse = np.linalg.pinv(scaled, rcond=1e-15, hermitian=True) / np.outer(strength, strength)
    widths = _NORMAL * np.sqrt(np.diag(inverse @ middle @ inverse))
    widths[silent] = np.inf
    return widths


def latency_interval(misfit: Misfit, found: Fit, longest: int) -> tuple[int, int]:
    """Return the least and the greatest latency that fit as well, physics steps.

    With each the parameters are fitted anew. It fits worse if the windows' losses are greater by
    1.96 standard errors of their mean difference.

    Args:
        misfit: Windows that are compared; the fewer, the wider the interval.
        found: What was found.
        longest: Longest latency that is possible.
    """
    least = _losses(misfit, found, found.logs, found.latency)
    ends = []
    for way in (-1, 1):
        end = found.latency
        while 0 <= end + way <= longest and abs(end + way - found.latency) <= _FARTHEST:
            logs = refit(misfit, found, end + way)
            more = _losses(misfit, found, logs, end + way) - least
            if more.mean() > _NORMAL * more.std(ddof=1) / np.sqrt(len(more)):
                break
            end += way
        ends.append(end)
    return ends[0], ends[1]


def _losses(misfit: Misfit, found: Fit, logs: Array, latency: int) -> Array:
    """Return each window's loss, shape (W,)."""
    return robust_loss(misfit.residual(logs, latency), found.scale).sum(axis=1)
