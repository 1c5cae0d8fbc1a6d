"""Pairs of inverse and forward model that share a task: what MPMA and its rivals have in common."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from numbers import Integral

import dm_env
import numpy as np
from numpy.typing import NDArray

from mpma_mj import metrics
from mpma_mj.agents.agent import Observation
from mpma_mj.agents.gains import Gains, performance
from mpma_mj.agents.learning import PairReadouts
from mpma_mj.errors import BadOptionError
from mpma_mj.esn import ReadoutBank, ReservoirBank
from mpma_mj.feedback import feedback_action
from mpma_mj.randomness import stream

__all__ = ["PairsAgent", "PairsConfig"]

Array = NDArray[np.float64]

_JOINTS, _POSTURE = 8, 12
_NEEDED_LAST = ("posture", "joint_angles", "reference")


@dataclass(frozen=True)
class PairsConfig:
    """Settings of the networks.

    Attributes:
        modules: Number of pairs, M.
        nodes: Neurons of each reservoir, N.
        proprioception: Whether inverse and forward models also sense the joint angles. A posture
            can be held in two ways, and what a joint velocity does depends on which: an arm
            that was raised through straight forward has turned over. False is the paper's.
        spectral_radius: Spectral radius of the reservoirs; the paper's 0.1.
        reservoir_noise: Noise level ν of the reservoirs; the paper's 0.2.

    Raises:
        BadOptionError: A setting is outside what it may be.
    """

    modules: int = 4
    nodes: int = 200
    proprioception: bool = True
    spectral_radius: float = 0.1
    reservoir_noise: float = 0.2

    def __post_init__(self) -> None:
        """Check the settings."""
        for name, most in {"modules": 1000, "nodes": 20000}.items():
            count = getattr(self, name)
            if not (
                type(count) is not bool and isinstance(count, Integral) and 1 <= int(count) <= most
            ):
                raise BadOptionError(f"{name} is {count!r}; expected a whole number, 1 to {most}")
        for name in ("spectral_radius", "reservoir_noise"):
            value = getattr(self, name)
            if not 0.0 <= value < 1.0:
                raise BadOptionError(f"{name} is {value:g}; expected 0 or more, below 1")


class PairsAgent(ABC):
    """M pairs of inverse model IM_i and forward model FM_i beside a feedback controller.

    One step, with responsibilities λ that sum to 1:

        u^i = clip(IM_i([x ; s ; x'_{t+1}]), -1, 1)
        u   = clip(L Σ_i λ^i u^i + K u_fb, -1, 1)
        x̂^i = FM_i([heard ; x ; s])

    The sense s of the joint angles q, [sin q ; cos q], is ours: `PairsConfig.proprioception`.
    Subclasses say who is responsible (`_gate`), which command forward models hear (`_heard`) and
    what is learned from an epoch (`_learn_epoch`). After it K and L move on.

    Attributes:
        gains: K and L of the present epoch.
    """

    def __init__(
        self,
        config: PairsConfig,
        *,
        max_joint_speed: Array,
        control_timestep: float,
        seed: int = 0,
        forgetting: float = 0.0,
        ridge: float = 1.0,
    ) -> None:
        """Draw the reservoirs.

        Args:
            config: Settings of the networks.
            max_joint_speed: Joint speeds that action 1 commands, shape (8,), rad/s.
            control_timestep: Time between two actions, s.
            seed: Seed of weights and noise.
            forgetting: Forgetting φ of the readouts, where they are fitted.
            ridge: Ridge ρ of the readouts, where they are fitted.
        """
        self.gains = Gains()
        self._modules = config.modules
        self._networks = config
        self._fitting = {"forgetting": forgetting, "ridge": ridge}
        self._untrained_error = float("nan")
        self._max_joint_speed = max_joint_speed
        self._control_timestep = control_timestep
        self._seed = seed
        self._banks: list[ReservoirBank] = []
        sensed = _POSTURE + (2 * _JOINTS if config.proprioception else 0)
        self._inverse = self._reservoirs("inverse", sensed + _POSTURE)
        self._forward = self._reservoirs("forward", _JOINTS + sensed)
        self._readouts = PairReadouts(
            inverse=self._readout(np.zeros((config.modules, _JOINTS, self._inverse.features))),
            forward=self._readout(np.zeros((config.modules, _POSTURE, self._forward.features))),
        )
        self.reset(0)

    @abstractmethod
    def _gate(self, observation: Observation) -> dict[str, Array]:
        """Return at least `prior` and `responsibility`, shape (M,), to be remembered."""

    @abstractmethod
    def _heard(self, action: Array, module_actions: Array) -> Array:
        """Return the command that forward models hear, (8,) or (M, 8), of u and the u^i."""

    @abstractmethod
    def _learn_epoch(self) -> dict[str, float]:
        """Learn from the epoch that ended; return what is worth logging, by name."""

    def reset(self, episode: int) -> None:
        """Begin an episode with reservoirs at rest and that episode's own noise."""
        for bank in self._banks:
            bank.reset()
        self._rng = stream(self._seed, "reservoir_noise", episode)
        self._steps: list[dict[str, Array]] = []
        self._stacked: dict[str, Array] = {}
        self._last: Observation = {}

    def act(self, observation: Observation) -> Array:
        """Return the action, shape (8,), in [-1, 1]."""
        modules, rng = self._modules, self._rng
        gate = self._gate(observation)
        self._stacked = {}  # of the steps before this one

        sensed = self._sense(observation)
        inverse_features = self._inverse.step(np.concatenate([sensed, observation["target"]]), rng)
        module_actions = np.clip(self._readouts.inverse(inverse_features), -1.0, 1.0)
        feedback = self._feedback(observation)
        mixed = gate["responsibility"] @ module_actions
        action = np.clip(self.gains.inverse * mixed + self.gains.feedback * feedback, -1.0, 1.0)

        heard = np.broadcast_to(self._heard(action, module_actions), (modules, _JOINTS))
        felt = np.broadcast_to(sensed, (modules, len(sensed)))
        forward_features = self._forward.step(np.concatenate([heard, felt], axis=1), rng)
        predictions = self._readouts.forward(forward_features)

        self._steps.append(
            {
                **gate,
                "inverse_features": inverse_features,
                "forward_features": forward_features,
                "module_actions": module_actions,
                "predictions": predictions,
                "action": action,
                "posture": observation["posture"].copy(),
                "feedback": feedback,
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
        """
        epoch = self._epoch_signals()
        logged = {"gain_feedback": self.gains.feedback, "gain_inverse": self.gains.inverse}
        mixed = np.einsum("tm,tmd->td", epoch["responsibility"], epoch["predictions"])
        error = metrics.posture_error_percent(mixed, epoch["next_posture"])
        if np.isnan(self._untrained_error):
            self._untrained_error = error
        logged |= self._learn_epoch()
        self.gains = self.gains.after(performance(error, self._untrained_error))
        return logged

    def signals(self) -> dict[str, Array]:
        """Return the signals of the episode that ended.

        Returns:
            `responsibility` and `prior` (T, M), `module_actions` (T, M, 8), `predictions`
            (T, M, 12) of the next posture, `feedback` (T, 8) with its gain.
        """
        epoch = self._epoch_signals()
        names = ("responsibility", "prior", "module_actions", "predictions")
        return {n: epoch[n] for n in names} | {"feedback": self._gain_used * epoch["feedback"]}

    def state_dict(self) -> dict[str, Array]:
        """Return all that learning has changed, as arrays by name."""
        state = {
            "progress": np.array(self.gains.progress),
            "untrained_error": np.array(self._untrained_error),
        }
        for part, readout in vars(self._readouts).items():
            state |= {f"{part}.{name}": value for name, value in readout.state_dict().items()}
        return state

    def load_state_dict(self, state: Mapping[str, Array]) -> None:
        """Continue from what `state_dict` returned."""
        self.gains = Gains(float(state["progress"]))
        self._untrained_error = float(state["untrained_error"])
        for part, readout in vars(self._readouts).items():
            readout.load_state_dict(
                {name: state[f"{part}.{name}"] for name in readout.state_dict()}
            )

    def _sense(self, observation: Observation) -> Array:
        """Return what the models know of the arms: posture and, if set, joint angles."""
        if not self._networks.proprioception:
            return observation["posture"]
        angles = observation["joint_angles"]
        return np.concatenate([observation["posture"], np.sin(angles), np.cos(angles)])

    def _reservoirs(self, name: str, inputs: int) -> ReservoirBank:
        bank = ReservoirBank(
            self._modules,
            inputs,
            self._networks.nodes,
            radius=self._networks.spectral_radius,
            noise=self._networks.reservoir_noise,
            rng=stream(self._seed, "reservoir", name),
        )
        self._banks.append(bank)
        return bank

    def _readout(self, weights: Array) -> ReadoutBank:
        return ReadoutBank(weights, **self._fitting)

    def _feedback(self, observation: Observation) -> Array:
        return feedback_action(
            observation["joint_angles"],
            observation["reference"],
            self._max_joint_speed,
            self._control_timestep,
        )

    def _epoch_signals(self) -> dict[str, Array]:
        """Stack what was remembered, once an episode: what `act` keeps, and what came of it."""
        if not self._stacked:
            steps = {n: np.stack([step[n] for step in self._steps]) for n in self._steps[0]}
            posture, last_feedback = steps.pop("posture"), self._feedback(self._last)
            self._gain_used = self.gains.feedback
            self._stacked = steps | {
                "next_posture": np.concatenate([posture[1:], self._last["posture"][None]]),
                "next_feedback": np.concatenate([steps["feedback"][1:], last_feedback[None]]),
            }
        return self._stacked
