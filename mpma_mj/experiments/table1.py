"""The paper's Table 1, its numbers beside ours."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Sequence
from dataclasses import dataclass

from mpma_mj.experiments.folder import RunResult
from mpma_mj.experiments.measures import Spread, converged, remarks, spread
from mpma_mj.experiments.spec import SweepSpec, seeds
from mpma_mj.training.config import RunConfig
from mpma_mj.utils.text import markdown_table

__all__ = ["LETTERS", "PAPER", "Line", "as_csv", "as_markdown", "lines", "of_size", "spec_of"]

LETTERS = ("Y", "M", "C", "A")

_EPOCHS = 30  # most of a run; the paper's took 14 to 18 on average (choice)
_NONE = Spread(math.nan, math.nan)


@dataclass(frozen=True)
class Line:
    """A line of the table.

    Attributes:
        nodes: Neurons of each reservoir.
        source: "paper" or "ours".
        measures: Means and standard deviations over seeds, by name in a summary.
        converged: How many of how many runs converged, where that is known.
        all_used: Share of the runs in which every module is dominant in some letter.
    """

    nodes: int
    source: str
    measures: dict[str, Spread]
    converged: tuple[int, int] | None = None
    all_used: float = math.nan


def _paper(
    nodes: int,
    epochs: tuple[float, float],
    p_e: tuple[float, float],
    ratio: tuple[float, float],
    active: tuple[float, float, float, float],
) -> Line:
    measures = {
        "epochs": Spread(*epochs),
        "p_e_percent": Spread(*p_e),
        "feedback_ratio": Spread(*ratio),
    }
    for letter, count in zip(LETTERS, active, strict=True):
        measures[f"active_modules.{letter}"] = Spread(count, math.nan)
    return Line(nodes, "paper", measures)


PAPER = {
    line.nodes: line
    for line in (
        _paper(50, (18, 3.78), (2.76, 0.23), (0.23, 0.02), (1, 1.6, 2.7, 1.05)),
        _paper(100, (17, 5.07), (2.73, 0.27), (0.24, 0.09), (1, 1.95, 2.25, 1.05)),
        _paper(200, (14, 3.89), (2.76, 0.17), (0.20, 0.02), (1.05, 1.8, 2.25, 1)),
        _paper(400, (15, 4.71), (2.79, 0.16), (0.23, 0.06), (1, 2.15, 2.65, 1.05)),
    )
}
"""Table 1 of Tidemann & Öztürk 2008, by nodes; p_e in percent, 20 runs a line."""

# Title, name in a summary, digits after the point, whether the deviation is shown.
_COLUMNS = (
    ("epochs µ/σ", "epochs", 2, True),
    ("p_e µ/σ, %", "p_e_percent", 2, True),
    ("Σu_fb/Σu µ/σ", "feedback_ratio", 3, True),
    *((f"active in {letter}", f"active_modules.{letter}", 2, False) for letter in LETTERS),
    ("nmi", "nmi", 2, False),
    ("repeatability", "repeatability.responsibility", 3, False),
    ("modules used", "modules_used", 2, False),
)


def spec_of(sizes: Sequence[int], runs: int, base: RunConfig) -> SweepSpec:
    """Return the runs of the table.

    Args:
        sizes: Numbers of nodes.
        runs: Runs of each size.
        base: All other settings.

    Raises:
        BadOptionError: A size or the number of runs is less than one, or a size comes twice.
    """
    points = [base.replace(nodes=nodes) for nodes in sizes]
    return SweepSpec(tuple(run for point in points for run in seeds(point, runs)), _EPOCHS)


def of_size(runs: Sequence[RunResult], nodes: int) -> list[RunResult]:
    """Return the runs with so many nodes."""
    return [run for run in runs if run.config.option("nodes") == nodes]


def lines(spec: SweepSpec, runs: Sequence[RunResult]) -> list[Line]:
    """Return the table: for each size the paper's line, if it has one, and ours."""
    table: list[Line] = []
    for nodes in dict.fromkeys(config.option("nodes") for config in spec.configs):
        if nodes in PAPER:
            table.append(PAPER[nodes])
        wanted = sum(config.option("nodes") == nodes for config in spec.configs)
        table.append(_ours(nodes, of_size(runs, nodes), wanted))
    return table


def _ours(nodes: int, runs: Sequence[RunResult], wanted: int) -> Line:
    measured = [run for run in runs if not run.diverged]
    every = [run.summary["modules_used"] == run.config.option("modules") for run in measured]
    return Line(
        nodes,
        "ours",
        {name: spread(runs, name) for _, name, _, _ in _COLUMNS},
        (converged(runs), wanted),
        sum(every) / len(every) if every else math.nan,
    )


def as_markdown(spec: SweepSpec, runs: Sequence[RunResult]) -> str:
    """Return the table with what has to be said about it."""
    titles = ["nodes", "", *(title for title, _, _, _ in _COLUMNS), "all used", "converged"]
    rows = []
    for line in lines(spec, runs):
        cells = [
            found.text(digits, "/") if deviation else found.text(digits, "/").split("/")[0]
            for _, name, digits, deviation in _COLUMNS
            for found in [line.measures.get(name, _NONE)]
        ]
        ended = f"{line.converged[0]} of {line.converged[1]}" if line.converged else "–"
        share = f"{100 * line.all_used:.0f} %" if math.isfinite(line.all_used) else "–"
        rows.append([str(line.nodes), line.source, *cells, share, ended])
    first = spec.configs[0]
    title = f"Table 1: {first.motions[0]}, {first.option('rule')} rule, {first.env.arms} arms"
    sentences = remarks(runs, len(spec.configs))
    return "\n\n".join([title, markdown_table(titles, rows), *sentences]) + "\n"


def as_csv(spec: SweepSpec, runs: Sequence[RunResult]) -> str:
    """Return the same with all digits."""
    names = [name for _, name, _, _ in _COLUMNS]
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    both = [f"{name}_{part}" for name in names for part in ("mean", "sd")]
    writer.writerow(["nodes", "source", *both, "all_used_share", "converged", "runs"])
    for line in lines(spec, runs):
        found = [line.measures.get(name, _NONE) for name in names]
        numbers = [number for one in found for number in (one.mean, one.deviation)]
        cells = map(_number, [*numbers, line.all_used])
        writer.writerow([line.nodes, line.source, *cells, *(line.converged or ("", ""))])
    return text.getvalue()


def _number(value: float) -> float | str:
    return value if math.isfinite(value) else ""
