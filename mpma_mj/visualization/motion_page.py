"""Page of figures of a recording."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from mpma_mj import joint_paths, kinematics
from mpma_mj.arm_kinematics import TWO_ARMS
from mpma_mj.motions.feasibility import CHANGED, JointLimits, joint_speeds, turned
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.motion import Motion
from mpma_mj.visualization.colours import DEMONSTRATED, INK, module_colours
from mpma_mj.visualization.figure_file import MOST_NAMED_RUNS, figure_file
from mpma_mj.visualization.responsibility_strip import label_runs

__all__ = ["write_page"]

Array = NDArray[np.float64]

_FIGURES = 9  # of the storyboard
_SPACING = 1.25  # m between them
_ABOVE: dict[str, Any] = {
    **{"loc": "lower right", "bbox_to_anchor": (1.0, 0.97), "fontsize": "x-small"},
    **{"frameon": False, "borderaxespad": 0.0},
}  # a legend above the axes, where it hides no curve
_SIDE_COLOURS = ("#0072b2", "#d55e00")  # left, right
_SHOULDERS = np.array([[0.0, 0.18, 0.0], [0.0, -0.18, 0.0]])  # m, of the stick figure
_LEAST = 0.2  # rad that an axis of angles spans at least, or rounding errors fill it
_LENGTHS = (0.3, 0.27)  # m: upper arm, forearm


def write_page(path: Path, motion: Motion, report: ImportReport, limits: JointLimits) -> None:
    """Write a page: storyboard, joint angles, joint speeds and their limits, context, gaps.

    Args:
        path: The `.png` file.
        motion: The motion.
        report: Times and gaps of its recording.
        limits: Limits of the arms.
    """
    times = report.times
    with figure_file(path, 11.0, 10.5) as figure:
        grid = figure.add_gridspec(6, 1, height_ratios=[1.7, 2.0, 2.0, 2.0, 2.0, 0.9])
        story = figure.add_subplot(grid[0])
        rows = [figure.add_subplot(grid[i]) for i in range(1, 6)]
        _draw_story(story, motion.posture, times)
        angles = motion.joint_angles
        original = None
        arms = limits.kinematics
        if arms == TWO_ARMS and turned(motion).max() > CHANGED:
            original = joint_paths.held_angles(motion.posture)
        speeds = joint_speeds(motion) / limits.max_speed
        for side, name in enumerate(kinematics.SIDES):
            for joint in range(4):
                column = 4 * side + joint
                label = arms.joint_names[column].removeprefix(f"{name}_").replace("_", " ")
                rows[side].plot(
                    times, angles[:, column], color=f"C{joint}", linewidth=1, label=label
                )
                if original is not None:
                    rows[side].plot(
                        times, original[:, column], color=f"C{joint}", linewidth=0.8, linestyle=":"
                    )
                rows[2 + side].plot(times[1:], speeds[:, column], color=f"C{joint}", linewidth=1)
            rows[side].set_ylabel(f"{name} arm\nangle, rad")
            low, high = rows[side].get_ylim()
            rows[side].set_ylim(min(low, high - _LEAST), max(high, low + _LEAST))
            rows[2 + side].axhline(1.0, color=INK, linestyle="--", linewidth=0.8)
            rows[2 + side].set_ylabel(f"{name} arm\nspeed / limit")
            rows[2 + side].set_ylim(0.0, max(1.1, 1.05 * float(speeds.max())))
        _draw_context(rows[4], motion.context, motion.labels, times)
        for row in rows:
            row.set_xlim(times[0], times[-1])
            row.spines[["top", "right"]].set_visible(False)
            if row is not rows[-1]:
                row.tick_params(labelbottom=False)
                _shade_gaps(row, report)
        rows[0].legend(**_ABOVE, ncols=4)
        notes = ["time in the recording, s"]
        if original is not None:
            notes.append("dotted: angles of the recording, which the arms cannot follow")
        most = float(turned(motion, arms).max())
        if arms != TWO_ARMS and most > CHANGED:
            notes.append(f"figures: the recording, from which the robot is up to {most:.0f}° off")
        if report.gaps:
            notes.append("grey: gaps")
        rows[-1].set_xlabel("; ".join(notes))
        figure.suptitle(f"{motion.name}: {motion.source}", fontsize="medium")


def _draw_story(axis: Axes, posture: Array, times: Array) -> None:
    """Draw stick figures from the front, evenly spread over time."""
    chosen = np.unique(np.linspace(0, len(posture) - 1, _FIGURES).round().astype(int))
    segments = posture.reshape(-1, 2, 2, 3)
    for place, frame in enumerate(chosen):
        for side, colour in enumerate(_SIDE_COLOURS):
            elbow = _SHOULDERS[side] + _LENGTHS[0] * segments[frame, side, 0]
            wrist = elbow + _LENGTHS[1] * segments[frame, side, 1]
            points = np.stack([_SHOULDERS[side], elbow, wrist])
            # In the view from the front the left arm is on the right.
            axis.plot(place * _SPACING + points[:, 1], points[:, 2], color=colour, linewidth=2.5)
            axis.plot(place * _SPACING + wrist[1], wrist[2], "o", color=colour, markersize=4)
        axis.plot(place * _SPACING + _SHOULDERS[:, 1], _SHOULDERS[:, 2], color=DEMONSTRATED, lw=2.5)
        axis.plot([place * _SPACING] * 2, [0.0, -0.5], color=DEMONSTRATED, linewidth=2.5)
        axis.plot(place * _SPACING, 0.18, "o", color=DEMONSTRATED, markersize=11)
        axis.text(place * _SPACING, -0.85, f"{times[frame]:.1f} s", ha="center", fontsize="small")
    axis.set(aspect="equal", ylim=(-0.95, 0.75))
    axis.set_axis_off()
    for name, colour in zip(kinematics.SIDES, _SIDE_COLOURS, strict=True):
        axis.plot([], color=colour, linewidth=2.5, label=f"{name} arm")
    axis.legend(**_ABOVE, ncols=2)


def _draw_context(axis: Axes, context: Array, labels: tuple[str, ...], times: Array) -> None:
    """Draw a band for each label; where labels overlap, they stand above each other."""
    colours = module_colours(len(labels))
    for number, colour in enumerate(colours):
        active = context[:, number] > 0
        axis.fill_between(
            times, number, number + active, step="post", color=colour, alpha=0.6, linewidth=0
        )
    runs = label_runs(context)
    if len(runs) <= MOST_NAMED_RUNS:
        for label, start, end in runs:
            middle = 0.5 * (times[start] + times[min(end, len(times) - 1)])
            axis.text(middle, label + 0.5, labels[label], ha="center", va="center", fontsize=7)
    axis.set(ylim=(0, len(labels)), yticks=[], ylabel="context")


def _shade_gaps(axis: Axes, report: ImportReport) -> None:
    for gaps in report.gaps.values():
        for start, end in gaps:
            axis.axvspan(start, end, color="0.85", zorder=0)
