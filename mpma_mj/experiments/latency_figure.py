"""Figure of the study `latency`: p_e of agents with several latencies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from mpma_mj.evaluation.statistics import Interval
from mpma_mj.experiments.points import draw_points
from mpma_mj.visualization.colours import module_colours
from mpma_mj.visualization.figure_file import figure_file, label_decades

__all__ = ["write_figure"]

_SPREAD = 0.5  # of the place of a latency, over which agents are laid side by side


def write_figure(path: Path, p_e: Mapping[str, Sequence[Interval]], titles: Sequence[str]) -> None:
    """Draw a point with its interval for each agent and latency.

    Args:
        path: The PNG file.
        p_e: p_e with each latency, percent, by agent.
        titles: Names of the latencies.
    """
    places, offsets = np.arange(len(titles)), np.linspace(-0.5, 0.5, len(p_e)) * _SPREAD
    with figure_file(path, 3.0 + 1.1 * len(titles), 4.5) as figure:
        axis = figure.add_subplot()
        colours = module_colours(len(p_e))
        for (agent, found), colour, offset in zip(p_e.items(), colours, offsets, strict=True):
            draw_points(axis, places + offset, found, colour, label=agent)
        axis.set_xticks(places, [title.replace(" ", "\n", 1) for title in titles])
        axis.set_xlabel("latency, control steps")
        axis.set_ylabel("p_e, %")
        axis.set_yscale("log")
        label_decades(axis.yaxis)
        axis.grid(axis="y", color="0.9")
        axis.set_axisbelow(True)
        axis.spines[["top", "right"]].set_visible(False)
        figure.legend(loc="outside upper center", ncols=3, frameon=False)
