"""The comparison of arms as tables."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mpma_mj.evaluation.statistics import interval
from mpma_mj.experiments.compare import Cell
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


def as_markdown(cells: Sequence[Cell], adaptation: int) -> str:
    """Return a table of all measures, one of the joints' errors, and what has to be said.

    Args:
        cells: What was found.
        adaptation: Number of epochs that agents learned on.
    """
    return "\n\n".join([_measures(cells, adaptation), _joints(cells), *_said(cells)]) + "\n"


def as_csv(cells: Sequence[Cell]) -> str:
    """Return a row for each agent in each condition, with all digits."""
    rows = []
    for cell in cells:
        for seed, epochs, dance, adapted in zip(
            cell.seeds, cell.epochs.tolist(), cell.dances, cell.adapted.tolist(), strict=True
        ):
            row = {"learned": cell.learned, "danced": cell.danced, "seed": seed, "epochs": epochs}
            row |= {} if dance is None else dance.measures
            rows.append(row | {"adapted_p_e_percent": adapted})
    return csv_text(rows)


def _measures(cells: Sequence[Cell], adaptation: int) -> str:
    later = f"after {adaptation} epochs"
    head = [
        "learned on",
        "danced on",
        "epochs",
        "p_e, %",
        later,
        *(title for title, _, _ in _COLUMNS),
    ]
    rows = []
    for cell in cells:
        adapted = cell.adapted[np.isfinite(cell.adapted)].tolist()
        rows.append(
            [
                *(cell.learned, cell.danced, _number(cell.epochs, 1)),
                interval(cell.values("p_e_percent")).text(2),
                interval(adapted).text(2),
                *(_number(cell.values(name), digits) for _, name, digits in _COLUMNS),
            ]
        )
    return markdown_table(head, rows)


def _joints(cells: Sequence[Cell]) -> str:
    head = ["RMS error, deg", *(name.replace("_", " ") for name in JOINT_NAMES)]
    rows = [
        [
            f"{cell.learned} → {cell.danced}",
            *(_number(cell.values(f"rms_{name}_deg"), 2) for name in JOINT_NAMES),
        ]
        for cell in cells
    ]
    return markdown_table(head, rows)


def _number(values: Sequence[float] | Array, digits: int) -> str:
    """Return the mean of values, or a dash where there is none."""
    mean = float(np.mean(values)) if len(values) else math.nan
    return f"{mean:.{digits}f}" if math.isfinite(mean) else "–"


def _said(cells: Sequence[Cell]) -> list[str]:
    seeds = len(cells[0].seeds)
    said = [
        "One episode of each agent, danced without learning. Who learned on nothing is the feedback"
        " controller alone."
    ]
    if seeds > 1:
        said.append(f"Means over {seeds} seeds, of p_e with their 95 % bootstrap intervals.")
    lost = sum(dance is None for cell in cells for dance in cell.dances)
    if lost:
        said.append(f"{lost} of {seeds * len(cells)} dances diverged; they count in no mean.")
    return said
