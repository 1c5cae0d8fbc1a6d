"""Movement primitives: ProMP of Paraschos et al. 2013 and DMP of Ijspeert et al. 2013."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.base import AgentSpec, Observation, Seeds
from mpma_mj.agents.baselines import FeedbackOnly
from mpma_mj.agents.config import JOINTS, AgentConfig, DMPConfig, ProMPConfig
from mpma_mj.agents.episode_buffer import EpisodeBuffer
from mpma_mj.agents.gain_schedule import FINAL_GAINS
from mpma_mj.arm_kinematics import ArmKinematics
from mpma_mj.errors import StateError
from mpma_mj.feedback import followed, joint_error
from mpma_mj.utils.clipping import clip
from mpma_mj.utils.saved_arrays import assign, shared_count

if TYPE_CHECKING:
    import dm_env

__all__ = ["DMP", "MovementPrimitive", "ProMP", "basis"]

Array = NDArray[np.float64]

# Choices: as dense as the moves of a dance need.
_SPACING = 0.1  # s between basis functions
_RIDGE = 1e-6  # a share of the mean of the diagonal
_LEAST_VARIANCE = 1e-12  # rad²
_STIFFNESS = 25.0  # α of a DMP, 1/s; β = α / 4, which is critically damped
_DECAY = 1.0  # α_x: the canonical system falls to 1 / e over the movement


def basis(steps: int, spacing: float) -> Array:
    """Return normalised Gaussian basis functions of time.

        φ_i(t) = ψ_i(t) / Σ_j ψ_j(t)        ψ_i(t) = exp(-(t - c_i)² / 2h²)

    Args:
        steps: Number of steps of the movement, T.
        spacing: Distance of the centres c and width h, steps.

    Returns:
        Values at each moment, shape (T + 1, K).
    """
    centres = np.linspace(0.0, steps, max(round(steps / spacing), 1) + 1)
    time = np.arange(steps + 1.0)
    bumps = np.exp(-0.5 * ((time[:, None] - centres) / spacing) ** 2)
    return bumps / bumps.sum(axis=1, keepdims=True)


class MovementPrimitive(FeedbackOnly):
    """A movement that is learned over time, from demonstrations with noise.

        u = clip(u_fb(q_t, q*_{t+1}) + K u_fb(q_t, q*_t))        K = 0.14

    In the first epochs, one for each of the `demonstrations`, it follows the target, as
    `ResolvedRate` does, and keeps the reference as joint angles, q_t + e(q_t, x'_t): on the branch
    of the arms, and without the noise of angles that are nearly undefined. Afterwards it executes
    the learned movement q*, step by step; the phase is time.
    """

    config_type: ClassVar[type[AgentConfig]] = ProMPConfig
    trainable: bool = True
    config: ProMPConfig

    def __init__(self, config: ProMPConfig, spec: AgentSpec, *, seed: Seeds = 0) -> None:
        """Begin without a demonstration; arguments as of `Agent`."""
        super().__init__(config, spec, seed=seed)
        self._batch_shape = np.shape(seed)
        # Sums over demonstrations of what is learned from each, (..., P, 8), and of its squares.
        self._sums = np.zeros((*self._batch_shape, 0, JOINTS))
        self._squares = self._sums.copy()
        self._epochs = self._moments = 0
        self.reset(0)

    @abstractmethod
    def parameters(self, angles: Array) -> Array:
        """Return what is learned from one demonstration, shape (..., P, 8).

        Args:
            angles: Its joint angles at each moment, shape (..., T + 1, 8), rad.
        """

    @abstractmethod
    def begin(self, mean: Array, variance: Array, angles: Array) -> Array:
        """Return the movement from its beginning, shape (..., T + 1, 8), rad.

        Args:
            mean: Mean of the parameters over demonstrations, shape (..., P, 8).
            variance: Their variance, likewise.
            angles: Joint angles at the beginning, shape (..., 8), rad.
        """

    @property
    def is_recording(self) -> bool:
        """Whether the present epoch is learned from."""
        return self._epochs < self.config.demonstrations

    def reset(self, episode: int) -> None:
        """Begin an episode."""
        super().reset(episode)
        self._movement: Array | None = None  # q*, (..., T + 1, 8)
        self._last: Observation | None = None

    def act(self, observation: Observation) -> Array:
        """Return the action, shape (..., 8), in [-1, 1]."""
        angles, step = observation["joint_angles"], len(self._steps)
        now, after = followed(observation, "reference"), followed(observation, "target")
        demonstrated = _angles_of(observation, "reference", self.spec.kinematics)
        if not self.is_recording:
            if self._movement is None:
                self._movement = self.begin(*self._statistics(), angles)
            now = self._movement[..., min(step, self._moments - 1), :]
            coming = _angles_of(observation, "target", self.spec.kinematics)
            after = self.next_angles(step + 1, coming)
        feedback = FINAL_GAINS.feedback * self.spec.feedback(angles, now)
        self._steps.append({"feedback": feedback, "demonstrated": demonstrated})
        self._last = None
        return clip(self.spec.feedback(angles, after) + feedback)

    def next_angles(self, step: int, target: Array) -> Array:
        """Return the joint angles to be reached at a step, shape (..., 8), rad.

        Args:
            step: The step.
            target: Joint angles of the target, shape (..., 8), rad.
        """
        assert self._movement is not None
        return self._movement[..., min(step, self._moments - 1), :]

    def observe(self, timestep: dm_env.TimeStep) -> None:
        """Receive the outcome of the action."""
        if len(self._steps):
            self._last = timestep.observation

    def learn(self) -> dict[str, Array]:
        """Learn from the demonstration of the episode.

        Returns:
            `learner_acts`, 1 where the learned movement was executed and 0 where the target was
            followed, and `calibrating`, 1 until the movement has been learned.

        Raises:
            StateError: There was no episode, or one of another length than those before.
        """
        if self._last is None:
            raise StateError("learn() was called before an episode; call act() and observe() first")
        recording = float(self.is_recording)
        if self.is_recording:
            steps, end = (
                self._steps.episode()["demonstrated"],
                _angles_of(self._last, "reference", self.spec.kinematics),
            )
            learned = self.parameters(np.moveaxis(np.concatenate([steps, end[None]]), 0, -2))
            if self._epochs == 0:
                self._moments = len(steps) + 1
                self._sums, self._squares = np.zeros_like(learned), np.zeros_like(learned)
            elif self._moments != len(steps) + 1:
                raise StateError(
                    f"an episode has {len(steps)} steps, those before {self._moments - 1}; a"
                    " movement primitive learns episodes of one length"
                )
            self._sums = self._sums + learned
            self._squares = self._squares + learned**2
        self._epochs += 1
        shape = self._batch_shape
        return {
            "learner_acts": np.full(shape, 1.0 - recording),
            "calibrating": np.full(shape, recording),
        }

    def select_runs(self, runs: NDArray[np.intp]) -> None:
        """Continue with some runs only, (R',) of R, from the next reset."""
        self._batch_shape = runs.shape
        self._sums, self._squares = self._sums[runs], self._squares[runs]
        self._steps = EpisodeBuffer()

    def state_dict(self) -> dict[str, Array]:
        """Return copies of all arrays that learning changes, by name."""
        counts = {"epochs": self._epochs, "moments": self._moments}
        state = {name: np.full(self._batch_shape, count) for name, count in counts.items()}
        return state | {"sums": self._sums.copy(), "squares": self._squares.copy()}

    def load_state_dict(self, state: Mapping[str, Array]) -> None:
        """Continue from the arrays that `state_dict` returned.

        Raises:
            ValueError: An array has another shape or type, or is not finite.
        """
        shape = np.shape(state["sums"])  # which depends on the length of the episodes
        if shape[:-2] != self._batch_shape or shape[-1:] != (JOINTS,):
            raise ValueError(f"sums of shape {shape}")
        self._sums, self._squares = np.zeros(shape), np.zeros(shape)
        assign(self._sums, state["sums"])
        assign(self._squares, state["squares"])
        self._epochs = shared_count(state["epochs"], self._batch_shape)
        self._moments = shared_count(state["moments"], self._batch_shape)

    def _statistics(self) -> tuple[Array, Array]:
        """Return mean and variance of the parameters over demonstrations, each (..., P, 8)."""
        count = self.config.demonstrations
        mean = self._sums / count
        variance = (self._squares - count * mean**2) / (count - 1)
        return mean, np.maximum(variance, 0.0)

    def _basis(self, moments: int) -> Array:
        """Return the basis functions of a movement, shape (T + 1, K)."""
        return basis(moments - 1, _SPACING / self.spec.control_timestep)


class ProMP(MovementPrimitive):
    """Probabilistic movement primitive: a distribution of movements, conditioned on the target.

        q_t = φ_tᵀ w + ε        w ~ N(μ, Σ)        ε ~ N(0, σ²)
        q*  = φᵀμ + φᵀΣφ / (φᵀΣφ + σ²) (q' - φᵀμ)

    The trajectory model and the conditioning on via-points of Paraschos et al. 2013. w of each
    demonstration follows by ridge regression; μ and Σ are mean and covariance over all of them, and
    kept as φᵀμ and φᵀΣφ, mean and variance of φᵀw; σ² is the mean square of what remains. The
    via-point q' is the target. Each joint has a distribution of its own, and each
    step is conditioned on its own target only (choices).
    """

    def parameters(self, angles: Array) -> Array:
        """Return φᵀw of a demonstration at each moment, and its mean square residual."""
        features = self._basis(angles.shape[-2])
        fitted = features @ _least_squares(features, angles)
        residual = ((angles - fitted) ** 2).mean(axis=-2, keepdims=True)
        return np.concatenate([fitted, residual], axis=-2)

    def begin(self, mean: Array, variance: Array, angles: Array) -> Array:
        """Return the mean movement; see `MovementPrimitive`."""
        spread, noise = variance[..., :-1, :], mean[..., -1:, :]
        self._trust = spread / np.maximum(spread + noise, _LEAST_VARIANCE)
        return mean[..., :-1, :]

    def next_angles(self, step: int, target: Array) -> Array:
        """Return the conditioned joint angles, shape (..., 8), rad."""
        mean = super().next_angles(step, target)
        trust = self._trust[..., min(step, self._moments - 1), :]
        return mean + trust * (target - mean)


class DMP(MovementPrimitive):
    """Dynamic movement primitive: a spring towards the goal and a learned force over time.

        v̇ = α (β (g - q*) - v) + f        q̇* = v        f = x Σ_i φ_i w_i
        ẋ = -α_x x / T                    α = 25 / s,  β = α / 4,  α_x = 1

    The discrete system of Ijspeert et al. 2013, but that f is not scaled by g - q_0, which is about
    0 where a dance ends as it began, and that the basis functions are equally spaced in time
    (choices). w follows by ridge regression from the f of the demonstrations; both
    use the same differences, so that a demonstration is reproduced. It starts where the arms are.
    """

    config_type: ClassVar[type[AgentConfig]] = DMPConfig

    def parameters(self, angles: Array) -> Array:
        """Return the weights w of a demonstration, and its goal g."""
        dt, goal = self.spec.control_timestep, angles[..., -1:, :]
        velocity = np.diff(angles, axis=-2) / dt
        before = np.concatenate([np.zeros_like(goal), velocity[..., :-1, :]], axis=-2)
        spring = _STIFFNESS * (_STIFFNESS / 4 * (goal - angles[..., :-1, :]) - before)
        force = (velocity - before) / dt - spring
        weights = _least_squares(self._forcing(angles.shape[-2]), force)
        return np.concatenate([weights, goal], axis=-2)

    def begin(self, mean: Array, variance: Array, angles: Array) -> Array:
        """Return the movement from where the arms are; see `MovementPrimitive`."""
        dt, goal = self.spec.control_timestep, mean[..., -1, :]
        force = self._forcing(self._moments) @ mean[..., :-1, :]
        path, velocity = [angles], np.zeros_like(angles)
        for step in range(self._moments - 1):
            spring = _STIFFNESS * (_STIFFNESS / 4 * (goal - path[-1]) - velocity)
            velocity = velocity + dt * (spring + force[..., step, :])
            path.append(path[-1] + dt * velocity)
        return np.stack(path, axis=-2)

    def _forcing(self, moments: int) -> Array:
        """Return x φ at each step, shape (T, K)."""
        canonical = np.exp(-_DECAY * np.arange(moments - 1) / (moments - 1))
        return canonical[:, None] * self._basis(moments)[:-1]


def _angles_of(observation: Observation, name: str, kinematics: ArmKinematics) -> Array:
    """Return the joint angles, (..., 8), rad, of the reference or target, on the arms' branch."""
    angles = observation["joint_angles"]
    return angles + joint_error(angles, followed(observation, name), kinematics)


def _least_squares(features: Array, values: Array) -> Array:
    """Return the weights of ridge regression, (..., K, 8), for features (T, K) and values."""
    gram = features.T @ features
    ridge = _RIDGE * np.trace(gram) / len(gram) * np.eye(len(gram))
    return np.linalg.solve(gram + ridge, features.T @ values)
