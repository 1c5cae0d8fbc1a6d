"""Pairs with responsibility predictors: how MPMA and MOSAIC decide who controls."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents import gating
from mpma_mj.agents.agent_spec import AgentSpec
from mpma_mj.agents.base import Observation, Seeds
from mpma_mj.agents.config import NetworkConfig
from mpma_mj.agents.learning_rules import Readouts
from mpma_mj.agents.paired_models import PairedModels
from mpma_mj.utils.clipping import clip
from mpma_mj.utils.seeding import stream

__all__ = ["GatedModels"]

Array = NDArray[np.float64]

_LEAST_PRIOR = 0.01  # p_min: no module is shut out for ever (choice)


class GatedModels(PairedModels):
    """Pairs that share control by what was heard and by what they predicted.

    The forward models' last predictions are held against the posture that came (likelihood ℓ),
    the context y says beforehand who should be suited (prior p); both give the responsibilities:

        p^i = clip(RP_i(y), p_min, 1)           λ^i = p^i ℓ^i / Σ_j p^j ℓ^j

    Wolpert & Kawato 1998; Haruno, Wolpert & Kawato 2001.
    """

    _readouts: Readouts

    def __init__(
        self,
        config: NetworkConfig,
        spec: AgentSpec,
        *,
        sigma: float,
        seed: Seeds = 0,
        forgetting: float = 0.0,
    ) -> None:
        """Draw the reservoirs.

        Args:
            config: Settings of the networks.
            spec: Where it acts.
            sigma: Width σ of the likelihood in the first epoch.
            seed: Seed of weights and noise; several are agents side by side.
            forgetting: Forgetting φ of the readouts, where they are fitted.
        """
        super().__init__(config, spec, seed=seed, forgetting=forgetting)
        self._sigma = np.full(self._batch_shape, sigma)
        self._predictor = self._reservoirs("predictor", spec.context_size)
        # Random preferences for contexts, so that modules differ from the first step (choice).
        preference = self._zeros(1, self._predictor.features)
        for own, run in zip(self._seeds, self._runs, strict=True):
            preference[(*run, ..., 0, slice(config.nodes, None))] = stream(
                own, "preference"
            ).random((config.modules, spec.context_size))
        self._readouts = Readouts(
            inverse=self._readouts.inverse,
            forward=self._readouts.forward,
            predictor=self._readout(preference),
        )
        self.reset(0)

    def select_runs(self, runs: NDArray[np.intp]) -> None:
        """Go on with some of the agents side by side only, (R',) of R."""
        super().select_runs(runs)
        self._sigma = self._sigma[runs]

    def state_dict(self) -> dict[str, Array]:
        """Return all that learning has changed, as arrays by name."""
        return super().state_dict() | {"sigma": self._sigma.copy()}

    def load_state_dict(self, state: Mapping[str, Array]) -> None:
        """Continue from what `state_dict` returned."""
        super().load_state_dict(state)
        self._sigma[...] = state["sigma"]

    def _gate(self, observation: Observation) -> dict[str, NDArray[Any]]:
        features = self._step("predictor", observation["context"])
        prior = self._prior(self._readouts.predictor(features)[..., 0])
        likelihood = np.ones_like(prior)
        if len(self._steps):
            predictions = self._steps.last("predictions")
            errors = gating.prediction_errors(predictions, observation["posture"])
            likelihood = self._likelihood(errors)
        responsibility = gating.responsibilities(prior, likelihood)
        return {"predictor_features": features, "prior": prior, "responsibility": responsibility}

    def _prior(self, said: Array) -> Array:
        """Return the priors p, (..., M), of what the responsibility predictors said."""
        return clip(said, _LEAST_PRIOR, 1.0)

    def _likelihood(self, errors: Array) -> Array:
        """Return the likelihoods ℓ, (..., M), of the forward models' errors."""
        return gating.likelihood(errors, self._sigma)
