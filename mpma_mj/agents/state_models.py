"""State of the arms: linear models that predict it, and its estimate from noisy observations."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.base import AgentSpec
from mpma_mj.agents.config import JOINTS
from mpma_mj.agents.plant_models import PLANT_INPUTS
from mpma_mj.kinematics import wrap
from mpma_mj.utils.saved_arrays import assign

__all__ = ["StateEstimate", "StateModels", "kinematic_prior", "state_inputs"]

Array = NDArray[np.float64]

STATE_OUTPUTS = 2 * JOINTS
"""Length of a state model's output: move and relative joint velocities."""

# Choices.
_FORGETTING = 0.7  # φ
_RIDGE = 1e-3  # a step; it leads back to the kinematic prior
_FIRST_VARIANCE, _LEAST_VARIANCE = 0.05, 2e-4  # of moves
_LEAST_STEPS = 20.0  # of a plant in an epoch from which its model learns
_EPISODE_RIDGE = 10.0  # against what an episode adds to a model: without it few steps decide


def kinematic_prior() -> Array:
    """Return the state model of joints that move as commanded, A_0, shape (16, 33)."""
    prior = np.zeros((STATE_OUTPUTS, PLANT_INPUTS))
    prior[:JOINTS, :JOINTS] = prior[JOINTS:, :JOINTS] = np.eye(JOINTS)
    return prior


def state_inputs(command: Array, angles: Array, speed: Array) -> Array:
    """Return a state model's input, o = [u; sin q; cos q; q̇ / v; 1], shape (..., 33).

    Args:
        command: Command u that acts, shape (..., 8).
        angles: Joint angles q, shape (..., 8), rad.
        speed: Joint velocities over top speeds, shape (..., 8).
    """
    one = np.ones((*command.shape[:-1], 1))
    return np.concatenate([command, np.sin(angles), np.cos(angles), speed, one], axis=-1)


class StateModels:
    """Linear models of the arms' state, of R runs and W plants; "..." is () or (R,).

        [move ; q̇ / v]_{s+1} = A^w o(u_s, q_s, q̇_s)           A^w = A_0 + [(G_w + ρ n I)⁻¹ B_w]ᵀ

    A_0 is the kinematic prior. After each epoch

        G_w ← φ G_w + Σ_s g^w_s o oᵀ        B_w ← φ B_w + Σ_s g^w_s o ([move ; q̇ / v] - A_0 o)ᵀ

    Inside an episode a model takes up the steps so far, as in a plant or a motion never met it is
    wrong, and arms swing. Where the model has learned much, they change little:

        A = A^w + [(G_w + G + 10 I)⁻¹ Σ_s o ([move ; q̇ / v] - A^w o)ᵀ]ᵀ        G = Σ_s o oᵀ

    Attributes:
        variance: Width s² of moves under the best plant's model, twice the median, shape (..., 8).
    """

    def __init__(self, spec: AgentSpec, batch_shape: tuple[int, ...], plants: int) -> None:
        """Begin with the kinematic prior.

        Args:
            spec: Description of the arms.
            batch_shape: Shape of the runs.
            plants: Largest number of plants, W.
        """
        self._spec, self._prior = spec, kinematic_prior()
        self._weights = np.tile(self._prior, (*batch_shape, plants, 1, 1))
        self._gram = np.zeros((*batch_shape, plants, PLANT_INPUTS, PLANT_INPUTS))
        self._moment = np.zeros((*batch_shape, plants, PLANT_INPUTS, STATE_OUTPUTS))
        self.variance = np.full((*batch_shape, JOINTS), _FIRST_VARIANCE)
        self.reset()

    def reset(self) -> None:
        """Begin an episode with what was learned alone."""
        self._recent_gram = np.zeros_like(self._gram[..., 0, :, :])
        self._recent_moment = np.zeros_like(self._moment[..., 0, :, :])

    def observe(self, inputs: Array, outputs: Array, acted: NDArray[np.bool_]) -> None:
        """Update the models with a step of the episode.

        Args:
            inputs: Inputs o, shape (..., 33).
            outputs: Move and relative velocities that followed, shape (..., 16).
            acted: Whether a command acted on it, shape (...).
        """
        weighted = (acted[..., None] * inputs)[..., :, None]
        self._recent_gram += weighted * inputs[..., None, :]
        self._recent_moment += weighted * outputs[..., None, :]

    def of_plant(self, plant: NDArray[np.intp] | int) -> Array:
        """Return the models A of one plant of each run, shape (..., 16, 33)."""
        index = np.asarray(plant)[..., None, None, None]
        weights, gram = (
            np.take_along_axis(array, index, axis=-3)[..., 0, :, :]
            for array in (self._weights, self._gram)
        )
        rest = self._recent_moment - self._recent_gram @ np.swapaxes(weights, -1, -2)
        ridge = _EPISODE_RIDGE * np.eye(PLANT_INPUTS)
        change = np.linalg.solve(gram + self._recent_gram + ridge, rest)
        adapted: Array = weights + np.swapaxes(change, -1, -2)
        return adapted

    def following(
        self, model: Array, command: Array, angles: Array, speed: Array
    ) -> tuple[Array, Array]:
        """Return joint angles, rad, and relative velocities after a command, each (..., 8).

        Args:
            model: Model A, shape (..., 16, 33).
            command: Command that acts, shape (..., 8).
            angles: Joint angles, shape (..., 8), rad.
            speed: Joint velocities over top speeds, shape (..., 8).
        """
        outputs = (model @ state_inputs(command, angles, speed)[..., None])[..., 0]
        reach = self._spec.largest_move
        return angles + reach * outputs[..., :JOINTS], outputs[..., JOINTS:]

    def learn(self, steps: Mapping[str, Array], shares: Array, run: tuple[int, ...]) -> Array:
        """Refit the models of the plants that were on, and return the mean squared error.

        Args:
            steps: Steps of one run as `Senses.aligned` returns them.
            shares: Which plant was on, shape (T, W').
            run: Index of the run.

        Returns:
            Mean squared error of the best model's joint angles, shape (8,), rad².
        """
        top = self._spec.max_joint_speed
        angles, after = steps["joint_angles"], steps["next_joint_angles"]
        inputs = state_inputs(steps["action"], angles, steps["joint_velocities"] / top)
        move = self._spec.move(angles, after)
        targets = np.concatenate([move, steps["next_joint_velocities"] / top], axis=-1)
        rest = targets - inputs @ self._prior.T
        weights, gram, moment = self._weights[run], self._gram[run], self._moment[run]
        ridge = _RIDGE * len(inputs) * np.eye(PLANT_INPUTS)
        for plant in np.flatnonzero(shares.sum(axis=0) > _LEAST_STEPS).tolist():
            weighted = shares[:, plant, None] * inputs
            gram[plant] = _FORGETTING * gram[plant] + weighted.T @ inputs
            moment[plant] = _FORGETTING * moment[plant] + weighted.T @ rest
            weights[plant] = self._prior + np.linalg.solve(gram[plant] + ridge, moment[plant]).T
        moves = inputs @ np.swapaxes(weights[:, :JOINTS], -1, -2)  # (W, T, 8)
        least = ((moves - move) ** 2)[: shares.shape[1]].min(axis=0)
        self.variance[run] = np.maximum(2.0 * np.median(least, axis=0), _LEAST_VARIANCE)
        error: Array = least.mean(axis=0) * (self._spec.control_timestep * top) ** 2
        return error

    def select_runs(self, runs: NDArray[np.intp]) -> None:
        """Continue with some runs only, (R',) of R, from the next reset."""
        for name in _LEARNED:
            setattr(self, name, getattr(self, name)[runs])

    def state_dict(self) -> dict[str, Array]:
        """Return copies of all arrays that learning changes, by name."""
        return {f"state_models.{name.strip('_')}": getattr(self, name).copy() for name in _LEARNED}

    def load_state_dict(self, state: Mapping[str, Array]) -> None:
        """Continue from the arrays that `state_dict` returned; others are left out."""
        for name in _LEARNED:
            assign(getattr(self, name), state[f"state_models.{name.strip('_')}"])


_LEARNED = ("_weights", "_gram", "_moment", "variance")

# Choices; the last two keep an estimate from running away.
_FIRST = 1e-3  # P_0 and S_0, rad²
_RATE = 0.02  # of the running mean square of innovations
_LEAST_NOISE = 1e-8  # Q, rad²
_LEAST_GAIN = 0.05  # κ
_FAR = 5.0  # widths of an innovation from which the observation counts alone


class StateEstimate:
    """Share of observation and prediction in the state, for each joint.

        q̃ = q̂ + κ (q - q̂),   q̇̃ likewise with the same κ
        P⁻ = P + Q,   κ = max(P⁻ / (P⁻ + max(S - P⁻, 0)), C / S),   P = (1 - κ) P⁻

    Q is the variance of the state model's error, S the running mean square of the innovations
    q - q̂, C that of each times the one before. Innovations of the right gain are white (Mehra
    1970): where they are alike from step to step, the model is wrong, as in a plant never met, and
    the observation counts more. Without noise κ is 1. It is bounded from below, and a joint whose
    innovation is beyond five widths is taken as observed.
    """

    def __init__(self, batch_shape: tuple[int, ...]) -> None:
        """Begin with an unknown model error, given the shape of the runs."""
        self._noise = np.full((*batch_shape, JOINTS), 1e-4)
        self.reset()

    def reset(self) -> None:
        """Begin an episode with no prediction."""
        self._variance = np.full(self._noise.shape, _FIRST)
        self._innovation = np.full(self._noise.shape, _FIRST)
        self._repeated = np.zeros(self._noise.shape)  # C
        self._last = np.zeros(self._noise.shape)
        self._predicted: tuple[Array, Array] | None = None
        self._steps = 0

    def __call__(self, angles: Array, speed: Array) -> tuple[Array, Array]:
        """Return the estimated joint angles, rad, and relative velocities, each (..., 8).

        Args:
            angles: Observed joint angles, shape (..., 8), rad.
            speed: Observed joint velocities over top speeds, shape (..., 8).
        """
        if self._predicted is None:
            return angles, speed
        predicted, then = self._predicted
        innovation = wrap(angles - predicted)
        far = innovation**2 > _FAR**2 * self._innovation
        self._steps += 1
        rate = max(1.0 / self._steps, _RATE)
        self._innovation += rate * (innovation**2 - self._innovation)
        self._repeated += rate * (innovation * self._last - self._repeated)
        self._last = innovation
        before = self._variance + self._noise
        gain = before / np.maximum(self._innovation, before)
        alike = self._repeated / np.maximum(self._innovation, _LEAST_NOISE)
        gain = np.maximum(gain, np.minimum(alike, 1.0))
        gain = np.where(far, 1.0, np.maximum(gain, _LEAST_GAIN))
        self._variance = (1.0 - gain) * before
        return predicted + gain * innovation, then + gain * (speed - then)

    def predict(self, angles: Array, speed: Array) -> None:
        """Receive the state that is predicted to come next."""
        self._predicted = angles, speed

    def learn(self, error: Array, run: tuple[int, ...]) -> None:
        """Set the model error Q of one run, shape (8,), rad²; only the least so far counts.

        An epoch with noise on the observations would count it as the model's.
        """
        self._noise[run] = np.clip(error, _LEAST_NOISE, self._noise[run])

    def select_runs(self, runs: NDArray[np.intp]) -> None:
        """Continue with some runs only, (R',) of R, from the next reset."""
        self._noise = self._noise[runs]

    def state_dict(self) -> dict[str, Array]:
        """Return a copy of the model error."""
        return {"model_error": self._noise.copy()}

    def load_state_dict(self, state: Mapping[str, Array]) -> None:
        """Continue from the array that `state_dict` returned; others are left out."""
        assign(self._noise, state["model_error"])
