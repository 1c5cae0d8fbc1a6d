"""How well a log determines what was found from it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpma_mj.sysid.misfit import Misfit

__all__ = ["NORMAL", "Evidence", "evidence"]

Array = NDArray[np.float64]

NORMAL = 1.96
"""Standard deviations of a 95 % interval."""

_RESOLUTION = 1e-4  # rad; no log is taken to be more exact (choice)


@dataclass(frozen=True, eq=False)
class Evidence:
    """What a log says of P parameters at the optimum.

    Attributes:
        curvature: H, shape (P, P).
        middle: Covariance of the loss's gradient, shape (P, P).
    """

    curvature: Array
    middle: Array

    def covariance(self) -> Array:
        """Return the covariance of the parameters, shape (P, P); infinite where nothing is said.

        cov = H⁻¹ · middle · H⁻¹
        """
        strength = np.sqrt(np.diag(self.curvature))
        silent = strength <= 0.0
        strength[silent] = 1.0
        scaled = self.curvature / np.outer(strength, strength)
        scaled[silent, silent] = 1.0
        inverse = np.linalg.pinv(scaled, rcond=1e-15, hermitian=True)
        inverse /= np.outer(strength, strength)
        found = inverse @ self.middle @ inverse
        found[silent, silent] = np.inf
        return found

    def half_widths(self) -> Array:
        """Return half widths of 95 % intervals, shape (P,)."""
        return NORMAL * np.sqrt(np.diag(self.covariance()))

    def half_widths_over(self, reference: int) -> Array:
        """Return half widths of 95 % intervals, shape (P,), if one parameter were known.

        As a common factor on all parameters may be open, these are of ratios to that one; its own
        is 0.
        """
        kept = np.arange(len(self.curvature)) != reference
        square = np.ix_(kept, kept)
        widths = np.zeros(len(kept))
        widths[kept] = Evidence(self.curvature[square], self.middle[square]).half_widths()
        return widths


def evidence(misfit: Misfit, logs: Array, latency: int, scale: float) -> Evidence:
    """Return what the windows of a log say of the parameters.

    From the Jacobian J of the residual r at the optimum, and the gradients of each window's loss ρ
    (Huber's sandwich with windows as clusters: errors of a window hang together, as all come from
    its start):

        H = Jᵀ ρ'' J        middle = W / (W - P) Σ_w g_w g_wᵀ + σ₀² H        g_w = J_wᵀ ρ'(r_w)

    σ₀ being the resolution that a log has at best.

    Args:
        misfit: The windows.
        logs: Logarithms of the factors on the parameters, shape (P,).
        latency: Physics steps until a command acts.
        scale: Scale of the loss, rad.
    """
    residual = misfit.residual(logs, latency)
    jacobian = misfit.jacobian(logs, latency)
    weight = 1.0 / np.sqrt(1.0 + (residual.ravel() / scale) ** 2)
    curvature = (jacobian * weight[:, None] ** 3).T @ jacobian
    windows = len(residual)  # of which as many as there are parameters may be fitted exactly
    pull = (jacobian * (weight * residual.ravel())[:, None]).reshape(windows, -1, len(logs))
    pull = pull.sum(axis=1)  # (W, P)
    middle = pull.T @ pull * windows / (windows - len(logs)) + _RESOLUTION**2 * curvature
    return Evidence(curvature, middle)
