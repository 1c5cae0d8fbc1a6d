"""What was measured, as a table and as JSON."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from mpma_mj.bench.timing import Bound, Ratio, Spread, Target

__all__ = ["Report", "as_json", "as_markdown", "joined"]

_UNITS = (("s", 1.0), ("ms", 1e3), ("µs", 1e6))  # and how many make a second


@dataclass(frozen=True)
class Report:
    """What was measured.

    Attributes:
        seconds: Times by what was timed.
        ratios: What is wanted of a time beside another of the same rounds, by name.
        bounds: What is wanted of a quantity itself, by name.
        notes: What else there is to say, such as what could not be measured; a line each.
    """

    seconds: dict[str, Spread] = field(default_factory=dict)
    ratios: dict[str, Ratio] = field(default_factory=dict)
    bounds: dict[str, Bound] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


def joined(reports: Sequence[Report]) -> Report:
    """Return several reports, whose names are their own, as one."""
    whole = Report(notes=tuple(note for report in reports for note in report.notes))
    for report in reports:
        whole.seconds.update(report.seconds)
        whole.ratios.update(report.ratios)
        whole.bounds.update(report.bounds)
    return whole


def as_json(report: Report) -> dict[str, Any]:
    """Return a report as JSON can hold it."""
    return {
        "seconds": {name: dataclasses.asdict(spread) for name, spread in report.seconds.items()},
        "ratios": _targets_as_json(report.ratios),
        "bounds": _targets_as_json(report.bounds),
        "notes": list(report.notes),
    }


def _targets_as_json(targets: Mapping[str, Target]) -> dict[str, Any]:
    return {
        name: dataclasses.asdict(target) | {"reached": target.reached}
        for name, target in targets.items()
    }


def as_markdown(report: Report) -> str:
    """Return a report as tables: times, ratios, bounds; and the notes."""
    parts = []
    if report.seconds:
        times = map(_time, report.seconds, report.seconds.values())
        parts.append(["| time | median | least to greatest |", "|---|---|---|", *times])
    for title, targets in (("ratio", report.ratios), ("bound", report.bounds)):
        if targets:
            rows = map(_target, targets, targets.values())
            head = f"| {title} | wanted | median | least to greatest |"
            parts.append([head, "|---|---|---|---|", *rows])
    parts += [[note] for note in report.notes]
    return "\n\n".join("\n".join(part) for part in parts)


def _time(name: str, spread: Spread) -> str:
    unit, scale = next((u for u in _UNITS if u[1] * spread.median >= 1.0), _UNITS[-1])
    median, least, greatest = (f"{scale * value:.3g}" for value in dataclasses.astuple(spread))
    return f"| {name} | {median} {unit} | {least} to {greatest} {unit} |"


def _target(name: str, target: Target) -> str:
    unit = f" {target.unit}" if isinstance(target, Bound) and target.unit else ""
    wanted = f"{'≥' if target.at_least else '≤'} {target.wanted:g}{unit}"
    values = dataclasses.astuple(target.spread)
    # Of a hundred and more, as of frames a second, what stands after the point is noise.
    median, least, greatest = (
        f"{value:.0f}" if value >= 100 else f"{value:.2f}" for value in values
    )
    missed = "" if target.reached else " (missed)"
    return f"| {name} | {wanted} | {median}{unit}{missed} | {least} to {greatest}{unit} |"
