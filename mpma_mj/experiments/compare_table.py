"""Tables of the comparison of arms."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mpma_mj.evaluation.statistics import interval
from mpma_mj.experiments.compare import Transfer
from mpma_mj.kinematics import JOINT_NAMES
from mpma_mj.utils.atomic_files import csv_text
from mpma_mj.utils.text import markdown_table

__all__ = ["as_csv", "as_markdown"]

Array = NDArray[np.float64]

# Title, name of the measure, digits after the point.
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
            *(one.trained_on, one.evaluated_on, _number(one.epochs, 1)),
            *(interval(values).text(2) for values in (one.values("p_e_percent"), one.tuned)),
            *(_number(one.values(name), digits) for _, name, digits in _COLUMNS),
        ]
        for one in transfers
    ]
    joints = [
        [
            f"{one.trained_on} → {one.evaluated_on}",
            *(_number(one.values(f"rms_{name}_deg"), 2) for name in JOINT_NAMES),
        ]
        for one in transfers
    ]
    return (
        "\n\n".join(
            [
                markdown_table([*head, *(title for title, _, _ in _COLUMNS)], rows),
                markdown_table(
                    ["RMS error, deg", *(name.replace("_", " ") for name in JOINT_NAMES)], joints
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


def _number(values: Sequence[float] | Array, digits: int) -> str:
    """Return the mean of values, or a dash where there is none."""
    mean = float(np.mean(values)) if len(values) else math.nan
    return f"{mean:.{digits}f}" if math.isfinite(mean) else "–"


def _notes(transfers: Sequence[Transfer]) -> list[str]:
    seeds = len(transfers[0].seeds)
    notes = [
        "One episode of each agent, without learning. Trained on nothing: the feedback controller."
    ]
    if seeds > 1:
        notes.append(f"Means over {seeds} seeds, of p_e with 95 % bootstrap intervals.")
    diverged = sum(episode is None for one in transfers for episode in one.episodes)
    if diverged:
        total = seeds * len(transfers)
        notes.append(f"{diverged} of {total} episodes diverged; they count in no mean.")
    return notes
