"""Pairs of inverse and forward model that share a task: what MPMA and its rivals have in common."""

from __future__ import annotations

import functools
import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any

import dm_env
import numpy as np
from numpy.typing import NDArray

from mpma_mj import metrics
from mpma_mj.agents.agent_spec import AgentSpec
from mpma_mj.agents.base import Observation, Seeds
from mpma_mj.agents.config import JOINTS, POSTURE, NetworkConfig
from mpma_mj.agents.episode_buffer import EpisodeBuffer
from mpma_mj.agents.gain_schedule import Gains, performance
from mpma_mj.agents.learning_rules import PairReadouts
from mpma_mj.errors import BadOptionError
from mpma_mj.esn import PRECISION, FeatureReplay, Features, ReadoutBank, ReservoirBank
from mpma_mj.utils.clipping import clip
from mpma_mj.utils.seeding import stream

__all__ = ["PairedModels", "RunIndex"]

Array = NDArray[np.float64]
RunIndex = tuple[int, ...]  # index of a run; () where there is one

_NEEDED_LAST = ("posture", "joint_angles", "reference")
_MOST_KEPT = 2**26  # bytes of features of each bank; those of more steps are replayed (choice)
_SIGNALS = ("responsibility", "prior", "module_actions", "predictions")


class PairedModels(ABC):
    """M pairs of inverse model IM_i and forward model FM_i beside a feedback controller.

    One step, with responsibilities λ that sum to 1:

        u^i = clip(IM_i([x ; s ; x'_{t+1}]), -1, 1)
        u   = clip(L Σ_i λ^i u^i + K u_fb, -1, 1)
        x̂^i = FM_i([heard ; x ; s])

    The sense s of the joint angles q, [sin q ; cos q], is ours: `NetworkConfig.proprioception`.
    Subclasses say who is responsible (`_gate`), which command forward models hear
    (`_efference_copy`) and what is learned from an epoch (`_learn_epoch`). After it K and L move
    on.

    With several seeds it is so many agents side by side: all arrays of observations, actions,
    signals and state have an axis R for them, and each acts and learns as it would alone.

    Attributes:
        gains: K and L of the present epoch.
    """

    def __init__(
        self,
        config: NetworkConfig,
        spec: AgentSpec,
        *,
        seed: Seeds = 0,
        forgetting: float = 0.0,
    ) -> None:
        """Draw the reservoirs.

        Args:
            config: Settings of the networks.
            spec: Where it acts.
            seed: Seed of weights and noise; several are agents side by side.
            forgetting: Forgetting φ of the readouts, where they are fitted.
        """
        self._batch_shape = np.shape(seed)
        self._seeds: list[int] = np.ravel(seed).tolist()
        self._runs = list(np.ndindex(self._batch_shape))
        self._modules = config.modules
        self._networks = config
        self._spec = spec
        self._fitting = {"forgetting": forgetting, "ridge": config.ridge}
        self._progress = np.zeros(self._batch_shape)
        self._untrained_error = np.full(self._batch_shape, np.nan)
        self._banks: dict[str, ReservoirBank] = {}
        state_size = config.state_size
        self._inverse = self._reservoirs("inverse", state_size + POSTURE)
        self._forward = self._reservoirs("forward", JOINTS + state_size)
        self._readouts = PairReadouts(
            inverse=self._readout(self._zeros(JOINTS, self._inverse.features)),
            forward=self._readout(self._zeros(POSTURE, self._forward.features)),
        )
        self._steps = EpisodeBuffer()
        self.reset(0)

    @abstractmethod
    def _gate(self, observation: Observation) -> dict[str, NDArray[Any]]:
        """Return at least `prior` and `responsibility`, shape (..., M), to be remembered."""

    @abstractmethod
    def _efference_copy(self, action: Array, module_actions: Array) -> Array:
        """Return the command that forward models hear, (..., 8) or (..., M, 8)."""

    @abstractmethod
    def _learn_epoch(self, run: RunIndex, episode: dict[str, Array]) -> dict[str, float]:
        """Let one run learn from its episode, (T, ...); return what is worth logging."""

    @property
    def gains(self) -> Gains:
        """K and L of the present epoch, each of the shape of the seeds."""
        progress: Any = self._progress[()]
        return Gains(progress)

    @property
    def enabled(self) -> NDArray[np.bool_]:
        """Which modules take part, shape (..., M)."""
        return np.ones((*self._batch_shape, self._modules), bool)

    def reset(self, episode: int) -> None:
        """Begin an episode with reservoirs at rest and that episode's own noise."""
        for name, bank in self._banks.items():
            bank.reset([self._noise(name, seed, episode) for seed in self._seeds])
        self._number = episode
        self._steps.clear()
        self._last: Observation = {}

    def act(self, observation: Observation) -> Array:
        """Return the action, shape (..., 8), in [-1, 1]."""
        gate = self._gate(observation)
        state_size = self._networks.proprioceptive_state(observation)
        inverse_features = self._step(
            "inverse", np.concatenate([state_size, observation["target"]], axis=-1)
        )
        module_actions = clip(self._readouts.inverse(inverse_features))
        feedback = self._spec.feedback(observation["joint_angles"], observation["reference"])
        mixed = (gate["responsibility"][..., None, :] @ module_actions)[..., 0, :]
        gains = self.gains
        feedback_gain = np.asarray(gains.feedback)
        action = np.asarray(gains.inverse)[..., None] * mixed + feedback_gain[..., None] * feedback
        action = clip(action)

        heard = self._efference_copy(action, module_actions)
        forward_features = self._step("forward", _beside(heard, state_size))
        self._steps.append(
            {
                **gate,
                "inverse_features": inverse_features,
                "forward_features": forward_features,
                "module_actions": module_actions,
                "predictions": self._readouts.forward(forward_features),
                "action": action,
                "posture": observation["posture"],
                "feedback": feedback,
                "feedback_gain": feedback_gain,
            }
        )
        return action

    def observe(self, timestep: dm_env.TimeStep) -> None:
        """Take in what the action led to."""
        self._last = {n: np.copy(timestep.observation[n]) for n in _NEEDED_LAST}

    def learn(self) -> dict[str, float]:
        """Learn from the episode and let the gains follow.

        Returns:
            Gains K and L of the episode, and what else the architecture logs, by name.

        Raises:
            BadOptionError: There are several agents side by side, or there was no episode.
        """
        if len(self._runs) > 1:
            raise BadOptionError(
                f"{len(self._runs)} agents side by side cannot say in one what each learned;"
                " call learn_batch()"
            )
        (logged,) = self.learn_batch()
        return logged

    def learn_batch(self) -> list[dict[str, float]]:
        """Let every run learn from its episode; return what `learn` does of each.

        Raises:
            BadOptionError: There was no episode.
        """
        if not (len(self._steps) and self._last):
            raise BadOptionError("there is nothing to learn from; call act() and observe() first")
        return [self._learn_run(run) for run in self._runs]

    def predicted_posture(self) -> Array:
        """Return the posture that was last expected to come next, Σ_i λ^i x̂^i, shape (..., 12)."""
        last = self._steps[-1]
        expected: Array = (last["responsibility"][..., None, :] @ last["predictions"])[..., 0, :]
        return expected

    def signals(self) -> dict[str, Array]:
        """Return the signals of the episode that ended.

        Returns:
            `responsibility` and `prior` (T, ..., M), `module_actions` (T, ..., M, 8),
            `predictions` (T, ..., M, 12) of the next posture, `feedback` (T, ..., 8) with the
            gain that it had; nothing before the first step.
        """
        if not len(self._steps):
            return {}
        steps = self._steps.episode()
        feedback = steps["feedback_gain"][..., None] * steps["feedback"]
        return {n: steps[n].copy() for n in _SIGNALS} | {"feedback": feedback}

    def state_dict(self) -> dict[str, Array]:
        """Return all that learning has changed, as arrays by name."""
        return {
            "progress": self._progress.copy(),
            "untrained_error": self._untrained_error.copy(),
        } | self._readouts.state_dict()

    def load_state_dict(self, state: Mapping[str, Array]) -> None:
        """Continue from what `state_dict` returned."""
        self._progress[...] = state["progress"]
        self._untrained_error[...] = state["untrained_error"]
        self._readouts.load_state_dict(state)

    def select_runs(self, runs: NDArray[np.intp]) -> None:
        """Go on with some of the agents side by side only.

        Args:
            runs: Their numbers, shape (R',).
        """
        self._batch_shape = runs.shape
        self._seeds = [self._seeds[i] for i in runs]
        self._runs = list(np.ndindex(self._batch_shape))
        self._progress = self._progress[runs]
        self._untrained_error = self._untrained_error[runs]
        for part in (*self._banks.values(), *vars(self._readouts).values()):
            part.select_runs(runs)
        self._steps = EpisodeBuffer()

    def drop_modules(self, modules: Sequence[int]) -> None:
        """Go on without some of the modules, from the next reset.

        What is left is an agent of fewer modules, each as it was, with the noise that it would
        have had; the others' numbers close up.

        Args:
            modules: Their numbers, from 0, shape (K,).

        Raises:
            BadOptionError: There are no others, or no such modules.
        """
        if not set(modules) <= set(range(self._modules)):
            raise BadOptionError(
                f"modules to lose are {[*modules]}; expected numbers from 0 to {self._modules - 1}"
            )
        left = np.delete(np.arange(self._modules), modules)
        if not len(left):
            raise BadOptionError(f"all {self._modules} modules would be lost; leave one")
        self._modules = len(left)
        for part in (*self._banks.values(), *vars(self._readouts).values()):
            part.drop_modules(modules)
        self._steps = EpisodeBuffer()

    def _reservoirs(self, name: str, inputs: int) -> ReservoirBank:
        bank = ReservoirBank(
            self._batch_shape,
            self._modules,
            inputs,
            self._networks.nodes,
            radius=self._networks.spectral_radius,
            noise=self._networks.reservoir_noise,
            streams=[stream(seed, "reservoir", name) for seed in self._seeds],
        )
        self._banks[name] = bank
        return bank

    def _step(self, name: str, inputs: Array) -> Features:
        """Let reservoirs go on, and return their features, written where they are remembered."""
        bank = self._banks[name]
        self._steps.reserve(f"{name}_inputs", inputs.shape, PRECISION)[...] = inputs
        most = max(1, _MOST_KEPT // (math.prod(bank.shape) * PRECISION().itemsize))
        return bank.step(
            inputs, self._steps.reserve(f"{name}_features", bank.shape, PRECISION, most)
        )

    def _readout(self, weights: Array) -> ReadoutBank:
        return ReadoutBank(weights, **self._fitting)

    def _zeros(self, outputs: int, features: int) -> Array:
        return np.zeros((*self._batch_shape, self._modules, outputs, features))

    def _learn_run(self, run: RunIndex) -> dict[str, float]:
        episode = self._episode(run)
        gains = Gains(float(self._progress[run]))
        mixed = np.einsum("tm,tmd->td", episode["responsibility"], episode["predictions"])
        error = metrics.posture_error_percent(mixed, episode["next_posture"])
        if np.isnan(self._untrained_error[run]):
            self._untrained_error[run] = error
        logged = {"gain_feedback": gains.feedback, "gain_inverse": gains.inverse}
        logged |= self._learn_epoch(run, episode)
        performed = performance(error, float(self._untrained_error[run]))
        self._progress[run] = gains.after(performed).progress
        return logged

    def _noise(self, name: str, seed: int, episode: int) -> np.random.Generator:
        return stream(seed, "reservoir_noise", name, episode)

    def _episode(self, run: RunIndex) -> dict[str, Any]:
        """Return what one run remembers, (T, ...) by name, and what came of each step."""
        own: tuple[Any, ...] = (slice(None), *run)
        steps: dict[str, Any] = {n: rows[own] for n, rows in self._steps.episode().items()}
        seed = self._seeds[self._runs.index(run)]
        for name, bank in self._banks.items():
            inputs = steps.pop(f"{name}_inputs")
            if f"{name}_features" not in steps:  # they were too many to be kept
                noise = functools.partial(self._noise, name, seed, self._number)
                steps[f"{name}_features"] = FeatureReplay(bank.of_run(run), noise, inputs)
        last = {name: value[run] for name, value in self._last.items()}
        feedback = self._spec.feedback(last["joint_angles"], last["reference"])
        return steps | {
            "next_posture": np.concatenate([steps["posture"][1:], last["posture"][None]]),
            "next_feedback": np.concatenate([steps["feedback"][1:], feedback[None]]),
        }


def _beside(heard: Array, state_size: Array) -> Array:
    """Join a command, for all modules alike or for each, and what is state_size."""
    if heard.ndim > state_size.ndim:
        state_size = np.broadcast_to(
            state_size[..., None, :], (*heard.shape[:-1], state_size.shape[-1])
        )
    return np.concatenate([heard, state_size], axis=-1)
