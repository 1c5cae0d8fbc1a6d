"""Measure speed beside the necessary computations and other libraries; print tables as Markdown.

make bench                               # all but scaling, which takes minutes
make bench ARGS="environment training"   # or some of it
make bench ARGS=scaling
"""

from __future__ import annotations

import importlib
from typing import Annotated, Literal

import tyro

from benchmarks.speed.timing import Report, Sizes

Part = Literal["environment", "training", "programs", "peers", "scaling"]


def main(
    parts: Annotated[tuple[Part, ...], tyro.conf.Positional] = (
        *("environment", "training", "programs", "peers"),
    ),
    sizes: Annotated[Sizes, tyro.conf.arg(name="")] = Sizes(),  # noqa: B008
) -> None:
    """Measure speed, relative to the necessary computations and to other libraries.

    Args:
        parts: Environments, single and batched; acting, learning and training; whole programs and
            videos; peers (`pip install -e '.[bench]'`); training at many sizes, for minutes.
        sizes: How much is measured.
    """
    reports: list[Report] = []
    for part in dict.fromkeys(parts):
        reports.append(importlib.import_module(f"benchmarks.speed.{part}").measure(sizes))
    whole = Report(
        {name: values for one in reports for name, values in one.seconds.items()},
        {name: target for one in reports for name, target in one.targets.items()},
        tuple(note for one in reports for note in one.notes),
    )
    print(whole.markdown())


if __name__ == "__main__":
    tyro.cli(main)
