"""Tables of what trials came to."""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable, Sequence

from mpma_mj.evaluation.disturbances import DISTURBANCES, Level
from mpma_mj.experiments.robustness import THIS_RUN, Found
from mpma_mj.experiments.robustness_results import RECOVERED, Results
from mpma_mj.utils.atomic_files import csv_text
from mpma_mj.utils.text import markdown_table

__all__ = ["as_csv", "as_markdown", "courses_as_csv"]

_BEYOND = "beyond the arms"


def as_markdown(results: Results) -> str:
    """Return a table of p_e, and one of what learning on came to, if there was any."""
    seeds = {one.seed for one in results.found if one.agent != THIS_RUN}
    said = "p_e of the arms as they are, in %, without learning"
    if len(seeds) > 1:
        said += f"; means over {len(seeds)} seeds, in brackets their 95 % bootstrap intervals"
    parts = [_table(results, results.agents, lambda *where: results.p_e(*where).text), f"{said}."]
    if any(one.outcome == "diverged" for one in results.found):
        parts.append("What diverged counts in no mean.")
    if results.adapts:
        parts.append(_table(results, results.learners, lambda *where: _recovered(results, *where)))
        parts.append(
            f"Epochs of learning on until p_e was under {RECOVERED:g} %, median over seeds; of how"
            f" many seeds it ever was; and p_e in the epoch after {results.adapts} epochs of"
            " learning on."
        )
        idle = [agent for agent in results.agents if agent not in results.learners]
        if idle:
            parts.append(f"Left out, as they learn nothing more: {_listed(idle)}.")
    return "\n\n".join(parts) + "\n"


def _table(results: Results, agents: Sequence[str], cell: Callable[[str, str, Level], str]) -> str:
    """Return a table with a row for each level and a column for each agent."""
    titles = ["disturbance", "level", *(agent.replace("_", " ") for agent in agents)]
    rows: list[list[str]] = []
    for name, levels in results.levels.items():
        title = DISTURBANCES[name].title
        rows += [
            [title, _shown(level), *(cell(a, name, level) for a in agents)] for level in levels
        ]
        rows += [
            [title, _shown(level), *(_BEYOND for _ in agents)] for level in results.beyond[name]
        ]
    return markdown_table(titles, rows)


def _recovered(results: Results, agent: str, disturbance: str, level: Level) -> str:
    epochs = results.recovery(agent, disturbance, level)
    middle = statistics.median(epochs)
    shown = f"{middle:g}" if math.isfinite(middle) else f">{results.adapts}"
    there = sum(map(math.isfinite, epochs))
    after = results.p_e_after(agent, disturbance, level).text
    return f"{shown}; {there} of {len(epochs)}; {after}"


def as_csv(results: Results) -> str:
    """Return a row for each agent, disturbance, level and seed, without learning."""
    return csv_text(
        [
            _where(one) | {"outcome": one.outcome, "p_e_percent": one.p_e_percent}
            for one in results.found
        ]
    )


def courses_as_csv(results: Results) -> str:
    """Return the same for each number of epochs of learning on."""
    return csv_text(
        [
            _where(one) | {"epochs_learned": epochs, "p_e_percent": p_e}
            for one in results.found
            for epochs, p_e in enumerate(one.course)
        ]
    )


def _where(one: Found) -> dict[str, object]:
    """Return the cells that all rows begin with."""
    place = {"agent": one.agent, "disturbance": one.disturbance}
    return place | {"level": _shown(one.level), "seed": one.seed}


def _shown(level: Level) -> str:
    return level if isinstance(level, str) else f"{level:g}"


def _listed(names: Sequence[str]) -> str:
    return ", ".join(name.replace("_", " ") for name in names)
