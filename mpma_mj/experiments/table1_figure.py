"""The paper's Table 1 as a picture: every run of ours beside the paper's mean and spread."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from mpma_mj.agents.gain_schedule import CRITERION
from mpma_mj.experiments.folder import RunResult
from mpma_mj.experiments.measures import Spread, spread, values
from mpma_mj.experiments.spec import SweepSpec
from mpma_mj.experiments.table1 import LETTERS, PAPER, of_size
from mpma_mj.visualization.colours import DEMONSTRATED, INK, module_colours
from mpma_mj.visualization.figure_file import figure_file

__all__ = ["write_figure"]

_OURS = module_colours(1)[0]
_APART = 0.17  # of the paper's and our place from the middle between them
_SPRAY = 0.16  # width over which runs are laid side by side

_PALER = 0.5  # a bar beside the one of a module more
_NAMED_SHARE = 10.0  # percent; less has no room for a number

_PANELS = (
    ("epochs until the end", "epochs"),
    ("p_e, %", "p_e_percent"),
    ("feedback ratio Σu_fb/Σu", "feedback_ratio"),
    ("nmi of letter and module", "nmi"),
)


def write_figure(path: Path, spec: SweepSpec, runs: Sequence[RunResult]) -> None:
    """Draw the table.

    Args:
        path: The PNG file.
        spec: What the sweep is.
        runs: Its finished runs.
    """
    sizes = list(dict.fromkeys(config.option("nodes") for config in spec.configs))
    with figure_file(path, 11.0, 6.2) as figure:
        axes = figure.subplots(2, 3)
        panels = [axes[0, 0], axes[0, 1], axes[0, 2], axes[1, 1]]
        for axis, (title, measure) in zip(panels, _PANELS, strict=True):
            _every_run(axis, runs, sizes, measure)
            axis.set_title(title, fontsize="medium")
        line: dict[str, Any] = {"color": INK, "linestyle": "--", "linewidth": 0.8, "zorder": 0}
        axes[0, 1].axhline(CRITERION, **line, label=f"the criterion, {CRITERION:g} %")
        _active_modules(axes[1, 0], runs, sizes)
        _modules_used(axes[1, 2], runs, sizes, spec.configs[0].option("modules"))
        for axis in axes.flat:
            axis.spines[["top", "right"]].set_visible(False)
            axis.tick_params(labelsize="small")
        first = spec.configs[0]
        figure.suptitle(
            f"Table 1: {first.option('rule')} rule, {first.env.arms} arms,"
            f" {len(spec.configs) // len(sizes)} runs a size",
            fontsize="large",
        )
        handles, names = axes[0, 1].get_legend_handles_labels()
        once = dict(zip(names, handles, strict=True))
        figure.legend(
            once.values(), once.keys(), loc="outside lower center", ncols=4, fontsize="small"
        )


def _every_run(axis: Axes, runs: Sequence[RunResult], sizes: Sequence[int], measure: str) -> None:
    """Draw a dot a run, and mean and deviation beside the paper's."""
    paper = {place: PAPER[n] for place, n in enumerate(sizes) if n in PAPER}
    told = {p: line.measures[measure] for p, line in paper.items() if measure in line.measures}
    apart = _APART if told else 0.0
    for place, nodes in enumerate(sizes):
        found = values(of_size(runs, nodes), measure)
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
        _mean(axis, place + apart, spread(of_size(runs, nodes), measure), _OURS, "ours, µ ± σ")
    for place, value in told.items():
        _mean(axis, place - apart, value, DEMONSTRATED, "the paper, µ ± σ")
    _name_sizes(axis, sizes)
    axis.set_ylim(bottom=0)


def _mean(axis: Axes, place: float, value: Spread, colour: str, label: str) -> None:
    look: dict[str, Any] = {"markersize": 6, "capsize": 3, "linewidth": 1.5, "clip_on": False}
    axis.errorbar(place, value.mean, value.deviation, fmt="o", color=colour, **look, label=label)


def _active_modules(axis: Axes, runs: Sequence[RunResult], sizes: Sequence[int]) -> None:
    """Draw for each letter how many modules are active, from the least size to the largest."""
    step = 0.7 / max(1, len(sizes) - 1)
    for group, letter in enumerate(LETTERS):
        measure = f"active_modules.{letter}"
        places = group - 0.35 + step * np.arange(len(sizes))
        ours = [spread(of_size(runs, nodes), measure).mean for nodes in sizes]
        paper = [PAPER[n].measures[measure].mean if n in PAPER else np.nan for n in sizes]
        axis.plot(places, paper, "o-", color=DEMONSTRATED, markersize=5, linewidth=1.2)
        axis.plot(places, ours, "o-", color=_OURS, markersize=5, linewidth=1.2)
    axis.set_xticks(range(len(LETTERS)), LETTERS)
    axis.set_ylim(bottom=0)
    axis.set_title("active modules, mean", fontsize="medium")
    axis.set_xlabel(f"letter; in each {', '.join(map(str, sizes))} nodes", fontsize="small")


def _modules_used(
    axis: Axes, runs: Sequence[RunResult], sizes: Sequence[int], modules: int
) -> None:
    """Draw which share of the runs uses how many modules."""
    used = [np.array(values(of_size(runs, nodes), "modules_used")) for nodes in sizes]
    below = np.zeros(len(sizes))
    for count in range(modules, 0, -1):
        share = np.array([100 * np.mean(u == count) if len(u) else 0.0 for u in used])
        shade = _PALER ** (modules - count)
        axis.bar(range(len(sizes)), share, 0.6, below, color=_OURS, alpha=shade)
        ink = "white" if shade > 0.6 else INK
        for place, (start, height) in enumerate(zip(below, share, strict=True)):
            if height >= _NAMED_SHARE:
                middle = start + height / 2
                axis.text(place, middle, str(count), color=ink, ha="center", va="center")
        below += share
    _name_sizes(axis, sizes)
    axis.set_title(f"runs that use so many of {modules} modules, %", fontsize="medium")


def _name_sizes(axis: Axes, sizes: Sequence[int]) -> None:
    axis.set_xticks(range(len(sizes)), [str(nodes) for nodes in sizes])
    axis.set_xlim(-0.5, len(sizes) - 0.5)
    axis.set_xlabel("nodes", fontsize="small")
