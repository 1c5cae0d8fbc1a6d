"""MPMA that begins with one module and recruits others where none predicts well."""

from __future__ import annotations

import copy
import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import astuple, dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from mpma_mj import metrics
from mpma_mj.agents.base import AgentSpec, Seeds
from mpma_mj.agents.config import AgentConfig, GrowingConfig
from mpma_mj.agents.gating import ResponsibilityGate, prediction_errors
from mpma_mj.agents.learning_rules import Epoch
from mpma_mj.agents.mpma import MPMA
from mpma_mj.agents.networks import RunIndex
from mpma_mj.context import active_label
from mpma_mj.errors import BadOptionError

__all__ = ["EPOCHS", "LEAST_GAIN", "GrowingMPMA", "Recruitment", "with_added_module"]

Array = NDArray[np.float64]

EPOCHS = 4
"""Epochs with each number of modules; the first does not count, the last module is new in it
(choice)."""

LEAST_GAIN = 0.03
"""Share by which one more module has to reduce the prediction error to have helped (choice)."""

_HELPED = "helped."  # begins the names of what was learned before the last recruitment


@dataclass(frozen=True)
class Recruitment:
    """State of recruitment.

    Every number of modules is tried for `EPOCHS` epochs. A module has helped if the mean
    prediction error is then `LEAST_GAIN` lower than without it. The first that has not is removed
    again, and recruitment is over, as it is at the largest number.

    Attributes:
        modules: Number of enabled modules.
        epochs: Epochs with this number.
        error: Sum of the prediction errors that count, percent.
        best_error: Mean prediction error with one module less, percent.
        over: Whether recruitment is over.
    """

    modules: int = 1
    epochs: int = 0
    error: float = 0.0
    best_error: float = math.inf
    over: bool = False

    def after(self, error: float, most: int) -> Recruitment:
        """Return the state after an epoch.

        Args:
            error: Prediction error of the epoch, percent.
            most: Largest number of modules.
        """
        if self.over:
            return self
        counted = self.error + (error if self.epochs else 0.0)
        tried = replace(self, epochs=self.epochs + 1, error=counted)
        return tried if tried.epochs < EPOCHS else tried._next(most)

    def _next(self, most: int) -> Recruitment:
        mean = self.error / (EPOCHS - 1)
        if mean >= (1.0 - LEAST_GAIN) * self.best_error:
            return Recruitment(self.modules - 1, best_error=self.best_error, over=True)
        if self.modules == most:
            return Recruitment(self.modules, best_error=mean, over=True)
        return Recruitment(self.modules + 1, best_error=mean)

    def as_row(self) -> Array:
        """Return the state as an array, shape (5,)."""
        return np.array(astuple(self), np.float64)

    @classmethod
    def of_row(cls, row: Array) -> Recruitment:
        """Return the state of an array that `as_row` returned."""
        modules, epochs, error, best_error, over = row.tolist()
        return cls(int(modules), int(epochs), error, best_error, bool(over))


class _RecruitingGate(ResponsibilityGate):
    """Responsibility of enabled modules; the others have p = 0, so that λ = 0."""

    enabled: NDArray[np.bool_]  # (..., M)

    def _prior(self, outputs: Array) -> Array:
        return np.where(self.enabled, super()._prior(outputs), 0.0)

    def _likelihood(self, errors: Array) -> Array:
        return super()._likelihood(np.where(self.enabled, errors, np.inf))


class GrowingMPMA(MPMA):
    """MPMA that begins with one module, of as many as `modules` at most.

    All modules' reservoirs are drawn at the beginning; those that are not enabled learn nothing.
    When control has passed to the inverse models, `Recruitment` decides after each epoch whether
    one more is enabled; see `with_added_module` for its first targets. A module that did not
    help is undone: state and σ are those from before its recruitment. The paper leaves growth to
    future work; all of it is our choice.
    """

    config_type: ClassVar[type[AgentConfig]] = GrowingConfig
    _gate: _RecruitingGate

    def __init__(self, config: GrowingConfig, spec: AgentSpec, *, seed: Seeds = 0) -> None:
        """Draw the reservoirs; arguments as of `Agent`.

        Raises:
            BadOptionError: The rule cannot be imported, or learns at every step.
        """
        super().__init__(config, spec, seed=seed, gate_type=_RecruitingGate)
        if self._rule.online:
            expected = "a rule that learns after an epoch, since modules are recruited then"
            raise BadOptionError(option="rule", value=config.rule, expected=expected)
        self._growth = np.tile(Recruitment().as_row(), (*self._batch_shape, 1))  # (..., 5)
        self._helped = copy.deepcopy(self._readouts)  # before the last recruitment
        self._helped_sigma = self._gate.sigma.copy()
        self._gate.enabled = self.enabled

    @property
    def enabled(self) -> NDArray[np.bool_]:
        """Which modules are enabled, shape (..., M)."""
        return np.arange(self._modules) < self._growth[..., :1]

    def learn(self) -> dict[str, Array]:
        """Let every run learn; log also the number of enabled modules and whether it may grow."""
        logged = {
            "modules_enabled": self._growth[..., 0].copy(),
            "growing": 1.0 - self._growth[..., 4],
        }
        logged = super().learn() | logged
        self._gate.enabled = self.enabled
        return logged

    def select_runs(self, runs: NDArray[np.intp]) -> None:
        """Continue with some runs only, (R',) of R, from the next reset."""
        super().select_runs(runs)
        self._growth = self._growth[runs]
        self._helped_sigma = self._helped_sigma[runs]
        self._helped.select_runs(runs)
        self._gate.enabled = self.enabled

    def drop_modules(self, modules: Sequence[int]) -> None:
        """Continue without some modules; no other is recruited in their place (choice).

        Args:
            modules: Their indices, shape (K,).

        Raises:
            BadOptionError: There are no such modules, or no others that are enabled.
        """
        stay = np.isin(np.arange(self._modules), modules, invert=True)
        left = (self.enabled & stay).sum(axis=-1)  # (...)
        if not np.all(left):
            expected = "at least one enabled module to be left"
            raise BadOptionError(option="modules", value=[*modules], expected=expected)
        super().drop_modules(modules)
        self._helped.drop_modules(modules)
        for run in np.ndindex(self._batch_shape):
            growth = Recruitment.of_row(self._growth[run])
            over = growth.over or len(modules) > 0
            self._growth[run] = replace(growth, modules=int(left[run]), over=over).as_row()
        self._gate.enabled = self.enabled

    def state_dict(self) -> dict[str, Array]:
        """Return copies of all arrays that learning changes, by name."""
        state = super().state_dict() | {"growth": self._growth.copy()}
        helped = self._helped.state_dict() | {"sigma": self._helped_sigma.copy()}
        return state | {f"{_HELPED}{name}": value for name, value in helped.items()}

    def load_state_dict(self, state: Mapping[str, Array]) -> None:
        """Continue from the arrays that `state_dict` returned; see `PairedModels`."""
        super().load_state_dict(state)
        self._growth[...] = state["growth"]
        names = [name for name in state if name.startswith(_HELPED)]
        helped = {name.removeprefix(_HELPED): state[name] for name in names}
        self._helped_sigma[...] = helped["sigma"]
        self._helped.load_state_dict(helped)
        self._gate.enabled = self.enabled

    def _learn_epoch(self, run: RunIndex, epoch: Epoch) -> None:
        """Recruit, and let the enabled modules of one run learn, or undo the last recruitment."""
        now = after = Recruitment.of_row(self._growth[run])
        if self._progress[run] >= 1.0:
            predicted = epoch.mixed(epoch.predictions)
            error = metrics.posture_error_percent(predicted, epoch.next_posture)
            after = now.after(error, self._modules)
        self._growth[run] = after.as_row()
        readouts = self._readouts.of_run(run)
        if after.modules < now.modules:
            readouts.copy_from(self._helped.of_run(run))
            self._gate.sigma[run] = self._helped_sigma[run]
            return
        if after.modules > now.modules:
            self._helped.of_run(run).copy_from(readouts)
            self._helped_sigma[run] = self._gate.sigma[run]
            epoch = with_added_module(epoch, now.modules)
        epoch = epoch.first_modules(after.modules)
        self._rule.fit(readouts.first_modules(after.modules), epoch)
        self._gate.adapt(run, epoch, self._rule)


def with_added_module(epoch: Epoch, new: int) -> Epoch:
    """Return an epoch in which a module has half of the worst predicted label (choice).

    That is the label with most of the epoch's error Σ_t Σ_i λ^i errⁱ, where most can be gained.
    The outputs of the new module, which has learned nothing, are replaced by those of all
    modules together.

    Args:
        epoch: An epoch.
        new: Index of the module.

    Returns:
        The same with other signals of that module, and responsibilities that still sum to 1.
    """
    errors = prediction_errors(epoch.predictions, epoch.next_posture)
    error = np.sum(epoch.responsibility * errors, axis=1)
    label = active_label(epoch.context)
    worst = max(np.unique(label), key=lambda one: float(error[label == one].sum()))
    responsibility = epoch.responsibility.copy()
    responsibility[label == worst] *= 0.5
    responsibility[label == worst, new] = 0.5
    module_actions, predictions = epoch.module_actions.copy(), epoch.predictions.copy()
    module_actions[:, new] = epoch.mixed(epoch.module_actions)
    predictions[:, new] = epoch.mixed(epoch.predictions)
    return dataclasses.replace(
        epoch,
        responsibility=responsibility,
        module_actions=module_actions,
        predictions=predictions,
    )
