"""Records of runs: which belong to a row of a table, their measures, and what is missing."""

from __future__ import annotations

import statistics
from collections.abc import Mapping, Sequence
from typing import Any

from mpma_mj.evaluation.statistics import Interval, MeanStd, interval, mean_std

__all__ = [
    "Record",
    "converged",
    "flat",
    "matching",
    "mean_std_over_seeds",
    "measured",
    "of_agent",
    "over_seeds",
    "remarks",
    "value",
]

Record = dict[str, Any]
"""What JSON can hold of one run: `agent`, `seed`, `diverged`, and measures by name, perhaps
nested."""


def matching(records: Sequence[Record], labels: Mapping[str, Any]) -> list[Record]:
    """Return the records with certain entries."""
    return [one for one in records if all(one.get(k) == v for k, v in labels.items())]


def of_agent(records: Sequence[Record], agent: str) -> list[Record]:
    """Return the records of an agent, in the order of seeds."""
    return sorted(matching(records, {"agent": agent}), key=lambda one: one["seed"])


def value(record: Record, *path: str) -> float | None:
    """Return a measure of a run, None if it has none.

    Args:
        record: The record.
        path: Name of the measure and, where entries are nested, of the entries in it; the mean
            over nested entries is returned if these are not named.
    """
    found: Any = record
    for name in path:
        found = found.get(name) if isinstance(found, Mapping) else None
    if isinstance(found, Mapping):
        return statistics.fmean(found.values()) if found else None
    return None if found is None else float(found)


def measured(records: Sequence[Record], *path: str) -> list[float]:
    """Return a measure of all runs that have it, given its path as of `value`.

    Runs that diverged have none, and neither have some agents; those that did not converge count
    with their best epoch (choice).
    """
    found = (value(one, *path) for one in records)
    return [number for number in found if number is not None]


def over_seeds(records: Sequence[Record], *path: str) -> Interval:
    """Return mean and interval of a measure; see `measured`."""
    return interval(measured(records, *path))


def mean_std_over_seeds(records: Sequence[Record], *path: str) -> MeanStd:
    """Return mean and standard deviation of a measure; see `measured`."""
    return mean_std(measured(records, *path))


def converged(records: Sequence[Record]) -> int:
    """Count the runs that converged."""
    return sum(bool(one.get("converged")) for one in records)


def remarks(runs: Sequence[Sequence[Record]], requested: int) -> list[str]:
    """Return a sentence for each kind of irregularity: missing, diverged and repeated runs.

    Args:
        runs: Records of each finished run.
        requested: Number of requested runs.
    """
    missing = requested - len(runs)
    diverged = sum(any(one["diverged"] for one in records) for records in runs)
    again = sum(any(one["attempts"] > 1 for one in records) for records in runs)
    counts = {
        f"{missing} of {requested} runs are missing, because their workers died or the command was"
        " stopped; resume with the same command.": missing,
        f"{diverged} of {requested} runs diverged; they count in no mean.": diverged,
        f"{again} of {requested} runs were tried again, because their worker died.": again,
    }
    return [sentence for sentence, count in counts.items() if count]


def flat(record: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Return a record with the paths of nested entries as names, `active_modules.Y` and so on."""
    leaves: dict[str, Any] = {}
    for name, entry in record.items():
        if isinstance(entry, Mapping):
            leaves |= flat(entry, f"{prefix}{name}.")
        else:
            leaves[f"{prefix}{name}"] = entry
    return leaves
