"""Behaviour cloning, and DAgger of Ross, Gordon & Bagnell 2011, of a trained MPMA."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.base import Agent, AgentSpec, Observation, Seeds
from mpma_mj.agents.basic_config import EXPERT_EPOCHS
from mpma_mj.agents.config import JOINTS, AgentConfig, BCConfig, DAggerConfig, MPMAConfig
from mpma_mj.agents.episode_buffer import EpisodeBuffer
from mpma_mj.agents.mpma import MPMA
from mpma_mj.errors import StateError
from mpma_mj.esn.readout import ReadoutBank, Ridge
from mpma_mj.feedback import followed, joint_error
from mpma_mj.utils.clipping import clip
from mpma_mj.utils.saved_arrays import shared_count

if TYPE_CHECKING:
    import dm_env

__all__ = ["BC", "DAgger", "policy_features"]

Array = NDArray[np.float64]

# A share of each feature's own second moment, as if features were standardised (choice).
_RIDGE = Ridge(absolute=1e-8, relative=5e-5)


def policy_features(observation: Observation, spec: AgentSpec) -> Array:
    """Return the inputs of a policy, in units of about 1.

        [e(x'_{t+1}) ; e(x'_t)] / (Δt v)    q̇ / v    sin q    cos q    1

    e is the joint error towards the demonstration, `feedback.joint_error`; with `lookahead` towards
    each of the coming targets.

    Args:
        observation: Observation, whose arrays have the leading shape (...).
        spec: Description of arms and observations.

    Returns:
        Features, shape (..., 41 + 8 (n - 1)) for n targets.
    """
    angles = observation["joint_angles"]
    ahead = followed(observation, "lookahead" if spec.lookahead else "target")
    reference = followed(observation, "reference")[..., None, :]
    if not spec.lookahead:
        ahead = ahead[..., None, :]
    paths = np.concatenate([ahead, reference], axis=-2)  # (..., n + 1, 12 or 8)
    still = np.broadcast_to(angles[..., None, :], (*paths.shape[:-1], JOINTS))
    errors = joint_error(still, paths, spec.kinematics)
    moves = (errors / spec.largest_move).reshape(*angles.shape[:-1], -1)
    speeds = observation["joint_velocities"] / spec.max_joint_speed
    one = np.ones((*angles.shape[:-1], 1))
    return np.concatenate([moves, speeds, np.sin(angles), np.cos(angles), one], axis=-1)


class BC(Agent):
    """Behaviour cloning: a linear policy, fitted to what a trained expert did (Pomerleau 1989).

        u = clip(W z)        W = argmin Σ ‖u_expert - W z‖² + ridge

    z are `policy_features`. In the first 3 epochs the expert, a default MPMA, learns; in the next
    ones, `expert_episodes` of them, it acts and learns no more; then the policy acts alone,
    without feedback controller (choices). A multi-layer perceptron in place of W tracks far worse:
    it extrapolates wrongly where it strays from the expert's states.

    Attributes:
        expert: The expert.
    """

    config_type: ClassVar[type[AgentConfig]] = BCConfig
    trainable: bool = True
    config: BCConfig

    def __init__(self, config: BCConfig, spec: AgentSpec, *, seed: Seeds = 0) -> None:
        """Create the untrained expert; arguments as of `Agent`."""
        super().__init__(config, spec, seed=seed)
        self.expert = MPMA(MPMAConfig(), spec, seed=seed)
        self._batch_shape = np.shape(seed)
        size = JOINTS * (max(spec.lookahead, 1) + 4) + 1
        self._policy = ReadoutBank(
            np.zeros((*self._batch_shape, 1, JOINTS, size)), forgetting=1.0, ridge=_RIDGE
        )
        self._epochs = 0
        self._steps = EpisodeBuffer()
        self.reset(0)

    @property
    def expert_acts(self) -> bool:
        """Whether the expert acts in the present epoch."""
        return self._epochs < EXPERT_EPOCHS + self._acted_by_expert

    @property
    def is_recording(self) -> bool:
        """Whether the present epoch is learned from, or the expert still learns."""
        return self._epochs < EXPERT_EPOCHS + self.config.expert_episodes

    @property
    def _acted_by_expert(self) -> int:
        """Number of epochs in which the trained expert acts."""
        return self.config.expert_episodes

    def reset(self, episode: int) -> None:
        """Begin an episode."""
        if self.is_recording:
            self.expert.reset(episode)
        self._steps.clear()
        self._acted = False  # and the outcome was observed

    def act(self, observation: Observation) -> Array:
        """Return the action, shape (..., 8), in [-1, 1]."""
        features = policy_features(observation, self.spec)
        if self.expert_acts:
            action = label = self.expert.act(observation)
        else:
            action = label = clip(self._policy(features[..., None, :])[..., 0, :])
            if self.is_recording:
                label = self.expert.act(observation, executed=action)
        self._steps.append({"features": features, "label": label})
        return action

    def observe(self, timestep: dm_env.TimeStep) -> None:
        """Receive the outcome of the action."""
        self._acted = len(self._steps) > 0
        if self.is_recording:
            self.expert.observe(timestep)

    def learn(self) -> dict[str, Array]:
        """Let the expert learn, or the policy from the expert.

        Returns:
            `learner_acts`, 1 where the policy acted and 0 where the expert did, and `calibrating`,
            1 until the policy has learned all.

        Raises:
            StateError: There was no episode.
        """
        if not self._acted:
            raise StateError("learn() was called before an episode; call act() and observe() first")
        shape = self._batch_shape
        logged = {
            "learner_acts": np.full(shape, float(not self.expert_acts)),
            "calibrating": np.full(shape, float(self.is_recording)),
        }
        if self._epochs < EXPERT_EPOCHS:
            self.expert.learn()
        elif self.is_recording:
            steps = self._steps.episode()
            for run in np.ndindex(shape):
                own = (slice(None), *run, None)
                self._policy.of_run(run).fit(steps["features"][own], steps["label"][own])
        self._epochs += 1
        return logged

    def select_runs(self, runs: NDArray[np.intp]) -> None:
        """Continue with some runs only, (R',) of R, from the next reset."""
        self._batch_shape = runs.shape
        self.expert.select_runs(runs)
        self._policy.select_runs(runs)
        self._steps = EpisodeBuffer()

    def state_dict(self) -> dict[str, Array]:
        """Return copies of all arrays that learning changes, by name."""
        state = {f"policy.{name}": array for name, array in self._policy.state_dict().items()}
        state |= {f"expert.{name}": array for name, array in self.expert.state_dict().items()}
        return state | {"epochs": np.full(self._batch_shape, self._epochs)}

    def load_state_dict(self, state: Mapping[str, Array]) -> None:
        """Continue from the arrays that `state_dict` returned."""
        self._epochs = shared_count(state["epochs"], self._batch_shape)
        self._policy.load_state_dict(state, "policy.")
        prefix = "expert."
        self.expert.load_state_dict(
            {
                name.removeprefix(prefix): array
                for name, array in state.items()
                if name.startswith(prefix)
            }
        )


class DAgger(BC):
    """Dataset aggregation: the expert labels the states that the policy visits.

    As `BC`, but of the `expert_episodes` the expert acts in the first only. In the others the
    policy acts, and the expert names the action that it would take in each state; its forward
    models receive what the policy did. After each of them the policy is fitted to all so far
    (Ross, Gordon & Bagnell 2011 with β = 1, 0, 0, …).
    """

    config_type: ClassVar[type[AgentConfig]] = DAggerConfig

    @property
    def _acted_by_expert(self) -> int:
        """Number of epochs in which the trained expert acts."""
        return 1
