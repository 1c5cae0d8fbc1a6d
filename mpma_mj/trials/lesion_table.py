"""What is told about lesions as tables of text."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from mpma_mj.analysis.tables import markdown_table
from mpma_mj.sweep.interval import Interval, interval
from mpma_mj.trials.lesion import Dance, Lesion, Lesions

__all__ = ["matrix", "name_of", "summary"]

Array = NDArray[np.float64]
Part = NDArray[np.bool_]  # labels that count, shape (C,)
Chosen = Callable[[Lesions, Lesion], Part]
Picked = Callable[[Lesions, Lesion], Dance | None]


def name_of(lesion: Lesion, without: Lesions) -> str:
    """Return what a row is called; modules are counted from 1."""
    if lesion is without.silent:
        return "all silent"
    return f"without {', '.join(str(i + 1) for i in lesion.lost)}" if lesion.lost else "intact"


def matrix(without: Lesions) -> str:
    """Return the lesions of a run as two tables: p_e, and who is dominant, in each label."""
    arrow = " → after learning on" if without.retrained else ""
    names = [name_of(lesion, without) for lesion in without.lesions]
    errors, owners = [], []
    for name, lesion in zip(names, without.lesions, strict=True):
        dances = [dance for dance in (lesion.at_once, lesion.retrained) if dance]
        columns = zip(*(_errors(dance) for dance in dances), strict=True)
        errors.append([name, *(" → ".join(column) for column in columns)])
        if lesion is not without.silent:
            shares = zip(*(_owners(dance) for dance in dances), strict=True)
            owners.append([name, *(" → ".join(column) for column in shares)])
    head = (f"p_e, %, at once{arrow}", *without.labels, "all")
    who = (f"dominant module (its mean λ), at once{arrow}", *without.labels)
    return f"{markdown_table(head, errors)}\n\n{markdown_table(who, owners)}"


def _errors(dance: Dance) -> list[str]:
    return [_number(error) for error in (*dance.label_p_e_percent, dance.p_e_percent)]


def _owners(dance: Dance) -> list[str]:
    return [
        f"{owner + 1} ({share[owner]:.2f})" if owner >= 0 else "–"
        for owner, share in zip(dance.dominant.tolist(), dance.responsibility, strict=True)
    ]


def _number(value: float) -> str:
    return "–" if np.isnan(value) else f"{value:.2f}"


def summary(runs: Sequence[Lesions]) -> str:
    """Return means over runs, with 95 % intervals: p_e, and the largest λ that one module has.

    Of each run it is the mean over its lesions, and over the labels of each, which count alike
    (choice).

    Args:
        runs: The lesions of each run.
    """
    epochs = max(run.epochs for run in runs)
    dances: dict[str, Picked] = {
        "intact": lambda run, lesion: run.intact.at_once,
        "at once": lambda run, lesion: lesion.at_once,
    }
    if any(run.retrained for run in runs):
        learned = f"{epochs} epoch{'s' * (epochs != 1)}"
        dances[f"intact, {learned} on"] = lambda run, lesion: run.intact.retrained
        dances[f"after {learned}"] = lambda run, lesion: lesion.retrained
    beside: dict[str, Picked] = dances | {"all silent": lambda run, lesion: run.silent.at_once}
    errors = _table("p_e, %, without", runs, beside, lambda dance: dance.label_p_e_percent, _PARTS)
    owned = {name: part for name, part in _PARTS.items() if part is _own}
    heirs = _table(
        "largest λ of a module, without",
        runs,
        dances,
        lambda dance: dance.responsibility.max(axis=1),
        owned,
    )
    return f"{errors}\n\n{heirs}"


def _own(run: Lesions, lesion: Lesion) -> Part:
    return run.owned(lesion.lost)


def _others(run: Lesions, lesion: Lesion) -> Part:
    """Return the labels of other modules, where some are of the lost ones."""
    own = run.owned(lesion.lost)
    return ~own & (run.intact.at_once.dominant >= 0) & own.any()


def _all(run: Lesions, lesion: Lesion) -> Part:
    """Return all labels, where none is of the lost modules."""
    return (run.intact.at_once.dominant >= 0) & ~run.owned(lesion.lost).any()


_PARTS: dict[str, Chosen] = {
    "in its own labels": _own,
    "in other labels": _others,
    "dominant in none": _all,
}
_SIZES = {1: "one module", 2: "two modules"}


def _table(
    title: str,
    runs: Sequence[Lesions],
    dances: Mapping[str, Picked],
    measure: Callable[[Dance], Array],
    parts: Mapping[str, Chosen],
) -> str:
    """Return a row for each number of modules lost and each part of the labels that there is."""
    rows = []
    for (size, modules), (where, part) in itertools.product(_SIZES.items(), parts.items()):
        cells = [_mean(runs, size, part, picked, measure) for picked in dances.values()]
        if any(not np.isnan(cell.mean) for cell in cells):
            rows.append((f"{modules}, {where}", *(cell.text(2) for cell in cells)))
    return markdown_table((title, *dances), rows)


def _mean(
    runs: Sequence[Lesions],
    size: int,
    part: Chosen,
    picked: Picked,
    measure: Callable[[Dance], Array],
) -> Interval:
    """Return the mean over runs that have such lesions, labels and dances."""
    found = []
    for run in runs:
        values = [
            float(measure(dance)[labels].mean())
            for lesion in run.some
            if len(lesion.lost) == size
            and (labels := part(run, lesion)).any()
            and (dance := picked(run, lesion)) is not None
        ]
        if values:
            found.append(float(np.mean(values)))
    return interval(found)
