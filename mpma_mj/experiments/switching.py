"""Study `switching`: plants are learned one after the other, then they switch unannounced."""

from __future__ import annotations

import statistics
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import NDArray

from mpma_mj.context import one_hot
from mpma_mj.envs.options import MASS_OPTIONS, EnvironmentOptions
from mpma_mj.envs.plants import Plant
from mpma_mj.experiments.points import draw_points
from mpma_mj.experiments.study import (
    DRAWN,
    Agents,
    Count,
    Record,
    Study,
    batches,
    of_agent,
    over_seeds,
)
from mpma_mj.options import Arms
from mpma_mj.training.config import RunConfig
from mpma_mj.utils.text import markdown_table
from mpma_mj.visualization.colours import INK, PAPER, module_colours
from mpma_mj.visualization.figure_file import draw_labels, figure_file

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from mpma_mj.experiments.switching_job import SwitchingJob
    from mpma_mj.visualization.video import Progress

__all__ = ["AGENTS", "PLANTS", "Switching"]

PLANTS: dict[str, dict[str, float]] = {
    "empty": {},
    "3 kg": {"payload": 3.0},
    "gain 0.6": {"actuator_gain": 0.6},
    "gain 1.5": {"actuator_gain": 1.5},
}
"""Options of the plants by name, in the order in which they are learned (choice)."""

AGENTS: Agents = {
    "mpma": {"agent": "mpma"},
    "mpma, 1 × 200": {"agent": "mpma", "modules": 1, "nodes": 200},
    "single, 200": {"agent": "single", "nodes": 200},
    "single, 800": {"agent": "single", "nodes": 800},
    "single, history": {"agent": "single", "nodes": 200, "history": True},
    "adaptive": {"agent": "adaptive"},
    "resolved rate": {"agent": "resolved_rate"},
    "oracle": {"agent": "oracle"},
}
"""Agents of the study."""

_LESIONED = "mpma"  # whose modules are switched off
_IN_VIDEO = ("mpma", "single, 200")


@dataclass(frozen=True, kw_only=True)
class Switching(Study):
    """Learn four plants one after the other, then imitate while they switch unannounced.

    Attributes:
        motion: Built-in motion, or path of a recording.
        arms: Simulated arms, or arms that move ideally.
        reverse: Learn the plants in reverse order.
        epochs: Epochs in each plant.
        agents: The agents.
    """

    name: ClassVar[str] = "switching"
    motion: str = "ymca"
    arms: Arms = "physics"
    reverse: bool = False
    epochs: Count = 3
    agents: Agents = field(default_factory=lambda: AGENTS)

    @property
    def plants(self) -> dict[str, dict[str, float]]:
        """The plants in their order; ideal arms have no mass, and carry no load."""
        left_out = set() if self.arms == "physics" else {*MASS_OPTIONS}
        order = reversed(PLANTS) if self.reverse else PLANTS
        return {name: PLANTS[name] for name in order if not {*PLANTS[name]} & left_out}

    def jobs(self) -> list[SwitchingJob]:
        """Return a job for each agent; errors as of `Study`."""
        from mpma_mj.experiments.switching_job import SwitchingJob
        from mpma_mj.training.dataset import read_motions
        from mpma_mj.training.trainer import check

        base = RunConfig.of(
            self.motion,
            arms=self.arms,
            plants=tuple(self.plants.values()),
            epochs_per_plant=self.epochs,
            seed=self.seed,
        )
        motion = read_motions(base)
        check(base, motion)
        return [
            SwitchingJob(
                agent=name,
                configs=configs,
                motion=motion,
                plants=tuple(self.plants),
                drawn_seed=self.seed,
                lesions=name == _LESIONED,
            )
            for name, configs in batches(self.agents, base, self.runs)
        ]

    def table(self, records: Sequence[Record]) -> str:
        """Return the table of agents, and the lesions of mpma."""
        head = ["agent", *self.plants, "mean", "switched", "first plant kept", "plants found"]
        head += ["steps to lead", "right plant leads", "learned share", "feedback ratio"]
        rows = [self._row(agent, of_agent(records, agent)) for agent in self.agents]
        parts = [
            markdown_table(head, rows),
            f"p_e in %; means over {self.runs} seeds with 95 % bootstrap intervals. First plant"
            f" kept: p_e in {next(iter(self.plants))} after all plants over p_e there before the"
            f" second. Plants found: runs that found exactly {len(self.plants)}. Steps to lead:"
            " median from a switch to the first step in which the modules of the right plant"
            " lead; the whole stretch where they never do. Right plant leads: share of steps while"
            f" plants switch; where two share modules, these count in both.",
        ]
        lesioned = [one for one in of_agent(records, _LESIONED) if "lesion" in one]
        if lesioned:
            cells = [
                [off, *(over_seeds(lesioned, "lesion", off, on).text(2) for on in self.plants)]
                for off in self.plants
            ]
            parts += [
                markdown_table(
                    ["modules switched off", *(f"in {on}" for on in self.plants)], cells
                ),
                f"p_e of {_LESIONED} over that of the intact agent, by the plant whose modules are"
                " switched off and the plant that is on.",
            ]
        return "\n\n".join(parts)

    def draw(self, path: Path, records: Sequence[Record]) -> None:
        """Write the figure."""
        write_figure(path, records, tuple(self.agents), tuple(self.plants))

    def write_video(self, path: Path, records: Sequence[Record], progress: Progress) -> None:
        """Write the video of the first agent next to one that does not distinguish plants."""
        from mpma_mj.experiments.switching_video import write_video

        drawn = _drawn(records, self.agents)
        plants = tuple(Plant(**options) for options in self.plants.values())
        options = EnvironmentOptions(arms=self.arms, plants=plants)
        episodes = {agent: drawn[agent] for agent in _IN_VIDEO if agent in drawn}
        if episodes:
            write_video(path, episodes, tuple(self.plants), options, progress)

    def _row(self, agent: str, records: Sequence[Record]) -> list[str]:
        cells = [over_seeds(records, "p_e", plant).text(2) for plant in self.plants]
        cells += [over_seeds(records, name).text(3) for name in ("mean", "switched")]
        cells.append(over_seeds(records, "first_kept").text(2))
        found = [one["plants"] for one in records if one.get("plants") is not None]
        cells.append(f"{found.count(len(self.plants))} of {len(found)}" if found else "–")
        steps = [s for one in records for s in one.get("steps_to_lead") or ()]
        cells.append(f"{statistics.median(steps):g}" if steps else "–")
        shares = ("right_share", "learned_share", "feedback_ratio")
        return [agent, *cells, *(over_seeds(records, name).text(3) for name in shares)]


Array = NDArray[np.float64]

_RIVALS = ("single, 200", "resolved rate")  # whose errors are drawn over time, too
_CONTRAST = (INK, "#d55e00", "#7f8794")  # of the agents whose errors are drawn over time
_OTHER = "#4f6d7a"  # of the other agents
_WINDOW = 5  # steps over which these are averaged
_OFFSET = 0.14  # of points from the middle of an agent's row
_TINT = 0.13  # opacity of plants behind errors
_PALEST = 0.6  # share of white in the palest module of a plant
_FOREIGN = "#b9bec7"  # plants of the agent that answer for no true one


def write_figure(
    path: Path, records: Sequence[Record], agents: Sequence[str], plants: Sequence[str]
) -> None:
    """Draw an episode with switches above the results of all agents.

    Args:
        path: The PNG file.
        records: Records of all runs.
        agents: Names of the agents, the first of which is drawn in the episode.
        plants: Names of the plants.
    """
    shown = _drawn(records, agents)
    drawn = [agents[0], *_RIVALS]
    lesioned = [one for one in of_agent(records, agents[0]) if "lesion" in one]
    with figure_file(path, 11.0, 8.6) as figure:
        grid = figure.add_gridspec(4, 2, height_ratios=(2.6, 0.55, 1.8, 4.6), width_ratios=(1.7, 1))
        strip = figure.add_subplot(grid[0, :])
        below = [figure.add_subplot(grid[row, :], sharex=strip) for row in (1, 2)]
        episode = shown.get(agents[0])
        if episode is not None and "responsibility" in episode:
            _draw_strip(strip, episode, plants)
            _draw_plants(below, episode, plants)
            _draw_errors(below[1], shown, drawn)
            strip.set_title(
                f"Who leads in {agents[0]}: hue = plant, shade = module inside it."
                f" Which plant is on is hidden.\n",
                fontsize="medium",
            )
            labels = one_hot(np.array(episode["label"]), len(episode["labels"]))
            draw_labels([strip], labels, episode["labels"], episode["rate"])
        for axis in (strip, below[0]):
            axis.tick_params(labelbottom=False)
        colours = dict(zip(drawn, _CONTRAST, strict=True))
        _draw_agents(figure.add_subplot(grid[3, 0]), records, agents, colours)
        if lesioned:
            _draw_lesions(figure.add_subplot(grid[3, 1]), lesioned, plants)


def _drawn(records: Sequence[Record], agents: Iterable[str]) -> dict[str, Record]:
    """Return the episodes that are drawn, by their agents."""
    return {
        agent: one[DRAWN] for agent in agents for one in of_agent(records, agent) if DRAWN in one
    }


def _shades(colour: str, count: int) -> list[tuple[float, ...]]:
    """Return a colour and paler ones of the same hue."""
    from matplotlib.colors import to_rgb

    base, white = np.array(to_rgb(colour)), np.ones(3)
    mix = np.linspace(0.0, _PALEST, count) if count > 1 else [0.0]
    return [tuple(((1 - share) * base + share * white).tolist()) for share in mix]


def _edges(episode: Record) -> Array:
    return np.arange(len(episode["plant"]) + 1) / episode["rate"]


def _draw_strip(axis: Axes, episode: Record, plants: Sequence[str]) -> None:
    """Stack responsibilities in the order of true plants, modules of a plant in shades."""
    share = np.array(episode["responsibility"])
    modules, matched = episode["modules"], list(dict.fromkeys(episode["matched"]))
    others = [w for w in range(share.shape[1] // modules) if w not in matched]
    hues = dict(zip(plants, module_colours(len(plants)), strict=True))
    base, times = np.zeros(len(share)), _edges(episode)
    for found in [*matched, *others]:
        true = found in matched and plants[episode["matched"].index(found)]
        for k, colour in enumerate(_shades(hues[true] if true else _FOREIGN, modules)):
            top = base + share[:, found * modules + k]
            axis.fill_between(
                times,
                np.append(base, base[-1]),
                np.append(top, top[-1]),
                step="post",
                color=colour,
                linewidth=0,
            )
            base = top
    axis.set_ylim(0, 1)
    axis.set_yticks([0, 1])
    axis.set_ylabel("responsibility λ\nof modules")


def _draw_plants(axes: Sequence[Axes], episode: Record, plants: Sequence[str]) -> None:
    """Draw the true plants as bands with names, and tint the axes below."""
    plant, rate = np.array(episode["plant"]), episode["rate"]
    starts = np.flatnonzero(np.diff(plant, prepend=-1))
    colours = module_colours(len(plants))
    for start, end in zip(starts, [*starts[1:], len(plant)], strict=True):
        for axis, opacity in zip(axes, (1.0, _TINT), strict=True):
            colour = colours[plant[start]]
            axis.axvspan(start / rate, end / rate, color=colour, alpha=opacity, linewidth=0)
        axes[0].text(
            0.5 * (start + end) / rate,
            0.5,
            plants[plant[start]],
            transform=axes[0].get_xaxis_transform(),
            color=PAPER,
            ha="center",
            va="center",
            fontsize="small",
            fontweight="bold",
        )
    axes[0].set_yticks([])
    axes[0].set_ylabel("true\nplant", rotation=0, ha="right", va="center")


def _draw_errors(axis: Axes, shown: Mapping[str, Record], agents: Sequence[str]) -> None:
    """Draw the errors of some agents over time."""
    for agent, colour in zip(agents, _CONTRAST, strict=True):
        if agent in shown:
            error = np.array(shown[agent]["error"])
            smooth = np.convolve(error, np.full(_WINDOW, 1.0 / _WINDOW), "same")
            time = (np.arange(len(error)) + 0.5) / shown[agent]["rate"]
            axis.plot(time, smooth, color=colour, linewidth=1.4, label=agent)
    axis.set_ylim(0)
    axis.set_ylabel("error, %\n(0.25 s mean)")
    axis.set_xlabel("time, s")
    axis.spines[["top", "right"]].set_visible(False)
    axis.legend(loc="upper right", ncols=len(_CONTRAST), frameon=False, fontsize="small")


def _draw_agents(
    axis: Axes, records: Sequence[Record], agents: Sequence[str], colours: Mapping[str, str]
) -> None:
    """Draw p_e of each agent where plants stay and where they switch."""
    for place, agent in zip(range(len(agents), 0, -1), agents, strict=True):
        colour, own = colours.get(agent, _OTHER), of_agent(records, agent)
        for measure, offset, filled in (("mean", _OFFSET, True), ("switched", -_OFFSET, False)):
            found, where = [over_seeds(own, measure)], np.array([place + offset])
            draw_points(axis, where, found, colour, filled=filled, horizontal=True)
    for label, filled in (("one plant an episode, mean", True), ("switched every 1 to 3 s", False)):
        face = INK if filled else PAPER
        axis.plot([], [], "o", color=INK, markerfacecolor=face, label=label)
    axis.set_yticks(range(len(agents), 0, -1), agents)
    axis.set_xlim(0)
    axis.set_xlabel("p_e, %")
    axis.grid(axis="x", color="0.9")
    axis.set_axisbelow(True)
    axis.spines[["top", "right"]].set_visible(False)
    axis.legend(loc="lower center", fontsize="small")


def _draw_lesions(axis: Axes, records: Sequence[Record], plants: Sequence[str]) -> None:
    """Draw by how much p_e grows in each plant without the modules of each."""
    ratio = np.array(
        [[over_seeds(records, "lesion", off, on).mean for on in plants] for off in plants]
    )
    axis.imshow(np.log(ratio), cmap="Reds", vmin=0.0, vmax=max(np.log(ratio).max(), 1.0))
    for (row, column), value in np.ndenumerate(ratio):
        dark = np.log(value) > 0.6 * np.log(ratio).max()
        text = f"×{value:.1f}" if value < 10 else f"×{value:.0f}"
        axis.text(column, row, text, ha="center", va="center", color=PAPER if dark else INK)
    axis.set_xticks(range(len(plants)), plants)
    axis.set_yticks(range(len(plants)), plants)
    axis.set_xlabel("plant that is on")
    axis.set_ylabel("modules switched off")
    axis.set_title("p_e without the modules of a plant, over intact", fontsize="medium")
