"""The Multiple Paired Models Architecture of Tidemann & Öztürk 2008."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from numbers import Integral
from typing import Literal, get_args

import dm_env
import numpy as np
from numpy.typing import NDArray

from mpma_mj import metrics
from mpma_mj.agents import responsibility as gating
from mpma_mj.agents.agent import Observation
from mpma_mj.agents.gains import Gains, performance
from mpma_mj.agents.learning import RULES, Epoch, Readouts
from mpma_mj.errors import BadOptionError
from mpma_mj.esn import ReadoutBank, ReservoirBank
from mpma_mj.feedback import feedback_action
from mpma_mj.options import RuleName
from mpma_mj.randomness import stream

__all__ = ["MPMA", "MPMAConfig"]

Array = NDArray[np.float64]

_JOINTS, _POSTURE = 8, 12
_LEAST_PRIOR = 0.01  # p_min: no module is shut out for ever (choice)
_NEEDED_LAST = ("posture", "joint_angles", "reference")


@dataclass(frozen=True)
class MPMAConfig:
    """Settings of the architecture.

    Attributes:
        modules: Number of modules, M.
        nodes: Neurons of each reservoir, N; each module has three.
        rule: "weighted" (ours) or "gated" (the paper's); see `learning`.
        proprioception: Whether inverse and forward models also sense the joint angles. A posture
            can be held in two ways, and what a joint velocity does depends on which: an arm
            that was raised through straight forward has turned over. False is the paper's.
        forward_input: Which command forward models hear: "total" that was taken, or each
            module's "own", as the paper's text says.
        spectral_radius: Spectral radius of the reservoirs; the paper's 0.1.
        reservoir_noise: Noise level ν of the reservoirs; the paper's 0.2.

    Raises:
        BadOptionError: A setting is outside what it may be.
    """

    modules: int = 4
    nodes: int = 200
    rule: RuleName = "weighted"
    proprioception: bool = True
    forward_input: Literal["total", "own"] = "total"
    spectral_radius: float = 0.1
    reservoir_noise: float = 0.2

    def __post_init__(self) -> None:
        """Check the settings."""
        for name, most in {"modules": 1000, "nodes": 20000}.items():
            count = getattr(self, name)
            if not (isinstance(count, Integral) and 1 <= int(count) <= most):
                raise BadOptionError(f"{name} is {count!r}; expected a whole number, 1 to {most}")
        if self.rule not in get_args(RuleName):
            raise BadOptionError(f"rule is '{self.rule}'; expected weighted or gated")
        if self.forward_input not in ("total", "own"):
            raise BadOptionError(f"forward_input is '{self.forward_input}'; expected total or own")
        for name in ("spectral_radius", "reservoir_noise"):
            value = getattr(self, name)
            if not 0.0 <= value < 1.0:
                raise BadOptionError(f"{name} is {value:g}; expected 0 or more, below 1")


class MPMA:
    """Modules of inverse model, forward model and responsibility predictor that share a task.

    One step: the forward models' last predictions are held against the posture that came
    (likelihood ℓ), the context says beforehand who should be suited (prior p); both give the
    responsibilities λ, which mix the inverse models' actions. The feedback controller is added.

        p^i = clip(RP_i(y), p_min, 1)           λ^i = p^i ℓ^i / Σ_j p^j ℓ^j
        u^i = clip(IM_i([x ; s ; x'_{t+1}]), -1, 1)
        u   = clip(L Σ_i λ^i u^i + K u_fb, -1, 1)
        x̂^i = FM_i([u ; x ; s])

    The sense s of the joint angles q, [sin q ; cos q], is ours: `MPMAConfig.proprioception`.

    After an epoch the learning rule refits all readouts, and K and L move on.

    Attributes:
        gains: K and L of the present epoch.
    """

    def __init__(
        self,
        config: MPMAConfig,
        *,
        context_size: int,
        max_joint_speed: Array,
        control_timestep: float,
        seed: int = 0,
    ) -> None:
        """Draw the reservoirs.

        Args:
            config: Settings.
            context_size: Size of the observation's context, C.
            max_joint_speed: Joint speeds that action 1 commands, shape (8,), rad/s.
            control_timestep: Time between two actions, s.
            seed: Seed of weights and noise.
        """
        self.config = config
        self.gains = Gains()
        self._rule = RULES[config.rule]
        self._sigma = self._rule.first_sigma
        self._untrained_error = float("nan")
        self._max_joint_speed = max_joint_speed
        self._control_timestep = control_timestep
        self._seed = seed
        sensed = _POSTURE + (2 * _JOINTS if config.proprioception else 0)
        self._inverse = self._reservoirs("inverse", sensed + _POSTURE)
        self._forward = self._reservoirs("forward", _JOINTS + sensed)
        self._predictor = self._reservoirs("predictor", context_size)
        # Random preferences for contexts, so that modules differ from the first step (choice).
        preference = np.zeros((config.modules, 1, self._predictor.features))
        preference[:, 0, config.nodes :] = stream(seed, "preference").random(
            (config.modules, context_size)
        )
        self._readouts = Readouts(
            inverse=self._readout(np.zeros((config.modules, _JOINTS, self._inverse.features))),
            forward=self._readout(np.zeros((config.modules, _POSTURE, self._forward.features))),
            predictor=self._readout(preference),
        )
        self.reset(0)

    def reset(self, episode: int) -> None:
        """Begin an episode with reservoirs at rest and that episode's own noise."""
        for bank in (self._inverse, self._forward, self._predictor):
            bank.reset()
        self._rng = stream(self._seed, "reservoir_noise", episode)
        self._steps: list[dict[str, Array]] = []
        self._epoch: Epoch | None = None
        self._last: Observation = {}

    def act(self, observation: Observation) -> Array:
        """Return the action, shape (8,), in [-1, 1]."""
        posture, rng = observation["posture"], self._rng
        modules = self.config.modules

        predictor_features = self._predictor.step(observation["context"], rng)
        predicted = self._readouts.predictor(predictor_features)[:, 0]
        prior = np.clip(predicted, _LEAST_PRIOR, 1.0)
        likelihood = np.ones(modules)
        if self._steps:
            errors = gating.prediction_errors(self._steps[-1]["predictions"], posture)
            likelihood = gating.likelihood(errors, self._sigma)
        responsibility = gating.responsibilities(prior, likelihood)

        sensed = self._sense(observation)
        inverse_features = self._inverse.step(np.concatenate([sensed, observation["target"]]), rng)
        module_actions = np.clip(self._readouts.inverse(inverse_features), -1.0, 1.0)
        feedback = self._feedback(observation)
        mixed = responsibility @ module_actions
        action = np.clip(self.gains.inverse * mixed + self.gains.feedback * feedback, -1.0, 1.0)

        heard = action if self.config.forward_input == "total" else module_actions
        heard = np.broadcast_to(heard, (modules, _JOINTS))
        felt = np.broadcast_to(sensed, (modules, len(sensed)))
        forward_features = self._forward.step(np.concatenate([heard, felt], axis=1), rng)
        predictions = self._readouts.forward(forward_features)

        self._steps.append(
            {
                "inverse_features": inverse_features,
                "forward_features": forward_features,
                "predictor_features": predictor_features,
                "prior": prior,
                "responsibility": responsibility,
                "module_actions": module_actions,
                "predictions": predictions,
                "action": action,
                "posture": posture.copy(),
                "feedback": feedback,
            }
        )
        return action

    def observe(self, timestep: dm_env.TimeStep) -> None:
        """Take in what the action led to."""
        self._last = {n: np.copy(timestep.observation[n]) for n in _NEEDED_LAST}

    def learn(self) -> dict[str, float]:
        """Refit all readouts to the episode and let the gains follow.

        Returns:
            Gains K and L and width σ of the episode, by name.
        """
        epoch = self._close_epoch()
        logged = {
            "gain_feedback": self.gains.feedback,
            "gain_inverse": self.gains.inverse,
            "sigma": self._sigma,
        }
        mixed = np.einsum("tm,tmd->td", epoch.responsibility, epoch.predictions)
        error = metrics.posture_error_percent(mixed, epoch.next_posture)
        if np.isnan(self._untrained_error):
            self._untrained_error = error
        self._rule.fit(self._readouts, epoch)
        self._sigma = self._rule.next_sigma(epoch, self._sigma)
        self.gains = self.gains.after(performance(error, self._untrained_error))
        return logged

    def signals(self) -> dict[str, Array]:
        """Return the signals of the episode that ended.

        Returns:
            `responsibility` and `prior` (T, M), `module_actions` (T, M, 8), `predictions`
            (T, M, 12) of the next posture, `feedback` (T, 8) with its gain.
        """
        epoch = self._close_epoch()
        return {
            "responsibility": epoch.responsibility,
            "prior": epoch.prior,
            "module_actions": epoch.module_actions,
            "predictions": epoch.predictions,
            "feedback": epoch.feedback_gain * epoch.feedback,
        }

    def state_dict(self) -> dict[str, Array]:
        """Return all that learning has changed, as arrays by name."""
        state = {
            "progress": np.array(self.gains.progress),
            "sigma": np.array(self._sigma),
            "untrained_error": np.array(self._untrained_error),
        }
        for part, readout in self._readouts._asdict().items():
            state |= {f"{part}.{name}": value for name, value in readout.state_dict().items()}
        return state

    def load_state_dict(self, state: Mapping[str, Array]) -> None:
        """Continue from what `state_dict` returned."""
        self.gains = Gains(float(state["progress"]))
        self._sigma = float(state["sigma"])
        self._untrained_error = float(state["untrained_error"])
        for part, readout in self._readouts._asdict().items():
            readout.load_state_dict(
                {name: state[f"{part}.{name}"] for name in readout.state_dict()}
            )

    def _sense(self, observation: Observation) -> Array:
        """Return what the models know of the arms: posture and, if set, joint angles."""
        if not self.config.proprioception:
            return observation["posture"]
        angles = observation["joint_angles"]
        return np.concatenate([observation["posture"], np.sin(angles), np.cos(angles)])

    def _reservoirs(self, name: str, inputs: int) -> ReservoirBank:
        return ReservoirBank(
            self.config.modules,
            inputs,
            self.config.nodes,
            radius=self.config.spectral_radius,
            noise=self.config.reservoir_noise,
            rng=stream(self._seed, "reservoir", name),
        )

    def _readout(self, weights: Array) -> ReadoutBank:
        return ReadoutBank(weights, forgetting=self._rule.forgetting, ridge=self._rule.ridge)

    def _feedback(self, observation: Observation) -> Array:
        return feedback_action(
            observation["joint_angles"],
            observation["reference"],
            self._max_joint_speed,
            self._control_timestep,
        )

    def _close_epoch(self) -> Epoch:
        """Stack what was remembered, once an episode."""
        if self._epoch is None:
            steps = {n: np.stack([step[n] for step in self._steps]) for n in self._steps[0]}
            posture, last_feedback = steps.pop("posture"), self._feedback(self._last)
            self._epoch = Epoch(
                **steps,
                next_posture=np.concatenate([posture[1:], self._last["posture"][None]]),
                next_feedback=np.concatenate([steps["feedback"][1:], last_feedback[None]]),
                feedback_gain=self.gains.feedback,
            )
        return self._epoch
