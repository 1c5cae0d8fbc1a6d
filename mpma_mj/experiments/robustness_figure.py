"""p_e against disturbances, as a picture."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from mpma_mj.evaluation.disturbances import DISTURBANCES, Disturbance, Level
from mpma_mj.experiments.robustness import THIS_RUN
from mpma_mj.experiments.robustness_results import RECOVERED, Results, Tally
from mpma_mj.utils.text import printable
from mpma_mj.visualization.colours import INK, module_colours
from mpma_mj.visualization.figure_file import figure_file, label_decades

__all__ = ["write_figure"]

Array = NDArray[np.float64]
Measure = Callable[[str, str, Level], Tally]

_COLUMNS = 4
_WIDE = ("locked", "unseen")  # panels with many names below
_SPREAD = 0.62  # of the place of a name, over which agents are laid side by side
# So that those are told apart best that are compared most.
_ORDER = (
    *("mpma", "single", "mosaic", "hammer", "adaptive"),
    *("resolved_rate", "feedback_only", "open_loop", "random"),
)
_COLOURS = dict(zip(_ORDER, module_colours(len(_ORDER)), strict=True)) | {THIS_RUN: INK}
_OUTSIDE = "#7f7f7f"
_MARKERS = dict(zip((*_ORDER, THIS_RUN), "osD^v<PX*x", strict=True))


def write_figure(
    path: Path, results: Results, agents: Sequence[str], measure: Measure, said: str
) -> None:
    """Draw a panel for each disturbance, a line for each agent with the interval of its mean.

    Args:
        path: The PNG file.
        results: What was found.
        agents: Names of the agents to draw.
        measure: What to draw, given agent, disturbance and level.
        said: What it is, for the axis.
    """
    places, rows, columns = _places(list(results.levels))
    with figure_file(path, 0.9 + 3.0 * columns, 0.9 + 2.6 * rows) as figure:
        grid = figure.add_gridspec(rows, columns)
        axes: list[Axes] = []
        for name, (row, column) in places.items():
            where = grid[row, column : column + _width(name)]
            axes.append(figure.add_subplot(where, sharey=axes[0] if axes else None))
            _draw(axes[-1], results, name, agents, measure)
            axes[-1].tick_params(labelleft=column == 0)
        figure.supylabel(said, fontsize="medium")
        handles, labels = axes[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=2 * columns, frameon=False)


def _width(name: str) -> int:
    return 2 if name in _WIDE else 1


def _places(names: Sequence[str]) -> tuple[dict[str, tuple[int, int]], int, int]:
    """Return row and column of each panel, and the numbers of rows and columns."""
    places, row, column, most = dict[str, tuple[int, int]](), 0, 0, 0
    for name in names:
        if column + _width(name) > _COLUMNS:
            row, column = row + 1, 0
        places[name] = row, column
        column += _width(name)
        most = max(most, column)
    return places, row + 1, most


def _draw(axis: Axes, results: Results, name: str, agents: Sequence[str], measure: Measure) -> None:
    """Draw one disturbance."""
    disturbance, levels = DISTURBANCES[name], results.levels[name]
    if disturbance.is_ordered:
        levels = sorted(levels)
    x = np.array(levels if disturbance.is_ordered else range(len(levels)), np.float64)
    for number, agent in enumerate(agents):
        tallies = [measure(agent, name, level) for level in levels]
        if disturbance.is_ordered:
            _draw_line(axis, agent, x, tallies)
        else:
            aside = np.float64(_SPREAD * ((number + 0.5) / len(agents) - 0.5))
            _draw_points(axis, agent, x + aside, tallies)
    if disturbance.is_ordered:
        told = [float(level) for level in (*levels, *results.beyond[name])]
        axis.set_xticks(told, [f"{level:g}" for level in told])
        _order(axis, disturbance, results.beyond[name])
    else:
        axis.set_xticks(range(len(levels)), [_shown(level) for level in levels])
        axis.set_xlim(-0.5, len(levels) - 0.5)
        for between in np.arange(0.5, len(levels) - 1):
            axis.axvline(between, color="0.9", linewidth=0.8)
    axis.axhline(RECOVERED, color="0.75", linewidth=0.8, linestyle="--", zorder=1)
    axis.set_yscale("log")
    label_decades(axis.yaxis)
    axis.grid(axis="y", color="0.94")
    axis.set_axisbelow(True)
    axis.set_title(disturbance.title, fontsize="medium", loc="left")
    axis.tick_params(labelsize="small")
    axis.spines[["top", "right"]].set_visible(False)


def _draw_line(axis: Axes, agent: str, x: Array, tallies: Sequence[Tally]) -> None:
    """Draw means over levels, shape (N,), with a band for their intervals."""
    low, mean, high = _ends(tallies)
    axis.plot(x, mean, **_look(agent))
    axis.fill_between(x, low, high, color=_colour(agent), alpha=0.2, linewidth=0)
    _draw_lost(axis, agent, x, tallies)


def _draw_points(axis: Axes, agent: str, x: Array, tallies: Sequence[Tally]) -> None:
    """Draw means at places, shape (N,), with bars for their intervals."""
    low, mean, high = _ends(tallies)
    around = [np.nan_to_num(mean - low), np.nan_to_num(high - mean)]
    axis.errorbar(x, mean, yerr=around, linestyle="none", capsize=2, **_look(agent))
    _draw_lost(axis, agent, x, tallies)


def _ends(tallies: Sequence[Tally]) -> Array:
    """Return lower ends, means and upper ends, shape (3, N)."""
    ends = [(tally.mean.low, tally.mean.mean, tally.mean.high) for tally in tallies]
    return np.array(ends, float).reshape(-1, 3).T


def _look(agent: str) -> dict[str, Any]:
    thin = agent == THIS_RUN
    return {
        "color": _colour(agent),
        "marker": _MARKERS.get(agent, "h"),
        "markersize": 4,
        "linewidth": 0.9 if thin else 1.5,
        "zorder": 3 if thin else 2,
        "label": agent if ":" in agent else agent.replace("_", " "),
    }


def _draw_lost(axis: Axes, agent: str, x: Array, tallies: Sequence[Tally]) -> None:
    """Draw a cross at the upper edge where some of an agent's runs diverged."""
    lost = x[[tally.diverged > 0 for tally in tallies]]
    edge, colour = axis.get_xaxis_transform(), _colour(agent)
    for cross in axis.plot(lost, np.ones(len(lost)), "x", color=colour, transform=edge):
        cross.set(clip_on=False, in_layout=False)


def _colour(agent: str) -> str:
    """Return the colour of an agent; all from outside the package have the same."""
    return _COLOURS.get(agent, _OUTSIDE)


def _order(axis: Axes, disturbance: Disturbance, beyond: Sequence[Level]) -> None:
    """Let what is harder be on the right, and say where the arms cannot follow."""
    first, *_, last = map(float, disturbance.levels)
    if first > last:
        axis.invert_xaxis()
    for level in beyond:
        axis.axvline(float(level), color="0.6", linestyle=":")
        axis.annotate(
            "beyond the arms",
            (float(level), 0.5),
            xycoords=("data", "axes fraction"),
            xytext=(-3, 0),
            textcoords="offset points",
            rotation=90,
            ha="right",
            va="center",
            fontsize="small",
            color="0.4",
        )


def _shown(level: Level) -> str:
    """Return a level's name on so many lines that there is room for it."""
    return printable(Path(str(level)).stem).replace("_", "\n").replace("-", "\n")
