"""Figure of lesions: p_e and responsibilities in each label."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.patches import Patch, Rectangle
from numpy.typing import NDArray

from mpma_mj.analysis.lesion import LabelMeasures, Lesion, Lesions
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


def drawn(found: Lesions) -> list[Lesion]:
    """Return the lesions that have a row: all, or where those are many all but pairs."""
    if len(found.lesions) <= _MOST:
        return list(found.lesions)
    some = [lesion for lesion in found.partial if len(lesion.dropped) == 1]
    return [found.intact, *some, found.silent]


def write_figure(path: Path, found: Lesions, motion: str) -> None:
    """Write p_e and responsibilities in each label, at once and after fine-tuning.

    Args:
        path: The PNG file.
        found: The lesions of a run.
        motion: Name of the motion.
    """
    lesions = drawn(found)
    times: dict[str, list[LabelMeasures | None]] = {
        "at once": [lesion.at_once for lesion in lesions]
    }
    if found.fine_tuned:
        again = f"after {found.epochs} epoch{'s' * (found.epochs != 1)} of fine-tuning"
        times[again] = [lesion.fine_tuned for lesion in lesions]
    column = max(_NARROWEST, _CELL[0] * (len(found.labels) + 1))
    width = _AROUND[0] + len(times) * column
    height = _AROUND[1] + 2 * _CELL[1] * len(lesions)
    with figure_file(path, width, height) as figure:
        # Below, there is no row for the last lesion, in which all are silent.
        heights = len(lesions), len(lesions) - 1
        axes = figure.subplots(
            2, len(times), sharey="row", squeeze=False, gridspec_kw={"height_ratios": heights}
        )
        found_p_e = [m.label_p_e_percent for one in times.values() for m in one if m]
        norm = LogNorm(float(np.nanmin(found_p_e)), float(np.nanmax(found_p_e)))
        for column, (when, episodes) in enumerate(times.items()):
            _draw_errors(axes[0, column], found, lesions, episodes, norm)
            _draw_shares(axes[1, column], found, lesions, episodes)
            axes[0, column].set_title(f"p_e, %, {when}", fontsize="medium")
            axes[1, column].set_title(f"responsibility λ, {when}", fontsize="medium")
        names = [name_of(lesion, found) for lesion in lesions]
        for axis, count in zip(axes[:, 0], heights, strict=True):
            axis.set_yticks(range(count), names[:count], fontsize=8)
            axis.set_ylim(count - 0.5, -0.5)
        colours = module_colours(found.modules)
        patches = [Patch(color=colours[i], label=f"module {i + 1}") for i in range(found.modules)]
        frame = Patch(facecolor="none", edgecolor=INK, label="label of a dropped module")
        figure.legend(
            handles=[*patches, frame],
            loc="outside lower center",
            ncols=int(width / _ENTRY),
            fontsize=8,
            frameon=False,
        )
        figure.suptitle(f"Lesions ({motion})", fontsize="medium")


def _draw_errors(
    axis: Axes,
    found: Lesions,
    lesions: Sequence[Lesion],
    episodes: Sequence[LabelMeasures | None],
    norm: LogNorm,
) -> None:
    """Draw a cell for each lesion and label, framed where a dropped module was dominant."""
    labels = len(found.labels)
    table = np.full((len(episodes), labels + 1), np.nan)
    for row, episode in enumerate(episodes):
        if episode is not None:
            table[row] = [*episode.label_p_e_percent, episode.p_e_percent]
    axis.imshow(table, cmap=_MAP, norm=norm, aspect="auto")
    for (row, column), error in np.ndenumerate(table):
        if not np.isnan(error):
            colour = "white" if norm(error) > _LIGHT else INK
            text = f"{error:.2f}" if error < _ONE_DIGIT else f"{error:.1f}"
            axis.text(column, row, text, ha="center", va="center", color=colour, fontsize=7.5)
    for row, (lesion, episode) in enumerate(zip(lesions, episodes, strict=True)):
        if episode is not None and lesion is not found.silent:
            for column in np.flatnonzero(found.owned(lesion.dropped)):
                place = (column - 0.47, row - 0.45)
                axis.add_patch(
                    Rectangle(place, 0.94, 0.9, fill=False, edgecolor=INK, linewidth=1.4)
                )
    axis.axvline(labels - 0.5, color="white", linewidth=4, zorder=0.5)
    _name_columns(axis, found, [*found.labels, "all"])


def _draw_shares(
    axis: Axes, found: Lesions, lesions: Sequence[Lesion], episodes: Sequence[LabelMeasures | None]
) -> None:
    """Draw a bar for each lesion and label, divided among the modules that are left."""
    colours = module_colours(found.modules)
    for row, (lesion, episode) in enumerate(zip(lesions, episodes, strict=True)):
        if episode is None or lesion is found.silent:
            continue
        left = np.arange(len(found.labels)) - 0.5 * _BAR
        for share, colour in zip(episode.responsibility.T, colours, strict=False):
            axis.barh(row, _BAR * share, 0.74, left, color=colour)
            left = left + _BAR * np.nan_to_num(share)
    axis.set_xlim(-0.5, len(found.labels) - 0.5)
    _name_columns(axis, found, found.labels)


def _name_columns(axis: Axes, found: Lesions, names: Sequence[str]) -> None:
    """Name the labels above their columns, over the colour of the module that was dominant."""
    colours = module_colours(found.modules)
    for column, owner in enumerate(found.intact.at_once.dominant.tolist()):
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
