"""Report of lesions: a table of one run, a summary of several runs, and a figure."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.patches import Patch, Rectangle
from numpy.typing import NDArray

from mpma_mj.analysis.lesion import LabelMeasures, Lesion, Lesions
from mpma_mj.evaluation.statistics import interval
from mpma_mj.utils.text import markdown_table
from mpma_mj.visualization.colours import INK, module_colours
from mpma_mj.visualization.figure_file import figure_file

__all__ = ["drawn", "matrix", "name_of", "summary", "write_figure"]

Array = NDArray[np.float64]
Part = NDArray[np.bool_]  # labels that count, shape (C,)
Selection = Callable[[Lesions, Lesion], Part]
Measure = Callable[[LabelMeasures], Array]  # a value for each label, shape (C,)
Episode = Callable[[Lesions, Lesion], LabelMeasures | None]


def name_of(lesion: Lesion, lesions: Lesions) -> str:
    """Return the name of a row; modules are counted from 1."""
    if lesion is lesions.silent:
        return "all silent"
    dropped = ", ".join(str(module + 1) for module in lesion.dropped)
    return f"without {dropped}" if dropped else "intact"


def matrix(lesions: Lesions) -> str:
    """Return p_e, and the dominant module, of each lesion and label as two tables."""
    arrow = " → after fine-tuning" if lesions.fine_tuned else ""
    names = [name_of(lesion, lesions) for lesion in lesions.lesions]
    errors, owners = [], []
    for name, lesion in zip(names, lesions.lesions, strict=True):
        measures = [one for one in (lesion.at_once, lesion.fine_tuned) if one]
        columns = zip(*(_errors(one) for one in measures), strict=True)
        errors.append([name, *(" → ".join(column) for column in columns)])
        if lesion is not lesions.silent:
            shares = zip(*(_owners(one) for one in measures), strict=True)
            owners.append([name, *(" → ".join(column) for column in shares)])
    head = (f"p_e, %, at once{arrow}", *lesions.labels, "all")
    who = (f"dominant module (its mean λ), at once{arrow}", *lesions.labels)
    return f"{markdown_table(head, errors)}\n\n{markdown_table(who, owners)}"


def _errors(measures: LabelMeasures) -> list[str]:
    return [_number(error) for error in (*measures.label_p_e_percent, measures.p_e_percent)]


def _owners(measures: LabelMeasures) -> list[str]:
    return [
        f"{owner + 1} ({share[owner]:.2f})" if owner >= 0 else "–"
        for owner, share in zip(measures.dominant.tolist(), measures.responsibility, strict=True)
    ]


def _number(value: float) -> str:
    return "–" if np.isnan(value) else f"{value:.2f}"


def summary(runs: Sequence[Lesions]) -> str:
    """Return means over runs, with 95 % intervals, as two tables.

    The first has p_e in the labels of dropped modules and in others. The second shows how others
    take over in the labels of a dropped module: their share of what modules do for p_e, 100 % where
    p_e is that of the intact agent and 0 % where it is that without modules; and the largest λ of a
    module there. A run's value is the mean over its lesions, and over the labels of each (choice).

    Args:
        runs: The lesions of each run.
    """
    return f"{_errors_table(runs)}\n\n{_takeover_table(runs)}"


def _own(run: Lesions, lesion: Lesion) -> Part:
    return run.owned(lesion.dropped)


def _others(run: Lesions, lesion: Lesion) -> Part:
    """Return the labels of other modules, where some are of the dropped ones."""
    own = run.owned(lesion.dropped)
    return ~own & (run.intact.at_once.dominant >= 0) & own.any()


def _all(run: Lesions, lesion: Lesion) -> Part:
    """Return all labels, where none is of the dropped modules."""
    return (run.intact.at_once.dominant >= 0) & ~run.owned(lesion.dropped).any()


_EPISODES: dict[str, Episode] = {
    "intact": lambda run, lesion: run.intact.at_once,
    "at once": lambda run, lesion: lesion.at_once,
    "intact, fine-tuned": lambda run, lesion: run.intact.fine_tuned,
    "fine-tuned": lambda run, lesion: lesion.fine_tuned,
    "all silent": lambda run, lesion: run.silent.at_once,
}
_SIZES = {1: "one module", 2: "two modules"}
_PARTS: dict[str, Selection] = {
    "in its own labels": _own,
    "in other labels": _others,
    "dominant in none": _all,
}


def _errors_table(runs: Sequence[Lesions]) -> str:
    """Return p_e for each number of dropped modules and each part of the labels."""
    columns = {"intact": "intact", "at once": "at once"}
    if epochs := _epochs(runs):
        columns |= {f"intact, {epochs} on": "intact, fine-tuned", f"after {epochs}": "fine-tuned"}
    columns["all silent"] = "all silent"
    rows = []
    for (size, modules), (where, part) in itertools.product(_SIZES.items(), _PARTS.items()):
        found = [_of_runs(runs, size, part, name, _p_e) for name in columns.values()]
        if not np.isnan(found[0]).all():
            rows.append((f"{modules}, {where}", *(_text(values, 2) for values in found)))
    return markdown_table(("p_e, %, without", *columns), rows)


def _takeover_table(runs: Sequence[Lesions]) -> str:
    """Return how much is taken over in the labels of dropped modules, and the largest λ there."""
    columns = {"at once": ("intact", "at once")}
    if epochs := _epochs(runs):
        columns[f"after {epochs}"] = ("intact, fine-tuned", "fine-tuned")
    rows = []
    for size, modules in _SIZES.items():
        silent = _of_runs(runs, size, _own, "all silent", _p_e)
        if np.isnan(silent).all():
            continue
        shares, largest = [], [_of_runs(runs, size, _own, "intact", _largest)]
        for whole, part in columns.values():
            intact = _of_runs(runs, size, _own, whole, _p_e)
            dropped = _of_runs(runs, size, _own, part, _p_e)
            shares.append(100.0 * (silent - dropped) / (silent - intact))
            largest.append(_of_runs(runs, size, _own, part, _largest))
        cells = [*(_text(share, 0) for share in shares), *(_text(share, 2) for share in largest)]
        rows.append((modules, *cells))
    taken = (f"taken over {when}, %" for when in columns)
    most = (f"largest λ {when}" for when in ("intact", *columns))
    return markdown_table(("in its own labels, without", *taken, *most), rows)


def _epochs(runs: Sequence[Lesions]) -> str:
    """Return the epochs of fine-tuning as text; empty without any."""
    epochs = max((run.epochs for run in runs if run.fine_tuned), default=0)
    return f"{epochs} epoch{'s' * (epochs != 1)}" if epochs else ""


def _p_e(measures: LabelMeasures) -> Array:
    return measures.label_p_e_percent


def _largest(measures: LabelMeasures) -> Array:
    return measures.responsibility.max(axis=1)


def _of_runs(
    runs: Sequence[Lesions], size: int, part: Selection, episode: str, measure: Measure
) -> Array:
    """Return the mean of each run, shape (R,); NaN of one without such lesions or episodes."""
    means = []
    for run in runs:
        values = [
            float(measure(measures)[labels].mean())
            for lesion in run.partial
            if len(lesion.dropped) == size
            and (labels := part(run, lesion)).any()
            and (measures := _EPISODES[episode](run, lesion)) is not None
        ]
        means.append(float(np.mean(values)) if values else np.nan)
    return np.array(means)


def _text(values: Array, digits: int) -> str:
    return interval(values[~np.isnan(values)].tolist()).text(digits)


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
