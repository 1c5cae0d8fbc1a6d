"""Runs that grow beside runs of every fixed number of modules."""

from __future__ import annotations

import math
from collections.abc import Sequence

from mpma_mj.errors import BadOptionError
from mpma_mj.sweep.folder import RunResult
from mpma_mj.sweep.measures import remarks, spread, values
from mpma_mj.sweep.spec import SweepSpec, seeds
from mpma_mj.training.config import RunConfig
from mpma_mj.utils.text import markdown_table

__all__ = ["SETTLED", "as_markdown", "by_number", "growing_runs", "spec_of"]

SETTLED = "modules_enabled"
"""Name of the number of modules, in the summary of a run that grows."""

# Title, name in a summary, digits after the point.
_COLUMNS = (
    ("epochs", "epochs", 1),
    ("p_e, %", "p_e_percent", 2),
    ("prediction error, %", "prediction_error_percent", 2),
    ("feedback ratio", "feedback_ratio", 3),
)


def spec_of(most: int, runs: int, base: RunConfig, epochs: int) -> SweepSpec:
    """Return runs that grow, and runs of each number of modules up to the most.

    Args:
        most: Most modules.
        runs: Runs of each kind.
        base: All other settings.
        epochs: Most epochs of a run.

    Raises:
        BadOptionError: A number is less than one, or the settings say what growth has to find.
    """
    if most < 1:
        raise BadOptionError(option="most", value=most, expected="at least 1")
    plain = RunConfig()
    for name in ("agent", "modules"):
        value = base.option(name)
        if value != plain.option(name):
            raise BadOptionError(
                option=name,
                value=value,
                remedy="leave it out: growth is tried beside 1 to as many modules as {most} says",
            )
    points = [base.replace(agent="growing", modules=most)]
    points += [base.replace(modules=modules) for modules in range(1, most + 1)]
    return SweepSpec(tuple(run for point in points for run in seeds(point, runs)), epochs)


def growing_runs(runs: Sequence[RunResult]) -> list[RunResult]:
    """Return the runs that have grown to the end."""
    return [
        run
        for run in runs
        if run.config.agent_name == "growing" and not run.summary.get("growing", True)
    ]


def by_number(runs: Sequence[RunResult]) -> dict[int, list[RunResult]]:
    """Return the runs of each fixed number of modules."""
    fixed = [run for run in runs if run.config.agent_name == "mpma"]
    numbers = sorted({run.config.option("modules") for run in fixed})
    return {n: [run for run in fixed if run.config.option("modules") == n] for n in numbers}


def as_markdown(spec: SweepSpec, runs: Sequence[RunResult]) -> str:
    """Return a table, means ± standard deviations over seeds, and what it comes to."""
    titles = ["modules", "converged", *(title for title, _, _ in _COLUMNS)]
    rows = [_row(str(number), fixed) for number, fixed in by_number(runs).items()]
    grown = [run for run in runs if run.config.agent_name == "growing"]
    rows.append(_row(f"growing: {spread(growing_runs(runs), SETTLED).text(1)}", grown))
    sentences = [*_outcome(runs), *remarks(runs, len(spec.configs))]
    return "\n".join([markdown_table(titles, rows), "", " ".join(sentences)]) + "\n"


def _row(name: str, runs: Sequence[RunResult]) -> list[str]:
    converged = sum(bool(run.summary.get("converged")) for run in runs)
    measures = [spread(runs, measure).text(digits) for _, measure, digits in _COLUMNS]
    return [name, f"{converged} of {len(runs)}", *measures]


def _outcome(runs: Sequence[RunResult]) -> list[str]:
    """Return at which numbers growth settled, and how that does beside the best fixed one."""
    grown = growing_runs(runs)
    means = {n: spread(fixed, "p_e_percent").mean for n, fixed in by_number(runs).items()}
    means = {n: mean for n, mean in means.items() if math.isfinite(mean)}
    if not grown or not means:
        return ["No run has grown to the end."] if means else []
    best = min(means, key=lambda n: means[n])
    change = 100.0 * (spread(grown, "p_e_percent").mean / means[best] - 1.0)
    numbers = " ".join(f"{n:.0f}" for n in values(grown, SETTLED))
    return [
        f"Growth settled at {numbers} modules, seed by seed; its mean p_e is {abs(change):.0f} %"
        f" {'above' if change > 0 else 'below'} that of the best fixed number, {best}."
    ]
