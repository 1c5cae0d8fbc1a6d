"""Runs that differ in their seed only, trained one after the other."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

from mpma_mj.errors import DivergedError
from mpma_mj.motions import Motion
from mpma_mj.training.config import RunConfig
from mpma_mj.training.imitate import _one_thread, _trainer

__all__ = ["check", "train_crowd"]


def check(config: RunConfig, motion: Motion) -> None:
    """Refuse settings with which no run can begin, for the price of the smallest networks.

    Raises:
        MpmaError: A setting is outside what it may be, or does not fit the motion.
    """
    _trainer(dataclasses.replace(config, nodes=min(config.nodes, 1)), motion)


def train_crowd(configs: Sequence[RunConfig], motion: Motion, epochs: int) -> list[dict[str, Any]]:
    """Train runs and return the summary of each, or {"failed": why} where it diverged."""
    with _one_thread():
        return [_train(config, motion, epochs) for config in configs]


def _train(config: RunConfig, motion: Motion, epochs: int) -> dict[str, Any]:
    trainer = _trainer(config, motion)
    try:
        while len(trainer.rows) < epochs and not trainer.converged:
            trainer.run_epoch()
    except DivergedError as error:
        return {"failed": str(error)}
    return trainer.summary()
