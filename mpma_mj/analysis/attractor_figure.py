"""The figure of a dance that goes on without its demonstration.

Drawn with matplotlib's objects alone, without its global state.
"""

from __future__ import annotations

import functools
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from mpma_mj.analysis.attractor import FreeDance
from mpma_mj.analysis.freedom import LOST, error_over_time, nearest_over_time
from mpma_mj.arm import SEGMENT_NAMES
from mpma_mj.files import write_whole
from mpma_mj.motions import Motion
from mpma_mj.training.colours import DEMONSTRATED, INK, module_colours

__all__ = ["write_figure"]

_DPI = 110
_COLOURS = ("C3", "C2", "C0")  # of x, y and z, as in trajectory.png


def write_figure(path: Path, free: FreeDance, motion: Motion) -> None:
    """Draw all segments' directions, demonstrated and danced, and the errors over time.

    Args:
        path: The PNG file.
        free: What was danced.
        motion: The movement that had been learned.
    """
    figure = Figure(figsize=(9.0, 8.6), layout="constrained")
    axes = figure.subplots(5, 1, sharex=True)
    time = np.arange(len(free.posture)) / free.rate
    for number, (axis, segment) in enumerate(zip(axes, SEGMENT_NAMES, strict=False)):
        for part, colour in enumerate(_COLOURS):
            column = 3 * number + part
            shown, danced = free.reference[:, column], free.posture[:, column]
            axis.plot(time, shown, color=DEMONSTRATED, linewidth=2.5, alpha=0.6)
            axis.plot(time, danced, color=colour, linewidth=1.2, label="xyz"[part])
        axis.set(ylim=(-1.08, 1.08), ylabel=segment.replace("_", " "))
    axes[0].plot([], color=DEMONSTRATED, linewidth=2.5, alpha=0.6, label="would be demonstrated")
    error_colour, nearest_colour = module_colours(2)
    axes[4].plot(time, error_over_time(free), color=error_colour, label="error now")
    nearest = nearest_over_time(free, free.posture)
    axes[4].plot(time, nearest, color=nearest_colour, label="to the nearest of the label")
    axes[4].axhline(LOST, color=INK, linestyle="--", linewidth=0.8, label=f"{LOST:g} %: lost")
    axes[4].set(ylabel="error, %", xlabel="time since the demonstration was taken away, s")
    axes[4].set_ylim(bottom=0.0)
    for axis in axes:
        for repetition in range(free.period, len(time), free.period):
            axis.axvline(repetition / free.rate, color="0.85", linewidth=1.0, zorder=0)
        axis.margins(x=0)
        axis.spines[["top", "right"]].set_visible(False)
    for axis, columns in ((axes[0], 4), (axes[4], 3)):
        axis.legend(
            loc="lower center",
            bbox_to_anchor=(0.5, 1.0),
            ncols=columns,
            fontsize="small",
            frameon=False,
        )
    figure.suptitle(f"Dancing without the demonstration ({motion.name})", fontsize="medium")
    write_whole(path, functools.partial(figure.savefig, dpi=_DPI))
