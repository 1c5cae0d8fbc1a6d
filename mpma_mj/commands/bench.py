"""`mpma bench`."""

from __future__ import annotations

import dataclasses
import json
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

if TYPE_CHECKING:
    from mpma_mj.bench.environment import Report

__all__ = ["Bench"]


@dataclass(frozen=True)
class Bench:
    """Time a step of the environment beside the physics that is in it."""

    what: Annotated[Literal["env"], tyro.conf.Positional] = "env"
    """What is timed: environments, one and many."""
    json: bool = False
    """Print JSON instead of a table."""

    def run(self) -> str:
        """Do it and return the report."""
        from mpma_mj.bench.environment import measure
        from mpma_mj.training.progress import show_range

        report = measure(show_range)
        return json.dumps(_as_json(report), indent=2) if self.json else _as_table(report)


def _as_json(report: Report) -> dict[str, Any]:
    from mpma_mj.training.config import versions

    ratios = {
        name: dataclasses.asdict(ratio) | {"reached": ratio.reached}
        for name, ratio in report.ratios.items()
    }
    seconds = {name: dataclasses.asdict(spread) for name, spread in report.seconds.items()}
    return {"versions": versions(), "seconds": seconds, "ratios": ratios}


def _as_table(report: Report) -> str:
    rows = ["| time | median | least to greatest |", "|---|---|---|"]
    for name, spread in report.seconds.items():
        unit, scale = ("s", 1.0) if spread.median > 0.01 else ("µs", 1e6)
        median, least, greatest = (f"{scale * value:.3g}" for value in dataclasses.astuple(spread))
        rows.append(f"| {name} | {median} {unit} | {least} to {greatest} {unit} |")
    rows += ["", "| ratio | wanted | median | least to greatest |", "|---|---|---|---|"]
    for name, ratio in report.ratios.items():
        wanted = f"{'≥' if ratio.at_least else '≤'} {ratio.wanted:g}"
        median, least, greatest = (f"{value:.2f}" for value in dataclasses.astuple(ratio.spread))
        missed = "" if ratio.reached else " (missed)"
        rows.append(f"| {name} | {wanted} | {median}{missed} | {least} to {greatest} |")
    return "\n".join(rows)
