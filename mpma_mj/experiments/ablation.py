"""MPMA with one thing changed at a time, beside the whole."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from mpma_mj.evaluation.statistics import interval
from mpma_mj.experiments.folder import RunResult
from mpma_mj.experiments.measures import converged, of_point, remarks, spread, value, values
from mpma_mj.experiments.spec import SweepSpec, seeds, without_seed
from mpma_mj.training.config import RunConfig
from mpma_mj.utils.atomic_files import csv_text
from mpma_mj.utils.text import markdown_table

__all__ = ["as_csv", "as_markdown", "changes_of", "spec_of", "title"]

_CHANGES: dict[str, dict[str, Any]] = {
    "the whole": {},
    "no responsibility predictors": {"responsibility_predictors": False},
    "no forward-model gating": {"forward_gating": False},
    "no context": {"context_signal": "nothing"},
    "constant context": {"context_signal": "constant"},
    "shuffled labels": {"context_signal": "shuffled"},
    "labels twice as fine": {"context_signal": "halves"},
    "no noise in the reservoirs": {"reservoir_noise": 0.0},
    "no noise on the demonstration": {"reference_noise": 0.0},
    "one module": {"modules": 1},
    "10 modules": {"modules": 10},
}
_CHANGES_OF_MODELS: dict[str, dict[str, dict[str, Any]]] = {
    "joint": {"modules' predictions left out": {"temperature": 0.0}},
    "posture": {"forward models receive their own command": {"efference_copy": "module"}},
}

_FEWEST = 5  # runs of a difference that is marked; an interval of fewer is too narrow (choice)

_EPOCHS = 30  # most of a run, as of Table 1 (choice)

# Title, name in a summary, digits after the point.
_COLUMNS = (
    ("p_e, %", "p_e_percent", 2),
    ("epochs", "epochs", 1),
    ("feedback ratio", "feedback_ratio", 3),
    ("learned share", "learned_share", 3),
    ("nmi", "nmi", 2),
    ("modules used", "modules_used", 1),
    ("active modules", "active_modules", 2),
    ("repeatability of λ", "repeatability.responsibility", 3),
)
_TITLES = [title for title, _, _ in _COLUMNS]


def changes_of(models: str) -> dict[str, dict[str, Any]]:
    """Return what is changed, by its name; the others are compared with the first.

    Args:
        models: Space of the models, "joint" or "posture".
    """
    return _CHANGES | _CHANGES_OF_MODELS[models]


def spec_of(base: RunConfig, runs: int) -> SweepSpec:
    """Return the runs of all changes.

    Args:
        base: Settings of the whole.
        runs: Runs of each change; they have the same seeds.

    Raises:
        BadOptionError: The number of runs is less than one.
    """
    changes = changes_of(base.option("models"))
    points = [base.replace(**change) for change in changes.values()]
    return SweepSpec(tuple(run for point in points for run in seeds(point, runs)), _EPOCHS)


def title(spec: SweepSpec, config: RunConfig) -> str:
    """Return the name of the change that a run belongs to."""
    return next(name for name, p in _points(spec).items() if p == without_seed(config))


def as_markdown(spec: SweepSpec, runs: Sequence[RunResult]) -> str:
    """Return two tables, of means and of differences, with what has to be said about them."""
    first = spec.configs[0]
    number = len(spec.configs) // len(_points(spec))
    parts = [
        f"Ablations: {first.motions[0]}, {first.option('rule')} rule,"
        f" {first.option('nodes')} nodes,"
        f" {first.env.arms} arms, runs of each: {number}."
        " Means ± standard deviations over seeds:",
        _means(spec, runs),
        "Differences to the whole, seed by seed: means and their 95 % bootstrap intervals, bold"
        f" where these are of {_FEWEST} runs or more and do not contain 0:",
        _differences(spec, runs),
        *_nothing_marked(number),
        *remarks(runs, len(spec.configs)),
    ]
    return "\n\n".join(parts) + "\n"


def as_csv(spec: SweepSpec, runs: Sequence[RunResult]) -> str:
    """Return both with all digits."""
    rows = []
    whole, *_ = _by_name(spec, runs).values()
    for name, own in _by_name(spec, runs).items():
        row: dict[str, object] = {"change": name, "converged": converged(own), "runs": len(own)}
        for _, measure, _ in _COLUMNS:
            row |= interval(values(own, measure)).columns(measure)
            row |= interval(_changes(whole, own, measure)).columns(f"{measure}_difference")
        rows.append(row)
    return csv_text(rows)


def _means(spec: SweepSpec, runs: Sequence[RunResult]) -> str:
    rows = []
    wanted = len(spec.configs) // len(_points(spec))
    for name, own in _by_name(spec, runs).items():
        cells = (spread(own, measure).text(digits) for _, measure, digits in _COLUMNS)
        rows.append([name, f"{converged(own)} of {wanted}", *cells])
    return markdown_table(("change", "converged", *_TITLES), rows)


def _differences(spec: SweepSpec, runs: Sequence[RunResult]) -> str:
    rows = []
    (_, whole), *others = _by_name(spec, runs).items()
    for name, own in others:
        cells = []
        for _, measure, digits in _COLUMNS:
            changes = _changes(whole, own, measure)
            found = interval(changes)
            text = found.text(digits + 1, "+")
            marked = found.excludes_zero and len(changes) >= _FEWEST
            cells.append(f"**{text}**" if marked else text)
        rows.append([name, *cells])
    return markdown_table(("change", *_TITLES), rows)


def _nothing_marked(number: int) -> list[str]:
    """Return why no difference is in bold, if so many runs of each change are too few."""
    if number >= _FEWEST:
        return []
    return [
        f"Nothing is in bold: intervals of fewer than {_FEWEST} runs are too narrow to tell a"
        " change from chance."
    ]


def _changes(whole: Sequence[RunResult], own: Sequence[RunResult], measure: str) -> list[float]:
    """Return by how much a measure changes, over the seeds that have it both times."""
    before = {run.config.seed: value(run, measure) for run in whole}
    after = {run.config.seed: value(run, measure) for run in own}
    pairs = ((before[seed], after[seed]) for seed in before if seed in after)
    return [b - a for a, b in pairs if a is not None and b is not None]


def _by_name(spec: SweepSpec, runs: Sequence[RunResult]) -> dict[str, list[RunResult]]:
    return {name: of_point(runs, point) for name, point in _points(spec).items()}


def _points(spec: SweepSpec) -> dict[str, RunConfig]:
    whole = without_seed(spec.configs[0])
    changes = changes_of(whole.option("models"))
    return {name: whole.replace(**change) for name, change in changes.items()}
