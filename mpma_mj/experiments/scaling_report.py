"""Report of the study `scaling`: tables, where more no longer helps, and a figure."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, get_args

from matplotlib.axes import Axes

from mpma_mj.evaluation.statistics import MeanStd
from mpma_mj.experiments.records import Record, converged, matching, mean_std_over_seeds
from mpma_mj.experiments.scaling import Amount, Scaling, Size, Unit, Varying, labels
from mpma_mj.experiments.training import COLUMNS, Column
from mpma_mj.utils.text import markdown_table
from mpma_mj.visualization.colours import INK, module_colours
from mpma_mj.visualization.figure_file import figure_file

__all__ = [
    "TOLERANCE",
    "as_markdown",
    "fixed",
    "least_enough",
    "named",
    "saturation",
    "write_figure",
]

TOLERANCE = 0.1  # of the best value; what is nearer counts as good (choice)

_COLUMNS = (
    COLUMNS["p_e_percent"],
    Column("prediction error, %", "prediction_error_percent", 2),
    *(COLUMNS["feedback_ratio"], COLUMNS["epochs"]),
    Column("nmi of label and module", "nmi", 2),
    COLUMNS["modules_used"],
    Column("entropy of λ in the whole (usage), 1 is all modules alike", "entropy.usage", 2),
    Column("entropy of λ at a time (sharing), 0 is one module alone", "entropy.sharing", 2),
)


def as_markdown(study: Scaling, records: Sequence[Record]) -> str:
    """Return a table for each measure, means over seeds, and where it saturates."""
    amounts = study.amounts

    def table(title: str, cell: Callable[[Amount, Size], str]) -> str:
        head = ["modules", "nodes", *(named([amount]) for amount in amounts)]
        rows = [
            [str(size.modules), str(size.nodes), *(cell(amount, size) for amount in amounts)]
            for size in study.sizes
        ]
        return f"**{title}**\n\n{markdown_table(head, rows)}"

    def mean(column: Column) -> Callable[[Amount, Size], str]:
        return lambda amount, size: _number(
            study.mean(records, amount, size, column.measure), column.digits
        )

    def count(amount: Amount, size: Size) -> str:
        return str(converged(matching(records, labels(amount, size))))

    return "\n\n".join(
        [
            "Means over seeds; columns are what is learned, rows are the sizes of the agent.",
            *(table(column.title, mean(column)) for column in _COLUMNS),
            table("runs that converged", count),
            "**Where it saturates**",
            f"Enough is the least number with which p_e is within {100 * TOLERANCE:.0f} % of the"
            " lowest that was reached.",
            "\n".join(f"- {sentence}" for sentence in saturation(study, records)),
        ]
    )


def saturation(study: Scaling, records: Sequence[Record]) -> list[str]:
    """Return in sentences from which size on more does not help, and the cost of more motion."""
    sentences = []
    for unit in get_args(Unit):
        own = [amount for amount in study.amounts if amount.unit == unit]
        sentences += _enough(study, unit, own, records)
        sentences.append(_most_used(study, unit, own, records))
        size = study.crossing
        found = (_number(study.mean(records, one, size, "p_e_percent"), 2) for one in own)
        sentences.append(
            f"More {unit}: p_e with {fixed('nodes', size)} and {fixed('modules', size)} is"
            f" {', '.join(found)} % for {named(own)}."
        )
    return sentences


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


def named(amounts: Sequence[Amount]) -> str:
    """Return in words how much is learned; all have the same unit."""
    numbers = ", ".join(f"{amount.number:g}" for amount in amounts)
    last = amounts[-1]
    return (
        f"{numbers} s" if last.unit == "seconds" else f"{numbers} {_noun('motions', last.number)}"
    )


def fixed(varying: Varying, size: Size) -> str:
    """Return in words the number that is the same all along a line of sizes."""
    other: Varying = "nodes" if varying == "modules" else "modules"
    number = getattr(size, other)
    return f"{number} {_noun(other, number)}"


def _enough(
    study: Scaling, unit: Unit, amounts: Sequence[Amount], records: Sequence[Record]
) -> list[str]:
    """Return how many modules and nodes are enough for p_e."""
    sentences = []
    for varying, line in study.lines.items():
        if len(line) < 2:
            continue
        groups: dict[str, list[Amount]] = {}
        for amount in amounts:
            found = {
                getattr(size, varying): study.mean(records, amount, size, "p_e_percent")
                for size in line
            }
            groups.setdefault(str(least_enough(found) or "–"), []).append(amount)
        listed = "; ".join(f"{least} for {named(group)}" for least, group in groups.items())
        sentences.append(f"More {unit}, {fixed(varying, line[0])}: enough {varying} are {listed}.")
    return sentences


def _most_used(
    study: Scaling, unit: Unit, amounts: Sequence[Amount], records: Sequence[Record]
) -> str:
    """Return how many modules are used at most."""
    most = []
    for amount in amounts:
        found = [
            study.mean(records, amount, size, "modules_used") for size in study.lines["modules"]
        ]
        most.append(max((value for value in found if math.isfinite(value)), default=math.nan))
    return (
        f"More {unit}: most modules used {', '.join(_number(value, 1) for value in most)} for"
        f" {named(amounts)}; {max(study.modules)} is the most there are."
    )


def _noun(plural: str, number: float) -> str:
    return plural.removesuffix("s") if number == 1 else plural


def _number(value: float, digits: int) -> str:
    return f"{value:.{digits}f}" if math.isfinite(value) else "–"


_AXIS: dict[Unit, str] = {
    "motions": "motions, a label for each",
    "seconds": "seconds of one, in four labels",
}
# Title of a row of panels, and the measure of its lines, or of solid and of dashed ones.
_ROWS: tuple[tuple[str, tuple[tuple[str, ...], ...]], ...] = (
    ("p_e, %", (("p_e_percent",),)),
    ("modules used", (("modules_used",),)),
    ("entropy of λ, of log M", (("entropy", "usage"), ("entropy", "sharing"))),
)
_STYLES = {"in the whole (usage)": "o-", "at a time (sharing)": "o--"}


def write_figure(path: Path, study: Scaling, records: Sequence[Record]) -> None:
    """Draw a column of panels for each unit and each number that varies; a line for each size.

    Args:
        path: The PNG file.
        study: The study.
        records: Records of its finished runs.
    """
    columns = list(itertools.product(get_args(Unit), study.lines))
    amounts = study.amounts
    with figure_file(path, 12.0, 8.0) as figure:
        axes = figure.subplots(len(_ROWS), len(columns), sharey="row", sharex="col", squeeze=False)
        for column, (unit, varying) in enumerate(columns):
            own = [amount for amount in amounts if amount.unit == unit]
            _draw_column(list(axes[:, column]), study, own, varying, records)
            axes[-1, column].set_xlabel(_AXIS[unit], fontsize="small")
        for row, (title, _) in enumerate(_ROWS):
            axes[row, 0].set_ylabel(title)
            axes[row, 0].set_ylim(bottom=0)
        handles = [
            axes[0, 0].plot([], [], style[1:], color=INK, label=f"entropy {name}")[0]
            for name, style in _STYLES.items()
        ]
        figure.legend(handles=handles, loc="outside lower center", ncols=2, fontsize="small")
        figure.suptitle(
            f"{study.rule} rule, {study.arms} arms, µ ± σ over seeds: the agent's size by line, and"
            " the amount of motion from left to right",
            fontsize="medium",
        )


def _draw_column(
    axes: Sequence[Axes],
    study: Scaling,
    amounts: Sequence[Amount],
    varying: Varying,
    records: Sequence[Record],
) -> None:
    """Draw all measures for one unit and one number that varies."""
    sizes, numbers = study.lines[varying], [amount.number for amount in amounts]
    for axis, (_, measures) in zip(axes, _ROWS, strict=True):
        for measure, style in zip(measures, _STYLES.values(), strict=False):
            for size, colour in zip(sizes, module_colours(len(sizes)), strict=True):
                own = (matching(records, labels(amount, size)) for amount in amounts)
                found = [mean_std_over_seeds(one, *measure) for one in own]
                _draw_line(axis, numbers, found, style, colour)
        axis.spines[["top", "right"]].set_visible(False)
        axis.tick_params(labelsize="small")
    names = [str(getattr(size, varying)) for size in sizes]
    look: dict[str, Any] = {"fontsize": "small", "title_fontsize": "small", "ncols": 2}
    axes[0].legend(axes[0].get_lines(), names, title=varying, loc="lower right", **look)
    axes[0].set_title(f"{varying} vary, {fixed(varying, sizes[0])}", fontsize="medium")
    axes[-1].set_xscale("log", base=2)
    axes[-1].set_xticks(numbers, [f"{number:g}" for number in numbers])
    axes[-1].minorticks_off()


def _draw_line(
    axis: Axes, numbers: Sequence[float], found: Sequence[MeanStd], style: str, colour: str
) -> None:
    """Draw means, and a band of a standard deviation on both sides."""
    axis.plot(numbers, [one.mean for one in found], style, color=colour, markersize=4, lw=1.2)
    low = [one.mean - one.std for one in found]
    high = [one.mean + one.std for one in found]
    axis.fill_between(numbers, low, high, color=colour, alpha=0.15, linewidth=0)
