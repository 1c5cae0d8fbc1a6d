"""Comparison of arms: agents trained on each kind and evaluated on each."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.registry import check_trainable
from mpma_mj.arm_kinematics import TWO_ARMS, ArmKinematics
from mpma_mj.envs.options import MASS_OPTIONS, EnvironmentOptions
from mpma_mj.envs.physics import PhysicsArms
from mpma_mj.envs.plants import PLANT_OPTIONS
from mpma_mj.errors import BadOptionError, WorkerError
from mpma_mj.evaluation.effort import Effort, effort
from mpma_mj.evaluation.evaluate import EvalCondition, evaluate, fine_tune, posture_errors_percent
from mpma_mj.experiments.backend import Backend, Work, get_done
from mpma_mj.feedback import joint_error
from mpma_mj.metrics import phase_lag
from mpma_mj.motions import Motion
from mpma_mj.trace import Trace
from mpma_mj.training.checkpoints import TrainedAgents
from mpma_mj.training.config import RunConfig
from mpma_mj.training.history import epoch_metrics
from mpma_mj.training.trainer import check, train_agents

__all__ = [
    "ARMS",
    "UNTRAINED",
    "CompareJob",
    "Episode",
    "Transfer",
    "compare",
    "done_by_name",
    "jobs",
    "measured",
]

Array = NDArray[np.float64]

_NO_MASS = {name: getattr(EnvironmentOptions(), name) for name in MASS_OPTIONS}

ARMS: dict[str, dict[str, Any]] = {
    "kinematic": {"arms": "kinematic"} | _NO_MASS,
    "physics": {"arms": "physics", "gravity_compensation": False},
    "compensated": {"arms": "physics", "gravity_compensation": True},
}
"""Options of the environments: ideal arms, simulated arms, simulated arms without weight."""

UNTRAINED = "nothing"
"""Row of the feedback controller, which is trained on nothing."""


@dataclass(frozen=True, eq=False)
class Episode:
    """An episode of one agent without learning.

    Attributes:
        trace: Its signals, as `record_epoch` returns them.
        options: Options of its environment.
        effort: Its effort; None on ideal arms, and where commands are late or hands are pushed.
        measures: Its measures by name.
    """

    trace: Trace
    options: EnvironmentOptions
    effort: Effort | None
    measures: dict[str, float]


@dataclass(frozen=True, eq=False)
class Transfer:
    """R agents that were trained on one kind of arms and are evaluated on another.

    Attributes:
        trained_on: Arms of the training, a name of `ARMS`, or `UNTRAINED`.
        evaluated_on: Arms of the evaluation.
        seeds: Seed of each agent.
        epochs: Number of the best epoch of each, from 1, shape (R,); NaN without training.
        episodes: Episode of each at once; None where the simulation diverged.
        fine_tuned: p_e of each after fine-tuning, shape (R,), percent; NaN where the simulation
            diverged, and without training.
    """

    trained_on: str
    evaluated_on: str
    seeds: tuple[int, ...]
    epochs: Array
    episodes: tuple[Episode | None, ...]
    fine_tuned: Array

    def values(self, measure: str) -> list[float]:
        """Return a measure of all episodes that have it."""
        found = [episode.measures.get(measure, np.nan) for episode in self.episodes if episode]
        return [value for value in found if np.isfinite(value)]

    @property
    def tuned(self) -> list[float]:
        """p_e after fine-tuning where the simulation did not diverge, percent."""
        return [value for value in self.fine_tuned.tolist() if np.isfinite(value)]


@dataclass(frozen=True, eq=False)
class CompareJob(Work):
    """Agents that are trained on one kind of arms, and evaluated on each.

    Attributes:
        trained_on: Arms of the training, a name of `ARMS`, or `UNTRAINED`.
        configs: Config of each of R runs, which differ in their seeds only; their arms do not
            count.
        motion: The motion.
        epochs: Largest number of epochs of training.
        fine_tune: Epochs of fine-tuning on the arms of the evaluation.
    """

    trained_on: str
    configs: tuple[RunConfig, ...]
    motion: Motion
    epochs: int
    fine_tune: int

    def do(self) -> list[Transfer]:
        """Return the transfer to each kind of arms.

        Raises:
            DivergedError: A simulation diverged in training.
        """
        trained = self._train()
        conditions = (EvalCondition(name, self.motion, options) for name, options in ARMS.items())
        return [
            _transfer(trained, self.trained_on, condition, self.fine_tune)
            for condition in conditions
        ]

    def _train(self) -> TrainedAgents:
        if self.trained_on == UNTRAINED:
            feedback = [config.replace(agent="feedback_only") for config in self.configs]
            return train_agents(feedback, self.motion, 1, {})
        # The configs stay, so that the arms of training are no part of an evaluation.
        return train_agents(self.configs, self.motion, self.epochs, ARMS[self.trained_on])


def jobs(
    configs: Sequence[RunConfig], motion: Motion, *, epochs: int, fine_tune: int
) -> list[CompareJob]:
    """Return the jobs of a comparison, what takes longest first; arguments as of `CompareJob`.

    Raises:
        MpmaError: An option is out of bounds, the agent does not learn, or the arms cannot follow
            the motion.
    """
    for name, value in {"epochs": epochs, "fine_tune": fine_tune}.items():
        if value < 1:
            raise BadOptionError(option=name, value=value, expected="at least 1")
    if configs[0].env.plants is not None:
        problem = "kinds of arms are compared, each without plants"
        raise BadOptionError(problem, remedy="leave {plants} out")
    for name, ends in configs[0].env.ranges.items():
        if name in PLANT_OPTIONS:
            expected = "one number, as kinds of arms are compared with a single plant"
            raise BadOptionError(option=name, value=ends, expected=expected)
    check_trainable(configs[0].agent_name)
    check(configs[0], motion)
    return [
        CompareJob(name, tuple(configs), motion, epochs, fine_tune) for name in (*ARMS, UNTRAINED)
    ]


def compare(
    spec: Sequence[CompareJob],
    backend: Backend,
    on_trained: Callable[[str], None] = lambda trained_on: None,
) -> list[Transfer]:
    """Train on each kind of arms, and evaluate on each.

    Args:
        spec: The jobs.
        backend: The workers.
        on_trained: Called with the arms of a job that is done.

    Returns:
        The transfer between each pair of `ARMS`, those trained on the same arms in a row; before
        them the feedback controller on each.

    Raises:
        DivergedError: A simulation diverged in training.
        WorkerError: A worker died repeatedly.
    """
    found: dict[str, list[Transfer]] = done_by_name(spec, backend, on_trained)
    return [one for trained_on in (UNTRAINED, *ARMS) for one in found[trained_on]]


def done_by_name(
    jobs: Sequence[Any], backend: Backend, on_trained: Callable[[str], None]
) -> dict[str, Any]:
    """Do jobs, and return their results by what they are trained on; errors as of `compare`."""
    found = {}
    for job, done in get_done(jobs, backend):
        if done is None:
            raise WorkerError(
                "a worker process died repeatedly, perhaps for lack of memory",
                remedy="use fewer {runs}, or smaller {nodes}",
            )
        found[job.trained_on] = done
        on_trained(job.trained_on)
    return found


def _transfer(
    trained: TrainedAgents, trained_on: str, condition: EvalCondition, fine_tune_epochs: int
) -> Transfer:
    options = dataclasses.replace(trained.configs[0].env, **condition.options)
    arms = PhysicsArms.make(options)
    episodes = tuple(
        None if trace is None else measured(trace, options, condition.motion.rate, arms)
        for trace in evaluate(trained, condition)
    )
    epochs, fine_tuned = trained.epochs.astype(float), np.full(len(trained.seeds), np.nan)
    if trained_on == UNTRAINED:
        epochs = fine_tuned
    else:
        later, course = fine_tune(trained, condition, fine_tune_epochs)
        p_e = posture_errors_percent(evaluate(later, condition))
        fine_tuned = np.where(np.isnan(course[-1]), np.nan, p_e)
    seeds = tuple(trained.seeds)
    return Transfer(trained_on, condition.name, seeds, epochs, episodes, fine_tuned)


def measured(trace: Trace, options: EnvironmentOptions, rate: float, arms: PhysicsArms) -> Episode:
    """Return an episode with its measures.

    Args:
        trace: Its signals.
        options: Options of its environment.
        rate: Control steps per second, Hz.
        arms: Arms of these options.
    """
    delayed_or_pushed = options.longest_latency > 0 or options.perturbed
    cost = None if delayed_or_pushed else effort(trace, options, rate)
    measures = epoch_metrics(arms.site_positions, trace)
    measures["mpkpe_mm"] = 1e3 * measures.pop("mpkpe_m")
    measures["lag_ms"] = 1e3 * phase_lag(trace.posture[1:], trace.reference[1:], 1.0 / rate)
    measures |= _joint_errors(trace, arms.kinematics)
    if cost is not None:
        measures |= {
            "mean_torque_nm": cost.mean_torque,
            "peak_torque_nm": cost.peak_torque,
            "work_j": cost.work,
        }
    return Episode(trace, options, cost, measures)


def _joint_errors(trace: Trace, kinematics: ArmKinematics) -> dict[str, float]:
    """Return the root mean square of each joint's error, deg.

    It is that of `joint_error`, or, for other robots, the way to the nearest joint angles.
    """
    angles, reference = trace.joint_angles[1:], trace.reference[1:]
    if kinematics == TWO_ARMS:
        error = joint_error(angles, reference)
    else:  # whose correction is damped
        error = kinematics.angles(reference, near=angles) - angles
    rms = np.degrees(np.sqrt(np.mean(error**2, axis=0)))
    return {
        f"rms_{name}_deg": float(x) for name, x in zip(kinematics.joint_names, rms, strict=True)
    }
