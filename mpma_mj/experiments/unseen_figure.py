"""Figure of the study `unseen`: p_e of agents in motions that they have not learned."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from mpma_mj.evaluation.statistics import Interval
from mpma_mj.experiments.points import draw_points
from mpma_mj.visualization.colours import DEMONSTRATED, module_colours
from mpma_mj.visualization.figure_file import figure_file

__all__ = ["write_figure"]

_SPREAD = 0.5  # of the place of a motion, over which agents are laid side by side


def write_figure(
    path: Path, p_e: Mapping[str, Sequence[Interval]], titles: Sequence[str], reference: str
) -> None:
    """Draw a point with its interval for each agent and motion.

    Args:
        path: The PNG file.
        p_e: p_e in each motion, percent, by agent.
        titles: Names of the motions.
        reference: Agent with which the others are compared.
    """
    places, offsets = np.arange(len(titles)), np.linspace(-0.5, 0.5, len(p_e)) * _SPREAD
    with figure_file(path, 3.0 + 1.3 * len(titles), 4.0) as figure:
        axis = figure.add_subplot()
        colours = module_colours(len(p_e))
        for (agent, found), own, offset in zip(p_e.items(), colours, offsets, strict=True):
            colour = DEMONSTRATED if agent == reference else own
            draw_points(axis, places + offset, found, colour, label=agent)
        axis.set_xticks(places, titles)
        axis.set_xlabel("motion left out")
        axis.set_ylabel("p_e without learning, %")
        axis.set_ylim(0)
        axis.grid(axis="y", color="0.9")
        axis.set_axisbelow(True)
        axis.spines[["top", "right"]].set_visible(False)
        figure.legend(loc="outside upper center", ncols=len(p_e), frameon=False)
