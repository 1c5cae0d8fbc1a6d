"""Learning a movement, epoch after epoch."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from dm_control.rl import control
from numpy.typing import NDArray

from mpma_mj import metrics
from mpma_mj.agents import Agent
from mpma_mj.agents.gains import CRITERION, FINAL_FEEDBACK
from mpma_mj.training.trace import epoch_metrics, record_epoch

__all__ = ["Kept", "Row", "Trainer", "has_converged"]

Array = NDArray[np.float64]
Row = dict[str, float]


@dataclass(frozen=True, eq=False)
class Kept:
    """The best epoch so far.

    Attributes:
        row: Its measures.
        state: The agent's state with which it was danced.
        trace: Its signals.
    """

    row: Row
    state: dict[str, Array]
    trace: dict[str, Array]


class Trainer:
    """Trains an agent in an environment and keeps the best epoch.

    Attributes:
        env: Environment.
        agent: Agent.
        rows: Measures of all epochs so far.
        kept: The best epoch so far.
    """

    def __init__(self, env: control.Environment, agent: Agent) -> None:
        """Begin with no epoch danced."""
        self.rows: list[Row] = []
        self.kept: Kept | None = None
        self.env = env
        self.agent = agent

    @property
    def converged(self) -> bool:
        """Whether the last epoch met the paper's criteria."""
        return bool(self.rows) and has_converged(self.rows[-1])

    def run_epoch(self) -> bool:
        """Dance an epoch and learn from it.

        Returns:
            Whether it is the new best.
        """
        state = self.agent.state_dict()
        number = len(self.rows)
        trace = record_epoch(self.env, self.agent, number)
        row = {"epoch": number + 1} | epoch_metrics(self.env, trace) | self.agent.learn()
        self.rows.append(row)
        if self.kept is not None and _rank(row) >= _rank(self.kept.row):
            return False
        self.kept = Kept(row, state, trace)
        return True

    def summary(self) -> dict[str, Any]:
        """Return what training came to: the measures of the kept epoch, and when it stopped."""
        assert self.kept is not None, "no epoch has been run"
        row, trace = self.kept.row, self.kept.trace
        responsibility, context = trace["responsibility"], trace["context"][:-1]
        output = responsibility[:, :, None] * trace["module_actions"]
        labels, period = self.env.task.motion.labels, self.env.task.period
        active = metrics.active_modules(responsibility, context)
        dominant = metrics.dominant_module(responsibility, context)
        return {
            "epochs": len(self.rows),
            "converged": self.converged,
            "kept_epoch": row["epoch"],
            **{name: value for name, value in row.items() if name != "epoch"},
            "active_modules": dict(zip(labels, active, strict=True)),
            "dominant_module": dict(zip(labels, dominant, strict=True)),
            "repeatability": {
                "responsibility": metrics.repeatability(responsibility, period),
                "module_output": metrics.repeatability(output, period),
            },
            "environment_steps": len(self.rows) * self.env.task.steps,
        }


def has_converged(row: Row) -> bool:
    """Tell whether an epoch meets the paper's criteria for the end of training.

    Control has passed (L = 1, K < 0.15), responsibility predictors are within 3 % of the
    responsibilities, and the trajectory within 3 % of the demonstration.
    """
    accurate = row["rp_error_percent"] < CRITERION and row["p_e_percent"] < CRITERION
    return _control_has_passed(row) and accurate


def _control_has_passed(row: Row) -> bool:
    return row["gain_inverse"] >= 1.0 and row["gain_feedback"] < FINAL_FEEDBACK


def _rank(row: Row) -> tuple[bool, bool, float]:
    """Order epochs, the best first: feedback alone tracks well too, so it does not count."""
    return (not has_converged(row), not _control_has_passed(row), row["p_e_percent"])
