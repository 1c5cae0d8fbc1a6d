"""How MPMA scales, as a picture: p_e, modules used and entropy of λ against what is learned."""

from __future__ import annotations

import functools
import itertools
from collections.abc import Sequence
from pathlib import Path
from typing import Any, get_args

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mpma_mj.files import write_whole
from mpma_mj.sweep.measures import spread
from mpma_mj.sweep.scale import Growing, Size
from mpma_mj.sweep.scale_table import Results
from mpma_mj.training.colours import module_colours

__all__ = ["write_figure"]

_DPI = 110
# Title of a row of panels, and the measure of its lines, or of solid and of dashed ones.
_ROWS: tuple[tuple[str, tuple[str, ...]], ...] = (
    ("p_e, %", ("p_e_percent",)),
    ("modules used", ("modules_used",)),
    ("entropy of λ / log M", ("entropy.usage", "entropy.sharing")),
)
_STYLES = ("o-", "o--")


def write_figure(path: Path, results: Results) -> None:
    """Draw a column of panels for what grows and what varies; a line for each size.

    Args:
        path: The PNG file.
        results: Finished runs by material and size.
    """
    lines = results.scale.lines
    columns = list(itertools.product(get_args(Growing), lines))
    figure = Figure(figsize=(12.0, 8.0), layout="constrained")
    axes = figure.subplots(len(_ROWS), len(columns), sharey="row", sharex="col", squeeze=False)
    for column, (growing, varying) in enumerate(columns):
        for row, (title, measures) in enumerate(_ROWS):
            axis = axes[row, column]
            for style, measure in zip(_STYLES, measures, strict=False):
                _lines(axis, results, growing, lines[varying], measure, style)
            axis.spines[["top", "right"]].set_visible(False)
            axis.tick_params(labelsize="small")
            axis.set_ylim(bottom=0)
            if column == 0:
                axis.set_ylabel(title)
        amounts = [material.amount for material in results.growing(growing)]
        axes[0, column].set_xscale("log", base=2)
        axes[-1, column].set_xticks(amounts, [f"{amount:g}" for amount in amounts])
        axes[-1, column].minorticks_off()
        named = {
            "movements": "movements, a label for each",
            "seconds": "seconds of one, four labels",
        }
        axes[-1, column].set_xlabel(named[growing], fontsize="small")
        handles = axes[0, column].get_lines()
        names = [str(getattr(size, varying)) for size in lines[varying]]
        axes[0, column].legend(handles, names, title=varying, fontsize="x-small", ncols=2)
        size = lines[varying][0]
        fixed = f"{size.nodes} nodes" if varying == "modules" else f"{size.modules} modules"
        axes[0, column].set_title(f"{varying} vary, {fixed}", fontsize="medium")
    base = results.scale.base
    figure.suptitle(
        f"{base.rule} rule, {base.arms} arms, mean ± standard deviation over seeds",
        fontsize="large",
    )
    write_whole(path, functools.partial(figure.savefig, dpi=_DPI))


def _lines(
    axis: Axes,
    results: Results,
    growing: Growing,
    sizes: Sequence[Size],
    measure: str,
    style: str,
) -> None:
    """Draw a measure over the amount of material, a line for each size."""
    materials = results.growing(growing)
    amounts = [material.amount for material in materials]
    look: dict[str, Any] = {"markersize": 4, "linewidth": 1.2}
    for size, colour in zip(sizes, module_colours(len(sizes)), strict=True):
        found = [spread(results.of(material, size), measure) for material in materials]
        means = [one.mean for one in found]
        axis.plot(amounts, means, style, color=colour, **look)
        low = [one.mean - one.deviation for one in found]
        high = [one.mean + one.deviation for one in found]
        axis.fill_between(amounts, low, high, color=colour, alpha=0.15, linewidth=0)
