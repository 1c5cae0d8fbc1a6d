"""History of a run's training: the metrics of its epochs, and the best epoch."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpma_mj import metrics
from mpma_mj.agents.gain_schedule import CRITERION, FINAL_FEEDBACK
from mpma_mj.envs.vector_env import VectorImitationEnv
from mpma_mj.errors import StateError
from mpma_mj.trace import Trace
from mpma_mj.training.epoch_rows import EpochMetrics
from mpma_mj.training.factory import Environments

__all__ = [
    "BestEpoch",
    "EpisodeInfo",
    "TrainingHistory",
    "epoch_metrics",
    "has_converged",
    "part_metrics",
]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class EpisodeInfo:
    """Facts about episodes that metrics need.

    Attributes:
        labels: Names of the context's labels.
        period: Steps from one repetition of the motion to the next.
        steps: Steps T of an episode.
        site_positions: Positions of shoulders, elbows and wrists in postures; see
            `PhysicsArms.site_positions`.
    """

    labels: tuple[str, ...]
    period: int
    steps: int
    site_positions: Callable[[Array], Array]

    @classmethod
    def of(cls, env: Environments) -> EpisodeInfo:
        """Return the facts about the episodes of an environment, or of those of a batch."""
        if isinstance(env, VectorImitationEnv):
            return cls(env.motion.labels, env.period, env.steps, env.arms.site_positions)
        task = env.task
        return cls(task.motion.labels, task.period, task.steps, env.physics.site_positions)


@dataclass(frozen=True, eq=False)
class BestEpoch:
    """The best epoch of a run so far.

    Attributes:
        row: Its metrics.
        state: State of the agent before it, arrays by name; empty where states are not kept.
        trace: Its trace.
    """

    row: EpochMetrics
    state: dict[str, Array]
    trace: Trace


class TrainingHistory:
    """The epochs of one run so far.

    Attributes:
        rows: Metrics of all epochs.
    """

    def __init__(self, info: EpisodeInfo) -> None:
        """Begin with no epoch, given facts about the episodes."""
        self.rows: list[EpochMetrics] = []
        self._best: BestEpoch | None = None
        self._info = info

    @property
    def best(self) -> BestEpoch:
        """The best epoch so far.

        Raises:
            StateError: No epoch has been run.
        """
        if self._best is None:
            raise StateError("no epoch has been run yet; run one first")
        return self._best

    @property
    def converged(self) -> bool:
        """Whether the last epoch met the paper's criteria."""
        return bool(self.rows) and has_converged(self.rows[-1])

    def add(
        self, trace: Trace, logged: EpochMetrics, state: dict[str, Array], *, latest: bool = False
    ) -> bool:
        """Add an epoch, and return whether it is the new best.

        Args:
            trace: Its trace.
            logged: What the agent logged when it learned from it.
            state: State of the agent before it, arrays by name; with plants after it.
            latest: Whether it counts as the best, whatever its metrics.
        """
        measures = epoch_metrics(self._info.site_positions, trace)
        row = {"epoch": len(self.rows) + 1} | measures | logged
        self.rows.append(row)
        better = self._best is None or _rank(row) < _rank(self._best.row)
        if not (latest or better):
            return False
        self._best = BestEpoch(row, state, trace)
        return True

    def restore(self, rows: list[EpochMetrics], best: BestEpoch) -> None:
        """Continue from the epochs of a run that was saved."""
        self.rows, self._best = rows, best

    def summary(self) -> dict[str, Any]:
        """Return the result of the training: metrics of the best epoch, and when it stopped."""
        row = self.best.row
        return {
            "epochs": len(self.rows),
            "converged": has_converged(row),
            "best_epoch": row["epoch"],
            **{name: value for name, value in row.items() if name != "epoch"},
            **self._decomposition(self.best.trace),
            "environment_steps": len(self.rows) * self._info.steps,
        }

    def _decomposition(self, trace: Trace) -> dict[str, Any]:
        """Return how modules shared an epoch; nothing for an agent without modules."""
        if trace.modules is None:
            return {}
        responsibility, context = trace.modules.responsibility, trace.context[:-1]
        output = responsibility[:, :, None] * trace.modules.module_actions
        labels, period = self._info.labels, self._info.period
        active = metrics.active_modules(responsibility, context)
        dominant = map(metrics.module_number, metrics.dominant_module(responsibility, context))
        return {
            "active_modules": dict(zip(labels, active, strict=True)),
            "dominant_module": dict(zip(labels, dominant, strict=True)),
            "entropy": {
                "sharing": metrics.sharing_entropy(responsibility),
                "usage": metrics.usage_entropy(responsibility),
            },
            "repeatability": {
                "responsibility": metrics.repeatability(responsibility, period),
                "module_output": metrics.repeatability(output, period),
            },
        }


def epoch_metrics(site_positions: Callable[[Array], Array], trace: Trace) -> EpochMetrics:
    """Return the metrics of an epoch by name; see `mpma_mj.metrics` for their definitions.

    Args:
        site_positions: Positions of the arms' sites in postures; `PhysicsArms.site_positions`.
        trace: Trace of one run; metrics of modules need an agent that has some.
    """
    posture, reference = trace.posture[1:], trace.reference[1:]
    measures = part_metrics(trace, np.ones(len(trace), bool)) | {
        "mpkpe_m": metrics.mpkpe(site_positions(posture), site_positions(reference)),
        "mean_reward": float(np.mean(trace.reward)),
    }
    if trace.modules is not None:
        responsibility, context = trace.modules.responsibility, trace.context[:-1]
        measures["nmi"] = metrics.nmi(responsibility, context)
        measures["modules_used"] = metrics.modules_used(responsibility, context)
    return measures


def part_metrics(trace: Trace, part: NDArray[np.bool_]) -> EpochMetrics:
    """Return those metrics by name that a part of an epoch has, too.

    Args:
        trace: Trace of one run.
        part: Which steps count, shape (T,).
    """
    posture, reference = trace.posture[1:][part], trace.reference[1:][part]
    measures = {"p_e_percent": metrics.posture_error_percent(posture, reference)}
    if trace.modules is not None:
        responsibility = trace.modules.responsibility[part]
        predicted = np.einsum("tm,tmd->td", responsibility, trace.modules.predictions[part])
        prior = trace.modules.prior[part]
        measures |= {
            "prediction_error_percent": metrics.posture_error_percent(predicted, posture),
            "rp_error_percent": metrics.rp_error_percent(prior, responsibility),
        }
    if trace.feedback is not None:
        feedback, action = trace.feedback[part], trace.action[part]
        measures["feedback_ratio"] = metrics.feedback_ratio(feedback, action)
    if trace.learned is not None:
        measures["learned_share"] = metrics.learned_share(trace.learned[part], trace.action[part])
    return measures


def has_converged(row: EpochMetrics) -> bool:
    """Return whether an epoch meets the paper's criteria for the end of training.

    Control has passed (L = 1, K < 0.15; or a learner without gains acts), responsibility predictors
    are within 3 % of the responsibilities, and the trajectory within 3 % of the demonstration.
    Joint models have been calibrated, too.
    """
    if row.get("calibrating", 0.0) or not _control_has_passed(row):
        return False
    # An agent without modules has no responsibility predictors.
    return max(row.get("rp_error_percent", 0.0), row["p_e_percent"]) < CRITERION


def _control_has_passed(row: EpochMetrics) -> bool:
    """Return whether inverse models, or a learner, control; agents that do not learn have none."""
    if "learner_acts" in row:
        return row["learner_acts"] == 1.0
    return row.get("gain_inverse", 0.0) >= 1.0 and row.get("gain_feedback", np.inf) < FINAL_FEEDBACK


def _rank(row: EpochMetrics) -> tuple[bool, bool, float]:
    """Return a key that sorts the best epoch first: good tracking by feedback alone comes last."""
    return (not has_converged(row), not _control_has_passed(row), row["p_e_percent"])
