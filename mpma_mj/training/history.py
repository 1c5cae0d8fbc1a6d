"""How a run's training goes: the measures of its epochs, and the best one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from dm_control.rl import control
from numpy.typing import NDArray

from mpma_mj import metrics
from mpma_mj.agents.gain_schedule import CRITERION, FINAL_FEEDBACK
from mpma_mj.envs.vector_env import VectorImitationEnv
from mpma_mj.training.trace import epoch_metrics

__all__ = ["BestEpoch", "EpisodeInfo", "EpochMetrics", "TrainingHistory", "has_converged"]

Array = NDArray[np.float64]
EpochMetrics = dict[str, float]


@dataclass(frozen=True, eq=False)
class EpisodeInfo:
    """What measures have to know of where epochs are danced.

    Attributes:
        labels: Names of the context's labels.
        period: Steps from one repetition to the next.
        steps: Steps of an epoch.
        site_positions: Where shoulders, elbows and wrists are in postures; see `PhysicsArms`.
    """

    labels: tuple[str, ...]
    period: int
    steps: int
    site_positions: Callable[[Array], Array]

    @classmethod
    def of(cls, env: control.Environment | VectorImitationEnv) -> EpisodeInfo:
        """Return the info of one environment, or of many."""
        if isinstance(env, VectorImitationEnv):
            return cls(env.motion.labels, env.period, env.steps, env.arms.site_positions)
        task = env.task
        return cls(task.motion.labels, task.period, task.steps, env.physics.site_positions)


@dataclass(frozen=True, eq=False)
class BestEpoch:
    """The best epoch so far.

    Attributes:
        row: Its measures.
        state: The agent's state with which it was danced; empty where none was asked for.
        trace: Its signals.
    """

    row: EpochMetrics
    state: dict[str, Array]
    trace: dict[str, Array]


class TrainingHistory:
    """The epochs of one run so far.

    Attributes:
        rows: Measures of all epochs so far.
        kept: The best epoch so far.
    """

    def __init__(self, info: EpisodeInfo) -> None:
        """Begin with no epoch danced."""
        self.rows: list[EpochMetrics] = []
        self.best: BestEpoch | None = None
        self._info = info

    @property
    def converged(self) -> bool:
        """Whether the last epoch met the paper's criteria."""
        return bool(self.rows) and has_converged(self.rows[-1])

    def enter(
        self, trace: dict[str, Array], logged: dict[str, float], state: dict[str, Array]
    ) -> bool:
        """Take in an epoch.

        Args:
            trace: Its signals.
            logged: What the agent logged when it learned from it.
            state: The agent's state before it.

        Returns:
            Whether it is the new best.
        """
        measures = epoch_metrics(self._info.site_positions, trace)
        row = {"epoch": len(self.rows) + 1} | measures | logged
        self.rows.append(row)
        if self.best is not None and _rank(row) >= _rank(self.best.row):
            return False
        self.best = BestEpoch(row, state, trace)
        return True

    def summary(self) -> dict[str, Any]:
        """Return what training came to: the measures of the kept epoch, and when it stopped."""
        assert self.best is not None, "no epoch has been run"
        return {
            "epochs": len(self.rows),
            "converged": has_converged(self.best.row),
            "best_epoch": self.best.row["epoch"],
            **{name: value for name, value in self.best.row.items() if name != "epoch"},
            **self._decomposition(self.best.trace),
            "environment_steps": len(self.rows) * self._info.steps,
        }

    def _decomposition(self, trace: dict[str, Array]) -> dict[str, Any]:
        """Return how modules shared an epoch; nothing for an agent without modules."""
        if "responsibility" not in trace:
            return {}
        responsibility, context = trace["responsibility"], trace["context"][:-1]
        output = responsibility[:, :, None] * trace["module_actions"]
        labels, period = self._info.labels, self._info.period
        active = metrics.active_modules(responsibility, context)
        dominant = metrics.dominant_module(responsibility, context)
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


def has_converged(row: EpochMetrics) -> bool:
    """Tell whether an epoch meets the paper's criteria for the end of training.

    Control has passed (L = 1, K < 0.15), responsibility predictors are within 3 % of the
    responsibilities, and the trajectory within 3 % of the demonstration. An agent that grows has
    a number of modules that it stays with.
    """
    if row.get("growing", 0.0) or not _control_has_passed(row):
        return False
    return row["rp_error_percent"] < CRITERION and row["p_e_percent"] < CRITERION


def _control_has_passed(row: EpochMetrics) -> bool:
    """Tell whether inverse models lead; agents that do not learn have none."""
    return row.get("gain_inverse", 0.0) >= 1.0 and row["gain_feedback"] < FINAL_FEEDBACK


def _rank(row: EpochMetrics) -> tuple[bool, bool, float]:
    """Order epochs, the best first: feedback alone tracks well too, so it does not count."""
    return (not has_converged(row), not _control_has_passed(row), row["p_e_percent"])
