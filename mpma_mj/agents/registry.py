"""All agents by name."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

from mpma_mj.agents.agent_spec import AgentSpec
from mpma_mj.agents.base import Agent, Seeds
from mpma_mj.agents.feedback_only import FeedbackOnly
from mpma_mj.agents.growing import GrowingMPMA
from mpma_mj.agents.hammer import HAMMER
from mpma_mj.agents.mosaic import MOSAIC
from mpma_mj.agents.mpma import MPMA, MPMAConfig
from mpma_mj.agents.open_loop import OpenLoop
from mpma_mj.agents.random import RandomAgent

__all__ = ["AGENTS", "IRRELEVANT_OPTIONS", "NOT_TRAINABLE", "NO_FINE_TUNING"]


def _mpma(config: MPMAConfig, spec: AgentSpec, seed: Seeds) -> MPMA:
    return MPMA(config, spec, seed=seed)


def _growing(config: MPMAConfig, spec: AgentSpec, seed: Seeds) -> GrowingMPMA:
    return GrowingMPMA(config, spec, seed=seed)


def _mosaic(config: MPMAConfig, spec: AgentSpec, seed: Seeds) -> MOSAIC:
    return MOSAIC(config, spec, seed=seed)


def _hammer(config: MPMAConfig, spec: AgentSpec, seed: Seeds) -> HAMMER:
    """Return as many pairs as there are labels, whatever `modules` says."""
    labelled = dataclasses.replace(config, modules=spec.context_size)
    return HAMMER(labelled, spec, seed=seed)


def _single(config: MPMAConfig, spec: AgentSpec, seed: Seeds) -> MPMA:
    """Return one pair, which is MPMA of one module."""
    return _mpma(dataclasses.replace(config, modules=1), spec, seed)


AGENTS: dict[str, Callable[[MPMAConfig, AgentSpec, Seeds], Agent]] = {
    "mpma": _mpma,
    "growing": _growing,
    "mosaic": _mosaic,
    "hammer": _hammer,
    "single": _single,
    "feedback_only": lambda config, spec, seed: FeedbackOnly(spec),
    "open_loop": lambda config, spec, seed: OpenLoop(spec),
    "random": lambda config, spec, seed: RandomAgent(seed=seed),
}
"""Makers of agents: what each is given are settings, of which it takes what it has, where it acts,
and a seed, or several for agents side by side."""

_OF_MPMA = ("rule", "efference_copy", "responsibility_predictors", "forward_gating")
_OF_MODELS = ("proprioception", "spectral_radius", "reservoir_noise", "ridge", "context_signal")

IRRELEVANT_OPTIONS: dict[str, tuple[str, ...]] = {
    "mosaic": (*_OF_MPMA, "ridge"),
    "hammer": _OF_MPMA,
    "feedback_only": (*_OF_MPMA, *_OF_MODELS),
    "open_loop": (*_OF_MPMA, *_OF_MODELS),
    "random": (*_OF_MPMA, *_OF_MODELS),
}
"""Settings of a run that an agent does not have, by the agent's name. Sizes are not among them, so
that all agents can stand in one grid of `modules` and `nodes`: who has none, or one of its own, is
what the others are held against."""

NOT_TRAINABLE = ("feedback_only", "open_loop", "random")
"""Agents for which one epoch says all."""

NO_FINE_TUNING = (*NOT_TRAINABLE, "hammer")
"""Agents that learn nothing after their training, or never."""
