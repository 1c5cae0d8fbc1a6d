"""The figure of what breaks without which modules, and who takes over."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.patches import Patch, Rectangle
from numpy.typing import NDArray

from mpma_mj.analysis.lesion import Dance, Lesion, Lesions
from mpma_mj.analysis.lesion_table import name_of
from mpma_mj.visualization.colours import INK, module_colours
from mpma_mj.visualization.figure_file import figure_file

__all__ = ["drawn", "write_figure"]

Array = NDArray[np.float64]

_MOST = 18  # rows; if there were more, pairs of modules are left to the table
_CELL = (0.56, 0.27)  # width and height of a cell, inches
_AROUND = (1.4, 2.0)  # what stands around all cells, inches
_NARROWEST = 3.4  # inches of a column, for its title
_ENTRY = 1.5  # width of an entry of the legend, inches
_SHORT, _LONGEST = 5, 18  # longer names of labels stand upright, and are cut
_BAR = 0.92  # width of a bar, of a cell
_ONE_DIGIT = 10.0  # from here on a number has one digit after the point
_CHIP = 0.2  # height of a label's mark of its module, of a cell
_MAP = "YlOrBr"
_LIGHT = 0.55  # from here on a colour is dark enough for white numbers


def drawn(without: Lesions) -> list[Lesion]:
    """Return the lesions that have a row: all, or where those are many all but pairs."""
    if len(without.lesions) <= _MOST:
        return list(without.lesions)
    some = [lesion for lesion in without.some if len(lesion.lost) == 1]
    return [without.intact, *some, without.silent]


def write_figure(path: Path, without: Lesions, movement: str) -> None:
    """Write p_e and responsibilities in each label, at once and after learning on.

    Args:
        path: The PNG file.
        without: The lesions of a run.
        movement: What is danced.
    """
    lesions = drawn(without)
    times: dict[str, list[Dance | None]] = {"at once": [lesion.at_once for lesion in lesions]}
    if without.retrained:
        again = f"after {without.epochs} epoch{'s' * (without.epochs != 1)} of learning"
        times[again] = [lesion.retrained for lesion in lesions]
    column = max(_NARROWEST, _CELL[0] * (len(without.labels) + 1))
    width = _AROUND[0] + len(times) * column
    height = _AROUND[1] + 2 * _CELL[1] * len(lesions)
    with figure_file(path, width, height) as figure:
        # Below, there is no row for the last lesion, in which all are silent.
        heights = len(lesions), len(lesions) - 1
        axes = figure.subplots(
            2, len(times), sharey="row", squeeze=False, gridspec_kw={"height_ratios": heights}
        )
        norm = _norm(lesions)
        for column, (when, dances) in enumerate(times.items()):
            _errors(axes[0, column], without, lesions, dances, norm)
            _shares(axes[1, column], without, lesions, dances)
            axes[0, column].set_title(f"p_e, %, {when}", fontsize="medium")
            axes[1, column].set_title(f"responsibility λ, {when}", fontsize="medium")
        names = [name_of(lesion, without) for lesion in lesions]
        for axis, count in zip(axes[:, 0], heights, strict=True):
            axis.set_yticks(range(count), names[:count], fontsize=8)
            axis.set_ylim(count - 0.5, -0.5)
        colours = _colours(without)
        patches = [Patch(color=colours[i], label=f"module {i + 1}") for i in range(without.modules)]
        frame = Patch(facecolor="none", edgecolor=INK, label="label of a lost module")
        figure.legend(
            handles=[*patches, frame],
            loc="outside lower center",
            ncols=int(width / _ENTRY),
            fontsize=8,
            frameon=False,
        )
        figure.suptitle(f"What breaks without which modules ({movement})", fontsize="medium")


def _norm(lesions: Sequence[Lesion]) -> LogNorm:
    """Return the scale of the colours, which is that of ratios."""
    dances = [d for lesion in lesions for d in (lesion.at_once, lesion.retrained) if d]
    errors = np.concatenate([dance.label_p_e_percent for dance in dances])
    return LogNorm(float(np.nanmin(errors)), float(np.nanmax(errors)))


def _errors(
    axis: Axes,
    without: Lesions,
    lesions: Sequence[Lesion],
    dances: Sequence[Dance | None],
    norm: LogNorm,
) -> None:
    """Draw a cell for each lesion and label, framed where a lost module was dominant."""
    labels = len(without.labels)
    table = np.full((len(dances), labels + 1), np.nan)
    for row, dance in enumerate(dances):
        if dance is not None:
            table[row] = [*dance.label_p_e_percent, dance.p_e_percent]
    axis.imshow(table, cmap=_MAP, norm=norm, aspect="auto")
    for (row, column), error in np.ndenumerate(table):
        if not np.isnan(error):
            colour = "white" if norm(error) > _LIGHT else INK
            text = f"{error:.2f}" if error < _ONE_DIGIT else f"{error:.1f}"
            axis.text(column, row, text, ha="center", va="center", color=colour, fontsize=7.5)
    for row, (lesion, dance) in enumerate(zip(lesions, dances, strict=True)):
        if dance is not None and lesion is not without.silent:
            for column in np.flatnonzero(without.owned(lesion.lost)):
                place = (column - 0.47, row - 0.45)
                axis.add_patch(
                    Rectangle(place, 0.94, 0.9, fill=False, edgecolor=INK, linewidth=1.4)
                )
    axis.axvline(labels - 0.5, color="white", linewidth=4, zorder=0.5)
    _columns(axis, without, [*without.labels, "all"])


def _shares(
    axis: Axes, without: Lesions, lesions: Sequence[Lesion], dances: Sequence[Dance | None]
) -> None:
    """Draw a bar for each lesion and label, divided among the modules that are left."""
    colours = _colours(without)
    for row, (lesion, dance) in enumerate(zip(lesions, dances, strict=True)):
        if dance is None or lesion is without.silent:
            continue
        left = np.arange(len(without.labels)) - 0.5 * _BAR
        for share, colour in zip(dance.responsibility.T, colours, strict=False):
            axis.barh(row, _BAR * share, 0.74, left, color=colour)
            left = left + _BAR * np.nan_to_num(share)
    axis.set_xlim(-0.5, len(without.labels) - 0.5)
    _columns(axis, without, without.labels)


def _columns(axis: Axes, without: Lesions, names: Sequence[str]) -> None:
    """Name the labels above their columns, over the colour of the module that was dominant."""
    colours = _colours(without)
    for column, owner in enumerate(without.intact.at_once.dominant.tolist()):
        if owner >= 0:
            place = (column - 0.5 * _BAR, -0.5 - _CHIP)
            chip = Rectangle(place, _BAR, _CHIP, color=colours[owner], clip_on=False, linewidth=0)
            axis.add_patch(chip)
    cut = [n if len(n) <= _LONGEST else f"{n[: _LONGEST - 1]}…" for n in names]
    upright = max(map(len, cut)) > _SHORT
    axis.xaxis.tick_top()
    axis.set_xticks(range(len(cut)), cut, fontsize=8, rotation=90 if upright else 0)
    axis.tick_params(axis="x", length=0, pad=6)
    axis.tick_params(axis="y", length=0)
    axis.spines[:].set_visible(False)


def _colours(without: Lesions) -> list[str]:
    return module_colours(without.modules)
