"""Figure of the study `agents`: p_e of every agent, with both kinds of arms."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import get_args

import numpy as np
from matplotlib.axes import Axes

from mpma_mj.evaluation.statistics import interval
from mpma_mj.experiments.points import draw_points
from mpma_mj.experiments.training import short
from mpma_mj.options import Arms
from mpma_mj.visualization.colours import module_colours
from mpma_mj.visualization.figure_file import figure_file, label_decades

__all__ = ["write_figure"]

_MAX_COLUMNS = 3
_OFFSET = 0.17  # of both kinds of arms from the middle between them
_SPREAD = 0.12  # half the width over which runs are laid


def write_figure(path: Path, p_e: Mapping[tuple[str, ...], Sequence[float]]) -> None:
    """Draw p_e of every agent, a panel for each motion.

    Args:
        path: The PNG file.
        p_e: p_e of each run, percent, by motion, kind of arms and agent.
    """
    motions = list(dict.fromkeys(motion for motion, _, _ in p_e))
    columns = min(len(motions), _MAX_COLUMNS)
    rows = math.ceil(len(motions) / columns)
    with figure_file(path, 1.6 + 4.2 * columns, 0.6 + 3.2 * rows) as figure:
        axes = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
        for axis, motion in itertools.zip_longest(axes.flat, motions):
            if motion is None:
                axis.set_visible(False)
                continue
            own = {(arms, agent): runs for (m, arms, agent), runs in p_e.items() if m == motion}
            _draw(axis, own)
            axis.set_title(short(motion), fontsize="medium", loc="left")
        figure.supxlabel(
            "p_e, %, and the 95 % interval of its mean; pale: each run", fontsize="small"
        )
        handles, names = axes[0, 0].get_legend_handles_labels()
        figure.legend(
            handles, names, loc="outside upper right", ncols=2, fontsize="small", frameon=False
        )


def _draw(axis: Axes, p_e: Mapping[tuple[str, str], Sequence[float]]) -> None:
    """Draw one motion, a row for each agent."""
    agents = list(dict.fromkeys(agent for _, agent in p_e))
    kinds: tuple[str, ...] = get_args(Arms)
    for kind, colour, side in zip(kinds, module_colours(2), (-_OFFSET, _OFFSET), strict=True):
        own = {
            agents.index(agent) + side: runs for (arms, agent), runs in p_e.items() if arms == kind
        }
        for place, runs in own.items():
            places = place + np.linspace(-_SPREAD, _SPREAD, max(len(runs), 2))[: len(runs)]
            axis.plot(runs, places, ".", color=colour, alpha=0.35, markeredgewidth=0, markersize=6)
        found = [interval(runs) for runs in own.values()]
        draw_points(axis, np.array([*own]), found, colour, label=f"{kind} arms", horizontal=True)
    axis.set_xscale("log")
    names = [agent if ":" in agent else agent.replace("_", " ") for agent in agents]
    axis.set_yticks(range(len(agents)), names)
    axis.set_ylim(len(agents) - 0.5, -0.5)
    label_decades(axis.xaxis)
    axis.grid(axis="x", color="0.92")
    axis.set_axisbelow(True)
    axis.tick_params(labelsize="small")
    axis.spines[["top", "right"]].set_visible(False)
