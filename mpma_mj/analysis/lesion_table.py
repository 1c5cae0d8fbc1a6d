"""What is told about lesions as tables of text."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from mpma_mj.analysis.lesion import Dance, Lesion, Lesions
from mpma_mj.evaluation.statistics import interval
from mpma_mj.utils.text import markdown_table

__all__ = ["matrix", "name_of", "summary"]

Array = NDArray[np.float64]
Part = NDArray[np.bool_]  # labels that count, shape (C,)
Chosen = Callable[[Lesions, Lesion], Part]
Measured = Callable[[Dance], Array]  # a value for each label, shape (C,)
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
    """Return means over runs, with 95 % intervals, as two tables.

    One has p_e in the labels of lost modules and in others. The other tells who takes over where
    a module is lost: what part of what modules do for p_e the others do, which is 100 % where it
    is as of the intact agent and 0 % where it is as if all were silent; and the largest λ that a
    module has there. Of each run it is the mean over its lesions, and over the labels of each,
    which count alike (choice).

    Args:
        runs: The lesions of each run.
    """
    return f"{_errors_table(runs)}\n\n{_heirs_table(runs)}"


def _intact(run: Lesions, lesion: Lesion) -> Dance:
    return run.intact.at_once


def _intact_later(run: Lesions, lesion: Lesion) -> Dance | None:
    return run.intact.retrained


def _at_once(run: Lesions, lesion: Lesion) -> Dance:
    return lesion.at_once


def _later(run: Lesions, lesion: Lesion) -> Dance | None:
    return lesion.retrained


def _silent(run: Lesions, lesion: Lesion) -> Dance:
    return run.silent.at_once


def _own(run: Lesions, lesion: Lesion) -> Part:
    return run.owned(lesion.lost)


def _others(run: Lesions, lesion: Lesion) -> Part:
    """Return the labels of other modules, where some are of the lost ones."""
    own = run.owned(lesion.lost)
    return ~own & (run.intact.at_once.dominant >= 0) & own.any()


def _all(run: Lesions, lesion: Lesion) -> Part:
    """Return all labels, where none is of the lost modules."""
    return (run.intact.at_once.dominant >= 0) & ~run.owned(lesion.lost).any()


_SIZES = {1: "one module", 2: "two modules"}
_PARTS: dict[str, Chosen] = {
    "in its own labels": _own,
    "in other labels": _others,
    "dominant in none": _all,
}


def _errors_table(runs: Sequence[Lesions]) -> str:
    """Return p_e for each number of modules lost and each part of the labels that there is."""
    columns: dict[str, Picked] = {"intact": _intact, "at once": _at_once}
    if learned := _epochs(runs):
        columns |= {f"intact, {learned} on": _intact_later, f"after {learned}": _later}
    columns["all silent"] = _silent
    rows = []
    for (size, modules), (where, part) in itertools.product(_SIZES.items(), _PARTS.items()):
        found = [_of_runs(runs, size, part, picked, _p_e) for picked in columns.values()]
        if not np.isnan(found[0]).all():
            rows.append((f"{modules}, {where}", *(_text(values, 2) for values in found)))
    return markdown_table(("p_e, %, without", *columns), rows)


def _heirs_table(runs: Sequence[Lesions]) -> str:
    """Return how much is taken over in the labels of lost modules, and by how few."""
    columns: dict[str, tuple[Picked, Picked]] = {"at once": (_intact, _at_once)}
    if learned := _epochs(runs):
        columns[f"after {learned}"] = (_intact_later, _later)
    rows = []
    for size, modules in _SIZES.items():
        silent = _of_runs(runs, size, _own, _silent, _p_e)
        if np.isnan(silent).all():
            continue
        shares, largest = [], [_of_runs(runs, size, _own, _intact, _largest)]
        for whole, part in columns.values():
            intact = _of_runs(runs, size, _own, whole, _p_e)
            lost = _of_runs(runs, size, _own, part, _p_e)
            shares.append(100.0 * (silent - lost) / (silent - intact))
            largest.append(_of_runs(runs, size, _own, part, _largest))
        cells = [*(_text(share, 0) for share in shares), *(_text(share, 2) for share in largest)]
        rows.append((modules, *cells))
    taken = (f"taken over {when}, %" for when in columns)
    most = (f"largest λ {when}" for when in ("intact", *columns))
    return markdown_table(("in its own labels, without", *taken, *most), rows)


def _epochs(runs: Sequence[Lesions]) -> str:
    """Return how long agents learned on; nothing where none did."""
    epochs = max((run.epochs for run in runs if run.retrained), default=0)
    return f"{epochs} epoch{'s' * (epochs != 1)}" if epochs else ""


def _p_e(dance: Dance) -> Array:
    return dance.label_p_e_percent


def _largest(dance: Dance) -> Array:
    return dance.responsibility.max(axis=1)


def _of_runs(
    runs: Sequence[Lesions], size: int, part: Chosen, picked: Picked, measure: Measured
) -> Array:
    """Return the mean of each run, shape (R,); NaN of one without such lesions or dances."""
    means = []
    for run in runs:
        values = [
            float(measure(dance)[labels].mean())
            for lesion in run.some
            if len(lesion.lost) == size
            and (labels := part(run, lesion)).any()
            and (dance := picked(run, lesion)) is not None
        ]
        means.append(float(np.mean(values)) if values else np.nan)
    return np.array(means)


def _text(values: Array, digits: int) -> str:
    return interval(values[~np.isnan(values)].tolist()).text(digits)
