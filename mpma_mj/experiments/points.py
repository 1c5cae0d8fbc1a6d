"""Figures of means with their intervals, a point for each agent at each place."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mpma_mj.evaluation.statistics import Interval
from mpma_mj.visualization.colours import DEMONSTRATED, PAPER, module_colours
from mpma_mj.visualization.figure_file import figure_file, label_decades

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["draw_points", "write_points"]

_SPREAD = 0.5  # of the distance of places, over which agents are laid


def draw_points(
    axis: Axes,
    places: NDArray[np.float64],
    found: Sequence[Interval],
    colour: str,
    *,
    label: str = "",
    filled: bool = True,
    horizontal: bool = False,
) -> None:
    """Draw the mean of each interval, and its ends where there are some.

    Args:
        axis: The axes.
        places: Where each is drawn, shape (N,).
        found: N intervals.
        colour: Colour of all.
        label: Name of all in a legend; none if not given.
        filled: Whether points are filled.
        horizontal: Whether values are on the horizontal axis.
    """
    means = np.array([one.mean for one in found])
    ends = np.array([[one.low, one.high] for one in found]).T
    length = np.nan_to_num(np.abs(ends - means))  # none where a single seed has no interval
    style: dict[str, Any] = {
        "fmt": "o",
        "color": colour,
        "markerfacecolor": colour if filled else PAPER,
        "label": label or None,
        "capsize": 2.5,
    }
    if horizontal:
        axis.errorbar(means, places, xerr=length, **style)
    else:
        axis.errorbar(places, means, yerr=length, **style)


def write_points(
    path: Path,
    found: Mapping[str, Sequence[Interval]],
    titles: Sequence[str],
    labels: tuple[str, str],
    *,
    reference: str = "",
    log: bool = False,
) -> None:
    """Draw a figure with a point for each agent at each place.

    Args:
        path: The PNG file.
        found: An interval at each place, by agent.
        titles: Names of the places.
        labels: Names of the axes.
        reference: Agent with which the others are compared; none if not given.
        log: Whether values are on a logarithmic axis.
    """
    places, offsets = np.arange(len(titles)), np.linspace(-0.5, 0.5, len(found)) * _SPREAD
    with figure_file(path, 3.0 + 1.2 * len(titles), 4.5) as figure:
        axis = figure.add_subplot()
        colours = module_colours(len(found))
        for (agent, own), colour, offset in zip(found.items(), colours, offsets, strict=True):
            colour = DEMONSTRATED if agent == reference else colour
            draw_points(axis, places + offset, own, colour, label=agent)
        axis.set_xticks(places, titles)
        axis.set_xlabel(labels[0])
        axis.set_ylabel(labels[1])
        if log:
            axis.set_yscale("log")
            label_decades(axis.yaxis)
        else:
            axis.set_ylim(0)
        axis.grid(axis="y", color="0.9")
        axis.set_axisbelow(True)
        axis.spines[["top", "right"]].set_visible(False)
        figure.legend(loc="outside upper center", ncols=3, frameon=False)
