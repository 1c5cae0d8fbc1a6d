"""Report of a comparison of arms: tables and figures."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpma_mj.envs.physics import PhysicsArms
from mpma_mj.evaluation.statistics import interval
from mpma_mj.experiments.compare import ARMS, Episode, Transfer
from mpma_mj.kinematics import SIDES
from mpma_mj.metrics import error_over_time
from mpma_mj.motions import Motion
from mpma_mj.utils.data_files import csv_text
from mpma_mj.utils.text import markdown_table
from mpma_mj.visualization.colours import DEMONSTRATED, module_colours
from mpma_mj.visualization.figure_file import draw_labels, figure_file

__all__ = [
    "SHOWN",
    "as_csv",
    "as_markdown",
    "first_episodes",
    "number",
    "write_episodes",
    "write_transfer",
]

Array = NDArray[np.float64]

# Title, name of the measure, digits after the point.
_JOINT_ERROR = re.compile(r"\brms_(\S+)_deg\b")
_COLUMNS = (
    ("mpkpe, mm", "mpkpe_mm", 1),
    ("feedback ratio", "feedback_ratio", 3),
    ("lag, ms", "lag_ms", 1),
    ("mean torque, N m", "mean_torque_nm", 2),
    ("peak torque, N m", "peak_torque_nm", 1),
    ("work, J", "work_j", 0),
)


def as_markdown(transfers: Sequence[Transfer], fine_tune: int) -> str:
    """Return a table of all measures, one of the joints' errors, and notes.

    Args:
        transfers: The results.
        fine_tune: Epochs of fine-tuning.
    """
    head = ["trained on", "evaluated on", "epochs", "p_e, %", f"after {fine_tune} epochs"]
    rows = [
        [
            *(one.trained_on, one.evaluated_on, number(one.epochs, 1)),
            *(interval(values).text(2) for values in (one.values("p_e_percent"), one.tuned)),
            *(number(one.values(name), digits) for _, name, digits in _COLUMNS),
        ]
        for one in transfers
    ]
    episodes = (episode for one in transfers for episode in one.episodes if episode is not None)
    measured = next(episodes, None)
    names = [] if measured is None else _JOINT_ERROR.findall(" ".join(measured.measures))
    joints = [
        [
            f"{one.trained_on} → {one.evaluated_on}",
            *(number(one.values(f"rms_{name}_deg"), 2) for name in names),
        ]
        for one in transfers
    ]
    return (
        "\n\n".join(
            [
                markdown_table([*head, *(title for title, _, _ in _COLUMNS)], rows),
                markdown_table(
                    ["RMS error, deg", *(name.replace("_", " ") for name in names)], joints
                ),
                *_notes(transfers),
            ]
        )
        + "\n"
    )


def as_csv(transfers: Sequence[Transfer]) -> str:
    """Return a row for each agent in each evaluation, with all digits."""
    rows = []
    for one in transfers:
        arms = {"trained_on": one.trained_on, "evaluated_on": one.evaluated_on}
        for seed, epochs, episode, fine_tuned in zip(
            one.seeds, one.epochs.tolist(), one.episodes, one.fine_tuned.tolist(), strict=True
        ):
            row = arms | {"seed": seed, "epochs": epochs}
            row |= {} if episode is None else episode.measures
            rows.append(row | {"fine_tuned_p_e_percent": fine_tuned})
    return csv_text(rows)


def number(values: Sequence[float] | Array, digits: int) -> str:
    """Return the mean of values, or a dash where there is none."""
    mean = float(np.mean(values)) if len(values) else math.nan
    return f"{mean:.{digits}f}" if math.isfinite(mean) else "–"


def _notes(transfers: Sequence[Transfer]) -> list[str]:
    first = (
        "One episode of each agent, without learning. Trained on nothing: the feedback controller."
    )
    return [first, *notes_on_means([one.episodes for one in transfers])]


def notes_on_means(episodes: Sequence[Sequence[Episode | None]]) -> list[str]:
    """Return notes on means over seeds.

    Args:
        episodes: Episodes of each row by seed, None where the simulation diverged.
    """
    notes, seeds = [], len(episodes[0])
    if seeds > 1:
        notes.append(f"Means over {seeds} seeds, of p_e with 95 % bootstrap intervals.")
    if diverged := sum(episode is None for row in episodes for episode in row):
        total = seeds * len(episodes)
        notes.append(f"{diverged} of {total} episodes diverged; they count in no mean.")
    return notes


SHOWN = {
    ("kinematic", "kinematic"): "ideal arms",
    ("kinematic", "physics"): "trained on ideal arms, physics",
    ("physics", "physics"): "physics",
    ("compensated", "compensated"): "physics, weight carried",
}
"""Titles of the pairs of arms, trained and evaluated on, that are drawn."""

_WRIST, _UP = 2, 2  # in what `site_positions` returns


def first_episodes(transfers: Sequence[Transfer]) -> dict[str, Episode]:
    """Return the first seed's episodes of `SHOWN` by title; without those that diverged."""
    found = {(one.trained_on, one.evaluated_on): one.episodes[0] for one in transfers}
    return {name: one for pair, name in SHOWN.items() if (one := found[pair]) is not None}


def write_transfer(path: Path, transfers: Sequence[Transfer], fine_tune: int) -> None:
    """Draw p_e of each kind of arms on each, at once and after epochs of fine-tuning."""
    count = len(ARMS)
    trained = [one for one in transfers if one.trained_on in ARMS]
    at_once = [_mean(one.values("p_e_percent")) for one in trained]
    tuned = [_mean(one.tuned) for one in trained]
    titles = {"at once": at_once, f"after {fine_tune} epochs there": tuned}
    with figure_file(path, 8.0, 3.9) as figure:
        axes = figure.subplots(1, 2, sharey=True)
        top = max(filter(math.isfinite, [*at_once, *tuned]), default=1.0)
        for axis, (title, values) in zip(axes, titles.items(), strict=True):
            matrix = np.reshape(values, (count, count))
            axis.imshow(matrix, cmap="Blues", vmin=0.0, vmax=1.6 * top)
            for row, column in np.ndindex(count, count):
                text = f"{matrix[row, column]:.2f} %" if np.isfinite(matrix[row, column]) else "–"
                axis.text(column, row, text, ha="center", va="center")
            axis.set_title(title, fontsize="medium")
            axis.set_xticks(range(count), list(ARMS))
            axis.set_yticks(range(count), list(ARMS))
            axis.set_xlabel("evaluated on")
            axis.spines[:].set_visible(False)
            axis.tick_params(length=0)
        axes[0].set_ylabel("trained on")
        figure.suptitle("p_e on one kind of arms after training on another", fontsize="medium")


def write_episodes(path: Path, transfers: Sequence[Transfer], motion: Motion) -> None:
    """Draw one repetition of the motion: the wrists' height, the error, and the torque."""
    with figure_file(path, 9.0, 9.0) as figure:
        axes = figure.subplots(4, 1, sharex=True)
        colours = dict(zip(SHOWN.values(), module_colours(len(SHOWN)), strict=True))
        steps = len(motion)
        time = np.arange(steps) / motion.rate
        for name, episode in first_episodes(transfers).items():
            arms = PhysicsArms.make(episode.options)
            heights = arms.site_positions(episode.trace.posture[:steps])[:, :, _WRIST, _UP]
            wanted = arms.site_positions(episode.trace.reference[:steps])[:, :, _WRIST, _UP]
            for axis, side, height, demonstrated in zip(
                axes, SIDES, heights.T, wanted.T, strict=False
            ):
                if name == SHOWN["kinematic", "kinematic"]:
                    axis.plot(time, demonstrated, color=DEMONSTRATED, linewidth=4, alpha=0.6)
                axis.plot(time, height, color=colours[name], linewidth=1.2)
                axis.set_ylabel(f"{side} wrist's\nheight, m")
        for one in transfers:
            name = SHOWN.get((one.trained_on, one.evaluated_on), "")
            episodes = [episode for episode in one.episodes if episode]
            if not (name and episodes):
                continue
            errors = np.mean(
                [
                    error_over_time(episode.trace.posture, episode.trace.reference)
                    for episode in episodes
                ],
                axis=0,
            )
            axes[2].plot(time, errors[:steps], color=colours[name], linewidth=1.2, label=name)
            torques = [
                _torque_over_time(episode, motion.rate) for episode in episodes if episode.effort
            ]
            if torques:
                torque = np.mean(torques, axis=0)
                axes[3].plot(
                    time[: len(torque)], torque[:steps], color=colours[name], linewidth=1.2
                )
        axes[2].set(ylabel=f"error, %,\nmean of {len(transfers[0].seeds)} seeds", ylim=(0.0, None))
        axes[3].set(ylabel="torque, N m,\nmean of joints", ylim=(0.0, None), xlabel="time, s")
        axes[0].plot([], color=DEMONSTRATED, linewidth=4, alpha=0.6, label="demonstrated")
        draw_labels(axes, motion.context, motion.labels, motion.rate)
        figure.suptitle(f"The first repetition of {motion.name}", fontsize="medium")
        figure.legend(loc="outside lower center", ncols=3, fontsize="small")


def _torque_over_time(episode: Episode, rate: float) -> Array:
    """Return the mean size of the joints' torques in each control step, shape (T,), N m."""
    assert episode.effort is not None
    substeps = round(1.0 / rate / episode.effort.timestep)
    size = np.abs(episode.effort.torque).mean(axis=1)
    return size.reshape(-1, substeps).mean(axis=1)


def _mean(values: Sequence[float]) -> float:
    return float(np.mean(values)) if len(values) else float("nan")
