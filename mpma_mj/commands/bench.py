"""`mpma bench`."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Annotated, Literal, get_args

import tyro

__all__ = ["Bench"]

Part = Literal["env", "agent", "video", "programs", "peers"]


@dataclass(frozen=True)
class Bench:
    """Time what this does beside what it cannot do without, and beside other people's libraries.

    Ratios are of the same round: what slows the machine down slows down both.
    """

    what: Annotated[tuple[Part, ...], tyro.conf.Positional] = ()
    """What is timed; all if nothing is named. Environments, one and many; acting, learning and
    training; frames of videos; whole programs; peers (`pip install -e '.[bench]'`)."""
    json: bool = False
    """Print JSON instead of tables."""

    def run(self) -> str:
        """Do it and return the report."""
        from mpma_mj.bench.parts import PARTS
        from mpma_mj.bench.report import as_json, as_markdown, joined
        from mpma_mj.training.config import versions
        from mpma_mj.training.progress import show_range

        parts = dict.fromkeys(self.what or get_args(Part))
        report = joined([PARTS[part](show_range) for part in parts])
        if self.json:
            return json.dumps({"versions": versions()} | as_json(report), indent=2)
        return as_markdown(report)
