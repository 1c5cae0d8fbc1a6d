"""Figure of the study `scaling`: p_e, modules used and entropy of λ by amount of motion."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from pathlib import Path
from typing import Any, get_args

from matplotlib.axes import Axes

from mpma_mj.evaluation.statistics import MeanStd
from mpma_mj.experiments.records import Record, matching, mean_std_over_seeds
from mpma_mj.experiments.scaling import Amount, Scaling, Unit, Varying, labels
from mpma_mj.experiments.scaling_table import fixed
from mpma_mj.visualization.colours import INK, module_colours
from mpma_mj.visualization.figure_file import figure_file

__all__ = ["write_figure"]

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
