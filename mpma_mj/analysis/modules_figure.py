"""Figure of the analysis of modules."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from mpma_mj.analysis.information import Estimate, ResponsibilityInformation
from mpma_mj.analysis.modules import ModuleAnalysis, Repetition
from mpma_mj.analysis.synergies import ENOUGH, Synergies
from mpma_mj.motions import Motion
from mpma_mj.visualization.colours import INK, module_colours
from mpma_mj.visualization.figure_file import figure_file

__all__ = ["write_figure"]

Array = NDArray[np.float64]

_MOST_NUMBERED = 8  # with more modules the numbers in the cells would touch
_DARK = 0.5  # least share that is drawn black, so that shares that are all alike look alike
_HEIGHTS = (1.3, 1.0, 1.0, 1.3, 0.8)  # of the panels on the right, relative
_ROW = 0.19  # height of a row of shares, inches
_SMALL: dict[str, Any] = {"fontsize": "x-small", "frameon": False, "borderaxespad": 0.2}
_CHANCE: dict[str, Any] = {"marker": "|", "color": "#d55e00", "markersize": 11, "mew": 2, "ls": ""}


def write_figure(path: Path, analysis: ModuleAnalysis, motion: Motion) -> None:
    """Write the figure: shares, information, synergies, repetitions.

    Args:
        path: The PNG file.
        analysis: The analysis.
        motion: The motion that was imitated.
    """
    rows = sum(len(names) for names in analysis.shares.values())
    with figure_file(path, 11.0, max(10.5, 1.5 + _ROW * rows)) as figure:
        grid = figure.add_gridspec(5, 2, width_ratios=[1.0, 1.25], height_ratios=_HEIGHTS)
        _draw_shares(figure.add_subplot(grid[:, 0]), analysis)
        panels = [figure.add_subplot(grid[row, 1]) for row in range(5)]
        _draw_information(panels[0], analysis.information)
        _draw_variance(panels[1], analysis.synergies)
        _draw_loads(panels[2], analysis.synergies, analysis.module_output)
        _draw_repetitions(panels[3], analysis.repetition, motion.rate)
        _draw_recurrence(panels[4], analysis.repetition, motion.rate)
        for panel in panels:
            panel.spines[["top", "right"]].set_visible(False)
        figure.suptitle(f"Modules ({motion.name})", fontsize="medium")


def _draw_shares(axis: Axes, analysis: ModuleAnalysis) -> None:
    """Draw a cell for each share and module."""
    kinds = analysis.shares
    table = np.array([share for names in kinds.values() for share in names.values()])
    darkest = max(_DARK, float(np.nanmax(table)))
    axis.imshow(table, cmap="Greys", vmin=0.0, vmax=darkest, aspect="auto")
    names = [
        f"{kind} {name}" if kind in ("label", "posture region") else name or "all steps"
        for kind, rows in kinds.items()
        for name in rows
    ]
    axis.set_yticks(range(len(names)), [name.replace("_", " ") for name in names], fontsize=8)
    modules = table.shape[1]
    axis.xaxis.tick_top()
    axis.set_xticks(range(modules), [str(i + 1) for i in range(modules)])
    for tick, colour in zip(axis.get_xticklabels(), module_colours(modules), strict=True):
        tick.set(color=colour, fontweight="bold")
    if modules <= _MOST_NUMBERED:
        for (row, module), share in np.ndenumerate(table):
            text = "" if np.isnan(share) else f"{100.0 * share:.0f}"
            colour = "white" if share > 0.5 * darkest else INK
            axis.text(module, row, text, ha="center", va="center", color=colour, fontsize=8)
    for end in np.cumsum([len(rows) for rows in kinds.values()])[:-1]:
        axis.axhline(end - 0.5, color=INK, linewidth=0.8)
    axis.set_title("Share of each module, %", fontsize="medium")
    axis.tick_params(length=0)


def _draw_information(axis: Axes, information: ResponsibilityInformation) -> None:
    """Draw the information in each source, as a share, and a mark at that by chance."""
    entropy = information.entropy_bits[0] if information.entropy_bits[0] > 0 else np.nan
    shares: tuple[tuple[str, str, dict[str, Estimate], float], ...] = (
        ("R² of a linear readout", "#7f7f7f", information.r2, 1.0),
        ("bits / entropy of the dominant module", "#d9d9d9", information.bits, entropy),
    )
    for number, (name, colour, measures, whole) in enumerate(shares):
        place = np.arange(len(measures)) + 0.38 * (number - 0.5)
        value = np.array([measure.value[0] for measure in measures.values()]) / whole
        chance = np.array([measure.by_chance[0] for measure in measures.values()]) / whole
        axis.barh(place, value, 0.36, color=colour, edgecolor=INK, linewidth=0.5, label=name)
        label = "by chance" if number == 0 else None
        axis.plot(chance, place, label=label, **_CHANCE)
    axis.set_yticks(range(len(information.r2)), list(information.r2))
    axis.set_ylim(len(information.r2) - 0.5, -0.5)
    axis.axvline(0.0, color=INK, linewidth=0.8)
    axis.set_title("Information about responsibility", fontsize="medium", pad=20)
    axis.legend(loc="lower center", bbox_to_anchor=(0.4, 0.98), ncols=3, **_SMALL)
    axis.set_xlim(right=1.05)


def _draw_variance(axis: Axes, synergies: Synergies) -> None:
    explained = 100.0 * synergies.variance_accounted_for
    enough = len(synergies.weights)
    axis.plot(np.arange(len(explained)) + 1, explained, "o-", color=INK, markersize=3.5, lw=1)
    axis.plot(enough, explained[enough - 1], "o", color="#d55e00", markersize=7)
    axis.axhline(100.0 * ENOUGH, color=INK, linestyle="--", linewidth=0.8)
    axis.set_xticks(np.arange(len(explained)) + 1)
    axis.set(ylim=(0.0, 105.0), xlabel="number of synergies", ylabel="variance\naccounted for, %")
    axis.set_title("Synergies in the modules' motor outputs", fontsize="medium")


def _draw_loads(axis: Axes, synergies: Synergies, output: Array) -> None:
    """Draw a bar for each synergy, divided among modules, and one for all motor output."""
    loads = np.concatenate([synergies.loads, output[None]])
    names = [*(str(k + 1) for k in range(len(synergies.loads))), "all"]
    below = np.zeros(len(loads))
    for load, colour in zip(loads.T, module_colours(len(output)), strict=True):
        axis.bar(range(len(loads)), 100.0 * load, 0.75, bottom=100.0 * below, color=colour)
        below = below + load
    axis.set_xticks(range(len(loads)), names)
    axis.set(ylim=(0.0, 100.0), xlabel="synergy", ylabel="in each\nmodule, %")


def _draw_repetitions(axis: Axes, repetition: Repetition, rate: float) -> None:
    _, period, modules = repetition.repetitions.shape
    time = np.arange(period) / rate
    for module, colour in enumerate(module_colours(modules)):
        for course in repetition.repetitions[:, :, module]:
            axis.plot(time, course, color=colour, linewidth=1.0, alpha=0.6)
    axis.set(ylim=(-0.03, 1.05), xlabel="time in a repetition, s", ylabel="λ")
    axis.margins(x=0)
    axis.set_title("λ of all repetitions", fontsize="medium")


def _draw_recurrence(axis: Axes, repetition: Repetition, rate: float) -> None:
    lag = np.arange(len(repetition.recurrence)) / rate
    axis.plot(lag, repetition.recurrence, color=INK, linewidth=1.2)
    axis.axvline(repetition.period / rate, color="#d55e00", linestyle="--", linewidth=1.0)
    axis.set(ylim=(0.0, 1.05), xlabel="lag, s; dashed: one repetition", ylabel="similarity\nof λ")
    axis.margins(x=0)
