"""Figure of the study `switching`: who leads while plants switch, and how well agents imitate."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from numpy.typing import NDArray

from mpma_mj.context import one_hot
from mpma_mj.experiments.points import draw_points
from mpma_mj.experiments.study import Record, of_agent, over_seeds
from mpma_mj.visualization.colours import INK, PAPER, module_colours
from mpma_mj.visualization.figure_file import draw_labels, figure_file

__all__ = ["write_figure"]

Array = NDArray[np.float64]

_RIVALS = ("single, 200", "resolved rate")  # whose errors are drawn over time, too
_CONTRAST = (INK, "#d55e00", "#9aa0ab")
_WINDOW = 5  # steps over which these are averaged
_OFFSET = 0.14  # of points from the middle of an agent's row
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
    shown = {
        agent: one["episode"]
        for agent in agents
        for one in of_agent(records, agent)
        if "episode" in one
    }
    lesioned = [one for one in of_agent(records, agents[0]) if "lesion" in one]
    with figure_file(path, 11.0, 8.6) as figure:
        grid = figure.add_gridspec(4, 2, height_ratios=(2.6, 0.55, 1.8, 4.6), width_ratios=(1.7, 1))
        strip = figure.add_subplot(grid[0, :])
        below = [figure.add_subplot(grid[row, :], sharex=strip) for row in (1, 2)]
        episode = shown.get(agents[0])
        if episode is not None and "responsibility" in episode:
            _draw_strip(strip, episode, plants)
            _draw_plants(below[0], episode, plants)
            _draw_errors(below[1], shown, [agents[0], *_RIVALS])
            labels = one_hot(np.array(episode["label"]), len(episode["labels"]))
            draw_labels([strip], labels, episode["labels"], episode["rate"])
        for axis in (strip, below[0]):
            axis.tick_params(labelbottom=False)
        _draw_agents(figure.add_subplot(grid[3, 0]), records, agents)
        if lesioned:
            _draw_lesions(figure.add_subplot(grid[3, 1]), lesioned, plants)


def _shades(colour: str, count: int) -> list[tuple[float, ...]]:
    """Return a colour and paler ones of the same hue."""
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


def _draw_plants(axis: Axes, episode: Record, plants: Sequence[str]) -> None:
    plant, rate = np.array(episode["plant"]), episode["rate"]
    starts = np.flatnonzero(np.diff(plant, prepend=-1))
    colours = module_colours(len(plants))
    for start, end in zip(starts, [*starts[1:], len(plant)], strict=True):
        axis.axvspan(start / rate, end / rate, color=colours[plant[start]], linewidth=0)
        middle = 0.5 * (start + end) / rate
        axis.text(
            middle,
            0.5,
            plants[plant[start]],
            color=PAPER,
            ha="center",
            va="center",
            fontsize="small",
            fontweight="bold",
            transform=axis.get_xaxis_transform(),
            clip_on=True,
        )
    axis.set_yticks([])
    axis.set_ylabel("true\nplant", rotation=0, ha="right", va="center")


def _draw_errors(axis: Axes, shown: Mapping[str, Record], agents: Sequence[str]) -> None:
    """Draw the errors of some agents over time, averaged over a fifth of a second or so."""
    for agent, colour in zip(agents, _CONTRAST, strict=False):
        if agent in shown:
            error = np.array(shown[agent]["error"])
            smooth = np.convolve(error, np.full(_WINDOW, 1.0 / _WINDOW), "same")
            time = (np.arange(len(error)) + 0.5) / shown[agent]["rate"]
            axis.plot(time, smooth, color=colour, linewidth=1.4, label=agent)
    axis.set_ylim(0)
    axis.set_ylabel("error, %")
    axis.set_xlabel("time, s")
    axis.spines[["top", "right"]].set_visible(False)
    axis.legend(loc="upper right", ncols=len(_CONTRAST), frameon=False, fontsize="small")


def _draw_agents(axis: Axes, records: Sequence[Record], agents: Sequence[str]) -> None:
    """Draw p_e of each agent where plants stay and where they switch."""
    places = np.arange(len(agents), 0, -1).astype(float)
    for measure, label, filled in (
        ("mean", "one plant an episode, mean of all", True),
        ("switched", "switched every 1 to 3 s", False),
    ):
        found = [over_seeds(of_agent(records, agent), measure) for agent in agents]
        offset = _OFFSET if filled else -_OFFSET
        draw_points(axis, places + offset, found, INK, label=label, filled=filled, horizontal=True)
    axis.set_yticks(places, agents)
    axis.set_xlim(0)
    axis.set_xlabel("p_e, %")
    axis.grid(axis="x", color="0.9")
    axis.set_axisbelow(True)
    axis.spines[["top", "right"]].set_visible(False)
    axis.legend(loc="lower right", fontsize="small")


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
    axis.set_title("p_e of mpma against intact", fontsize="medium")
