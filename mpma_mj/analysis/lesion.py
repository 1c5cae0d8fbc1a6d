"""Trained agents from which modules are taken away: what breaks, and who takes over."""

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

__all__ = ["Dance", "Lesion", "Lesions", "Lost", "dance_without", "what_can_be_lost"]

Array = NDArray[np.float64]
Lost = tuple[int, ...]  # numbers of modules, from 0

_TOGETHER = 2  # modules that are switched off at once, at most


@dataclass(frozen=True, eq=False)
class Dance:
    """An episode of C labels danced by some of M modules.

    Attributes:
        p_e_percent: p_e, percent.
        label_p_e_percent: p_e of the steps that lead to postures of each label, shape (C,),
            percent; NaN of one that is not danced.
        responsibility: Mean responsibility of each module while a label is active, shape (C, M);
            0 for removed modules, NaN for a label that does not occur.
        dominant: Module that most often has the largest responsibility, shape (C,); -1 of a
            label that is not danced.
    """

    p_e_percent: float
    label_p_e_percent: Array
    responsibility: Array
    dominant: NDArray[np.int_]


@dataclass(frozen=True, eq=False)
class Lesion:
    """What became of an agent without some modules.

    Attributes:
        lost: Which are switched off; none of the intact agent.
        at_once: How it danced then.
        retrained: How it danced after it had learned on; None where it did not.
    """

    lost: Lost
    at_once: Dance
    retrained: Dance | None


@dataclass(frozen=True, eq=False)
class Lesions:
    """What became of an agent without each module and each two.

    Attributes:
        labels: Names of the labels.
        lesions: All of them; the first is of the intact agent, in the last all are silent.
        epochs: Epochs of learning before they danced again.
    """

    labels: tuple[str, ...]
    lesions: tuple[Lesion, ...]
    epochs: int

    @property
    def intact(self) -> Lesion:
        """The agent that has lost nothing."""
        return self.lesions[0]

    @property
    def silent(self) -> Lesion:
        """The agent whose modules are all silent."""
        return self.lesions[-1]

    @property
    def some(self) -> tuple[Lesion, ...]:
        """Those without some modules, but not all."""
        return self.lesions[1:-1]

    @property
    def retrained(self) -> bool:
        """Whether the agent learned on."""
        return self.intact.retrained is not None

    @property
    def modules(self) -> int:
        """Largest number of modules; an agent that learns on may recruit a plant."""
        dances = [d for lesion in self.lesions for d in (lesion.at_once, lesion.retrained) if d]
        return max(dance.responsibility.shape[1] for dance in dances)

    def owned(self, lost: Lost) -> NDArray[np.bool_]:
        """Return which labels are those of some modules, dominant in them before, shape (C,)."""
        return np.isin(self.intact.at_once.dominant, lost)

    def as_json(self) -> dict[str, Any]:
        """Return it as JSON can hold it."""
        owners = map(metrics.module_number, self.intact.at_once.dominant.tolist())
        return {
            "retrain_epochs": self.epochs if self.retrained else 0,
            "dominant_module": dict(zip(self.labels, owners, strict=True)),
            "lesions": [
                {
                    "lost": [metrics.module_number(module) for module in lesion.lost],
                    "at_once": self._danced(lesion.at_once),
                    "retrained": lesion.retrained and self._danced(lesion.retrained),
                }
                for lesion in self.lesions
            ],
        }

    def _danced(self, dance: Dance) -> dict[str, Any]:
        by_label = {
            "p_e_percent": dance.label_p_e_percent.tolist(),
            "responsibility": dance.responsibility.tolist(),
            "dominant_module": [metrics.module_number(m) for m in dance.dominant.tolist()],
        }
        return {
            "p_e_percent": dance.p_e_percent,
            "labels": {
                label: {name: values[number] for name, values in by_label.items()}
                for number, label in enumerate(self.labels)
            },
        }


def what_can_be_lost(trained: TrainedAgents) -> list[Lost]:
    """Return nothing, each module, each two modules that leave another one, and all.

    Args:
        trained: One agent.

    Raises:
        BadOptionError: The agent has no modules, or a single one.
        CheckpointError: What it has learned does not fit its settings.
    """
    modules = range(len(_pairs(trained).enabled_modules))
    if len(modules) == 1:
        raise BadOptionError(
            f"{trained.source or 'trained agent'}: has one module, and none that could take over",
            remedy="expected a run of {modules=2} or more",
        )
    sizes = range(1 + min(_TOGETHER, len(modules) - 1))
    some = [lost for size in sizes for lost in itertools.combinations(modules, size)]
    return [*some, tuple(modules)]


def dance_without(trained: TrainedAgents, lost: Lost, retrain: int) -> Lesion:
    """Switch modules off, and let the agent dance at once and after it has learned on.

    Both times it is the same episode, one that no training sees, and nothing is learned from it.
    HAMMER that has been prepared learns no more, nor does an agent of which all modules are lost:
    it has only its feedback controller, with the gain K that it has.

    Args:
        trained: One agent.
        lost: Which modules.
        retrain: Number of epochs of learning; at 0 it does not learn.

    Raises:
        DivergedError: The simulation did not stay finite.
    """
    pairs = _pairs(trained)
    agent: TrainedAgents = _Lesioned(**vars(trained), lost=lost)
    condition = EvalCondition("home", trained.motion, {})
    at_once = _measure(_danced(agent, condition, lost))
    silent = len(lost) == len(pairs.enabled_modules)
    prepared = isinstance(pairs, HAMMER) and not pairs.is_preparing
    if silent or prepared or retrain == 0:
        return Lesion(lost, at_once, None)
    agent, course = fine_tune(agent, condition, retrain)
    if np.isnan(course).any():
        raise _diverged(lost)
    return Lesion(lost, at_once, _measure(_danced(agent, condition, lost)))


@dataclass(frozen=True, eq=False, kw_only=True)
class _Lesioned(TrainedAgents):
    """An agent of which some modules are switched off.

    Attributes:
        lost: Which.
    """

    lost: Lost

    def agent(self, envs: VectorImitationEnv) -> Agent:
        """Return the agent, with what it has learned since."""
        agent = super().agent(envs)
        pairs = paired_models_of(agent)
        enabled = pairs.enabled_modules
        enabled[[*self.lost]] = False
        pairs.set_enabled_modules(enabled)
        return agent


def _pairs(trained: TrainedAgents) -> PairedModels:
    """Return the agent itself, where no condition is needed."""
    envs = make_environments(trained.configs[0], trained.seeds, trained.motion)
    with contextlib.closing(envs):
        return paired_models_of(trained.agent(envs))


def _danced(agent: TrainedAgents, condition: EvalCondition, lost: Lost) -> Trace:
    (trace,) = evaluate(agent, condition)
    if trace is None:
        raise _diverged(lost)
    return trace


def _diverged(lost: Lost) -> DivergedError:
    missing = " and ".join(f"module {i + 1}" for i in lost) or "any loss"
    return DivergedError(
        f"without {missing}: the simulation diverged",
        remedy="train anew with a slower {tempo} or another {seed}",
    )


def _measure(trace: Trace) -> Dance:
    """Return the measures of an episode."""
    posture, reference = trace.posture[1:], trace.reference[1:]
    context, responsibility = trace.context, trace.with_modules().responsibility
    reached, active = active_label(context[1:]), active_label(context[:-1])
    labels = range(context.shape[1])
    return Dance(
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
