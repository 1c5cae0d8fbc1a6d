"""The table of a sweep: a row for each point of the grid."""

from __future__ import annotations

from collections.abc import Sequence

from mpma_mj.experiments.folder import RunResult
from mpma_mj.experiments.measures import converged, of_point, remarks, spread
from mpma_mj.experiments.spec import SweepSpec, by_point
from mpma_mj.utils.text import markdown_table, option_name

__all__ = ["as_markdown"]

# Title, name in a summary, digits after the point.
_COLUMNS = (
    ("epochs", "epochs", 1),
    ("p_e, %", "p_e_percent", 2),
    ("feedback ratio", "feedback_ratio", 3),
    ("learned share", "learned_share", 3),
    ("nmi", "nmi", 2),
    ("modules used", "modules_used", 1),
)


def as_markdown(spec: SweepSpec, runs: Sequence[RunResult]) -> str:
    """Return the table: how many converged, and means ± standard deviations over seeds.

    Args:
        spec: What the sweep is.
        runs: Its finished runs.
    """
    varying = spec.varying
    titles = [*map(option_name, varying), "converged", *(title for title, _, _ in _COLUMNS)]
    rows = []
    for point, configs in by_point(spec.configs).items():
        own = of_point(runs, point)
        rows.append(
            [
                *(_shown(point.option(name)) for name in varying),
                f"{converged(own)} of {len(configs)}",
                *(spread(own, name).text(digits) for _, name, digits in _COLUMNS),
            ]
        )
    sentences = _paragraphs(remarks(runs, len(spec.configs)))
    return "\n".join([markdown_table(titles, rows), *sentences]) + "\n"


def _paragraphs(sentences: Sequence[str]) -> list[str]:
    return ["", " ".join(sentences)] if sentences else []


def _shown(value: object) -> str:
    if value is None:
        return "–"
    return " ".join(map(str, value)) if isinstance(value, tuple) else str(value)
