"""Figures 3a, 3b and 4 of the paper, for a run."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Sequence
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from mpma_mj.kinematics import JOINT_NAMES, SEGMENT_NAMES
from mpma_mj.motions import Motion
from mpma_mj.trace import Trace
from mpma_mj.visualization.colours import DEMONSTRATED, module_colours
from mpma_mj.visualization.figure_file import draw_labels, figure_file, fitting

__all__ = ["write_figures"]

Array = NDArray[np.float64]

_WIDTH, _TITLE = 9.0, 7.6  # inches; a title is as wide as axes at most
_COLUMNS = 4  # of a legend
_TICKS = 12.0 / 72.0  # inches of ticks and the space around their labels, in any size of font


def write_figures(
    folder: Path,
    trace: Trace,
    motion: Motion,
    *,
    plants: int = 1,
    joints: Sequence[str] = JOINT_NAMES,
) -> None:
    """Write the figures of the best epoch.

    `responsibility.png` is the paper's figure 3a (λ and the responsibility predictors' output
    over time), `module_output.png` 3b (each module's share of the motor output) and
    `trajectory.png` 4 (desired against actual trajectories). An agent without modules has the
    last only.

    Args:
        folder: Folder of the figures.
        trace: Trace of the epoch, of an agent with modules.
        motion: The motion that was imitated.
        plants: Number of plants that were recruited, each with the same number of modules.
        joints: Names of the joints.
    """
    _trajectory(folder / "trajectory.png", trace, motion)
    if trace.modules is not None:
        names = _module_names(trace.modules.responsibility.shape[1], plants)
        _responsibility(folder / "responsibility.png", trace, motion, names)
        _module_output(folder / "module_output.png", trace, motion, names, joints)


def _module_names(modules: int, plants: int) -> list[str]:
    """Return the name of each module, with its plant where there are several."""
    names = [f"module {i + 1}" for i in range(modules)]
    if plants == 1:
        return names
    return [f"{name}\nplant {i * plants // modules + 1}" for i, name in enumerate(names)]


def _responsibility(path: Path, trace: Trace, motion: Motion, names: Sequence[str]) -> None:
    """Draw figure 3a: a row for each module."""
    responsibility, prior = trace.with_modules().responsibility, trace.with_modules().prior
    share = prior / prior.sum(axis=1, keepdims=True)
    steps, modules = responsibility.shape
    time = np.arange(steps) / motion.rate
    title = "Responsibility λ and responsibility predictors' output"
    with _rows(path, modules, 1.1, trace, motion, title) as axes:
        for i, (axis, colour) in enumerate(zip(axes, module_colours(modules), strict=True)):
            axis.fill_between(time, responsibility[:, i], color=colour, alpha=0.35, linewidth=0)
            axis.plot(time, responsibility[:, i], color=colour, linewidth=1.2, label="λ")
            axis.plot(time, share[:, i], "--", color="black", linewidth=0.8, label="RP output")
            axis.set(ylim=(-0.03, 1.03), ylabel=names[i])


def _module_output(
    path: Path, trace: Trace, motion: Motion, names: Sequence[str], joint_names: Sequence[str]
) -> None:
    """Draw figure 3b: a row for each module, a line for each joint."""
    output = trace.with_modules().responsibility[:, :, None] * trace.with_modules().module_actions
    steps, modules, joints = output.shape
    time = np.arange(steps) / motion.rate
    colours = [f"C{j}" for j in range(joints // 2)] * 2
    limit = 1.05 * max(0.1, float(np.max(np.abs(output))))
    title = "Motor output of the modules, λ times action"
    with _rows(path, modules, 1.3, trace, motion, title) as axes:
        for i, axis in enumerate(axes):
            for j in range(joints):
                style = "-" if j < joints // 2 else ":"
                label = joint_names[j].replace("_", " ")
                axis.plot(time, output[:, i, j], style, color=colours[j], linewidth=1, label=label)
            axis.set(ylim=(-limit, limit), ylabel=names[i])


def _trajectory(path: Path, trace: Trace, motion: Motion) -> None:
    """Draw figure 4: desired and actual directions of all segments."""
    posture, reference = trace.posture, trace.reference
    time = np.arange(len(posture)) / motion.rate
    title = "Desired and actual trajectory, as directions of the segments"
    with _rows(path, 4, 1.5, trace, motion, title) as axes:
        for i, (axis, segment) in enumerate(zip(axes, SEGMENT_NAMES, strict=True)):
            name = segment.replace("_", " ")
            for d, colour in enumerate(("C3", "C2", "C0")):
                column = 3 * i + d
                axis.plot(time, reference[:, column], color=DEMONSTRATED, linewidth=3, alpha=0.6)
                axis.plot(time, posture[:, column], color=colour, linewidth=1, label="xyz"[d])
            axis.set(ylim=(-1.08, 1.08), ylabel=name)
        axes[0].plot([], color=DEMONSTRATED, linewidth=3, alpha=0.6, label="desired")


@contextlib.contextmanager
def _rows(
    path: Path, count: int, height: float, trace: Trace, motion: Motion, title: str
) -> Iterator[list[Axes]]:
    """Yield axes over time in rows; then add labels, title and legend, and save the figure."""
    with figure_file(path, _WIDTH, 1.2 + height * count, layout=None) as figure:
        axes = list(figure.subplots(count, 1, sharex=True, squeeze=False)[:, 0])
        yield axes
        draw_labels(axes, trace.context[:-1], motion.labels, motion.rate)
        size = matplotlib.rcParams["font.size"]
        whole = fitting(f"{title} ({motion.name})", _TITLE)
        axes[0].set_title(whole, pad=2 * size, fontsize="medium")
        axes[-1].set_xlabel("time, s")
        handles, names = axes[0].get_legend_handles_labels()
        figure.legend(handles, names, loc="lower center", ncols=_COLUMNS, fontsize="small")
        _set_margins(figure, axes, -(-len(names) // _COLUMNS))


def _set_margins(figure: Figure, axes: Sequence[Axes], legend_rows: int) -> None:
    """Make room around rows of axes for their texts and for the legend."""
    em = matplotlib.rcParams["font.size"] / 72.0  # inches
    width, height = figure.get_size_inches()
    label_rows = max(axis.get_ylabel().count("\n") for axis in axes)
    left, right = _TICKS + (4.6 + 1.2 * label_rows) * em, 1.0 * em
    bottom, top, gap = _TICKS + (3.4 + 1.1 * legend_rows) * em, 3.2 * em, 0.9 * em
    row = (height - bottom - top + gap) / len(axes) - gap
    figure.subplots_adjust(
        left=left / width,
        right=1.0 - right / width,
        bottom=bottom / height,
        top=1.0 - top / height,
        hspace=gap / row,
    )
