"""Tables of lesions."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from mpma_mj.analysis.lesion import LabelMeasures, Lesion, Lesions
from mpma_mj.evaluation.statistics import interval
from mpma_mj.utils.text import markdown_table

__all__ = ["matrix", "name_of", "summary"]

Array = NDArray[np.float64]
Part = NDArray[np.bool_]  # labels that count, shape (C,)
Selection = Callable[[Lesions, Lesion], Part]
Measure = Callable[[LabelMeasures], Array]  # a value for each label, shape (C,)
Episode = Callable[[Lesions, Lesion], LabelMeasures | None]


def name_of(lesion: Lesion, lesions: Lesions) -> str:
    """Return the name of a row; modules are counted from 1."""
    if lesion is lesions.silent:
        return "all silent"
    dropped = ", ".join(str(module + 1) for module in lesion.dropped)
    return f"without {dropped}" if dropped else "intact"


def matrix(lesions: Lesions) -> str:
    """Return p_e, and the dominant module, of each lesion and label as two tables."""
    arrow = " → after fine-tuning" if lesions.fine_tuned else ""
    names = [name_of(lesion, lesions) for lesion in lesions.lesions]
    errors, owners = [], []
    for name, lesion in zip(names, lesions.lesions, strict=True):
        measures = [one for one in (lesion.at_once, lesion.fine_tuned) if one]
        columns = zip(*(_errors(one) for one in measures), strict=True)
        errors.append([name, *(" → ".join(column) for column in columns)])
        if lesion is not lesions.silent:
            shares = zip(*(_owners(one) for one in measures), strict=True)
            owners.append([name, *(" → ".join(column) for column in shares)])
    head = (f"p_e, %, at once{arrow}", *lesions.labels, "all")
    who = (f"dominant module (its mean λ), at once{arrow}", *lesions.labels)
    return f"{markdown_table(head, errors)}\n\n{markdown_table(who, owners)}"


def _errors(measures: LabelMeasures) -> list[str]:
    return [_number(error) for error in (*measures.label_p_e_percent, measures.p_e_percent)]


def _owners(measures: LabelMeasures) -> list[str]:
    return [
        f"{owner + 1} ({share[owner]:.2f})" if owner >= 0 else "–"
        for owner, share in zip(measures.dominant.tolist(), measures.responsibility, strict=True)
    ]


def _number(value: float) -> str:
    return "–" if np.isnan(value) else f"{value:.2f}"


def summary(runs: Sequence[Lesions]) -> str:
    """Return means over runs, with 95 % intervals, as two tables.

    The first has p_e in the labels of dropped modules and in others. The second shows how others
    take over in the labels of a dropped module: their share of what modules do for p_e, 100 % where
    p_e is that of the intact agent and 0 % where it is that without modules; and the largest λ of a
    module there. A run's value is the mean over its lesions, and over the labels of each (choice).

    Args:
        runs: The lesions of each run.
    """
    return f"{_errors_table(runs)}\n\n{_takeover_table(runs)}"


def _own(run: Lesions, lesion: Lesion) -> Part:
    return run.owned(lesion.dropped)


def _others(run: Lesions, lesion: Lesion) -> Part:
    """Return the labels of other modules, where some are of the dropped ones."""
    own = run.owned(lesion.dropped)
    return ~own & (run.intact.at_once.dominant >= 0) & own.any()


def _all(run: Lesions, lesion: Lesion) -> Part:
    """Return all labels, where none is of the dropped modules."""
    return (run.intact.at_once.dominant >= 0) & ~run.owned(lesion.dropped).any()


_EPISODES: dict[str, Episode] = {
    "intact": lambda run, lesion: run.intact.at_once,
    "at once": lambda run, lesion: lesion.at_once,
    "intact, fine-tuned": lambda run, lesion: run.intact.fine_tuned,
    "fine-tuned": lambda run, lesion: lesion.fine_tuned,
    "all silent": lambda run, lesion: run.silent.at_once,
}
_SIZES = {1: "one module", 2: "two modules"}
_PARTS: dict[str, Selection] = {
    "in its own labels": _own,
    "in other labels": _others,
    "dominant in none": _all,
}


def _errors_table(runs: Sequence[Lesions]) -> str:
    """Return p_e for each number of dropped modules and each part of the labels."""
    columns = {"intact": "intact", "at once": "at once"}
    if epochs := _epochs(runs):
        columns |= {f"intact, {epochs} on": "intact, fine-tuned", f"after {epochs}": "fine-tuned"}
    columns["all silent"] = "all silent"
    rows = []
    for (size, modules), (where, part) in itertools.product(_SIZES.items(), _PARTS.items()):
        found = [_of_runs(runs, size, part, name, _p_e) for name in columns.values()]
        if not np.isnan(found[0]).all():
            rows.append((f"{modules}, {where}", *(_text(values, 2) for values in found)))
    return markdown_table(("p_e, %, without", *columns), rows)


def _takeover_table(runs: Sequence[Lesions]) -> str:
    """Return how much is taken over in the labels of dropped modules, and the largest λ there."""
    columns = {"at once": ("intact", "at once")}
    if epochs := _epochs(runs):
        columns[f"after {epochs}"] = ("intact, fine-tuned", "fine-tuned")
    rows = []
    for size, modules in _SIZES.items():
        silent = _of_runs(runs, size, _own, "all silent", _p_e)
        if np.isnan(silent).all():
            continue
        shares, largest = [], [_of_runs(runs, size, _own, "intact", _largest)]
        for whole, part in columns.values():
            intact = _of_runs(runs, size, _own, whole, _p_e)
            dropped = _of_runs(runs, size, _own, part, _p_e)
            shares.append(100.0 * (silent - dropped) / (silent - intact))
            largest.append(_of_runs(runs, size, _own, part, _largest))
        cells = [*(_text(share, 0) for share in shares), *(_text(share, 2) for share in largest)]
        rows.append((modules, *cells))
    taken = (f"taken over {when}, %" for when in columns)
    most = (f"largest λ {when}" for when in ("intact", *columns))
    return markdown_table(("in its own labels, without", *taken, *most), rows)


def _epochs(runs: Sequence[Lesions]) -> str:
    """Return the epochs of fine-tuning as text; empty without any."""
    epochs = max((run.epochs for run in runs if run.fine_tuned), default=0)
    return f"{epochs} epoch{'s' * (epochs != 1)}" if epochs else ""


def _p_e(measures: LabelMeasures) -> Array:
    return measures.label_p_e_percent


def _largest(measures: LabelMeasures) -> Array:
    return measures.responsibility.max(axis=1)


def _of_runs(
    runs: Sequence[Lesions], size: int, part: Selection, episode: str, measure: Measure
) -> Array:
    """Return the mean of each run, shape (R,); NaN of one without such lesions or episodes."""
    means = []
    for run in runs:
        values = [
            float(measure(measures)[labels].mean())
            for lesion in run.partial
            if len(lesion.dropped) == size
            and (labels := part(run, lesion)).any()
            and (measures := _EPISODES[episode](run, lesion)) is not None
        ]
        means.append(float(np.mean(values)) if values else np.nan)
    return np.array(means)


def _text(values: Array, digits: int) -> str:
    return interval(values[~np.isnan(values)].tolist()).text(digits)
