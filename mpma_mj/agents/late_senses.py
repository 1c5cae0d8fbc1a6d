"""Senses of agents whose observations are late or noisy."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.anticipation import Anticipation
from mpma_mj.agents.base import AgentSpec, Observation, Seeds
from mpma_mj.agents.config import JOINTS
from mpma_mj.agents.plant_models import gaussian_log_likelihood
from mpma_mj.agents.senses import Senses, Steps
from mpma_mj.agents.state_models import StateEstimate, StateModels, state_inputs
from mpma_mj.agents.switching import filtered, predicted
from mpma_mj.arm_kinematics import TWO_ARMS, ArmKinematics

__all__ = ["LateSenses", "eased_target"]

Array = NDArray[np.float64]

# Choices.
_SWITCHING_PROBABILITY = 0.02  # of the delay, a step
_CORRECTION = 0.5  # α: part of the present error that a late command corrects
_ERROR = 4.0  # variances of the state model's error that a state estimate expects: it is not white


def eased_target(
    joint_angles: Array, reference: Array, target: Array, kinematics: ArmKinematics = TWO_ARMS
) -> Array:
    """Return a target at which only a part of the present error is corrected.

        q* = q + (q'_{s+1} - q'_s) + α (q'_s - q)        α = ½

    A command that corrects all of it is a feedback of gain 1, with which arms swing where the delay
    or the plant is another than expected. The motion of the demonstration itself is kept.

    Args:
        joint_angles: Expected joint angles q, shape (..., 8), rad.
        reference: Posture that is demonstrated then, shape (..., 12), or joint angles, (..., 8).
        target: Posture or joint angles one step later, of the same shape.
        kinematics: Kinematics of the arms.

    Returns:
        Posture of q*, shape (..., 12), or q* itself, (..., 8), rad.
    """
    if reference.shape[-1] == JOINTS:
        error = kinematics.step_to(reference, near=joint_angles)
        move = kinematics.step_to(target, near=joint_angles + error)
        return joint_angles + move + _CORRECTION * error
    shown = kinematics.angles(reference, near=joint_angles)
    following = kinematics.angles(target, near=shown)
    error = shown - joint_angles
    return kinematics.posture(joint_angles + (following - shown) + _CORRECTION * error)


class LateSenses(Senses):
    """The state that is expected when a command acts, k steps after it was given.

    Commands under way run through a model of the state (Smith 1957), that of the plant which is
    most probably on (`StateModels`). It learns from the command that acted, at every step for the
    episode and after it for good. Targets are those of the observation `lookahead`, or anticipated
    where that does not reach far enough. If k is not known, delays from 0 to a largest one are
    rival hypotheses that share the model and differ in the command that they assume,

        log ℓ_j = -½ Σ_d (move_{t-1} - A o(u_{t-1-j}, q_{t-1}, q̇_{t-1}))²_d / s²_d

    filtered with a switching probability of 0.02; the most probable counts. With a state estimate
    the present state is one of observation and prediction (`StateEstimate`).

    Attributes:
        delays: Delay k at each step so far, each of shape (...).
    """

    late = True

    def __init__(
        self,
        spec: AgentSpec,
        batch_shape: tuple[int, ...],
        *,
        plants: int,
        max_latency: int,
        estimates: bool,
        seed: Seeds,
    ) -> None:
        """Begin with the kinematic prior.

        Args:
            spec: Description of the arms; its latency is the delay, or None if it is not known.
            batch_shape: Shape of the runs.
            plants: Largest number of plants, W.
            max_latency: Largest compensated delay, control steps.
            estimates: Whether observation and prediction share the present state.
            seed: Seed of the anticipation; several are a batch of runs.
        """
        self._spec, self._shape, self._known = spec, batch_shape, spec.latency
        self._most = max_latency if spec.latency is None else spec.latency
        self._models = StateModels(spec, batch_shape, plants)
        self._estimate = StateEstimate(batch_shape) if estimates else None
        anticipates = 0 < self._most >= spec.lookahead
        # As many targets for every latency, so that an agent can meet another one.
        self._anticipation = (
            Anticipation(spec.context_size, seed, max_latency) if anticipates else None
        )
        parts = (self._models, self._estimate, self._anticipation)
        self._parts = [part for part in parts if part is not None]
        self.reset(0)

    def reset(self, episode: int) -> None:
        """Begin an episode with no command under way, and every delay alike."""
        count = self._most + 1
        self._commands = np.zeros((count, *self._shape, JOINTS))  # u_{t-1}, u_{t-2}, …
        self._belief = np.full((*self._shape, count), 1.0 / count)
        self._models.reset()
        self._model = self._models.of_plant(np.zeros(self._shape, np.intp))
        self._now: tuple[Array, Array] | None = None  # q and q̇ / v
        self._states: list[tuple[Array, Array]] = []
        self._predictions: list[Array] = []
        self.delays: list[NDArray[np.intp]] = []
        if self._estimate is not None:
            self._estimate.reset()
        if self._anticipation is not None:
            self._anticipation.reset(episode)

    @property
    def known(self) -> bool:
        """Whether the delay is known."""
        return self._known is not None

    @property
    def delay(self) -> NDArray[np.intp]:
        """Delay k that is most probable now, shape (...)."""
        if self._known is not None:
            return np.full(self._shape, self._known)
        return np.asarray(self._belief.argmax(axis=-1))

    def __call__(self, observation: Observation, plant: NDArray[np.intp] | int) -> Observation:
        """Return the observation that is expected when the next command acts."""
        angles = observation["joint_angles"]
        speed = observation["joint_velocities"] / self._spec.max_joint_speed
        if self._estimate is not None:
            angles, speed = self._estimate(angles, speed)
        if self._known is None and self._now is not None:
            self._find_delay(angles)
        self._adapt(angles, speed)
        self._now = angles, speed
        self._states.append(self._now)
        self.delays.append(self.delay)
        self._model = self._models.of_plant(plant)
        for j in range(self._most, 0, -1):
            command = self._commands[j - 1]
            following = self._models.following(self._model, command, angles, speed)
            under_way = (self.delay >= j)[..., None]
            angles = np.where(under_way, following[0], angles)
            speed = np.where(under_way, following[1], speed)
        expected = self._with_state(observation, angles, speed)
        expected |= self._shown(observation, angles, "", self._coming(observation))
        if "reference_angles" not in observation:
            return expected
        if self._anticipation is not None:  # which predicts postures
            del expected["reference_angles"], expected["target_angles"]
            return expected
        coming = observation.get("lookahead_angles", observation["target_angles"][..., None, :])
        return expected | self._shown(observation, angles, "_angles", coming)

    def present(self, observation: Observation) -> Observation:
        """Return the observation with the state of now, as it is estimated."""
        if self._estimate is None or self._now is None:
            return observation
        return self._with_state(observation, *self._now)

    def of_last_move(self, predictions: Array | None) -> Array | None:
        """Return the predictions that were made with the command that caused the last move."""
        if predictions is None:
            return None
        self._predictions.append(predictions)
        back = np.minimum(self.delay, len(self._predictions) - 1)
        if not self._shape:
            return self._predictions[-1 - int(back)]
        return np.stack([self._predictions[-1 - k][run] for run, k in enumerate(back.tolist())])

    def acting(self, observation: Observation, action: Array) -> tuple[Observation, Array]:
        """Receive an action; return present state and the action that acts on it, (..., 8)."""
        self._commands = np.concatenate([action[None], self._commands[:-1]])
        acting = np.take_along_axis(self._commands, self.delay[None, ..., None], axis=0)[0]
        if self._estimate is not None and self._now is not None:
            self._estimate.predict(*self._models.following(self._model, acting, *self._now))
        return self.present(observation), acting

    def aligned(self, steps: Steps, last: Steps, run: tuple[int, ...]) -> Steps:
        """Return the steps of one run by the command that acted, with the state on which it did.

        What belongs to the command is taken from the step at which it was given; steps at which
        no command acted yet are left out.
        """
        own: tuple[Any, ...] = (slice(None), *run)
        delays = np.stack(self.delays)[own]
        angles = np.stack([state[0] for state in self._states])[own]
        speed = np.stack([state[1] for state in self._states])[own]
        given = self._given(delays)
        acted = np.flatnonzero(given >= 0)
        velocities = speed * self._spec.max_joint_speed
        observed = {
            "joint_angles": angles,
            "joint_velocities": velocities,
            "posture": self._spec.kinematics.posture(angles),
        }
        last = last | {"posture": self._spec.kinematics.posture(last["joint_angles"])}
        following = {
            name: np.concatenate([array[1:], last[name][None]])[acted]
            for name, array in observed.items()
        }
        aligned = {name: array[given[acted]] for name, array in steps.items()}
        aligned |= {name: array[acted] for name, array in observed.items()}
        return aligned | {f"next_{name}": array for name, array in following.items()}

    def effects(self, predictions: Array) -> Array:
        """Return predictions, shape (T, ...), at the steps at which their commands act."""
        given = np.maximum(self._given(np.stack(self.delays)), 0)
        more = predictions.ndim - given.ndim
        return np.take_along_axis(predictions, given.reshape(*given.shape, *[1] * more), axis=0)

    def _given(self, delays: NDArray[np.intp]) -> NDArray[np.intp]:
        """Return the step at which the command of each step was given, below 0 if none was.

        The belief in a delay at a step follows from the move before it.
        """
        steps = np.arange(len(delays)).reshape(-1, *[1] * (delays.ndim - 1))
        return steps - np.concatenate([delays[1:], delays[-1:]])

    def learn(self, steps: Steps, shares: Array, run: tuple[int, ...]) -> None:
        """Refit the state models, the anticipation and the state estimate."""
        error = self._models.learn(steps, shares, run)
        if self._anticipation is not None:
            self._anticipation.learn(run)
        if self._estimate is not None:
            self._estimate.learn(_ERROR * error, run)

    def select_runs(self, runs: NDArray[np.intp]) -> None:
        """Continue with some runs only, (R',) of R, from the next reset."""
        self._shape = runs.shape
        for part in self._parts:
            part.select_runs(runs)

    def state_dict(self) -> dict[str, Array]:
        """Return copies of all arrays that learning changes, by name."""
        state: dict[str, Array] = {}
        for part in self._parts:
            state |= part.state_dict()
        return state

    def load_state_dict(self, state: Mapping[str, Array]) -> None:
        """Continue from the arrays that `state_dict` returned; others are left out.

        An agent that has never had to anticipate holds the target.
        """
        for part in self._parts:
            if part is not self._anticipation or part.state_dict().keys() & state.keys():
                part.load_state_dict(state)

    def _shown(
        self, observation: Observation, angles: Array, kind: str, coming: Array
    ) -> dict[str, Array]:
        """Return reference and target, eased, at the time at which the next command acts.

        Args:
            observation: The observation.
            angles: Joint angles that are expected then, shape (..., 8), rad.
            kind: "" for postures, "_angles" for joint angles, as names end.
            coming: Targets of the next steps, shape (..., most + 1 or more, 12 or 8).
        """
        now = observation[f"reference{kind}"][..., None, :]
        shown = np.concatenate([now, coming], axis=-2)
        place = self.delay[..., None, None]
        reference = np.take_along_axis(shown, place, axis=-2)[..., 0, :]
        target = np.take_along_axis(shown, place + 1, axis=-2)[..., 0, :]
        late = (self.delay > 0)[..., None]
        eased = eased_target(angles, reference, target, self._spec.kinematics)
        eased = np.where(late, eased, target)
        return {f"reference{kind}": reference, f"target{kind}": eased}

    def _coming(self, observation: Observation) -> Array:
        """Return the targets of the next steps, shape (..., most + 1 or more, 12)."""
        if self._anticipation is not None:
            return self._anticipation(observation)
        if self._most == 0:
            return observation["target"][..., None, :]
        return observation["lookahead"]

    def _with_state(self, observation: Observation, angles: Array, speed: Array) -> Steps:
        return dict(observation) | {
            "joint_angles": angles,
            "joint_velocities": speed * self._spec.max_joint_speed,
            "posture": self._spec.kinematics.posture(angles),
        }

    def _adapt(self, angles: Array, speed: Array) -> None:
        """Update the state models with the move to this state and the command that acted.

        With noise and no latency it would cost more in one plant than it brings: inputs are noisy.
        """
        if self._now is None or self._most == 0:
            return
        before, then = self._now
        place = self.delay[None, ..., None]
        command = np.take_along_axis(self._commands, place, axis=0)[0]
        outputs = np.concatenate([self._spec.move(before, angles), speed], axis=-1)
        acted = len(self._states) > self.delay
        self._models.observe(state_inputs(command, before, then), outputs, acted)

    def _find_delay(self, angles: Array) -> None:
        """Let the rival hypotheses of the delay account for the move to these joint angles."""
        assert self._now is not None
        before, speed = self._now
        inputs = np.stack([state_inputs(u, before, speed) for u in self._commands], axis=-2)
        moves = inputs @ np.swapaxes(self._model[..., :JOINTS, :], -1, -2)  # (..., J, 8)
        errors = moves - self._spec.move(before, angles)[..., None, :]
        logs = gaussian_log_likelihood(errors, self._models.variance[..., None, :])
        every = np.ones(self._belief.shape, bool)
        self._belief = filtered(predicted(self._belief, every, _SWITCHING_PROBABILITY), logs)
