"""Draw learning curves and print them as a Markdown table.

python benchmarks/learners/draw.py curves.csv --figure docs/pictures/learning_curves.png
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import tyro
from curves import Row, p_e_after, read_curves
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, NullLocator

from mpma_mj.visualization.colours import DEMONSTRATED, INK, PAPER

# Okabe & Ito's palette, which colour-blind people can tell apart.
COLOURS = {
    "MPMA": "#d55e00",
    "BC": "#000000",
    "DAgger": "#888888",
    "PPO": "#0072b2",
    "PPO + feedback": "#56b4e9",
    "CMA-ES": "#009e73",
    "CMA-ES + feedback": "#cc79a7",
}
# Steps above which the name is written where other curves pass the end.
NAMED_AT = {"MPMA": 1_100}
GOAL = 1.0  # percent


def main(
    curves: tyro.conf.Positional[Path],
    figure: Path | None = None,
    columns: tuple[int, ...] = (1_000, 6_000, 50_000, 100_000, 200_000, 2_000_000),
) -> None:
    """Print a table, and draw if there is a name for the figure.

    Args:
        curves: CSV file that train.py wrote.
        figure: PNG file to draw to.
        columns: Environment steps of the table's columns.
    """
    runs = by_run(read_curves(curves))
    print(table(runs, columns))
    if figure is not None:
        draw(runs).savefig(figure, dpi=110)


def by_run(rows: list[Row]) -> dict[str, dict[int, list[Row]]]:
    """Return the rows of every learner and seed."""
    runs: dict[str, dict[int, list[Row]]] = {}
    for row in rows:
        runs.setdefault(row.learner, {}).setdefault(row.seed, []).append(row)
    return runs


def table(runs: dict[str, dict[int, list[Row]]], columns: tuple[int, ...]) -> str:
    """Return medians and ranges over seeds as Markdown; nothing beyond the end of training."""
    heads = [f"{steps:,}" for steps in columns]
    lines = ["| p_e, %, after | " + " | ".join(heads) + f" | first below {GOAL:g} % | seeds |"]
    lines.append("|---" * (len(columns) + 3) + "|")
    for learner, seeds in runs.items():
        cells = [cell([p_e_after(rows, steps) for rows in seeds.values()]) for steps in columns]
        cells.append(reached([steps_to_goal(rows) for rows in seeds.values()]))
        lines.append(f"| {learner} | " + " | ".join(cells) + f" | {len(seeds)} |")
    return "\n".join(lines)


def cell(values: list[float | None], form: str = ".3g") -> str:
    """Return median, least and greatest as text; nothing where there is none."""
    known = [value for value in values if value is not None]
    if not known:
        return ""
    low, middle, high = (format(f(known), form) for f in (min, np.median, max))
    return middle if low == high else f"{middle} ({low} to {high})"


def steps_to_goal(rows: list[Row]) -> float | None:
    """Return the steps at which one run was first measured below the goal."""
    return next((row.steps for row in rows if row.p_e < GOAL), None)


def reached(steps: list[float | None]) -> str:
    """Return when the goal was reached, and by how many seeds if not by all."""
    count = sum(first is not None for first in steps)
    if count == 0:
        return "never"
    return cell(steps, ",.0f") + ("" if count == len(steps) else f", {count} of {len(steps)}")


def draw(runs: dict[str, dict[int, list[Row]]]) -> Figure:
    """Draw medians as lines and ranges over seeds as bands."""
    figure = Figure(figsize=(8, 4.8), layout="constrained")
    axes = figure.add_subplot(xscale="log", yscale="log")
    learning = {name: runs[name] for name in COLOURS if name in runs}
    last = max((seeds[0][-1].steps for seeds in learning.values()), default=1)
    axes.set_xlim(200, 16 * last)  # room for names
    axes.set_ylim(0.09, 50)
    axes.set_yticks([0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50])
    axes.yaxis.set_minor_locator(NullLocator())
    for name, seeds in learning.items():
        _curve(axes, name, seeds)
    for name in (name for name in runs if name not in COLOURS):
        _level(axes, name, float(np.median([rows[-1].p_e for rows in runs[name].values()])))
    axes.axhline(GOAL, color=INK, linewidth=0.6)
    axes.set_xlabel("environment steps of training")
    axes.set_ylabel("p_e, %")
    axes.xaxis.set_major_formatter(FuncFormatter(lambda steps, _: f"{steps:,.0f}"))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda p_e, _: f"{p_e:g}"))
    axes.spines[["top", "right"]].set_visible(False)
    return figure


def _curve(axes: Axes, name: str, seeds: dict[int, list[Row]]) -> None:
    moments = list(zip(*seeds.values(), strict=True))  # seeds are measured at the same steps
    steps = [moment[0].steps for moment in moments]
    p_e = np.array([[row.p_e for row in moment] for moment in moments])  # (moments, seeds)
    middle = np.median(p_e, axis=1)
    axes.fill_between(
        steps, p_e.min(axis=1), p_e.max(axis=1), color=COLOURS[name], alpha=0.25, linewidth=0
    )
    axes.plot(steps, middle, color=COLOURS[name], linewidth=2)
    at, offset, across = -1, (5, 0), "left"
    if name in NAMED_AT:
        at, offset, across = int(np.searchsorted(steps, NAMED_AT[name])), (0, 14), "center"
    axes.annotate(
        name,
        (steps[at], middle[at]),
        offset,
        textcoords="offset points",
        color=COLOURS[name],
        fontweight="bold",
        horizontalalignment=across,
        verticalalignment="center",
        bbox={"color": PAPER, "pad": 1.0},  # levels pass behind
    )


def _level(axes: Axes, name: str, p_e: float) -> None:
    axes.axhline(p_e, color=DEMONSTRATED, linewidth=1, linestyle=(0, (4, 3)))
    axes.text(220, p_e * 1.03, name, color="#6a707c", fontsize=9, verticalalignment="bottom")


if __name__ == "__main__":
    tyro.cli(main)
