"""Specialisation of the modules of a run: shares, information, synergies, repetition.

All shares are over modules: each column sums to 1. A column is NaN where there is nothing to
share, such as a label that does not occur. They are to be compared with the module's mean
responsibility: one that is responsible half of the time has half of most things.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpma_mj import metrics
from mpma_mj.analysis.information import (
    ResponsibilityInformation,
    posture_regions,
    responsibility_information,
)
from mpma_mj.analysis.synergies import Synergies, find_synergies
from mpma_mj.context import active_label
from mpma_mj.kinematics import JOINT_NAMES, SEGMENT_NAMES
from mpma_mj.trace import Trace

__all__ = [
    "ModuleAnalysis",
    "Repetition",
    "analyse_modules",
    "group_share",
    "joint_share",
    "recurrence",
    "repetitions",
    "segment_movement",
    "segment_share",
]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Repetition:
    """Repetition of activation patterns.

    Attributes:
        period: Steps of one repetition, P.
        repetitions: λ in each repetition, shape (R, P, M); NaN where the last is cut short.
        responsibility: Repeatability of each module's λ, shape (M,); see `metrics`.
        module_output: Repeatability of each module's motor output, shape (M,).
        recurrence: Similarity of λ to itself after 0, 1, 2, … steps, up to a period and a half.
    """

    period: int
    repetitions: Array
    responsibility: Array
    module_output: Array
    recurrence: Array


@dataclass(frozen=True, eq=False)
class ModuleAnalysis:
    """Specialisation of M modules.

    Attributes:
        shares: Each module's shares, shape (M,), by kind ("all", "label", "segment", "joint",
            "posture region") and name.
        information: Information about responsibility in posture and context.
        synergies: Synergies of the motor outputs.
        module_output: Each module's share of all motor output, shape (M,).
        repetition: Repetition of activation patterns.
        joints: Names of the joints.
    """

    shares: Mapping[str, Mapping[str, Array]]
    information: ResponsibilityInformation
    synergies: Synergies
    module_output: Array
    repetition: Repetition
    joints: Sequence[str] = JOINT_NAMES

    def as_json(self) -> dict[str, Any]:
        """Return what `write_json` can write."""
        content = dataclasses.asdict(self)
        del content["repetition"]["repetitions"]
        joints = content.pop("joints")
        content["synergies"]["joints"] = [f"{sign}{j}" for sign in "+-" for j in joints]
        return content


def analyse_modules(
    trace: Trace,
    labels: tuple[str, ...],
    period: int,
    progress: Callable[[range], Iterable[int]] = lambda numbers: numbers,
    joints: Sequence[str] = JOINT_NAMES,
) -> ModuleAnalysis:
    """Analyse the modules in an epoch.

    Args:
        trace: Signals of an epoch, see docs/formats.md; not all motor outputs 0.
        labels: Names of the context's entries.
        period: Steps of one repetition.
        progress: Wraps the numbers of synergies that are tried, to show the progress.
        joints: Names of the joints.
    """
    signals = trace.with_modules()
    responsibility = signals.responsibility
    output = responsibility[:, :, None] * signals.module_actions
    posture, context = trace.posture[:-1], trace.context[:-1]
    region, label = posture_regions(posture), active_label(context)
    regions = tuple(str(number + 1) for number in range(region.max() + 1))
    shares = {
        "label": (labels, group_share(responsibility, label, len(labels))),
        "segment": (SEGMENT_NAMES, segment_share(responsibility, segment_movement(trace.posture))),
        "joint": (joints, joint_share(output)),
        "posture region": (regions, group_share(responsibility, region, len(regions))),
    }
    modules = range(responsibility.shape[1])
    lags = min(len(responsibility), period + period // 2)
    repeated = Repetition(
        period=period,
        repetitions=repetitions(responsibility, period),
        responsibility=np.array(
            [metrics.repeatability(responsibility[:, i], period) for i in modules]
        ),
        module_output=np.array([metrics.repeatability(output[:, i], period) for i in modules]),
        recurrence=recurrence(responsibility, lags),
    )
    return ModuleAnalysis(
        shares={"all": {"": responsibility.mean(axis=0)}}
        | {kind: dict(zip(names, share.T, strict=True)) for kind, (names, share) in shares.items()},
        information=responsibility_information(
            responsibility, posture, context, region, label, period
        ),
        synergies=find_synergies(output, progress),
        module_output=np.abs(output).sum(axis=(0, 2)) / np.abs(output).sum(),
        repetition=repeated,
        joints=tuple(joints),
    )


def joint_share(output: Array) -> Array:
    """Return each module's share of each joint's motor output.

        Σ_t |λ^i u^i_j| / Σ_k Σ_t |λ^k u^k_j|

    Args:
        output: Motor outputs λ^i u^i of the modules, shape (T, M, J).

    Returns:
        Shares, shape (M, J).
    """
    return _over_modules(np.abs(output).sum(axis=0))


def group_share(responsibility: Array, group: NDArray[np.int_], groups: int) -> Array:
    """Return each module's share of each group of steps, its mean λ in them.

    Args:
        responsibility: Responsibilities λ, shape (T, M).
        group: Group of each step, such as its label, shape (T,); -1 for none.
        groups: Number of groups, G.

    Returns:
        Shares, shape (M, G).
    """
    members = (group[:, None] == np.arange(groups)).astype(np.float64)  # (T, G)
    return _over_modules(responsibility.T @ members)


def segment_share(responsibility: Array, movement: Array) -> Array:
    """Return each module's share of each segment's movement while it is responsible.

        Σ_t λ^i_t m_t / Σ_k Σ_t λ^k_t m_t

    Args:
        responsibility: Responsibilities λ, shape (T, M).
        movement: Angle through which each segment turns in each step, shape (T, S), rad.

    Returns:
        Shares, shape (M, S).
    """
    return _over_modules(responsibility.T @ movement)


def segment_movement(posture: Array) -> Array:
    """Return the angle through which each segment turns in each step.

    Args:
        posture: Postures, shape (T + 1, 12), four unit vectors.

    Returns:
        Angles, shape (T, 4), rad, in the order of `kinematics.SEGMENT_NAMES`.
    """
    chord = np.linalg.norm(np.diff(posture.reshape(len(posture), -1, 3), axis=0), axis=-1)
    return 2.0 * np.arcsin(np.minimum(chord / 2.0, 1.0))


def _over_modules(amount: Array) -> Array:
    """Divide each column by its sum; NaN where that is 0."""
    total = amount.sum(axis=0)
    return amount / np.where(total > 0.0, total, np.nan)


def repetitions(signal: Array, period: int) -> Array:
    """Cut a signal into its repetitions.

    Args:
        signal: Signal, shape (T, ...).
        period: Steps of one repetition, P.

    Returns:
        Repetitions, shape (R, P, ...); NaN where the last is cut short.
    """
    count = -(-len(signal) // period)
    cut = np.full((count * period, *signal.shape[1:]), np.nan)
    cut[: len(signal)] = signal
    return cut.reshape(count, period, *signal.shape[1:])


def recurrence(responsibility: Array, lags: int) -> Array:
    """Return the similarity of responsibility to itself some steps later.

    The mean over t of the cosine between λ_t and λ_{t+lag}: 1 where the same modules share in the
    same way, 0 where others do. A peak at the period is a repetition; one before it, a pattern
    that recurs within a repetition.

    Args:
        responsibility: Responsibilities λ, shape (T, M).
        lags: Number of lags, at most T.

    Returns:
        Similarity, shape (lags,), for lags 0, 1, 2, …; the first is 1.
    """
    direction = responsibility / np.linalg.norm(responsibility, axis=1, keepdims=True)
    steps = len(direction)
    return np.array(
        [np.mean(np.sum(direction[: steps - n] * direction[n:], axis=1)) for n in range(lags)]
    )
