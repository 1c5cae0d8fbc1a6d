"""Plant models: linear predictors of the arms' next move, whose errors distinguish plants."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.config import JOINTS, POSTURE
from mpma_mj.agents.switching import smoothed

__all__ = [
    "CALIBRATION",
    "PLANT_INPUTS",
    "PlantModels",
    "gaussian_log_likelihood",
    "novelty",
    "plant_inputs",
]

Array = NDArray[np.float64]

PLANT_INPUTS = 4 * JOINTS + 1
"""Length of a plant model's input o."""

CALIBRATION = 2
"""Epochs that calibrate the first plant: one led by feedback, one in own control (choice)."""

# Choices; those that results depend on most are in docs/science/design_choices.md.
_RIDGE = 1e-4  # of A, a step and divided by the largest number of plants
_FIRST_VARIANCE, _LEAST_VARIANCE = 0.05, 2e-4  # of moves
_IGNORANCE = 10.0  # κ: how much a model's ignorance of a place widens what it expects there
_MOST_NOVEL = 100.0
_WINDOW = 9  # steps over which novelty is averaged, 0.45 s
_LEAST_STEPS, _LEAST_SHARE = 20, 0.1  # of an epoch that a new plant needs
_ROUNDS = 3  # of posterior and refit
_INHERITED_STEPS = 20.0  # n: enough to guide a new model, few enough to be outweighed

_LEARNED = ("weights", "variance", "gram", "moment", "recruited", "epochs")


def plant_inputs(action: Array, state: Array) -> Array:
    """Return a plant model's input, o = [u; sin q; cos q; q̇ / v; 1], shape (..., 33).

    Args:
        action: Actions u, shape (..., 8).
        state: Proprioceptive states [x; sin q; cos q; q̇ / v; ...], shape (..., S).
    """
    inputs = np.empty((*action.shape[:-1], PLANT_INPUTS))
    inputs[..., :JOINTS] = action
    inputs[..., JOINTS:-1] = state[..., POSTURE : POSTURE + 3 * JOINTS]
    inputs[..., -1] = 1.0
    return inputs


def gaussian_log_likelihood(errors: Array, variance: Array, cap: float = np.inf) -> Array:
    """Compute the log likelihood of errors, -½ Σ_d (min(e_d² / s²_d, cap) + log s²_d).

    Args:
        errors: Errors e of moves, shape (..., 8).
        variance: Variances s², shape (..., 8).
        cap: Squared error, in variances, beyond which larger errors count alike.

    Returns:
        Log likelihood up to a constant, shape (...).
    """
    terms = np.minimum(errors**2 / variance, cap) + np.log(variance)
    return -0.5 * np.add.reduce(terms, axis=-1)


def novelty(errors: Array, variance: Array, gram: Array, inputs: Array) -> Array:
    """Compute how far moves are from what every plant model expects.

    It is the normalised innovation squared (Bar-Shalom):

        d_t = min_w mean_d e²_{w,d} / [ s²_{w,d} (1 + κ oᵀ (G_w + 1e-3 I)⁻¹ o) ]

    averaged over a window. It is about 1 where a plant model is right.

    Args:
        errors: Errors e of the plant models' moves, shape (T, W, 8).
        variance: Their variances s², shape (W, 8).
        gram: Sums G of their inputs' products, shape (W, 33, 33).
        inputs: Inputs o, shape (T, 33).

    Returns:
        Novelty, shape (T,).
    """
    inverse = np.linalg.inv(gram + 1e-3 * np.eye(PLANT_INPUTS))
    ignorance = np.einsum("ti,wij,tj->tw", inputs, inverse, inputs, optimize=True)
    expected = variance * (1.0 + _IGNORANCE * ignorance)[:, :, None]
    least = np.minimum((errors**2 / expected).mean(axis=2).min(axis=1), _MOST_NOVEL)
    return np.convolve(least, np.full(_WINDOW, 1.0 / _WINDOW), "same")[: len(least)]


class PlantModels:
    """Plant models of one run, or of a batch of R runs; "..." is () or (R,).

        move^w = A_w o

    with the move [q_{t+1} - q_t] / (Δt v) of the arms. Least squares over all steps of a plant:

        G_w ← G_w + Σ_t g^w_t o oᵀ    B_w ← B_w + Σ_t g^w_t o moveᵀ    A_w = [(G_w + ρ I)⁻¹ B_w]ᵀ

    where g is the posterior of the plants. A plant is recruited after an epoch in which no plant
    model accounts for enough steps, and its model begins with these. Variances s² of the first
    plant are those of its second epoch, the first in its own control; of others those of the
    epoch in which they were recruited. They then stay.

    Where recruitment is guarded, a new plant begins with n steps' worth of the sums of its parent
    p, which was taken for it in most of these steps, and learns alone in that epoch (choices):

        G_w = n G_p / N_p    B_w = n B_p / N_p        n = 20, N_p: steps of the parent

    With late senses arms swing in that epoch, in states that models have hardly seen: the few steps
    that are distinguished make a poor model, and others would learn the steps that are not.

    Attributes:
        most: Largest number of plants, W.
        guarded_recruitment: Whether a new plant inherits sums and learns alone.
        weights: A, shape (..., W, 8, 33).
        variance: s², shape (..., W, 8).
        gram: G, shape (..., W, 33, 33).
        moment: B, shape (..., W, 33, 8).
        recruited: Number of plants recruited so far, shape (...), 1 at the start.
        epochs: Epochs so far, shape (...).
    """

    def __init__(
        self,
        batch_shape: tuple[int, ...],
        *,
        most: int,
        novelty: float,
        switching_probability: float,
        guarded_recruitment: bool,
    ) -> None:
        """Begin with the first plant, of which nothing was learned.

        Args:
            batch_shape: Shape of the runs.
            most: Largest number of plants.
            novelty: Novelty above which no plant model accounts for a step.
            switching_probability: Probability of a switch of plants, a step.
            guarded_recruitment: Whether a new plant inherits sums and learns alone.
        """
        self.most, self._novelty, self._h = most, novelty, switching_probability
        self.guarded_recruitment = guarded_recruitment
        shape = (*batch_shape, most)
        self.weights = np.zeros((*shape, JOINTS, PLANT_INPUTS))
        self.variance = np.full((*shape, JOINTS), _FIRST_VARIANCE)
        self.gram = np.zeros((*shape, PLANT_INPUTS, PLANT_INPUTS))
        self.moment = np.zeros((*shape, PLANT_INPUTS, JOINTS))
        self.recruited: NDArray[np.intp] = np.ones(batch_shape, np.intp)
        self.epochs: NDArray[np.intp] = np.zeros(batch_shape, np.intp)

    @property
    def calibrating(self) -> NDArray[np.bool_]:
        """Whether the last epoch of each run calibrated the first plant, shape (...)."""
        return np.asarray(self.epochs <= CALIBRATION)

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return all arrays that learning changes, by name."""
        return {name: getattr(self, name) for name in _LEARNED}

    def of_run(self, run: tuple[int, ...]) -> PlantModels:
        """Return the plant models of one run, which share memory with these."""
        part = copy.copy(self)
        for name, array in self.arrays().items():
            view: tuple[Any, ...] = (*run, ...)  # not a copy, also of a single number
            setattr(part, name, array[view])
        return part

    def select_runs(self, runs: NDArray[np.intp]) -> None:
        """Continue with some runs only, (R',) of R."""
        for name, array in self.arrays().items():
            setattr(self, name, array[runs])

    def moves(self, inputs: Array, count: int) -> Array:
        """Return the moves that the first plants' models predict.

        Args:
            inputs: Inputs o, shape (..., 33).
            count: Number of plants, W'.

        Returns:
            Moves, shape (..., W', 8).
        """
        return (self.weights[..., :count, :, :] @ inputs[..., None, :, None])[..., 0]

    def learn(self, inputs: Array, moves: Array) -> tuple[Array, bool]:
        """Learn from an epoch of one run, and recruit a plant if one is new.

        Args:
            inputs: Inputs o, shape (T, 33).
            moves: Moves that followed, shape (T, 8).

        Returns:
            Posterior g of the plants, shape (T, W), and whether a plant was recruited.
        """
        posterior = np.zeros((len(inputs), self.most))
        calibrating = int(self.epochs) < CALIBRATION
        self.epochs[...] += 1
        count = int(self.recruited)
        if calibrating:
            posterior[:, 0] = 1.0
            self._refit(posterior, inputs, moves, measured=0)
            self._accumulate(posterior, inputs, moves)
            return posterior, False
        errors = self._errors(inputs, moves, count)
        posterior[:, :count] = self._posterior(errors)
        new = novelty(errors, self.variance[:count], self.gram[:count], inputs) > self._novelty
        enough = max(_LEAST_STEPS, _LEAST_SHARE * len(inputs))
        recruit = count if new.sum() >= enough and count < self.most else None
        learns = np.ones(self.most)
        if recruit is not None:
            if self.guarded_recruitment:
                learns[:recruit] = 0.0
                self._inherit(recruit, parent=int(posterior[new].sum(axis=0).argmax()))
            self.recruited[...] = count = count + 1
            posterior[new] = 0.0
            posterior[new, recruit] = 1.0
        for _ in range(_ROUNDS):
            self._refit(learns * posterior, inputs, moves, measured=recruit)
            errors = self._errors(inputs, moves, count)
            posterior[:, :count] = self._posterior(errors)
        self._accumulate(learns * posterior, inputs, moves)
        return posterior, recruit is not None

    def _inherit(self, recruit: int, parent: int) -> None:
        """Let a new plant begin with n steps' worth of its parent's sums."""
        steps = self.gram[parent, -1, -1]  # of the input that is 1
        for sums in (self.gram, self.moment):
            sums[recruit] = _INHERITED_STEPS / max(steps, 1.0) * sums[parent]

    def _posterior(self, errors: Array) -> Array:
        """Return the posterior of plants whose models have errors of shape (T, W', 8)."""
        logs = gaussian_log_likelihood(errors, self.variance[: errors.shape[1]])
        return smoothed(logs, self._h)

    def _errors(self, inputs: Array, moves: Array, count: int) -> Array:
        """Return the errors of the first plants' models, shape (T, W', 8)."""
        predicted = np.einsum("ti,wki->twk", inputs, self.weights[:count], optimize=True)
        return predicted - moves[:, None]

    def _refit(
        self, posterior: Array, inputs: Array, moves: Array, *, measured: int | None
    ) -> None:
        """Refit plants that were on for long enough, on top of their sums; measure one's s²."""
        ridge = _RIDGE * len(inputs) / self.most * np.eye(PLANT_INPUTS)
        for w in np.flatnonzero(posterior.sum(axis=0) > _LEAST_STEPS):
            weight = posterior[:, w, None]
            gram = self.gram[w] + inputs.T @ (weight * inputs) + ridge
            moment = self.moment[w] + inputs.T @ (weight * moves)
            self.weights[w] = np.linalg.solve(gram, moment).T
            if w == measured:
                errors = inputs @ self.weights[w].T - moves
                variance = (weight * errors**2).sum(axis=0) / weight.sum()
                self.variance[w] = np.maximum(variance, _LEAST_VARIANCE)

    def _accumulate(self, posterior: Array, inputs: Array, moves: Array) -> None:
        weighted = posterior.T[:, :, None] * inputs  # (W, T, 33)
        self.gram += weighted.transpose(0, 2, 1) @ inputs
        self.moment += weighted.transpose(0, 2, 1) @ moves
