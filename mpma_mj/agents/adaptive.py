"""One inverse model that adapts at every step, by least squares with forgetting (Åström)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.base import Agent, AgentSignals, AgentSpec, Observation, Seeds
from mpma_mj.agents.config import JOINTS, AdaptiveConfig, AgentConfig
from mpma_mj.agents.episode_buffer import EpisodeBuffer
from mpma_mj.agents.gain_schedule import FINAL_GAINS
from mpma_mj.agents.model_space import JointSpace
from mpma_mj.agents.networks import NetworkFactory
from mpma_mj.agents.plant_models import CALIBRATION
from mpma_mj.errors import StateError
from mpma_mj.utils.clipping import clip
from mpma_mj.utils.saved_arrays import assign

if TYPE_CHECKING:
    import dm_env

__all__ = ["Adaptive"]

Array = NDArray[np.float64]

_LEAST_RIDGE = 1e-4  # a remembered step (choice)


class Adaptive(Agent):
    """A residual on the resolved-rate command that is refitted at every step.

        u_t = clip(clip(m_t + W z_t) + K u_fb)                                  K = 0.14
        G ← μ G + z zᵀ       B ← μ B + z (u - m')ᵀ       W = ((G + ρ diag G + ε I)⁻¹ B)ᵀ

    z are features of a reservoir with the inputs of a joint inverse model. As in hindsight
    relabelling, each step is an example whose target is the posture that was reached; m' is the
    resolved-rate command towards it. It forgets what is past, instead of keeping it in modules.
    """

    config_type: ClassVar[type[AgentConfig]] = AdaptiveConfig
    trainable: bool = True
    fine_tunable: bool = True
    config: AdaptiveConfig

    def __init__(self, config: AdaptiveConfig, spec: AgentSpec, *, seed: Seeds = 0) -> None:
        """Draw the reservoir; arguments as of `Agent`."""
        super().__init__(config, spec, seed=seed)
        self._space = JointSpace(spec)
        networks = NetworkFactory(config, seed, 1)
        # The same reservoir twice: one receives the targets, one the postures that were reached.
        self._acting, self._learning = (
            networks.make("inverse", self._space.inverse_inputs, JOINTS) for _ in range(2)
        )
        shape, size = np.shape(seed), self._acting.readouts.weights.shape[-1]
        self._gram = np.zeros((*shape, size, size))
        self._moment = np.zeros((*shape, size, JOINTS))
        self._weights = np.zeros((*shape, size, JOINTS))
        self._epochs = np.zeros(shape)
        self._steps = EpisodeBuffer()
        self.reset(0)

    def reset(self, episode: int) -> None:
        """Begin an episode with reservoirs at rest and that episode's noise."""
        self._acting.reset(episode)
        self._learning.reset(episode)
        self._steps.clear()
        # State, joint angles and action, until the outcome.
        self._last: tuple[Array, Array, Array] | None = None

    def act(self, observation: Observation) -> Array:
        """Return the action, shape (..., 8), in [-1, 1]."""
        state, angles = self._space.state(observation, None), observation["joint_angles"]
        correction, command = self._space.commands(observation)
        self._acting.step(self._space.inverse_input(state, observation["target"], command))
        features = self._acting.features[..., 0, :].astype(np.float64)
        residual = (features[..., None, :] @ self._weights)[..., 0, :]
        feedback = FINAL_GAINS.feedback * correction
        planned = clip(command + residual)
        action = clip(planned + feedback)
        self._last = state, angles, action
        self._steps.append({"feedback": feedback, "learned": planned - command})
        return action

    def observe(self, timestep: dm_env.TimeStep) -> None:
        """Learn from the outcome of the action."""
        if self._last is not None:
            self._learn_step(*self._last, timestep.observation["posture"])
            self._last = None

    def signals(self) -> AgentSignals:
        """Return the parts of the action; none before the first step."""
        if not len(self._steps):
            return AgentSignals()
        steps = self._steps.episode()
        return AgentSignals(feedback=steps["feedback"].copy(), learned=steps["learned"].copy())

    def learn(self) -> dict[str, Array]:
        """Return the gains, which are constant; each step has been learned from.

        The first two epochs count as `calibrating`, as those of joint models do, so that both
        learn for as long.

        Raises:
            StateError: There was no episode.
        """
        if not len(self._steps) or self._last is not None:
            raise StateError("learn() was called before an episode; call act() and observe() first")
        self._epochs += 1
        return {
            "gain_feedback": np.full_like(self._epochs, FINAL_GAINS.feedback),
            "gain_inverse": np.full_like(self._epochs, FINAL_GAINS.inverse),
            "calibrating": (self._epochs <= CALIBRATION).astype(float),
        }

    def select_runs(self, runs: NDArray[np.intp]) -> None:
        """Continue with some runs only, (R',) of R, from the next reset."""
        self._acting.select_runs(runs)
        self._learning.select_runs(runs)
        self._gram, self._moment = self._gram[runs], self._moment[runs]
        self._weights, self._epochs = self._weights[runs], self._epochs[runs]
        self._steps = EpisodeBuffer()

    def state_dict(self) -> dict[str, Array]:
        """Return copies of all arrays that learning changes, by name."""
        return {name: array.copy() for name, array in self._arrays().items()}

    def load_state_dict(self, state: Mapping[str, Array]) -> None:
        """Continue from the arrays that `state_dict` returned."""
        for name, array in self._arrays().items():
            assign(array, state[name])

    def _arrays(self) -> dict[str, Array]:
        names = ("gram", "moment", "weights", "epochs")
        return {name: getattr(self, f"_{name}") for name in names}

    def _learn_step(self, state: Array, angles: Array, action: Array, reached: Array) -> None:
        command = self.spec.feedback(angles, reached)
        self._learning.step(self._space.inverse_input(state, reached, command))
        features = self._learning.features[..., 0, :].astype(np.float64)
        memory, size = self.config.forgetting, features.shape[-1]
        self._gram = memory * self._gram + features[..., :, None] * features[..., None, :]
        residual = (action - command)[..., None, :]
        self._moment = memory * self._moment + features[..., :, None] * residual
        diagonal = np.arange(size)
        regular = self._gram.copy()
        own = regular[..., diagonal, diagonal]
        ridge = self.config.inverse_ridge * own + _LEAST_RIDGE / (1.0 - memory)
        regular[..., diagonal, diagonal] = own + ridge
        self._weights = np.linalg.solve(regular, self._moment)
