"""How MPMA scales, as a picture: p_e, modules used and entropy of λ against what is learned."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from pathlib import Path
from typing import Any, get_args

from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from mpma_mj.experiments.measures import Spread, spread
from mpma_mj.experiments.scaling import Growing, Varying
from mpma_mj.experiments.scaling_table import Results, fixed
from mpma_mj.visualization.colours import INK, module_colours
from mpma_mj.visualization.figure_file import figure_file

__all__ = ["write_figure"]

_GROWN: dict[Growing, str] = {
    "movements": "movements, a label for each",
    "seconds": "seconds of one, in four labels",
}
# Title of a row of panels, and the measure of its lines, or of solid and of dashed ones.
_ROWS: tuple[tuple[str, tuple[str, ...]], ...] = (
    ("p_e, %", ("p_e_percent",)),
    ("modules used", ("modules_used",)),
    ("entropy of λ, of log M", ("entropy.usage", "entropy.sharing")),
)
_STYLES = {"in the whole (usage)": "o-", "at a time (sharing)": "o--"}


def write_figure(path: Path, results: Results) -> None:
    """Draw a column of panels for what grows and what varies; a line for each size.

    Args:
        path: The PNG file.
        results: RunResult runs by material and size.
    """
    columns = list(itertools.product(get_args(Growing), results.scale.lines))
    with figure_file(path, 12.0, 8.0) as figure:
        axes = figure.subplots(len(_ROWS), len(columns), sharey="row", sharex="col", squeeze=False)
        for column, (growing, varying) in enumerate(columns):
            _column(list(axes[:, column]), results, growing, varying)
        for row, (title, _) in enumerate(_ROWS):
            axes[row, 0].set_ylabel(title)
            axes[row, 0].set_ylim(bottom=0)
        entropies: list[dict[str, Any]] = [
            {"linestyle": style.removeprefix("o"), "label": f"entropy {name}"}
            for name, style in _STYLES.items()
        ]
        handles = [Line2D([], [], color=INK, **look) for look in entropies]
        figure.legend(handles=handles, loc="outside lower center", ncols=2, fontsize="small")
        base = results.scale.base
        figure.suptitle(
            f"{base.option('rule')} rule, {base.env.arms} arms, µ ± σ over seeds: what learns"
            " grows, line by line, and what is learned, from left to right",
            fontsize="medium",
        )


def _column(axes: Sequence[Axes], results: Results, growing: Growing, varying: Varying) -> None:
    """Draw all measures for what grows and what varies."""
    sizes, materials = results.scale.lines[varying], results.growing(growing)
    amounts = [material.amount for material in materials]
    for axis, (_, measures) in zip(axes, _ROWS, strict=True):
        for measure, style in zip(measures, _STYLES.values(), strict=False):
            for size, colour in zip(sizes, module_colours(len(sizes)), strict=True):
                found = [spread(results.of(material, size), measure) for material in materials]
                _line(axis, amounts, found, style, colour)
        axis.spines[["top", "right"]].set_visible(False)
        axis.tick_params(labelsize="small")
    names = [str(getattr(size, varying)) for size in sizes]
    look: dict[str, Any] = {
        "fontsize": "small",
        "title_fontsize": "small",
        "ncols": 2,
        "loc": "lower right",
    }
    axes[0].legend(axes[0].get_lines(), names, title=varying, **look)
    axes[0].set_title(f"{varying} vary, {fixed(varying, sizes[0])}", fontsize="medium")
    axes[-1].set_xscale("log", base=2)
    axes[-1].set_xticks(amounts, [f"{amount:g}" for amount in amounts])
    axes[-1].minorticks_off()
    axes[-1].set_xlabel(_GROWN[growing], fontsize="small")


def _line(
    axis: Axes, amounts: Sequence[float], found: Sequence[Spread], style: str, colour: str
) -> None:
    """Draw means, and a band of a deviation on both sides."""
    axis.plot(amounts, [one.mean for one in found], style, color=colour, markersize=4, lw=1.2)
    low = [one.mean - one.deviation for one in found]
    high = [one.mean + one.deviation for one in found]
    axis.fill_between(amounts, low, high, color=colour, alpha=0.15, linewidth=0)
