"""Command `mpma bench`."""

from __future__ import annotations

import contextlib
import json
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import tyro

from mpma_mj.commands.folders import output_folder
from mpma_mj.errors import BadOptionError

if TYPE_CHECKING:
    from mpma_mj.bench.scaling import Scaling

__all__ = ["Bench"]

_SCALING = "scaling"
Part = Literal["env", "agent", "video", "programs", "peers", "scaling"]


@dataclass(frozen=True)
class Bench:
    """Measure speed, relative to the necessary computations and to other libraries.

    Each ratio is measured within one round, so that the load of the machine affects both alike.
    """

    what: Annotated[tuple[Part, ...], tyro.conf.Positional] = ()
    """Parts to measure: environments, single and batched; acting, learning and training; frames
    of videos; whole programs; peers (`pip install -e '.[bench]'`). All of these, which take seconds
    each, if none is given. And scaling, which takes minutes: training at many sizes."""
    json: bool = False
    """Print JSON instead of tables."""
    out: Path | None = None
    """Folder of the tables and the figure of scaling; runs/scaling-TIME if not given."""

    def run(self) -> str:
        """Run the benchmarks and return the report."""
        if self.out is not None and _SCALING not in self.what:
            raise BadOptionError("--out is the folder of scaling; add scaling, or drop --out")
        from mpma_mj.bench import scaling
        from mpma_mj.bench.parts import PARTS
        from mpma_mj.bench.report import as_json, as_markdown, joined
        from mpma_mj.training.config import versions
        from mpma_mj.utils.progress import show_range

        parts = dict.fromkeys(self.what or PARTS)
        content, text = {}, []
        with contextlib.ExitStack() as stack:
            if _SCALING in parts:
                folder = stack.enter_context(output_folder(self.out, _SCALING))
            reports = [PARTS[part](show_range) for part in parts if part != _SCALING]
            if _SCALING in parts:
                sizes = scaling.measure(show_range)
                reports.append(sizes.report())
                content, text = {_SCALING: sizes.rows()}, [sizes.markdown()]
                _write(folder, sizes)
                print(f"mpma: tables and figure are in {folder}", file=sys.stderr)
        report = joined(reports)
        if self.json:
            return json.dumps({"versions": versions()} | as_json(report) | content, indent=2)
        return "\n\n".join([*text, as_markdown(report)])


def _write(folder: Path, sizes: Scaling) -> None:
    """Write the results of scaling as JSON, CSV, Markdown and a figure."""
    from mpma_mj.bench.report import as_json, as_markdown
    from mpma_mj.bench.scaling_figure import write_figure
    from mpma_mj.training.config import versions
    from mpma_mj.utils.atomic_files import csv_text, write_json, write_text

    report = sizes.report()
    content = {"versions": versions()} | as_json(report) | {_SCALING: sizes.rows()}
    write_json(folder / "scaling.json", content)
    write_text(folder / "scaling.csv", csv_text(sizes.rows()))
    write_text(folder / "scaling.md", f"{sizes.markdown()}\n\n{as_markdown(report)}\n")
    write_figure(folder / "scaling.png", sizes)
