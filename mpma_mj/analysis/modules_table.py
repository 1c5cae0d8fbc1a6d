"""Tables of the analysis of modules."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mpma_mj.analysis.information import ResponsibilityInformation
from mpma_mj.analysis.modules import ModuleAnalysis, Repetition
from mpma_mj.analysis.synergies import ENOUGH, Synergies
from mpma_mj.kinematics import JOINT_NAMES
from mpma_mj.utils.text import markdown_table

__all__ = ["as_markdown", "joint_terms"]

Array = NDArray[np.float64]

# A synergy is described by the joints that make up this much of its squared length (choice).
_DESCRIBED = 0.8


def as_markdown(analysis: ModuleAnalysis) -> str:
    """Return the analysis as tables."""
    return "\n\n".join(
        [
            _shares(analysis),
            _information(analysis.information),
            _information_of_each(analysis.information),
            _synergies(analysis.synergies, analysis.module_output),
            _repetition(analysis.repetition),
        ]
    )


def joint_terms(pattern: Array) -> list[str]:
    """Return the joints that are strongest in a synergy, such as "+left elbow".

    Args:
        pattern: Joints in the positive and the negative direction, shape (16,), of length 1.
    """
    names = [f"{sign}{joint.replace('_', ' ')}" for sign in "+-" for joint in JOINT_NAMES]
    order = np.argsort(-pattern, kind="stable")
    count = 1 + int(np.searchsorted(np.cumsum(pattern[order] ** 2), _DESCRIBED))
    return [names[i].replace("shoulder ", "") for i in order[:count]]


def _shares(analysis: ModuleAnalysis) -> str:
    rows = [
        (f"{kind} {name.replace('_', ' ')}".strip(), *map(_percent, share))
        for kind, names in analysis.shares.items()
        for name, share in names.items()
    ]
    return markdown_table(("share of, %", *_modules(len(analysis.module_output))), rows)


def _information(information: ResponsibilityInformation) -> str:
    """Return a row for each source, about all modules together."""
    entropy = information.entropy_bits[0]
    rows = []
    for source, r2 in information.r2.items():
        bits = information.bits[source]
        values = (r2.value[0], r2.by_chance[0], bits.value[0], bits.by_chance[0])
        share = bits.value[0] / entropy if entropy > 0 else np.nan
        rows.append((source, *map(_number, values), _percent(share)))
    head = ("λ from", "R²", "by chance", "bits", "by chance", f"% of {entropy:.2f} bits")
    return markdown_table(head, rows)


def _information_of_each(information: ResponsibilityInformation) -> str:
    """Return the information about each module, by chance in brackets."""
    rows = [
        (
            f"{source}, {unit}",
            *(
                f"{_number(value)} ({_number(chance)})"
                for value, chance in zip(
                    measures[source].value[1:], measures[source].by_chance[1:], strict=True
                )
            ),
        )
        for unit, measures in (("R²", information.r2), ("bits", information.bits))
        for source in ("posture", "context")
    ]
    rows.append(("entropy, bits", *map(_number, information.entropy_bits[1:])))
    return markdown_table(
        ("each alone (by chance)", *_modules(len(information.entropy_bits) - 1)), rows
    )


def _synergies(synergies: Synergies, output: Array) -> str:
    factors = len(synergies.weights)
    reached = synergies.variance_accounted_for[factors - 1]
    head = ("synergy", "strength, %", *_modules(len(output)), "joints")
    rows = [
        (str(k + 1), _percent(weight), *map(_percent, load), ", ".join(joint_terms(pattern)))
        for k, (weight, load, pattern) in enumerate(
            zip(synergies.weights, synergies.loads, synergies.patterns, strict=True)
        )
    ]
    rows.append(("motor output", "100", *map(_percent, output), ""))
    count = f"{factors} synergies account" if factors > 1 else "1 synergy accounts"
    title = (
        f"{count} for {100 * reached:.1f} % of the motor outputs"
        f" (the least number for {100 * ENOUGH:.0f} %); % in each module:"
    )
    return f"{title}\n\n{markdown_table(head, rows)}"


def _repetition(repetition: Repetition) -> str:
    rows = [
        ("λ", *map(_number, repetition.responsibility)),
        ("motor output", *map(_number, repetition.module_output)),
    ]
    head = ("correlation between repetitions", *_modules(len(repetition.responsibility)))
    text = markdown_table(head, rows)
    course = repetition.recurrence
    if len(course) <= repetition.period:
        return text
    after, usual = course[repetition.period], course[1 : repetition.period + 1].mean()
    return (
        f"{text}\n\nsimilarity of λ to itself one repetition later {after:.2f}, after any time"
        f" {usual:.2f}"
    )


def _modules(count: int) -> list[str]:
    return [f"module {i + 1}" for i in range(count)]


def _percent(share: float) -> str:
    return "–" if np.isnan(share) else f"{100 * share:.0f}"


def _number(value: float) -> str:
    return "–" if np.isnan(value) else f"{value:z.2f}"
