"""Report of a comparison of robots: tables."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mpma_mj.evaluation.statistics import interval
from mpma_mj.experiments.compare import Episode
from mpma_mj.experiments.compare_report import notes_on_means, number
from mpma_mj.experiments.compare_robots import OnRobot
from mpma_mj.robots.reachability import REACHED
from mpma_mj.utils.data_files import csv_text
from mpma_mj.utils.text import markdown_table

__all__ = ["as_csv", "as_markdown", "first_episodes"]

# Title, name of the measure, digits after the point.
_COLUMNS = (
    ("feedback ratio", "feedback_ratio", 3),
    ("lag, ms", "lag_ms", 1),
    ("top speed / limit", "speed_share", 2),
    ("mean torque, N m", "mean_torque_nm", 2),
    ("mean torque / limit", "torque_share", 2),
)
_NAMES = ("p_e_percent", *(name for _, name, _ in _COLUMNS))


def as_markdown(results: Sequence[OnRobot]) -> str:
    """Return tables of what robots can do, of their agents, and of the robots; and notes."""
    demands = [
        [
            one.robot.name,
            *(f"{100 * share:.1f}" for share in (one.reach.reachable, one.reach.feasible)),
            f"{one.reach.unavoidable:.2f}",
        ]
        for one in results
    ]
    agents = [
        [
            one.robot.name,
            number(one.epochs, 1),
            interval(one.values("p_e_percent")).text(2),
            interval(one.feedback[np.isfinite(one.feedback)].tolist()).text(2),
            *(number(one.values(name), digits) for _, name, digits in _COLUMNS),
        ]
        for one in results
    ]
    robots = [
        [one.robot.name, one.robot.title, _of_joints(one.limits.max_speed), one.robot.licence]
        for one in results
    ]
    agent_titles = [title for title, _, _ in _COLUMNS]
    parts = [
        markdown_table(
            ["robot", "reachable, %", "feasible, %", "unavoidable p_e, %"],
            demands,
        ),
        markdown_table(
            ["robot", "epochs", "p_e, %", "p_e of feedback alone, %", *agent_titles], agents
        ),
        markdown_table(
            ["robot", "title", "top speeds from the shoulder outward, rad/s", "licence"], robots
        ),
        *_notes(results),
    ]
    return "\n\n".join(parts) + "\n"


def as_csv(results: Sequence[OnRobot]) -> str:
    """Return a row for each agent on each robot, with all digits."""
    rows: list[dict[str, object]] = []
    for one in results:
        shared = {"robot": one.robot.name} | one.reach._asdict()
        for seed, epochs, episode, feedback in zip(
            one.seeds, one.epochs.tolist(), one.episodes, one.feedback.tolist(), strict=True
        ):
            measures = {} if episode is None else episode.measures
            own = {name: measures[name] for name in _NAMES if name in measures}
            rows.append(
                shared
                | {"seed": seed, "epochs": epochs}
                | own
                | {"feedback_alone_p_e_percent": feedback}
            )
    return csv_text(rows)


def first_episodes(results: Sequence[OnRobot]) -> dict[str, Episode]:
    """Return the first seed's episodes by the robots' titles; without those that diverged."""
    firsts = ((one.robot.title, one.episodes[0]) for one in results)
    return {title: episode for title, episode in firsts if episode is not None}


def _of_joints(values: np.ndarray) -> str:
    """Return a value of each joint, shape (8,), once where both arms have the same."""
    left, right = ([f"{value:g}" for value in arm] for arm in np.split(values, 2))
    return ", ".join(left if left == right else left + right)


def _notes(results: Sequence[OnRobot]) -> list[str]:
    notes = [
        f"Reachable: postures of the motion, each alone, within {REACHED:g}° of one that the ranges"
        f" of the joints allow. Feasible: within {REACHED:g}° after the whole motion is fitted to"
        " ranges and speeds. Unavoidable: the error of that fit, which no controller can avoid. All"
        " errors are from the original motion.",
        "One episode of each agent, without learning.",
    ]
    return [*notes, *notes_on_means([one.episodes for one in results])]
