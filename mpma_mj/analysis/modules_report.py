"""Report of the analysis of modules: tables and a figure."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from mpma_mj.analysis.information import Estimate, ResponsibilityInformation
from mpma_mj.analysis.modules import ModuleAnalysis, Repetition
from mpma_mj.analysis.synergies import ENOUGH, Synergies
from mpma_mj.kinematics import JOINT_NAMES
from mpma_mj.motions import Motion
from mpma_mj.utils.text import markdown_table
from mpma_mj.visualization.colours import INK, module_colours
from mpma_mj.visualization.figure_file import figure_file

__all__ = ["as_markdown", "joint_terms", "write_figure"]

Array = NDArray[np.float64]

# A synergy is described by the joints that make up this much of its squared length (choice).
_DESCRIBED = 0.8


def as_markdown(analysis: ModuleAnalysis) -> str:
    """Return the analysis as tables."""
    return "\n\n".join(
        [
            _shares(analysis),
            _information(analysis.information),
            _information_of_each(analysis.information),
            _synergies(analysis.synergies, analysis.module_output, analysis.joints),
            _repetition(analysis.repetition),
        ]
    )


def joint_terms(pattern: Array, joints: Sequence[str] = JOINT_NAMES) -> list[str]:
    """Return the joints that are strongest in a synergy, such as "+left elbow".

    Args:
        pattern: Joints in the positive and the negative direction, shape (16,), of length 1.
        joints: Names of the joints.
    """
    names = [f"{sign}{joint.replace('_', ' ')}" for sign in "+-" for joint in joints]
    order = np.argsort(-pattern, kind="stable")
    count = 1 + int(np.searchsorted(np.cumsum(pattern[order] ** 2), _DESCRIBED))
    return [names[i].replace("shoulder ", "") for i in order[:count]]


def _shares(analysis: ModuleAnalysis) -> str:
    rows = [
        (f"{kind} {name.replace('_', ' ')}".strip(), *map(_percent, share))
        for kind, names in analysis.shares.items()
        for name, share in names.items()
    ]
    return markdown_table(("share of, %", *_modules(len(analysis.module_output))), rows)


def _information(information: ResponsibilityInformation) -> str:
    """Return a row for each source, about all modules together."""
    entropy = information.entropy_bits[0]
    rows = []
    for source, r2 in information.r2.items():
        bits = information.bits[source]
        values = (r2.value[0], r2.by_chance[0], bits.value[0], bits.by_chance[0])
        share = bits.value[0] / entropy if entropy > 0 else np.nan
        rows.append((source, *map(_number, values), _percent(share)))
    head = ("λ from", "R²", "by chance", "bits", "by chance", f"% of {entropy:.2f} bits")
    return markdown_table(head, rows)


def _information_of_each(information: ResponsibilityInformation) -> str:
    """Return the information about each module, by chance in brackets."""
    rows = [
        (
            f"{source}, {unit}",
            *(
                f"{_number(value)} ({_number(chance)})"
                for value, chance in zip(
                    measures[source].value[1:], measures[source].by_chance[1:], strict=True
                )
            ),
        )
        for unit, measures in (("R²", information.r2), ("bits", information.bits))
        for source in ("posture", "context")
    ]
    rows.append(("entropy, bits", *map(_number, information.entropy_bits[1:])))
    return markdown_table(
        ("each alone (by chance)", *_modules(len(information.entropy_bits) - 1)), rows
    )


def _synergies(synergies: Synergies, output: Array, joints: Sequence[str]) -> str:
    factors = len(synergies.weights)
    reached = synergies.variance_accounted_for[factors - 1]
    named = [joint_terms(pattern, joints) for pattern in synergies.patterns]
    head = ("synergy", "strength, %", *_modules(len(output)), "joints")
    rows = [
        (str(k + 1), _percent(weight), *map(_percent, load), ", ".join(terms))
        for k, (weight, load, terms) in enumerate(
            zip(synergies.weights, synergies.loads, named, strict=True)
        )
    ]
    rows.append(("motor output", "100", *map(_percent, output), ""))
    count = f"{factors} synergies account" if factors > 1 else "1 synergy accounts"
    title = (
        f"{count} for {100 * reached:.1f} % of the motor outputs"
        f" (the least number for {100 * ENOUGH:.0f} %); % in each module:"
    )
    return f"{title}\n\n{markdown_table(head, rows)}"


def _repetition(repetition: Repetition) -> str:
    rows = [
        ("λ", *map(_number, repetition.responsibility)),
        ("motor output", *map(_number, repetition.module_output)),
    ]
    head = ("correlation between repetitions", *_modules(len(repetition.responsibility)))
    text = markdown_table(head, rows)
    course = repetition.recurrence
    if len(course) <= repetition.period:
        return text
    after, usual = course[repetition.period], course[1 : repetition.period + 1].mean()
    return (
        f"{text}\n\nsimilarity of λ to itself one repetition later {after:.2f}, after any time"
        f" {usual:.2f}"
    )


def _modules(count: int) -> list[str]:
    return [f"module {i + 1}" for i in range(count)]


def _percent(share: float) -> str:
    return "–" if np.isnan(share) else f"{100 * share:.0f}"


def _number(value: float) -> str:
    return "–" if np.isnan(value) else f"{value:z.2f}"


_MOST_NUMBERED = 8  # with more modules the numbers in the cells would touch
_DARK = 0.5  # least share that is drawn black, so that shares that are all alike look alike
_HEIGHTS = (1.3, 1.0, 1.0, 1.3, 0.8)  # of the panels on the right, relative
_ROW = 0.19  # height of a row of shares, inches
_SMALL: dict[str, Any] = {"fontsize": "x-small", "frameon": False, "borderaxespad": 0.2}
_CHANCE: dict[str, Any] = {"marker": "|", "color": "#d55e00", "markersize": 11, "mew": 2, "ls": ""}


def write_figure(path: Path, analysis: ModuleAnalysis, motion: Motion) -> None:
    """Write the figure: shares, information, synergies, repetitions.

    Args:
        path: The PNG file.
        analysis: The analysis.
        motion: The motion that was imitated.
    """
    rows = sum(len(names) for names in analysis.shares.values())
    with figure_file(path, 11.0, max(10.5, 1.5 + _ROW * rows)) as figure:
        grid = figure.add_gridspec(5, 2, width_ratios=[1.0, 1.25], height_ratios=_HEIGHTS)
        _draw_shares(figure.add_subplot(grid[:, 0]), analysis)
        panels = [figure.add_subplot(grid[row, 1]) for row in range(5)]
        _draw_information(panels[0], analysis.information)
        _draw_variance(panels[1], analysis.synergies)
        _draw_loads(panels[2], analysis.synergies, analysis.module_output)
        _draw_repetitions(panels[3], analysis.repetition, motion.rate)
        _draw_recurrence(panels[4], analysis.repetition, motion.rate)
        for panel in panels:
            panel.spines[["top", "right"]].set_visible(False)
        figure.suptitle(f"Modules ({motion.name})", fontsize="medium")


def _draw_shares(axis: Axes, analysis: ModuleAnalysis) -> None:
    """Draw a cell for each share and module."""
    kinds = analysis.shares
    table = np.array([share for names in kinds.values() for share in names.values()])
    darkest = max(_DARK, float(np.nanmax(table)))
    axis.imshow(table, cmap="Greys", vmin=0.0, vmax=darkest, aspect="auto")
    names = [
        f"{kind} {name}" if kind in ("label", "posture region") else name or "all steps"
        for kind, rows in kinds.items()
        for name in rows
    ]
    axis.set_yticks(range(len(names)), [name.replace("_", " ") for name in names], fontsize=8)
    modules = table.shape[1]
    axis.xaxis.tick_top()
    axis.set_xticks(range(modules), [str(i + 1) for i in range(modules)])
    for tick, colour in zip(axis.get_xticklabels(), module_colours(modules), strict=True):
        tick.set(color=colour, fontweight="bold")
    if modules <= _MOST_NUMBERED:
        for (row, module), share in np.ndenumerate(table):
            text = "" if np.isnan(share) else f"{100.0 * share:.0f}"
            colour = "white" if share > 0.5 * darkest else INK
            axis.text(module, row, text, ha="center", va="center", color=colour, fontsize=8)
    for end in np.cumsum([len(rows) for rows in kinds.values()])[:-1]:
        axis.axhline(end - 0.5, color=INK, linewidth=0.8)
    axis.set_title("Share of each module, %", fontsize="medium")
    axis.tick_params(length=0)


def _draw_information(axis: Axes, information: ResponsibilityInformation) -> None:
    """Draw the information in each source, as a share, and a mark at that by chance."""
    entropy = information.entropy_bits[0] if information.entropy_bits[0] > 0 else np.nan
    shares: tuple[tuple[str, str, dict[str, Estimate], float], ...] = (
        ("R² of a linear readout", "#7f7f7f", information.r2, 1.0),
        ("bits / entropy of the dominant module", "#d9d9d9", information.bits, entropy),
    )
    for number, (name, colour, measures, whole) in enumerate(shares):
        place = np.arange(len(measures)) + 0.38 * (number - 0.5)
        value = np.array([measure.value[0] for measure in measures.values()]) / whole
        chance = np.array([measure.by_chance[0] for measure in measures.values()]) / whole
        axis.barh(place, value, 0.36, color=colour, edgecolor=INK, linewidth=0.5, label=name)
        label = "by chance" if number == 0 else None
        axis.plot(chance, place, label=label, **_CHANCE)
    axis.set_yticks(range(len(information.r2)), list(information.r2))
    axis.set_ylim(len(information.r2) - 0.5, -0.5)
    axis.axvline(0.0, color=INK, linewidth=0.8)
    axis.set_title("Information about responsibility", fontsize="medium", pad=20)
    axis.legend(loc="lower center", bbox_to_anchor=(0.4, 0.98), ncols=3, **_SMALL)
    axis.set_xlim(right=1.05)


def _draw_variance(axis: Axes, synergies: Synergies) -> None:
    explained = 100.0 * synergies.variance_accounted_for
    enough = len(synergies.weights)
    axis.plot(np.arange(len(explained)) + 1, explained, "o-", color=INK, markersize=3.5, lw=1)
    axis.plot(enough, explained[enough - 1], "o", color="#d55e00", markersize=7)
    axis.axhline(100.0 * ENOUGH, color=INK, linestyle="--", linewidth=0.8)
    axis.set_xticks(np.arange(len(explained)) + 1)
    axis.set(ylim=(0.0, 105.0), xlabel="number of synergies", ylabel="variance\naccounted for, %")
    axis.set_title("Synergies in the modules' motor outputs", fontsize="medium")


def _draw_loads(axis: Axes, synergies: Synergies, output: Array) -> None:
    """Draw a bar for each synergy, divided among modules, and one for all motor output."""
    loads = np.concatenate([synergies.loads, output[None]])
    names = [*(str(k + 1) for k in range(len(synergies.loads))), "all"]
    below = np.zeros(len(loads))
    for load, colour in zip(loads.T, module_colours(len(output)), strict=True):
        axis.bar(range(len(loads)), 100.0 * load, 0.75, bottom=100.0 * below, color=colour)
        below = below + load
    axis.set_xticks(range(len(loads)), names)
    axis.set(ylim=(0.0, 100.0), xlabel="synergy", ylabel="in each\nmodule, %")


def _draw_repetitions(axis: Axes, repetition: Repetition, rate: float) -> None:
    _, period, modules = repetition.repetitions.shape
    time = np.arange(period) / rate
    for module, colour in enumerate(module_colours(modules)):
        for course in repetition.repetitions[:, :, module]:
            axis.plot(time, course, color=colour, linewidth=1.0, alpha=0.6)
    axis.set(ylim=(-0.03, 1.05), xlabel="time in a repetition, s", ylabel="λ")
    axis.margins(x=0)
    axis.set_title("λ of all repetitions", fontsize="medium")


def _draw_recurrence(axis: Axes, repetition: Repetition, rate: float) -> None:
    lag = np.arange(len(repetition.recurrence)) / rate
    axis.plot(lag, repetition.recurrence, color=INK, linewidth=1.2)
    axis.axvline(repetition.period / rate, color="#d55e00", linestyle="--", linewidth=1.0)
    axis.set(ylim=(0.0, 1.05), xlabel="lag, s; dashed: one repetition", ylabel="similarity\nof λ")
    axis.margins(x=0)
