"""Learning curves as rows of a table: learner, seed, steps, p_e."""

from __future__ import annotations

import csv
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

from mpma_mj.utils.atomic_files import atomic_write

__all__ = ["Row", "p_e_after", "read_curves", "replace_curves", "write_curves"]


class Row(NamedTuple):
    """One measurement of a learner: environment steps of training so far, and p_e in percent."""

    learner: str
    seed: int
    steps: int
    p_e: float


def read_curves(path: Path) -> list[Row]:
    """Read all rows of a CSV file; none where there is no file yet."""
    if not path.exists():
        return []
    with path.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    return [Row(r["learner"], int(r["seed"]), int(r["steps"]), float(r["p_e"])) for r in rows]


def write_curves(path: Path, rows: Iterable[Row]) -> None:
    """Write rows as CSV, four digits of p_e."""
    with atomic_write(path) as temporary, temporary.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(Row._fields)
        writer.writerows((*row[:3], f"{row.p_e:.4g}") for row in rows)


def replace_curves(old: Iterable[Row], new: list[Row]) -> list[Row]:
    """Return the old rows with new ones in the place of those of the same learner and seed."""
    runs = {(row.learner, row.seed) for row in new}
    return [row for row in old if (row.learner, row.seed) not in runs] + new


def p_e_after(rows: list[Row], steps: int) -> float | None:
    """Return what one run had reached after so many steps, percent.

    Args:
        rows: The rows of one learner and seed, in order.
        steps: Environment steps of training.

    Returns:
        The last measurement until then, or up to 1 % later, since training ends with a whole
        episode or generation; None before the first, and past the end of training unless there
        was none.
    """
    until = [row.p_e for row in rows if row.steps <= 1.01 * steps]
    trained = rows[-1].steps
    if not until or 0 < trained < 0.98 * steps:
        return None
    return until[-1]
