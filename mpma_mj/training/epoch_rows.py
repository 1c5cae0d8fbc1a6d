"""Metrics of an epoch by name, as a row of a table or an entry of a file."""

from __future__ import annotations

import numpy as np

from mpma_mj.utils.validation import is_integer

__all__ = ["EpochMetrics", "row_problem"]

EpochMetrics = dict[str, float]

_MOST_EPOCHS = 1_000_000_000  # far above what anybody trains (choice)


def row_problem(row: object, number: int | None = None) -> str:
    """Return what is wrong with the metrics of an epoch in a file, to follow its name, or "".

    Args:
        row: The metrics.
        number: Number of the epoch, if it is known.
    """
    if not isinstance(row, dict) or not all(map(_is_metric, row.values())):
        return "lacks the metrics of its epoch as numbers"
    epoch, p_e = row.get("epoch"), row.get("p_e_percent", np.nan)
    if not is_integer(epoch) or int(epoch) < 1 or number not in (None, epoch):
        return f"has an epoch that is not {number or 'a whole number from 1 on'}"
    return "" if 0.0 <= p_e < np.inf else "has no p_e_percent"


def _is_metric(value: object) -> bool:
    return isinstance(value, float) or (is_integer(value) and abs(int(value)) < _MOST_EPOCHS)
