"""Which module captures what: everything that is told about one run."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpma_mj import metrics
from mpma_mj.analysis import shares as capture
from mpma_mj.analysis.information import posture_regions
from mpma_mj.analysis.repetition import laid_over, recurrence
from mpma_mj.analysis.responsibility_information import Told, what_tells
from mpma_mj.analysis.synergies import Synergies, find_synergies
from mpma_mj.context import active_label
from mpma_mj.kinematics import JOINT_NAMES, SEGMENT_NAMES
from mpma_mj.trace import Trace

__all__ = ["Captured", "Repetition", "analyse"]

Array = NDArray[np.float64]
Shares = dict[str, dict[str, Array]]


@dataclass(frozen=True, eq=False)
class Repetition:
    """How activation patterns come back.

    Attributes:
        period: Steps of one repetition, P.
        laid_over: λ in each repetition, shape (R, P, M); NaN where the last is cut short.
        responsibility: Repeatability of each module's λ, shape (M,); see `metrics`.
        module_output: The same of its motor output.
        recurrence: Likeness of λ to itself after 0, 1, 2, … steps, up to a period and a half.
    """

    period: int
    laid_over: Array
    responsibility: Array
    module_output: Array
    recurrence: Array


@dataclass(frozen=True, eq=False)
class Captured:
    """Which module captures what.

    Attributes:
        shares: Each module's shares, shape (M,), by kind ("all", "label", "segment", "joint",
            "posture region") and name.
        told: What posture and context tell about responsibility.
        synergies: Synergies of the motor outputs.
        output: Each module's share of all motor output, shape (M,).
        repetition: How activation patterns come back.
    """

    shares: Shares
    told: Told
    synergies: Synergies
    output: Array
    repetition: Repetition

    def as_json(self) -> dict[str, Any]:
        """Return what JSON can hold."""
        synergies, repetition = self.synergies, self.repetition
        return {
            "shares": {
                kind: {name: share.tolist() for name, share in rows.items()}
                for kind, rows in self.shares.items()
            },
            "told": {
                "entropy_bits": self.told.entropy.tolist(),
                "r2": _beside_chance(self.told.r2),
                "bits": _beside_chance(self.told.bits),
            },
            "synergies": {
                "joints": [f"{sign}{joint}" for sign in "+-" for joint in JOINT_NAMES],
                "variance_accounted_for": synergies.variance_accounted_for.tolist(),
                "weights": synergies.weights.tolist(),
                "patterns": synergies.patterns.tolist(),
                "loads": synergies.loads.tolist(),
                "module_output": self.output.tolist(),
            },
            "repetition": {
                "period": repetition.period,
                "responsibility": repetition.responsibility.tolist(),
                "module_output": repetition.module_output.tolist(),
                "recurrence": repetition.recurrence.tolist(),
            },
        }


def analyse(
    trace: Trace,
    labels: tuple[str, ...],
    period: int,
    progress: Callable[[range], Iterable[int]] = lambda factors: factors,
) -> Captured:
    """Find out which module captures what.

    Args:
        trace: Signals of an epoch of T steps, see docs/formats.md; not all motor outputs 0.
        labels: Names of the context's entries.
        period: Steps of one repetition.
        progress: Wraps the numbers of synergies that are tried, to show how far it is.
    """
    responsibility = trace.with_modules().responsibility
    output = responsibility[:, :, None] * trace.with_modules().module_actions
    posture, context = trace.posture[:-1], trace.context[:-1]
    region, label = posture_regions(posture), active_label(context)
    return Captured(
        shares=_shares(responsibility, output, trace.posture, region, label, labels),
        told=what_tells(responsibility, posture, context, region, label, period),
        synergies=find_synergies(output, progress),
        output=np.abs(output).sum(axis=(0, 2)) / np.abs(output).sum(),
        repetition=_repetition(responsibility, output, period),
    )


def _shares(
    responsibility: Array,
    output: Array,
    posture: Array,
    region: NDArray[np.int_],
    label: NDArray[np.int_],
    labels: tuple[str, ...],
) -> Shares:
    regions = tuple(str(number + 1) for number in range(region.max() + 1))
    in_group = functools.partial(capture.group_share, responsibility)
    movement = capture.segment_movement(posture)
    return {
        "all": {"": responsibility.mean(axis=0)},
        "label": _named(labels, in_group(label, len(labels))),
        "segment": _named(SEGMENT_NAMES, capture.segment_share(responsibility, movement)),
        "joint": _named(JOINT_NAMES, capture.joint_share(output)),
        "posture region": _named(regions, in_group(region, len(regions))),
    }


def _repetition(responsibility: Array, output: Array, period: int) -> Repetition:
    modules = range(responsibility.shape[1])
    return Repetition(
        period=period,
        laid_over=laid_over(responsibility, period),
        responsibility=np.array(
            [metrics.repeatability(responsibility[:, i], period) for i in modules]
        ),
        module_output=np.array([metrics.repeatability(output[:, i], period) for i in modules]),
        recurrence=recurrence(responsibility, min(len(responsibility), period + period // 2)),
    )


def _named(names: tuple[str, ...], shares: Array) -> dict[str, Array]:
    return dict(zip(names, shares.T, strict=True))


def _beside_chance(measures: dict[str, Any]) -> dict[str, dict[str, list[float]]]:
    return {
        source: {"value": measure.value.tolist(), "by_chance": measure.by_chance.tolist()}
        for source, measure in measures.items()
    }
