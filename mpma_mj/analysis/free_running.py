"""Free-running: a trained agent continues when the demonstration is taken away."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.anticipation import Anticipation
from mpma_mj.agents.base import Agent, Observation
from mpma_mj.agents.config import POSTURE
from mpma_mj.agents.wrappers import Frozen, paired_models_of
from mpma_mj.context import active_label, equal_segments
from mpma_mj.envs.demonstration import Demonstration
from mpma_mj.envs.task import TwoArmImitation
from mpma_mj.errors import BadOptionError
from mpma_mj.motions import Motion
from mpma_mj.training.checkpoints import load_state
from mpma_mj.training.config import RunConfig
from mpma_mj.training.factory import agent_of, make_environments, one_thread
from mpma_mj.training.rollout import record_epoch
from mpma_mj.training.run_folder import RunFolder

__all__ = [
    "ANTICIPATION",
    "OWN_PREDICTION",
    "ClosedLoop",
    "DemonstrationSource",
    "FreeRun",
    "FreeRunning",
    "OwnPrediction",
    "run_freely",
]

Array = NDArray[np.float64]

_DEMONSTRATED = ("reference_angles", "target_angles", "lookahead_angles")


class DemonstrationSource(Protocol):
    """Postures that stand in for the demonstration."""

    def reset(self, episode: int) -> None:
        """Begin an episode."""

    def __call__(self, observation: Observation, shown: bool) -> Observation:
        """Return the observation with its reference and target.

        Args:
            observation: The observation.
            shown: Whether the demonstration is on; then the observation is returned as it is.
        """


class OwnPrediction:
    """The posture that an agent's own forward models predicted at the step before.

    x'_t = x'_{t+1} = Σ_i λ^i x̂^i
    """

    def __init__(self, agent: Agent) -> None:
        """Use the forward models of an agent.

        Raises:
            BadOptionError: The agent has no forward models, or compensates a latency.
        """
        self._pairs = paired_models_of(agent)
        if self._pairs.senses.late:
            expected = "an agent without latency, as predictions are of the next step"
            raise BadOptionError(option="latency", value=agent.spec.latency, expected=expected)

    def reset(self, episode: int) -> None:
        """Begin an episode."""

    def __call__(self, observation: Observation, shown: bool) -> Observation:
        """Return the observation with the prediction as reference and target."""
        if shown:
            return observation
        predicted = self._pairs.predicted_posture()
        return _shown_instead(observation, predicted, predicted)


class ClosedLoop:
    """A reservoir that anticipates the demonstration from what it anticipated itself.

    x'_{t+1} = anticipation(x'_t, x'_{t-1}, clock_{t-1})
    """

    def __init__(self, anticipation: Anticipation, clock: Array) -> None:
        """Close the loop.

        Args:
            anticipation: A reservoir that has learned the demonstration.
            clock: Its context in a repetition of the motion, shape (P, C).
        """
        self._anticipation, self._clock = anticipation, clock

    def reset(self, episode: int) -> None:
        """Begin an episode."""
        self._anticipation.reset(episode)
        self._step = 0
        self._target = self._following = np.zeros(POSTURE)

    def __call__(self, observation: Observation, shown: bool) -> Observation:
        """Return the observation with what is anticipated as reference and target."""
        if not shown:
            observation = _shown_instead(observation, self._target, self._following)
        context = {"context": self._clock[self._step % len(self._clock)]}
        self._step += 1
        self._target = observation["target"]
        self._following = self._anticipation(dict(observation) | context)[..., 1, :]
        return observation


def _shown_instead(observation: Observation, reference: Array, target: Array) -> Observation:
    """Return an observation with other postures, and without joint angles of the demonstration."""
    kept = {name: array for name, array in observation.items() if name not in _DEMONSTRATED}
    return kept | {"reference": reference, "target": target}


class FreeRunning(Frozen):
    """An agent that after a warm-up receives other postures than the demonstration.

    They are the inverse models' target and the feedback controller's reference. The context stays.
    """

    def __init__(self, agent: Agent, source: DemonstrationSource, warmup_steps: int) -> None:
        """Wrap an agent.

        Args:
            agent: A trained agent.
            source: What it receives after the warm-up.
            warmup_steps: Steps of an episode with the demonstration, at least 1.
        """
        super().__init__(agent)
        self._source, self._warmup_steps = source, warmup_steps
        self._step = 0

    def reset(self, episode: int) -> None:
        """Begin an episode."""
        super().reset(episode)
        self._source.reset(episode)
        self._step = 0

    def act(self, observation: Observation) -> Array:
        """Return the action for the demonstration, or after the warm-up for what replaces it."""
        shown = self._step < self._warmup_steps
        self._step += 1
        return super().act(self._source(observation, shown))


OWN_PREDICTION, ANTICIPATION = "own prediction", "anticipation"

# Choices.
_REPETITIONS, _DURATION = 3, 57.0  # at least, and s; without the demonstration
_NODES = 400  # of the anticipation
_LESSONS = 4  # epochs of the demonstration from which it learns


@dataclass(frozen=True, eq=False)
class FreeRun:
    """Postures from the moment of release on, and what would have been demonstrated.

    Attributes:
        posture: Postures of the arms, shape (T, 12).
        reference: Demonstrated postures that were not shown, shape (T, 12).
        label: Index of the active label, shape (T,); -1 for none.
        period: Steps of one repetition.
        rate: Steps per second, Hz.
    """

    posture: Array
    reference: Array
    label: NDArray[np.int_]
    period: int
    rate: float


def run_freely(folder: RunFolder, beat: float | None = None) -> tuple[dict[str, FreeRun], Motion]:
    """Let the agent of a run's best epoch run without the demonstration, after one repetition.

    It receives its own prediction in place of the demonstration, or what a reservoir anticipates
    that has learned the demonstration and runs in closed loop. The demonstration has no noise
    here, which would add to speeds and errors (choice).

    Args:
        folder: Folder of the run.
        beat: Length of the parts into which the reservoir's context divides a repetition, s; the
            motion's labels are its context if not given.

    Returns:
        Postures with each of the two, by name, and the motion.

    Raises:
        MpmaError: There is no run, or it is damaged, or its agent has no forward models.
        DivergedError: The simulation did not stay finite.
    """
    config, motion = folder.read_config(), folder.read_motion()
    state, row = folder.read_best(config)
    period = make_environments(config, config.seed, motion).task.period
    repetitions = max(_REPETITIONS, math.ceil(_DURATION * motion.rate / period))
    options = {"repeats": 1 + repetitions, "reference_noise": 0.0, "random_start": False}
    env = make_environments(config, config.seed, motion, options)
    clock = env.task.context[:period] if beat is None else _beats(period, motion.rate, beat)
    agent = load_state(agent_of(config, env, config.seed), state, folder.checkpoint("best"))
    anticipation = _learned(config, env.task, clock)
    sources: dict[str, DemonstrationSource] = {
        OWN_PREDICTION: OwnPrediction(agent),
        ANTICIPATION: ClosedLoop(anticipation, clock),
    }
    runs = {}
    for name, source in sources.items():
        with one_thread():
            # The reservoirs' noise is of the epoch after the best one.
            trace = record_epoch(env, FreeRunning(agent, source, period), int(row["epoch"]))
        runs[name] = FreeRun(
            trace.posture[period:],
            trace.reference[period:],
            active_label(trace.context[period:]),
            period,
            motion.rate,
        )
    return runs, motion


def check_beat(period: int, rate: float, beat: float) -> None:
    """Check the length of the parts into which a context divides a repetition.

    Args:
        period: Steps of a repetition.
        rate: Steps per second, Hz.
        beat: Length of a part, s.

    Raises:
        BadOptionError: A part is shorter than a step or longer than a repetition.
    """
    if not 1.0 <= beat * rate <= period:
        expected = f"{1 / rate:g} to {period / rate:g} s, a control step to a repetition"
        raise BadOptionError(option="beat", value=beat, expected=expected)


def _beats(period: int, rate: float, beat: float) -> Array:
    """Return a context that divides a repetition into parts of equal length, shape (P, C).

    Args:
        period: Steps of a repetition, P.
        rate: Steps per second, Hz.
        beat: Length of a part, s, about.

    Raises:
        BadOptionError: As of `check_beat`.
    """
    check_beat(period, rate, beat)
    return equal_segments(period, round(period / rate / beat))[0]


def _learned(config: RunConfig, task: TwoArmImitation, clock: Array) -> Anticipation:
    """Return a reservoir that has learned to anticipate the demonstration of a run.

    Args:
        config: Config of the run, with the noise of its demonstration.
        task: Task of the run's environment.
        clock: Context of one repetition, shape (P, C).
    """
    options = dataclasses.replace(config.env, random_start=False)
    demonstration = Demonstration(task.motion, options, task.max_joint_speed, task.kinematics)
    anticipation = Anticipation(clock.shape[1], config.seed, 1, _NODES)
    for number in range(_LESSONS):
        reference = demonstration.episode(config.seed, number).reference
        anticipation.reset(number)
        for t in range(demonstration.steps):
            context = clock[t % len(clock)]
            shown = {"reference": reference[t], "target": reference[t + 1], "context": context}
            anticipation(shown)
        anticipation.learn(())
    return anticipation
