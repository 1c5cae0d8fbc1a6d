"""Study `agents`: all agents in the same environments, in one table and one figure."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar, get_args

import numpy as np

from mpma_mj.agents.registry import agent_class
from mpma_mj.errors import BadOptionError
from mpma_mj.evaluation.statistics import interval, mean_std
from mpma_mj.experiments.points import draw_points
from mpma_mj.experiments.records import Record, matching, measured, over_seeds
from mpma_mj.experiments.study import Count
from mpma_mj.experiments.training import COLUMNS, Point, TrainingStudy, short
from mpma_mj.motions.options import ReadingOptions
from mpma_mj.options import Arms
from mpma_mj.training.config import RunConfig
from mpma_mj.training.trainer import check_epochs
from mpma_mj.utils.text import markdown_table
from mpma_mj.visualization.colours import module_colours
from mpma_mj.visualization.figure_file import figure_file, label_decades

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["CompareAgents"]

_BUILT_IN = "ymca"

_MEASURES = ("p_e_percent", "feedback_ratio", "learned_share", "epochs", "environment_steps")
_COLUMNS = [COLUMNS[name] for name in (*_MEASURES, "nmi", "modules_used")]


@dataclass(frozen=True, kw_only=True)
class CompareAgents(TrainingStudy):
    """Train all agents on the YMCA and on recordings, with both kinds of arms.

    Attributes:
        motions: Recordings, or folders of them; each is learned separately.
        agents: Agents, or paths of classes such as my_agents.py:MyAgent.
        nodes: Neurons of each reservoir; each agent's own default if not given.
        stop: End a run when it has converged; otherwise train all epochs, of which the best counts.
        reading: Options of reading recordings.
    """

    name: ClassVar[str] = "agents"
    motions: tuple[str, ...] = ()
    agents: tuple[str, ...] = (
        *("mpma", "single", "adaptive", "resolved_rate", "mosaic", "hammer"),
        *("bc", "dagger", "promp", "dmp"),
        *("feedback_only", "open_loop", "random"),
    )
    runs: Count = 5
    nodes: int | None = None
    stop: bool = True
    reading: ReadingOptions = ReadingOptions()

    def points(self) -> list[Point]:
        """Return a point for each motion, kind of arms and agent.

        Raises:
            BadOptionError: There is no such agent, one needs more epochs, or a motion is given
                twice.
        """
        for agent in self.agents:
            try:
                agent_class(agent)
            except BadOptionError as error:
                problem = f"has '{agent}'; expected {error.expected}"
                raise BadOptionError(problem, option="agents", remedy=error.remedy) from None
        points = [
            Point(
                {"motion": base.motions[0], "arms": arms, "agent": agent},
                base.replace(arms=arms, agent=agent),
            )
            for base in self._bases()
            for arms in get_args(Arms)
            for agent in self.agents
        ]
        for _, config in points:
            check_epochs(config, self.epochs)
        return points

    def table(self, records: Sequence[Record]) -> str:
        """Return a row for each point."""
        titles = ["motion", "arms", "agent", "converged", *(column.title for column in _COLUMNS)]
        rows = []
        for labels, config in self.points():
            own = matching(records, labels)
            seconds = mean_std(measured(own, "seconds")).mean
            cells = self.cells(own, _COLUMNS, over_seeds)
            if not agent_class(config.agent_name).trainable:
                cells[0] = "–"
            names = short(labels["motion"]), labels["arms"], labels["agent"]
            rows.append([*names, *cells, f"{seconds:.2g}" if own else "–"])
        return (
            f"{markdown_table([*titles, 'seconds a run'], rows)}\n\n"
            "Means over seeds, in brackets their 95 % bootstrap intervals, unless all seeds have"
            " the same. A run's seconds are its share of the time in which one process trained"
            " several runs of the row together."
        )

    def draw(self, path: Path, records: Sequence[Record]) -> None:
        """Write the figure."""
        p_e = {
            tuple(labels.values()): measured(matching(records, labels), "p_e_percent")
            for labels, _ in self.points()
        }
        write_figure(path, p_e)

    def _bases(self) -> list[RunConfig]:
        """Return the config of each motion; options of reading apply to recordings only."""
        from mpma_mj.training.dataset import expand_folders

        motions = expand_folders(self.motions)
        for motion in motions:
            if motions.count(motion) > 1:
                raise BadOptionError(
                    f"{motion} is given twice; each is learned separately, give it once"
                )
        sizes = {} if self.nodes is None else {"nodes": self.nodes}
        built_in = RunConfig.of(tempo=self.reading.tempo, seed=self.seed, **sizes)
        of_recordings = dataclasses.replace(built_in, reading=self.reading)
        recordings = (motion for motion in motions if motion != _BUILT_IN)
        return [built_in, *(of_recordings.replace(motions=(motion,)) for motion in recordings)]


_MAX_COLUMNS = 3
_OFFSET = 0.17  # of both kinds of arms from the middle between them
_SPREAD = 0.12  # half the width over which runs are laid


def write_figure(path: Path, p_e: Mapping[tuple[str, ...], Sequence[float]]) -> None:
    """Draw p_e of every agent, a panel for each motion.

    Args:
        path: The PNG file.
        p_e: p_e of each run, percent, by motion, kind of arms and agent.
    """
    motions = list(dict.fromkeys(motion for motion, _, _ in p_e))
    columns = min(len(motions), _MAX_COLUMNS)
    rows = math.ceil(len(motions) / columns)
    with figure_file(path, 1.6 + 4.2 * columns, 0.6 + 3.2 * rows) as figure:
        axes = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
        for axis, motion in itertools.zip_longest(axes.flat, motions):
            if motion is None:
                axis.set_visible(False)
                continue
            own = {(arms, agent): runs for (m, arms, agent), runs in p_e.items() if m == motion}
            _draw(axis, own)
            axis.set_title(short(motion), fontsize="medium", loc="left")
        figure.supxlabel(
            "p_e, %, and the 95 % interval of its mean; pale: each run", fontsize="small"
        )
        handles, names = axes[0, 0].get_legend_handles_labels()
        figure.legend(
            handles, names, loc="outside upper right", ncols=2, fontsize="small", frameon=False
        )


def _draw(axis: Axes, p_e: Mapping[tuple[str, str], Sequence[float]]) -> None:
    """Draw one motion, a row for each agent."""
    agents = list(dict.fromkeys(agent for _, agent in p_e))
    kinds: tuple[str, ...] = get_args(Arms)
    for kind, colour, side in zip(kinds, module_colours(2), (-_OFFSET, _OFFSET), strict=True):
        own = {
            agents.index(agent) + side: runs for (arms, agent), runs in p_e.items() if arms == kind
        }
        for place, runs in own.items():
            places = place + np.linspace(-_SPREAD, _SPREAD, max(len(runs), 2))[: len(runs)]
            axis.plot(runs, places, ".", color=colour, alpha=0.35, markeredgewidth=0, markersize=6)
        found = [interval(runs) for runs in own.values()]
        draw_points(axis, np.array([*own]), found, colour, label=f"{kind} arms", horizontal=True)
    axis.set_xscale("log")
    names = [agent if ":" in agent else agent.replace("_", " ") for agent in agents]
    axis.set_yticks(range(len(agents)), names)
    axis.set_ylim(len(agents) - 0.5, -0.5)
    label_decades(axis.xaxis)
    axis.grid(axis="x", color="0.92")
    axis.set_axisbelow(True)
    axis.tick_params(labelsize="small")
    axis.spines[["top", "right"]].set_visible(False)
