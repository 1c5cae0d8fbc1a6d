"""Lesions: errors and responsibilities of a trained agent without some of its modules."""

from __future__ import annotations

import contextlib
import itertools
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpma_mj import metrics
from mpma_mj.agents import HAMMER
from mpma_mj.agents.base import Agent
from mpma_mj.agents.paired_models import PairedModels
from mpma_mj.agents.wrappers import paired_models_of
from mpma_mj.context import active_label
from mpma_mj.envs.vector_env import VectorImitationEnv
from mpma_mj.errors import BadOptionError, DivergedError
from mpma_mj.evaluation.evaluate import EvalCondition, evaluate, fine_tune
from mpma_mj.trace import Trace
from mpma_mj.training.checkpoints import TrainedAgents
from mpma_mj.training.factory import make_environments

__all__ = ["Dropped", "LabelMeasures", "Lesion", "Lesions", "apply_lesion", "possible_lesions"]

Array = NDArray[np.float64]
Dropped = tuple[int, ...]
"""Indices of the modules that are switched off."""

_AT_ONCE = 2  # modules that are switched off together, at most


@dataclass(frozen=True, eq=False)
class LabelMeasures:
    """Measures of an episode, by label.

    Attributes:
        p_e_percent: p_e, percent.
        label_p_e_percent: p_e of the steps that lead to postures of each label, shape (C,),
            percent; NaN of one that does not occur.
        responsibility: Mean responsibility of each module while a label is active, shape (C, M);
            0 for dropped modules, NaN for a label that does not occur.
        dominant: Module that most often has the largest responsibility, shape (C,); -1 of a
            label that does not occur.
    """

    p_e_percent: float
    label_p_e_percent: Array
    responsibility: Array
    dominant: NDArray[np.int_]


@dataclass(frozen=True, eq=False)
class Lesion:
    """An agent without some modules.

    Attributes:
        dropped: The modules that are switched off; none of the intact agent.
        at_once: Measures without learning.
        fine_tuned: Measures after fine-tuning; None where there was none.
    """

    dropped: Dropped
    at_once: LabelMeasures
    fine_tuned: LabelMeasures | None


@dataclass(frozen=True, eq=False)
class Lesions:
    """All lesions of an agent.

    Attributes:
        labels: Names of the labels.
        lesions: The lesions; the first is the intact agent, the last has no module.
        epochs: Epochs of fine-tuning.
    """

    labels: tuple[str, ...]
    lesions: tuple[Lesion, ...]
    epochs: int

    @property
    def intact(self) -> Lesion:
        """The agent with all modules."""
        return self.lesions[0]

    @property
    def silent(self) -> Lesion:
        """The agent without modules."""
        return self.lesions[-1]

    @property
    def partial(self) -> tuple[Lesion, ...]:
        """The lesions of some modules, but not all."""
        return self.lesions[1:-1]

    @property
    def fine_tuned(self) -> bool:
        """Whether the agent was fine-tuned."""
        return self.intact.fine_tuned is not None

    @property
    def modules(self) -> int:
        """Largest number of modules; fine-tuning may recruit those of a plant."""
        found = [m for one in self.lesions for m in (one.at_once, one.fine_tuned) if m]
        return max(one.responsibility.shape[1] for one in found)

    def owned(self, dropped: Dropped) -> NDArray[np.bool_]:
        """Return which labels have one of some modules as dominant, if intact, shape (C,)."""
        return np.isin(self.intact.at_once.dominant, dropped)

    def as_json(self) -> dict[str, Any]:
        """Return what JSON can hold."""
        owners = map(metrics.module_number, self.intact.at_once.dominant.tolist())
        return {
            "fine_tune_epochs": self.epochs if self.fine_tuned else 0,
            "dominant_module": dict(zip(self.labels, owners, strict=True)),
            "lesions": [
                {
                    "dropped": [metrics.module_number(module) for module in one.dropped],
                    "at_once": self._measures(one.at_once),
                    "fine_tuned": one.fine_tuned and self._measures(one.fine_tuned),
                }
                for one in self.lesions
            ],
        }

    def _measures(self, measures: LabelMeasures) -> dict[str, Any]:
        labels = {
            label: {
                "p_e_percent": measures.label_p_e_percent[number],
                "responsibility": measures.responsibility[number],
                "dominant_module": metrics.module_number(int(measures.dominant[number])),
            }
            for number, label in enumerate(self.labels)
        }
        return {"p_e_percent": measures.p_e_percent, "labels": labels}


def possible_lesions(trained: TrainedAgents) -> list[Dropped]:
    """Return no module, each module, each pair that leaves another one, and all modules.

    Args:
        trained: One agent.

    Raises:
        BadOptionError: The agent has no modules, or a single one.
        CheckpointError: The agent's state does not fit its config.
    """
    modules = range(len(_pairs(trained).enabled_modules))
    if len(modules) == 1:
        raise BadOptionError(
            f"{trained.source or 'trained agent'}: has only one module, so that no other could"
            " take over",
            remedy="choose a run with {modules=2} or more",
        )
    sizes = range(1 + min(_AT_ONCE, len(modules) - 1))
    some = [dropped for size in sizes for dropped in itertools.combinations(modules, size)]
    return [*some, tuple(modules)]


def apply_lesion(trained: TrainedAgents, dropped: Dropped, epochs: int) -> Lesion:
    """Switch modules off, and measure an episode at once and after fine-tuning.

    Both times it is the same episode, which no training contains, without learning. An agent
    without modules is not fine-tuned, since only its feedback controller is left, nor HAMMER once
    it has been prepared.

    Args:
        trained: One agent.
        dropped: The modules.
        epochs: Number of epochs of fine-tuning; 0 for none.

    Raises:
        DivergedError: The simulation did not stay finite.
    """
    pairs = _pairs(trained)
    agent: TrainedAgents = _Lesioned(**vars(trained), dropped=dropped)
    condition = EvalCondition("home", trained.motion, {})
    at_once = _measure(_evaluated(agent, condition, dropped))
    silent = len(dropped) == len(pairs.enabled_modules)
    prepared = isinstance(pairs, HAMMER) and not pairs.is_preparing
    if silent or prepared or epochs == 0:
        return Lesion(dropped, at_once, None)
    agent, course = fine_tune(agent, condition, epochs)
    if np.isnan(course).any():
        raise _diverged(dropped)
    return Lesion(dropped, at_once, _measure(_evaluated(agent, condition, dropped)))


@dataclass(frozen=True, eq=False, kw_only=True)
class _Lesioned(TrainedAgents):
    """An agent of which some modules are switched off.

    Attributes:
        dropped: The modules.
    """

    dropped: Dropped

    def agent(self, envs: VectorImitationEnv) -> Agent:
        """Return the agent in its state, without the modules."""
        agent = super().agent(envs)
        pairs = paired_models_of(agent)
        enabled = pairs.enabled_modules
        enabled[[*self.dropped]] = False
        pairs.set_enabled_modules(enabled)
        return agent


def _pairs(trained: TrainedAgents) -> PairedModels:
    """Return the agent itself, where no condition is needed."""
    envs = make_environments(trained.configs[0], trained.seeds, trained.motion)
    with contextlib.closing(envs):
        return paired_models_of(trained.agent(envs))


def _evaluated(agent: TrainedAgents, condition: EvalCondition, dropped: Dropped) -> Trace:
    (trace,) = evaluate(agent, condition)
    if trace is None:
        raise _diverged(dropped)
    return trace


def _diverged(dropped: Dropped) -> DivergedError:
    missing = " and ".join(f"module {i + 1}" for i in dropped) or "any lesion"
    return DivergedError(
        f"without {missing}: the simulation diverged",
        remedy="train again with a lower {tempo} or another {seed}",
    )


def _measure(trace: Trace) -> LabelMeasures:
    """Return the measures of an episode."""
    posture, reference = trace.posture[1:], trace.reference[1:]
    context, responsibility = trace.context, trace.with_modules().responsibility
    reached, active = active_label(context[1:]), active_label(context[:-1])
    labels = range(context.shape[1])
    return LabelMeasures(
        p_e_percent=metrics.posture_error_percent(posture, reference),
        label_p_e_percent=np.array(
            [_error(posture[reached == c], reference[reached == c]) for c in labels]
        ),
        responsibility=np.array([_mean(responsibility[active == c]) for c in labels]),
        dominant=np.array(metrics.dominant_module(responsibility, context[:-1])),
    )


def _error(posture: Array, reference: Array) -> float:
    return metrics.posture_error_percent(posture, reference) if len(posture) else np.nan


def _mean(rows: Array) -> Array:
    return rows.mean(axis=0) if len(rows) else np.full(rows.shape[1], np.nan)
