"""Tables of how MPMA scales, and in words where more no longer helps."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import get_args

from mpma_mj.experiments.folder import RunResult
from mpma_mj.experiments.measures import remarks, spread
from mpma_mj.experiments.scaling import Growing, Material, Scale, Size, Varying
from mpma_mj.experiments.spec import without_seed
from mpma_mj.utils.text import markdown_table

__all__ = [
    "TOLERANCE",
    "Results",
    "amounts",
    "as_markdown",
    "as_rows",
    "fixed",
    "least_enough",
    "saturation",
]

TOLERANCE = 0.1  # of the best value; what is nearer counts as good (choice)

# Title, name in a summary, digits after the point.
_MEASURES = (
    ("p_e, %", "p_e_percent", 2),
    ("prediction error, %", "prediction_error_percent", 2),
    ("feedback ratio", "feedback_ratio", 3),
    ("epochs", "epochs", 1),
    ("nmi of label and module", "nmi", 2),
    ("modules used", "modules_used", 1),
    ("entropy of λ in the whole (usage), 1 is all modules alike", "entropy.usage", 2),
    ("entropy of λ at a time (sharing), 0 is one module alone", "entropy.sharing", 2),
)


_ENOUGH = (
    f"Enough is the least number with which p_e is within {100 * TOLERANCE:.0f} % of the lowest"
    " that was reached."
)


class Results:
    """RunResult runs by material and size.

    Attributes:
        scale: What was spec.
    """

    def __init__(self, scale: Scale, runs: Sequence[RunResult]) -> None:
        """Sort the runs."""
        self.scale = scale
        self._found: dict[object, list[RunResult]] = {}
        for run in runs:
            self._found.setdefault(without_seed(run.config), []).append(run)

    def of(self, material: Material, size: Size) -> list[RunResult]:
        """Return the runs of a size on a material."""
        return self._found.get(without_seed(self.scale.point(material, size)), [])

    def mean(self, material: Material, size: Size, measure: str) -> float:
        """Return the mean of a measure over seeds; NaN if there is none."""
        return spread(self.of(material, size), measure).mean

    def growing(self, what: Growing) -> list[Material]:
        """Return the materials of which one is more than the other in this, the least first."""
        return [m for m in self.scale.materials if m.growing == what]


def least_enough(found: Mapping[int, float]) -> int | None:
    """Return the least size whose value is within `TOLERANCE` of the best, the lowest.

    Args:
        found: Values by size; those that are NaN do not count.

    Returns:
        The size; None if there is no value.
    """
    known = {size: value for size, value in found.items() if math.isfinite(value)}
    if not known:
        return None
    most = min(known.values()) * (1.0 + TOLERANCE)
    return min(size for size, value in known.items() if value <= most)


def as_markdown(results: Results, runs: Sequence[RunResult], spec: int) -> str:
    """Return a table for each measure, means over seeds, and where it saturates.

    Args:
        results: Results by material and size.
        runs: The finished runs.
        spec: Number of requested runs.
    """
    scale = results.scale
    parts = ["Means over seeds; columns are what is learned, rows are what learns it."]
    for title, measure, digits in _MEASURES:
        cells = {
            (material, size): _number(results.mean(material, size, measure), digits)
            for material in scale.materials
            for size in scale.sizes
        }
        parts += [f"**{title}**", _table(scale, cells)]
    converged = {
        (material, size): str(sum(bool(run.summary.get("converged")) for run in found))
        for material in scale.materials
        for size in scale.sizes
        for found in [results.of(material, size)]
    }
    parts += ["**runs that converged**", _table(scale, converged)]
    parts += [
        "**Where it saturates**",
        _ENOUGH,
        "\n".join(f"- {said}" for said in saturation(results)),
    ]
    return "\n\n".join([*parts, *remarks(runs, spec)]) + "\n"


def _table(scale: Scale, cells: Mapping[tuple[Material, Size], str]) -> str:
    """Return a table with a column for each material and a row for each size."""
    titles = ["modules", "nodes", *(amounts([m]) for m in scale.materials)]
    rows = [
        [str(size.modules), str(size.nodes), *(cells[m, size] for m in scale.materials)]
        for size in scale.sizes
    ]
    return markdown_table(titles, rows)


def saturation(results: Results) -> list[str]:
    """Return in sentences from which size on more does not help, and what more material costs."""
    return [
        sentence
        for growing in get_args(Growing)
        for sentence in (
            *_enough(results, growing),
            _most_used(results, growing),
            _cost(results, growing),
        )
    ]


def _enough(results: Results, growing: Growing) -> list[str]:
    """Say how many modules and nodes are enough for p_e."""
    sentences = []
    for varying, line in results.scale.lines.items():
        if len(line) < 2:
            continue
        groups: dict[str, list[Material]] = {}
        for material in results.growing(growing):
            found = {
                getattr(size, varying): results.mean(material, size, "p_e_percent") for size in line
            }
            groups.setdefault(str(least_enough(found) or "–"), []).append(material)
        told = "; ".join(f"{least} for {amounts(group)}" for least, group in groups.items())
        sentences.append(f"More {growing}, {fixed(varying, line[0])}: enough {varying} are {told}.")
    return sentences


def _most_used(results: Results, growing: Growing) -> str:
    """Say how many modules are used at most."""
    most = []
    for material in results.growing(growing):
        found = [
            results.mean(material, size, "modules_used") for size in results.scale.lines["modules"]
        ]
        most.append(max((value for value in found if math.isfinite(value)), default=math.nan))
    return (
        f"More {growing}: most modules used {', '.join(_number(value, 1) for value in most)} for"
        f" {amounts(results.growing(growing))}; {max(results.scale.modules)} is the most there are."
    )


def _cost(results: Results, growing: Growing) -> str:
    """Say how p_e goes with the material, for the size where both lines cross."""
    size, grown = results.scale.crossing, results.growing(growing)
    found = (results.mean(material, size, "p_e_percent") for material in grown)
    return (
        f"More {growing}: p_e with {fixed('nodes', size)} and {fixed('modules', size)} is"
        f" {', '.join(_number(value, 2) for value in found)} % for {amounts(grown)}."
    )


def as_rows(results: Results) -> list[dict[str, object]]:
    """Return a row for each material and size, with means and deviations of all measures."""
    rows: list[dict[str, object]] = []
    for material in results.scale.materials:
        for size in results.scale.sizes:
            runs = results.of(material, size)
            row: dict[str, object] = {
                "growing": material.growing,
                "amount": material.amount,
                **size._asdict(),
                "runs": len(runs),
                "converged": sum(bool(run.summary.get("converged")) for run in runs),
            }
            for _, measure, _ in _MEASURES:
                found = spread(runs, measure)
                row |= {f"{measure}_mean": found.mean, f"{measure}_sd": found.deviation}
            rows.append(row)
    return rows


def amounts(materials: Sequence[Material]) -> str:
    """Return how much there is of materials of which one is more than the other, in words."""
    numbers = ", ".join(f"{material.amount:g}" for material in materials)
    if materials[-1].growing == "seconds":
        return f"{numbers} s"
    return f"{numbers} {_noun('movements', materials[-1].amount)}"


def fixed(varying: Varying, size: Size) -> str:
    """Say what is the same all along a line of sizes."""
    other: Varying = "nodes" if varying == "modules" else "modules"
    number = getattr(size, other)
    return f"{number} {_noun(other, number)}"


def _noun(plural: str, number: float) -> str:
    return plural.removesuffix("s") if number == 1 else plural


def _number(value: float, digits: int) -> str:
    return f"{value:.{digits}f}" if math.isfinite(value) else "–"
