"""The comparison of arms as pictures."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpma_mj.envs.physics import PhysicsArms
from mpma_mj.experiments.compare import ARMS, Cell, Dance
from mpma_mj.kinematics import SIDES
from mpma_mj.metrics import error_over_time
from mpma_mj.motions import Motion
from mpma_mj.trace import Trace
from mpma_mj.visualization.colours import DEMONSTRATED, module_colours
from mpma_mj.visualization.figure_file import draw_labels, figure_file

__all__ = ["SHOWN", "first_dances", "write_dances", "write_transfer"]

Array = NDArray[np.float64]

SHOWN = {
    ("kinematic", "kinematic"): "ideal arms",
    ("kinematic", "physics"): "learned on ideal arms, at once on physics",
    ("physics", "physics"): "physics",
    ("compensated", "compensated"): "physics, weight carried",
}
"""Which pairs of arms, learned and danced on, stand for all, and what they are called."""

_WRIST, _UP = 2, 2  # in what `site_positions` returns


def first_dances(cells: Sequence[Cell]) -> dict[str, Dance]:
    """Return the first seed's dances of `SHOWN` by what they are called; of those that are."""
    dances = {(cell.learned, cell.danced): cell.dances[0] for cell in cells}
    return {name: dance for pair, name in SHOWN.items() if (dance := dances[pair]) is not None}


def write_transfer(path: Path, cells: Sequence[Cell], adaptation: int) -> None:
    """Draw p_e on each kind of arms after learning on each, at once and after learning on.

    Args:
        path: The PNG file.
        cells: What was found.
        adaptation: Number of epochs that agents learned on.
    """
    count = len(ARMS)
    learned = [cell for cell in cells if cell.learned in ARMS]
    at_once = [_mean(cell.values("p_e_percent")) for cell in learned]
    adapted = [_mean(cell.adapted[np.isfinite(cell.adapted)].tolist()) for cell in learned]
    titles = {"at once": at_once, f"after {adaptation} epochs there": adapted}
    with figure_file(path, 8.0, 3.9) as figure:
        axes = figure.subplots(1, 2, sharey=True)
        top = max(filter(math.isfinite, [*at_once, *adapted]), default=1.0)
        for axis, (title, values) in zip(axes, titles.items(), strict=True):
            matrix = np.reshape(values, (count, count))
            axis.imshow(matrix, cmap="Blues", vmin=0.0, vmax=1.6 * top)
            for row, column in np.ndindex(count, count):
                text = f"{matrix[row, column]:.2f} %" if np.isfinite(matrix[row, column]) else "–"
                axis.text(column, row, text, ha="center", va="center")
            axis.set_title(title, fontsize="medium")
            axis.set_xticks(range(count), list(ARMS))
            axis.set_yticks(range(count), list(ARMS))
            axis.set_xlabel("danced on")
            axis.spines[:].set_visible(False)
            axis.tick_params(length=0)
        axes[0].set_ylabel("learned on")
        figure.suptitle("p_e: what is learned on one kind of arms, on another", fontsize="medium")


def write_dances(path: Path, cells: Sequence[Cell], motion: Motion) -> None:
    """Draw one repetition: the wrists' height, the error, and the torque.

    Args:
        path: The PNG file.
        cells: What was found.
        motion: The movement.
    """
    with figure_file(path, 9.0, 9.0) as figure:
        axes = figure.subplots(4, 1, sharex=True)
        colours = dict(zip(SHOWN.values(), module_colours(len(SHOWN)), strict=True))
        steps = len(motion)
        time = np.arange(steps) / motion.rate
        for name, dance in first_dances(cells).items():
            arms = PhysicsArms.make(dance.options)
            heights = arms.site_positions(dance.trace.posture[:steps])[:, :, _WRIST, _UP]
            wanted = arms.site_positions(dance.trace.reference[:steps])[:, :, _WRIST, _UP]
            for axis, side, height, demonstrated in zip(
                axes, SIDES, heights.T, wanted.T, strict=False
            ):
                if name == SHOWN["kinematic", "kinematic"]:
                    axis.plot(time, demonstrated, color=DEMONSTRATED, linewidth=4, alpha=0.6)
                axis.plot(time, height, color=colours[name], linewidth=1.2)
                axis.set_ylabel(f"{side} wrist's\nheight, m")
        for cell in cells:
            name = SHOWN.get((cell.learned, cell.danced), "")
            dances = [dance for dance in cell.dances if dance]
            if not (name and dances):
                continue
            errors = np.mean([_errors(dance.trace) for dance in dances], axis=0)
            axes[2].plot(time, errors[:steps], color=colours[name], linewidth=1.2, label=name)
            torques = [_torque_over_time(dance, motion.rate) for dance in dances if dance.effort]
            if torques:
                torque = np.mean(torques, axis=0)
                axes[3].plot(
                    time[: len(torque)], torque[:steps], color=colours[name], linewidth=1.2
                )
        axes[2].set(ylabel=f"error, %,\nmean of {len(cells[0].seeds)} seeds", ylim=(0.0, None))
        axes[3].set(ylabel="torque, N m,\nmean of joints", ylim=(0.0, None), xlabel="time, s")
        axes[0].plot([], color=DEMONSTRATED, linewidth=4, alpha=0.6, label="demonstrated")
        draw_labels(axes, motion.context, motion.labels, motion.rate)
        figure.suptitle(f"The first repetition of {motion.name}", fontsize="medium")
        figure.legend(loc="outside lower center", ncols=3, fontsize="small")


def _errors(trace: Trace) -> Array:
    return error_over_time(trace.posture, trace.reference)


def _torque_over_time(dance: Dance, rate: float) -> Array:
    """Return the mean size of the joints' torques in each control step, shape (T,), N m."""
    assert dance.effort is not None
    substeps = round(1.0 / rate / dance.effort.timestep)
    size = np.abs(dance.effort.torque).mean(axis=1)
    return size.reshape(-1, substeps).mean(axis=1)


def _mean(values: Sequence[float]) -> float:
    return float(np.mean(values)) if len(values) else float("nan")
