"""The same agents on ideal arms, on simulated ones, and on simulated ones without weight."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.registry import check_trainable
from mpma_mj.envs.options import MASS_OPTIONS, EnvironmentOptions
from mpma_mj.envs.physics import PhysicsArms
from mpma_mj.errors import BadOptionError, WorkerError
from mpma_mj.evaluation.effort import Effort, effort
from mpma_mj.evaluation.evaluate import EvalCondition, evaluate, fine_tune, tracking_errors
from mpma_mj.experiments.backend import Backend, Work, get_done
from mpma_mj.feedback import joint_error
from mpma_mj.kinematics import JOINT_NAMES
from mpma_mj.metrics import phase_lag
from mpma_mj.motions import Motion
from mpma_mj.trace import Trace
from mpma_mj.training.checkpoints import TrainedAgents
from mpma_mj.training.config import RunConfig
from mpma_mj.training.history import epoch_metrics
from mpma_mj.training.trainer import check, train_agents

__all__ = ["ARMS", "NOTHING", "Cell", "CompareJob", "Dance", "compare", "jobs"]

Array = NDArray[np.float64]

_NO_MASS = {name: getattr(EnvironmentOptions(), name) for name in MASS_OPTIONS}

ARMS: dict[str, dict[str, Any]] = {
    "kinematic": {"arms": "kinematic"} | _NO_MASS,
    "physics": {"arms": "physics", "gravity_compensation": False},
    "compensated": {"arms": "physics", "gravity_compensation": True},
}
"""Options of the environments that are compared: ideal arms, arms with mass and weight, and arms
with mass whose weight is carried for them."""

NOTHING = "nothing"
"""On which the feedback controller alone has learned, which is what others are held against."""


@dataclass(frozen=True, eq=False)
class Dance:
    """An episode of one agent, danced without learning.

    Attributes:
        trace: Its signals, as `record_epoch` returns them.
        options: Options of its environment.
        effort: What it cost; None on ideal arms.
        measures: What it amounts to, by name.
    """

    trace: Trace
    options: EnvironmentOptions
    effort: Effort | None
    measures: dict[str, float]


@dataclass(frozen=True, eq=False)
class Cell:
    """Agents that learned on one kind of arms and dance on another.

    Attributes:
        learned: On which they learned, a name of `ARMS`, or `NOTHING`.
        danced: On which they dance.
        seeds: Seed of each of R agents.
        epochs: Number of the best epoch of each, from 1, shape (R,); NaN of who does not learn.
        dances: How each dances at once; None where the simulation diverged.
        adapted: p_e of each after it has learned on, shape (R,), percent; NaN where the simulation
            diverged, and of who does not learn.
    """

    learned: str
    danced: str
    seeds: tuple[int, ...]
    epochs: Array
    dances: tuple[Dance | None, ...]
    adapted: Array

    def values(self, measure: str) -> list[float]:
        """Return a measure of all dances that have it."""
        found = [dance.measures.get(measure, np.nan) for dance in self.dances if dance]
        return [value for value in found if np.isfinite(value)]


@dataclass(frozen=True, eq=False)
class CompareJob(Work):
    """Agents that learn on one kind of arms, and dance on each.

    Attributes:
        learned: On which they learn, a name of `ARMS`, or `NOTHING`.
        configs: Settings of R runs that differ in their seeds only; which arms they say does not
            count.
        motion: The movement.
        epochs: Largest number of epochs of training.
        adaptation: Number of epochs that agents learn on where they are tried.
    """

    learned: str
    configs: tuple[RunConfig, ...]
    motion: Motion
    epochs: int
    adaptation: int

    def do(self) -> list[Cell]:
        """Return a cell for each kind of arms.

        Raises:
            DivergedError: A simulation did not stay finite while an agent was trained.
        """
        trained = self._train()
        conditions = (EvalCondition(name, self.motion, options) for name, options in ARMS.items())
        return [
            _cell(trained, self.learned, condition, self.adaptation) for condition in conditions
        ]

    def _train(self) -> TrainedAgents:
        if self.learned == NOTHING:
            feedback = [config.replace(agent="feedback_only") for config in self.configs]
            return train_agents(feedback, self.motion, 1, {})
        # The configs stay, so that the arms of training are no part of where agents dance.
        return train_agents(self.configs, self.motion, self.epochs, ARMS[self.learned])


def jobs(
    configs: Sequence[RunConfig], motion: Motion, *, epochs: int, adaptation: int
) -> list[CompareJob]:
    """Return the work of a comparison, what takes longest first.

    Args:
        configs: Settings of R runs that differ in their seeds only; which arms they say does not
            count.
        motion: The movement.
        epochs: Largest number of epochs of a training.
        adaptation: Number of epochs that agents learn on where they are tried.

    Raises:
        MpmaError: A setting is outside what it may be, the agent does not learn, or the arms
            cannot follow the movement.
    """
    for name, value in {"epochs": epochs, "adaptation": adaptation}.items():
        if value < 1:
            raise BadOptionError(option=name, value=value, expected="at least 1")
    if configs[0].env.plants is not None:
        problem = "kinds of arms are compared, each without plants"
        raise BadOptionError(problem, remedy="leave {plants} out")
    check_trainable(configs[0].agent_name)
    check(configs[0], motion)
    return [
        CompareJob(learned, tuple(configs), motion, epochs, adaptation)
        for learned in (*ARMS, NOTHING)
    ]


def compare(
    spec: Sequence[CompareJob],
    backend: Backend,
    on_learned: Callable[[str], None] = lambda learned: None,
) -> list[Cell]:
    """Train on each kind of arms, and dance on each.

    Args:
        spec: What `jobs` returned.
        backend: Who works.
        on_learned: Called when all cells of those who learned on some arms are there.

    Returns:
        A cell for each pair of `ARMS`, those that learned on the same arms in a row; before them
        the feedback controller alone on each.

    Raises:
        DivergedError: A simulation did not stay finite while an agent was trained.
        WorkerError: A worker died time and again.
    """
    cells: dict[str, list[Cell]] = {}
    for job, done in get_done(spec, backend):
        if done is None:
            raise WorkerError(
                "a worker died time and again (memory?)",
                remedy="take fewer {runs}, or smaller {nodes}",
            )
        cells[job.learned] = done
        on_learned(job.learned)
    return [cell for learned in (NOTHING, *ARMS) for cell in cells[learned]]


def _cell(trained: TrainedAgents, learned: str, condition: EvalCondition, adaptation: int) -> Cell:
    options = dataclasses.replace(trained.configs[0].env, **condition.options)
    site_positions = PhysicsArms.make(options).site_positions
    dances = tuple(
        None if trace is None else _dance(trace, options, condition.motion.rate, site_positions)
        for trace in evaluate(trained, condition)
    )
    seeds = tuple(trained.seeds)
    if learned == NOTHING:
        nothing = np.full(len(seeds), np.nan)
        return Cell(NOTHING, condition.name, seeds, nothing, dances, nothing)
    later, course = fine_tune(trained, condition, adaptation)
    adapted = np.where(np.isnan(course[-1]), np.nan, tracking_errors(evaluate(later, condition)))
    return Cell(learned, condition.name, seeds, trained.epochs.astype(float), dances, adapted)


def _dance(
    trace: Trace,
    options: EnvironmentOptions,
    rate: float,
    site_positions: Callable[[Array], Array],
) -> Dance:
    cost = effort(trace, options, rate)
    measures = epoch_metrics(site_positions, trace)
    measures["mpkpe_mm"] = 1e3 * measures.pop("mpkpe_m")
    measures["lag_ms"] = 1e3 * phase_lag(trace.posture[1:], trace.reference[1:], 1.0 / rate)
    measures |= _joint_errors(trace)
    if cost is not None:
        measures |= {
            "mean_torque_nm": cost.mean_torque,
            "peak_torque_nm": cost.peak_torque,
            "work_j": cost.work,
        }
    return Dance(trace, options, cost, measures)


def _joint_errors(trace: Trace) -> dict[str, float]:
    """Return the root mean square of each joint's error, deg; see `joint_error`."""
    error = joint_error(trace.joint_angles[1:], trace.reference[1:])
    rms = np.degrees(np.sqrt(np.mean(error**2, axis=0)))
    return {f"rms_{name}_deg": float(x) for name, x in zip(JOINT_NAMES, rms, strict=True)}
