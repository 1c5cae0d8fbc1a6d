"""How exactly each agent dances, as a picture."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, get_args

import numpy as np
from matplotlib.axes import Axes

from mpma_mj.experiments.agents import Line
from mpma_mj.experiments.measures import values
from mpma_mj.options import Arms
from mpma_mj.visualization.colours import module_colours
from mpma_mj.visualization.figure_file import figure_file, label_decades

__all__ = ["write_figure"]

_MEASURE = "p_e_percent"
_MOST_COLUMNS = 3
_APART = 0.17  # of both kinds of arms from the middle between them
_SPRAY = 0.12  # width over which runs are laid side by side


def write_figure(path: Path, lines: Sequence[Line]) -> None:
    """Draw p_e of every agent, a panel for each movement, both kinds of arms beside each other.

    Args:
        path: The PNG file.
        lines: The table.
    """
    panels = [
        list(group) for _, group in itertools.groupby(lines, key=lambda line: line.point.motions)
    ]
    columns = min(len(panels), _MOST_COLUMNS)
    rows = math.ceil(len(panels) / columns)
    with figure_file(path, 1.6 + 4.2 * columns, 0.6 + 3.2 * rows) as figure:
        axes = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
        for axis, panel in itertools.zip_longest(axes.flat, panels):
            if panel is None:
                axis.set_visible(False)
            else:
                _draw(axis, panel)
        figure.supxlabel(
            "p_e, %, and the 95 % interval of its mean; pale: each run", fontsize="small"
        )
        handles, names = axes[0, 0].get_legend_handles_labels()
        figure.legend(
            handles, names, loc="outside upper right", ncols=2, fontsize="small", frameon=False
        )


def _draw(axis: Axes, lines: Sequence[Line]) -> None:
    """Draw one movement, a row for each agent."""
    agents = list(dict.fromkeys(line.point.agent_name for line in lines))
    kinds: tuple[str, ...] = get_args(Arms)
    for kind, colour, side in zip(kinds, module_colours(2), (-_APART, _APART), strict=True):
        own = [line for line in lines if line.point.env.arms == kind]
        places = np.array([agents.index(line.point.agent_name) + side for line in own])
        for place, line in zip(places, own, strict=True):
            found = values(line.runs, _MEASURE)
            spray = place + np.linspace(-_SPRAY, _SPRAY, max(len(found), 2))[: len(found)]
            axis.plot(found, spray, ".", color=colour, alpha=0.35, markeredgewidth=0, markersize=6)
        intervals = [line.measures[_MEASURE] for line in own]
        mean = np.array([one.mean for one in intervals])
        low = mean - [one.low for one in intervals]
        high = [one.high for one in intervals] - mean
        look: dict[str, Any] = {
            "fmt": "o",
            "color": colour,
            "markersize": 5,
            "capsize": 3,
            "linewidth": 1.5,
        }
        axis.errorbar(mean, places, xerr=[low, high], **look, label=f"{kind} arms")
    axis.set_xscale("log")
    axis.set_yticks(
        range(len(agents)), [agent if ":" in agent else agent.replace("_", " ") for agent in agents]
    )
    axis.set_ylim(len(agents) - 0.5, -0.5)
    label_decades(axis.xaxis)
    axis.grid(axis="x", color="0.92")
    axis.set_axisbelow(True)
    axis.set_title(lines[0].motion, fontsize="medium", loc="left")
    axis.tick_params(labelsize="small")
    axis.spines[["top", "right"]].set_visible(False)
