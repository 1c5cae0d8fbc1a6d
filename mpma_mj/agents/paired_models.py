"""Pairs of inverse and forward model that share control."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mpma_mj import metrics
from mpma_mj.agents.base import (
    MODULE_SIGNALS,
    Agent,
    AgentSignals,
    AgentSpec,
    ModuleSignals,
    Observation,
)
from mpma_mj.agents.config import JOINTS, AgentConfig
from mpma_mj.agents.episode_buffer import EpisodeBuffer
from mpma_mj.agents.gain_schedule import FINAL_GAINS, Gains, performance
from mpma_mj.agents.gating import Gate, checked_mask, learned_part, mixed_outputs
from mpma_mj.agents.learning_rules import Epoch, LearningRule, Readouts, Step
from mpma_mj.agents.model_space import Before, ModelSpace, module_action
from mpma_mj.agents.networks import NetworkFactory, RunIndex
from mpma_mj.agents.senses import Senses
from mpma_mj.errors import StateError
from mpma_mj.feedback import followed
from mpma_mj.options import EfferenceCopy
from mpma_mj.utils.clipping import clip
from mpma_mj.utils.saved_arrays import assign

if TYPE_CHECKING:
    import dm_env

__all__ = ["PairedModels"]

Array = NDArray[np.float64]

_NEEDED_LAST = ("posture", "joint_angles", "joint_velocities", "reference", "reference_angles")


class PairedModels(Agent):
    """M pairs of inverse model IM_i and forward model FM_i, and a feedback controller.

    One step, with responsibilities λ that sum to 1 (`Gate`):

        u^i = clip(m + IM_i([s ; x'_{t+1} ; m]), -1, 1)
        u   = clip(L Σ_i λ^i u^i + K u_fb, -1, 1)
        x̂^i = FM_i([efference copy ; s])

    with state s, command m and prediction of a `ModelSpace`. The efference copy is u, or each
    module's own u^i. After an epoch the readouts learn (`LearningRule`), and the gains follow;
    `senses` makes up for late or noisy observations.
    """

    trainable: bool = True
    fine_tunable: bool = True
    has_modules: bool = True

    def __init__(
        self,
        config: AgentConfig,
        spec: AgentSpec,
        *,
        networks: NetworkFactory,
        gate: Gate,
        rule: LearningRule,
        space: ModelSpace,
        senses: Senses | None = None,
        efference_copy: EfferenceCopy = "total",
    ) -> None:
        """Draw the reservoirs.

        Args:
            config: Config of the agent.
            spec: Description of arms and observations.
            networks: What all networks have in common.
            gate: Decides which modules control.
            rule: Decides what is learned.
            space: What models sense, command and predict.
            senses: State that models receive; as it is observed if not given.
            efference_copy: Command that forward models receive, "total" or "module".
        """
        super().__init__(config, spec, seed=networks.seed)
        self._gate, self._rule, self._efference_copy = gate, rule, efference_copy
        self._batch_shape = np.shape(networks.seed)
        self._modules = networks.modules
        self._space, self.senses = space, senses or Senses()
        self._inverse = networks.make("inverse", space.inverse_inputs, JOINTS)
        self._forward = networks.make("forward", JOINTS + space.state_size, space.outputs)
        self._parts = (self._inverse, self._forward, gate, self.senses)
        self._readouts = Readouts(
            inverse=self._inverse.readouts,
            forward=self._forward.readouts,
            predictor=gate.predictor.readouts if gate.predictor else None,
        )
        self._progress = np.zeros(self._batch_shape)
        self._untrained_error = np.full(self._batch_shape, np.nan)
        self._steps = EpisodeBuffer()
        self.reset(0)

    @property
    def gains(self) -> Gains:
        """K and L of the present epoch."""
        return Gains(self._progress[()])

    @property
    def enabled_modules(self) -> NDArray[np.bool_]:
        """Which modules may control, shape (M,)."""
        return self._gate.enabled[: self._gate.plants * self._modules].copy()

    @property
    def responsibility(self) -> Array | None:
        """Responsibilities λ of the last step, shape (..., M); None before the first."""
        return self._steps.last("responsibility").copy() if len(self._steps) else None

    def reset(self, episode: int) -> None:
        """Begin an episode with reservoirs at rest and that episode's noise."""
        self._gate.reset(episode)
        self.senses.reset(episode)
        for network in (self._inverse, self._forward):
            network.set_plants(self._gate.plants)
            network.reset(episode)
        # One run's gains are arrays without axes, which are multiplied faster.
        gains = Gains(self._progress[..., None] if self._batch_shape else self._progress)
        self._inverse_gain, self._feedback_gain = map(np.asarray, (gains.inverse, gains.feedback))
        self._steps.clear()
        self._before: Before | None = None
        self._predictions: Array | None = None  # of the step before, as the gate compares them
        self._last: Observation = {}

    def act(self, observation: Observation, executed: Array | None = None) -> Array:
        """Return the action, shape (..., 8), in [-1, 1]; arms may receive `executed` instead."""
        space, senses = self._space, self.senses
        expected = senses(observation, self._gate.likely_plant)
        predictions = senses.of_last_move(self._predictions)
        prior, responsibility = self._gate(senses.present(observation), predictions)
        angles, state = expected["joint_angles"], space.state(expected, self._before)
        feedback, command = space.commands(expected)
        inputs = space.inverse_input(state, expected["target"], command)
        module_actions = module_action(self._inverse.step(inputs), command)
        planned = mixed_outputs(responsibility, module_actions, self._modules)
        action = clip(self._inverse_gain * planned + self._feedback_gain * feedback)
        executed = action if executed is None else executed
        copy = executed if self._efference_copy == "total" else module_actions
        outputs = self._forward.step(space.forward_input(copy, state))
        self._predictions = (
            space.predicted_posture(outputs, angles) if self._gate.compares_postures else outputs
        )
        if senses.late:
            present, acting = senses.acting(observation, executed)
            self._gate.observe_action(present["joint_angles"], space.state(present, None), acting)
        else:
            self._gate.observe_action(angles, state, executed)
        self._before = angles, executed
        step = {
            "context": observation["context"],
            "prior": prior,
            "responsibility": responsibility,
            "module_actions": module_actions,
            "predictions": outputs,
            "action": executed,
            "posture": observation["posture"],
            "joint_angles": angles,
            "state": state,
            "feedback": feedback,
        }
        self._steps.append(step if command is None else step | {"command": command})
        return action

    def observe(self, timestep: dm_env.TimeStep) -> None:
        """Receive the outcome of the action, from which some rules learn at once."""
        observation = timestep.observation
        self._last = {n: observation[n].copy() for n in _NEEDED_LAST if n in observation}
        if self._rule.online and len(self._steps):
            self._rule.partial_fit(self._readouts, self._step())

    def learn(self) -> dict[str, Array]:
        """Let every run learn from its episode, and its gains follow.

        Returns:
            Its gains K and L, `gain_feedback` and `gain_inverse`, and what the gate logs.

        Raises:
            StateError: There was no episode.
        """
        if not (len(self._steps) and self._last):
            raise StateError("learn() was called before an episode; call act() and observe() first")
        gains = Gains(self._progress)
        feedback, inverse = np.asarray(gains.feedback), np.asarray(gains.inverse)
        for run in np.ndindex(self._batch_shape):
            self._learn_run(run)
        return {"gain_feedback": feedback, "gain_inverse": inverse} | self._gate.logged()

    def predicted_posture(self) -> Array:
        """Return the posture that is predicted to come next, Σ_i λ^i x̂^i, shape (..., 12).

        Raises:
            StateError: There was no step yet.
        """
        if not len(self._steps):
            raise StateError("predicted_posture() was called before a step; call act() first")
        responsibility = self._steps.last("responsibility")
        outputs, angles = self._steps.last("predictions"), self._steps.last("joint_angles")
        predicted = self._space.predicted_posture(outputs, angles)
        return mixed_outputs(responsibility, predicted, self._modules)

    def signals(self) -> AgentSignals:
        """Return the signals of the episode so far; none before the first step."""
        if not len(self._steps):
            return AgentSignals()
        steps = self._steps.episode()
        modules = {name: steps[name].copy() for name in MODULE_SIGNALS}
        for run in np.ndindex(self._batch_shape):
            absent = slice(self._gate.plants_of(run) * self._modules, None)
            modules["prior"][(slice(None), *run, absent)] = np.nan
        predicted = self._space.predicted_posture(modules["predictions"], steps["joint_angles"])
        modules["predictions"] = self.senses.effects(predicted)
        learned = learned_part(
            steps["responsibility"], steps["module_actions"], steps.get("command"), self._modules
        )
        return AgentSignals(
            feedback=self._feedback_gain * steps["feedback"],
            learned=self._inverse_gain * learned,
            modules=ModuleSignals(**modules),
        )

    def state_dict(self) -> dict[str, Array]:
        """Return copies of all arrays that learning changes, by name."""
        state = {"progress": self._progress.copy(), "untrained_error": self._untrained_error.copy()}
        for part in self._parts:
            state |= part.state_dict()
        return state

    def load_state_dict(self, state: Mapping[str, Array]) -> None:
        """Continue from the arrays that `state_dict` returned; see `Agent`."""
        assign(self._progress, state["progress"], low=0.0, high=1.0)
        assign(self._untrained_error, state["untrained_error"], low=0.0, nan=True)
        for part in self._parts:
            part.load_state_dict(state)

    def select_runs(self, runs: NDArray[np.intp]) -> None:
        """Continue with some runs only, (R',) of R, from the next reset."""
        self._batch_shape = runs.shape
        self._progress = self._progress[runs]
        self._untrained_error = self._untrained_error[runs]
        for part in self._parts:
            part.select_runs(runs)
        self._steps = EpisodeBuffer()

    def set_enabled_modules(self, enabled: Sequence[bool] | NDArray[np.bool_]) -> None:
        """Switch modules off or on, from the next step; what they learned stays.

        A module that is off has prior and responsibility 0, and its models learn nothing; after an
        epoch, if it is off at its end. Reservoirs go on, so that it takes part again as if it had
        never been off. If all are off, the feedback controller is left alone.

        Args:
            enabled: Whether each module may control, shape (M,).

        Raises:
            BadOptionError: There are not as many modules, or an entry is no truth value.
        """
        self._gate.enable(checked_mask(enabled, self._gate.plants * self._modules))

    def _learn_run(self, run: RunIndex) -> None:
        steps = self._own_steps(run)
        if not len(steps["action"]):  # the latency is as long as the episode
            return
        epoch = self._epoch(run)
        predicted = self._space.predicted_posture(epoch.predictions, steps["joint_angles"])
        error = metrics.posture_error_percent(epoch.mixed(predicted), steps["next_posture"])
        if np.isnan(self._untrained_error[run]):
            self._untrained_error[run] = error
        self._gate.learn_context(run, _of_run(self._steps.episode()["context"], run))
        assigned = self._gate.assign(run, epoch)
        if assigned is not None:
            epoch = replace(epoch, assignment=assigned)
            plants = assigned.reshape(len(assigned), -1, self._modules).sum(axis=2)
            self.senses.learn(steps, plants, run)
        epoch = replace(epoch, **self._features(run))
        readouts = self._readouts.of_run(run)
        if not self._rule.online:
            self._rule.fit(readouts, epoch)
        self._gate.adapt(run, epoch, readouts)
        performed = performance(error, float(self._untrained_error[run]))
        gains = FINAL_GAINS if self._rule.immediate else Gains(self._progress[run]).after(performed)
        self._progress[run] = gains.progress

    def _own_steps(self, run: RunIndex) -> dict[str, Array]:
        """Return the steps of one run by name, each of shape (T, ...), as causes and effects."""
        recorded = {name: _of_run(rows, run) for name, rows in self._steps.episode().items()}
        last = {name: value[run] for name, value in self._last.items()}
        steps = self.senses.aligned(recorded, last, run)
        return steps | {"state": self._space.state(steps, None)} if self.senses.late else steps

    def _features(self, run: RunIndex) -> dict[str, Any]:
        """Return the features of one run's epoch, and the examples of the inverse models."""
        plants, steps = self._gate.plants_of(run), self._own_steps(run)
        for network in (self._inverse, self._forward):
            network.set_plants(max(plants, network.plants))
        predictor, modules = self._gate.predictor, plants * self._modules
        features: dict[str, Any] = {"forward_features": self._forward.episode(run, modules)}
        if self.senses.late:
            efference = self._space.forward_input(steps["action"], steps["state"])
            features["forward_features"] = self._forward.replay(run, efference)
        if predictor is not None:
            features["predictor_features"] = predictor.episode(run, modules)
        examples = self._space.hindsight(steps, by_angles="reference_angles" in self._last)
        if examples is None:
            return features | {"inverse_features": self._inverse.episode(run, modules)}
        inputs, features["desired"], features["usable"] = examples
        return features | {"inverse_features": self._inverse.replay(run, inputs)}

    def _epoch(self, run: RunIndex) -> Epoch:
        """Return the steps of one run, without features."""
        steps, last = self._own_steps(run), self._last
        feedback = self.spec.feedback(last["joint_angles"][run], followed(last, "reference")[run])
        next_feedback = np.concatenate([steps["feedback"][1:], feedback[None]])
        angles, after = steps["joint_angles"], steps["next_joint_angles"]
        return Epoch.without_features(
            steps,
            outcome=self._space.outcome(angles, after, steps["next_posture"]),
            next_feedback=next_feedback,
            feedback_gain=float(Gains(self._progress[run]).feedback),
        )

    def _step(self) -> Step:
        """Return the last step of all runs."""
        last, steps, predictor = self._last, self._steps, self._gate.predictor
        responsibility, angles = steps.last("responsibility"), steps.last("joint_angles")
        no_features = np.empty((*responsibility.shape, 0))
        return Step(
            inverse_features=self._inverse.features,
            forward_features=self._forward.features,
            predictor_features=predictor.features if predictor else no_features,
            responsibility=responsibility,
            predictions=steps.last("predictions"),
            outcome=self._space.outcome(angles, last["joint_angles"], last["posture"]),
            next_feedback=self.spec.feedback(last["joint_angles"], followed(last, "reference")),
            feedback_gain=np.asarray(self.gains.feedback),
        )


def _of_run(rows: Array, run: RunIndex) -> Array:
    """Return the rows of one run, shape (T, ...), of those of all."""
    return rows[(slice(None), *run)]  # type: ignore[arg-type] # an index
