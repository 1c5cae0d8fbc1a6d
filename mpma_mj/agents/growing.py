"""MPMA that begins with one module and adds others where none predicts well."""

from __future__ import annotations

import copy
import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpma_mj import metrics
from mpma_mj.agents.agent_spec import AgentSpec
from mpma_mj.agents.base import Observation, Seeds
from mpma_mj.agents.gating import prediction_errors
from mpma_mj.agents.learning_rules import Readouts
from mpma_mj.agents.mpma import MPMA, MPMAConfig
from mpma_mj.agents.paired_models import RunIndex
from mpma_mj.agents.recruitment import Recruitment
from mpma_mj.context import active_label
from mpma_mj.errors import BadOptionError
from mpma_mj.esn import FeatureReplay

__all__ = ["GrowingMPMA", "with_added_module", "with_first_modules"]

Array = NDArray[np.float64]

_HELPED = "helped."  # begins the names of what was learned before the last module awoke
_OF_MODULES = (
    *("inverse_features", "forward_features", "predictor_features", "prior"),
    *("responsibility", "module_actions", "predictions"),
)


class GrowingMPMA(MPMA):
    """MPMA that begins with one module, of as many as `modules` at most.

    All modules' reservoirs are there from the beginning; a module that sleeps has p = 0, so that
    λ = 0, and learns nothing. When control has passed to the inverse models `Recruitment` decides
    after each epoch whether one more awakes; how it then learns, see `with_added_module`. In the
    end all is again as it was before a module awoke that did not help. The paper leaves growth to
    future work; how it is done is our choice.
    """

    def __init__(self, config: MPMAConfig, spec: AgentSpec, *, seed: Seeds = 0) -> None:
        """Draw the reservoirs.

        Args:
            config: Settings; `modules` is the largest number.
            spec: Where it acts.
            seed: Seed of weights and noise; several are agents side by side.
        """
        super().__init__(config, spec, seed=seed)
        row = Recruitment().as_row()
        self._growth = np.tile(row, (*self._batch_shape, 1))  # (..., 5)
        self._helped = copy.deepcopy(self._readouts)  # as it was before the last module awoke
        self._helped_sigma = self._sigma.copy()

    @property
    def enabled(self) -> NDArray[np.bool_]:
        """Which modules are enabled and take part, shape (..., M)."""
        return np.arange(self._modules) < self._growth[..., :1]

    def select_runs(self, runs: NDArray[np.intp]) -> None:
        """Go on with some of the agents side by side only, (R',) of R."""
        super().select_runs(runs)
        self._growth = self._growth[runs]
        self._helped_sigma = self._helped_sigma[runs]
        for bank in vars(self._helped).values():
            bank.select_runs(runs)

    def drop_modules(self, modules: Sequence[int]) -> None:
        """Go on without some of the modules; no other awakes in their place (choice).

        Args:
            modules: Their numbers, from 0, shape (K,).

        Raises:
            BadOptionError: There are no others that are enabled.
        """
        stay = np.isin(np.arange(self._modules), modules, invert=True)
        left = (self.enabled & stay).sum(axis=-1)  # (...)
        if not np.all(left):
            raise BadOptionError("all modules that are enabled would be lost; leave one")
        super().drop_modules(modules)
        for bank in vars(self._helped).values():
            bank.drop_modules(modules)
        for run in self._runs:
            growth = Recruitment.of_row(self._growth[run])
            over = growth.over or len(modules) > 0
            changed = dataclasses.replace(growth, modules=int(left[run]), over=over)
            self._growth[run] = changed.as_row()

    def state_dict(self) -> dict[str, Array]:
        """Return all that learning has changed, as arrays by name."""
        state = super().state_dict() | {"growth": self._growth.copy()}
        helped = self._helped.state_dict() | {"sigma": self._helped_sigma}
        return state | {f"{_HELPED}{name}": value.copy() for name, value in helped.items()}

    def load_state_dict(self, state: Mapping[str, Array]) -> None:
        """Continue from what `state_dict` returned."""
        super().load_state_dict(state)
        self._growth[...] = state["growth"]
        names = [name for name in state if name.startswith(_HELPED)]
        helped = {name.removeprefix(_HELPED): state[name] for name in names}
        self._helped_sigma[...] = helped["sigma"]
        self._helped.load_state_dict(helped)

    def _gate(self, observation: Observation) -> dict[str, NDArray[Any]]:
        return super()._gate(observation) | {"context": observation["context"]}

    def _prior(self, said: Array) -> Array:
        return np.where(self.enabled, super()._prior(said), 0.0)

    def _likelihood(self, errors: Array) -> Array:
        return super()._likelihood(np.where(self.enabled, errors, np.inf))

    def _learners(self, run: RunIndex) -> Readouts:
        enabled = Recruitment.of_row(self._growth[run]).modules
        return super()._learners(run).first_modules(enabled)

    def _learn_epoch(self, run: RunIndex, episode: dict[str, Array]) -> dict[str, float]:
        """Let growth follow, and refit the readouts of those that are then enabled, or go back."""
        now = after = Recruitment.of_row(self._growth[run])
        logged = {"modules_enabled": float(now.modules), "growing": float(not now.over)}
        if self._progress[run] >= 1.0:
            after = now.after(_prediction_error(episode), self._modules)
        self._growth[run] = after.as_row()
        if after.modules < now.modules:
            return logged | self._go_back(run)
        if after.modules > now.modules:
            self._helped.of_run(run).take(self._readouts.of_run(run))
            self._helped_sigma[run] = self._sigma[run]
            episode = with_added_module(episode, now.modules)
        return logged | super()._learn_epoch(run, with_first_modules(episode, after.modules))

    def _go_back(self, run: RunIndex) -> dict[str, float]:
        """Have again what was learned before the last module awoke; learn nothing else."""
        sigma = float(self._sigma[run])
        self._readouts.of_run(run).take(self._helped.of_run(run))
        self._sigma[run] = self._helped_sigma[run]
        return {"sigma": sigma}


def with_added_module(episode: dict[str, Array], new: int) -> dict[str, Array]:
    """Give a module half of the responsibility for the label that is predicted worst (choice).

    That is the label with most of the epoch's error Σ_t Σ_i λ^i errⁱ, so that most can be won.
    In place of what the new module has said, which is nothing, stands what all said together.

    Args:
        episode: What happened in an epoch, (T, ...) by name.
        new: Number of the module.

    Returns:
        The same with other signals of that module, and responsibilities that still sum to 1.
    """
    responsibility, context = episode["responsibility"].copy(), episode["context"]
    errors = prediction_errors(episode["predictions"], episode["next_posture"])
    surprise = np.sum(responsibility * errors, axis=1)
    label = active_label(context)
    worst = max(np.unique(label), key=lambda danced: float(surprise[label == danced].sum()))
    responsibility[label == worst] *= 0.5
    responsibility[label == worst, new] = 0.5
    changed = {"responsibility": responsibility}
    for name in ("module_actions", "predictions"):
        changed[name] = episode[name].copy()
        changed[name][:, new] = _mixed(episode, name)
    return episode | changed


def with_first_modules(episode: dict[str, Any], count: int) -> dict[str, Any]:
    """Return an epoch as if there were only the first modules; the others had λ = 0."""
    return episode | {name: _first(episode[name], count) for name in _OF_MODULES}


def _first(signal: NDArray[Any] | FeatureReplay, count: int) -> NDArray[Any] | FeatureReplay:
    """Return the signal of the first modules."""
    return signal.first_modules(count) if isinstance(signal, FeatureReplay) else signal[:, :count]


def _prediction_error(episode: dict[str, Array]) -> float:
    return metrics.posture_error_percent(_mixed(episode, "predictions"), episode["next_posture"])


def _mixed(episode: dict[str, Array], name: str) -> Array:
    """Return what all modules said together, Σ_i λ^i (...)^i, shape (T, ...)."""
    return np.einsum("tm,tmd->td", episode["responsibility"], episode[name])
