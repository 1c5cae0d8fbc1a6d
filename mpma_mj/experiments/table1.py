"""Study `table1`: Table 1 of the paper, with our numbers below the paper's."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, TypeAlias

import numpy as np

from mpma_mj.agents.gain_schedule import CRITERION
from mpma_mj.evaluation.statistics import MeanStd, mean_std
from mpma_mj.experiments.records import Record, converged, matching, mean_std_over_seeds, measured
from mpma_mj.experiments.training import Column, Point, TrainingStudy
from mpma_mj.options import Arms, Models
from mpma_mj.training.config import RunConfig
from mpma_mj.utils.text import markdown_table
from mpma_mj.visualization.colours import DEMONSTRATED, INK, module_colours
from mpma_mj.visualization.figure_file import figure_file

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["LETTERS", "PAPER", "Table1"]

LETTERS = ("Y", "M", "C", "A")

_UNKNOWN = MeanStd(math.nan, math.nan)


def _paper(
    epochs: tuple[float, float],
    p_e: tuple[float, float],
    ratio: tuple[float, float],
    active: tuple[float, float, float, float],
) -> dict[str, MeanStd]:
    names = ("epochs", "p_e_percent", "feedback_ratio")
    measures = {n: MeanStd(*m) for n, m in zip(names, (epochs, p_e, ratio), strict=True)}
    counts = zip(LETTERS, active, strict=True)
    return measures | {f"active_modules.{letter}": MeanStd(n, math.nan) for letter, n in counts}


PAPER = {
    50: _paper((18, 3.78), (2.76, 0.23), (0.23, 0.02), (1, 1.6, 2.7, 1.05)),
    100: _paper((17, 5.07), (2.73, 0.27), (0.24, 0.09), (1, 1.95, 2.25, 1.05)),
    200: _paper((14, 3.89), (2.76, 0.17), (0.20, 0.02), (1.05, 1.8, 2.25, 1)),
    400: _paper((15, 4.71), (2.79, 0.16), (0.23, 0.06), (1, 2.15, 2.65, 1.05)),
}
"""Table 1 of Tidemann & Öztürk 2008: measures by nodes; p_e in percent, 20 runs a row."""

_WITH_STD = (
    Column("epochs µ/σ", "epochs", 2),
    Column("p_e µ/σ, %", "p_e_percent", 2),
    Column("Σu_fb/Σu µ/σ", "feedback_ratio", 3),
)
_MEANS = (
    *(Column(f"active in {letter}", f"active_modules.{letter}", 2) for letter in LETTERS),
    Column("nmi", "nmi", 2),
    Column("repeatability", "repeatability.responsibility", 3),
    Column("modules used", "modules_used", 2),
)


@dataclass(frozen=True, kw_only=True)
class Table1(TrainingStudy):
    """Reproduce Table 1 of the paper: train the YMCA with networks of several sizes.

    Attributes:
        nodes: Sizes: neurons of each reservoir.
        models: Joint models (ours), or posture models (the paper's).
        rule: Learning rule: weighted (ours), gated (the paper's), or the path of a class.
        arms: Simulated arms, or arms that move ideally.
    """

    name: ClassVar[str] = "table1"
    nodes: tuple[int, ...] = (50, 100, 200, 400)
    models: Models = "joint"
    rule: str = "weighted"
    arms: Arms = "physics"

    def points(self) -> list[Point]:
        """Return a point for each size."""
        base = RunConfig.of(models=self.models, rule=self.rule, arms=self.arms, seed=self.seed)
        return [Point({"nodes": nodes}, base.replace(nodes=nodes)) for nodes in self.nodes]

    def table(self, records: Sequence[Record]) -> str:
        """Return for each size the paper's row, if it has one, and ours."""
        titles = ["nodes", "", *(c.title for c in (*_WITH_STD, *_MEANS)), "all used", "converged"]
        rows = []
        for nodes in self.nodes:
            own = matching(records, {"nodes": nodes})
            if nodes in PAPER:
                rows.append([str(nodes), "paper", *_cells(PAPER[nodes]), "–", "–"])
            ours = {c.measure: mean_std_over_seeds(own, *c.path) for c in (*_WITH_STD, *_MEANS)}
            ended = f"{converged(own)} of {self.runs}"
            rows.append([str(nodes), "ours", *_cells(ours), self._all_used(own), ended])
        title = f"Table 1: ymca, {self.rule} rule, {self.arms} arms"
        return f"{title}\n\n{markdown_table(titles, rows)}"

    def draw(self, path: Path, records: Sequence[Record]) -> None:
        """Write the figure."""
        title = f"Table 1: {self.rule} rule, {self.arms} arms, {self.runs} runs a size"
        write_figure(path, records, self.nodes, RunConfig.of().option("modules"), title)

    def _all_used(self, records: Sequence[Record]) -> str:
        """Return the share of the runs in which every module is dominant in some letter."""
        modules = RunConfig.of().option("modules")
        every = [one["modules_used"] == modules for one in records if not one["diverged"]]
        return f"{100 * sum(every) / len(every):.0f} %" if every else "–"


def _cells(measures: dict[str, MeanStd]) -> list[str]:
    found = [(measures.get(column.measure, _UNKNOWN), column) for column in (*_WITH_STD, *_MEANS)]
    texts = [one.text(column.digits, "/") for one, column in found]
    ends = len(_WITH_STD)
    return [*texts[:ends], *(text.split("/")[0] for text in texts[ends:])]


Runs: TypeAlias = Mapping[int, Sequence[Record]]  # by nodes

_OURS = module_colours(1)[0]
_APART = 0.17  # of the paper's and our place from the middle between them
_SPRAY = 0.16  # width over which runs are laid

_PALER = 0.5  # of a bar for one module less
_NAMED_SHARE = 10.0  # percent; less has no room for a number

_PANELS = (
    ("epochs until the end", "epochs"),
    ("p_e, %", "p_e_percent"),
    ("feedback ratio Σu_fb/Σu", "feedback_ratio"),
    ("nmi of letter and module", "nmi"),
)


def write_figure(
    path: Path, records: Sequence[Record], sizes: Sequence[int], modules: int, title: str
) -> None:
    """Draw the table.

    Args:
        path: The PNG file.
        records: Records of the finished runs.
        sizes: Numbers of nodes.
        modules: Number of modules.
        title: Title of the figure.
    """
    runs = {nodes: matching(records, {"nodes": nodes}) for nodes in sizes}
    with figure_file(path, 11.0, 6.2) as figure:
        axes = figure.subplots(2, 3)
        panels = [axes[0, 0], axes[0, 1], axes[0, 2], axes[1, 1]]
        for axis, (name, measure) in zip(panels, _PANELS, strict=True):
            _draw_runs(axis, runs, measure)
            axis.set_title(name, fontsize="medium")
        line: dict[str, Any] = {"color": INK, "linestyle": "--", "linewidth": 0.8, "zorder": 0}
        axes[0, 1].axhline(CRITERION, **line, label=f"the criterion, {CRITERION:g} %")
        _draw_active_modules(axes[1, 0], runs)
        _draw_modules_used(axes[1, 2], runs, modules)
        for axis in axes.flat:
            axis.spines[["top", "right"]].set_visible(False)
            axis.tick_params(labelsize="small")
        figure.suptitle(title, fontsize="large")
        handles, names = axes[0, 1].get_legend_handles_labels()
        once = dict(zip(names, handles, strict=True))
        figure.legend(
            once.values(), once.keys(), loc="outside lower center", ncols=4, fontsize="small"
        )


def _draw_runs(axis: Axes, runs: Runs, measure: str) -> None:
    """Draw a dot for each run, and our mean and deviation next to the paper's."""
    paper = {place: PAPER[nodes] for place, nodes in enumerate(runs) if nodes in PAPER}
    known = {p: measures[measure] for p, measures in paper.items() if measure in measures}
    apart = _APART if known else 0.0
    for place, own in enumerate(runs.values()):
        found = measured(own, measure)
        if not found:
            continue
        spray = np.linspace(-_SPRAY / 2, _SPRAY / 2, max(len(found), 2))[: len(found)]
        dots: dict[str, Any] = {
            "color": _OURS,
            "alpha": 0.35,
            "markeredgewidth": 0,
            "markersize": 7,
            "clip_on": False,  # a dot at 0 is whole
        }
        axis.plot(place + apart + spray, found, ".", **dots, label="a run of ours")
        _draw_mean(axis, place + apart, mean_std(found), _OURS, "ours, µ ± σ")
    for place, value in known.items():
        _draw_mean(axis, place - apart, value, DEMONSTRATED, "the paper, µ ± σ")
    _name_sizes(axis, runs)
    axis.set_ylim(bottom=0)


def _draw_mean(axis: Axes, place: float, value: MeanStd, colour: str, label: str) -> None:
    look: dict[str, Any] = {"markersize": 6, "capsize": 3, "linewidth": 1.5, "clip_on": False}
    axis.errorbar(place, value.mean, value.std, fmt="o", color=colour, **look, label=label)


def _draw_active_modules(axis: Axes, runs: Runs) -> None:
    """Draw for each letter how many modules are active, from the least size to the largest."""
    step = 0.7 / max(1, len(runs) - 1)
    for group, letter in enumerate(LETTERS):
        measure = f"active_modules.{letter}"
        places = group - 0.35 + step * np.arange(len(runs))
        ours = [mean_std(measured(own, *measure.split("."))).mean for own in runs.values()]
        paper = [PAPER[n][measure].mean if n in PAPER else np.nan for n in runs]
        axis.plot(places, paper, "o-", color=DEMONSTRATED, markersize=5, linewidth=1.2)
        axis.plot(places, ours, "o-", color=_OURS, markersize=5, linewidth=1.2)
    axis.set_xticks(range(len(LETTERS)), LETTERS)
    axis.set_ylim(bottom=0)
    axis.set_title("active modules, mean", fontsize="medium")
    axis.set_xlabel(f"letter; in each {', '.join(map(str, runs))} nodes", fontsize="small")


def _draw_modules_used(axis: Axes, runs: Runs, modules: int) -> None:
    """Draw which share of the runs uses how many modules."""
    used = [np.array(measured(own, "modules_used")) for own in runs.values()]
    below = np.zeros(len(used))
    for count in range(modules, 0, -1):
        share = np.array([100 * np.mean(u == count) if len(u) else 0.0 for u in used])
        shade = _PALER ** (modules - count)
        axis.bar(range(len(used)), share, 0.6, below, color=_OURS, alpha=shade)
        ink = "white" if shade > 0.6 else INK
        for place, (start, height) in enumerate(zip(below, share, strict=True)):
            if height >= _NAMED_SHARE:
                middle = start + height / 2
                axis.text(place, middle, str(count), color=ink, ha="center", va="center")
        below += share
    _name_sizes(axis, runs)
    axis.set_title(f"runs that use so many of {modules} modules, %", fontsize="medium")


def _name_sizes(axis: Axes, runs: Runs) -> None:
    axis.set_xticks(range(len(runs)), [str(nodes) for nodes in runs])
    axis.set_xlim(-0.5, len(runs) - 0.5)
    axis.set_xlabel("nodes", fontsize="small")
