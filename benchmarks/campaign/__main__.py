"""Try to lose or invent results: kills, damaged files, extreme options, leaks.

make campaign                          # ten minutes, all parts
make campaign SECONDS=7200 SEED=3
python -m benchmarks.campaign kills --seconds 3600
"""

from __future__ import annotations

import importlib
import sys
import time
from typing import Annotated, Literal

import tyro

from benchmarks.campaign.faults import Part, report

_Part = Literal["kills", "folders", "random-kills", "options", "leaks", "recordings"]
_MODULES = {
    "kills": ("kills", "kill_everywhere", 3.0),
    "folders": ("damaged_folders", "damage_folders", 2.5),
    "random-kills": ("random_kills", "kill_at_random", 1.0),
    "options": ("random_options", "try_options", 1.0),
    "leaks": ("leaks", "look_for_leaks", 1.5),
    "recordings": ("mangled_recordings", "mangle_recordings", 1.0),
}
"""Module and function of each part, and its share of the time."""


def main(
    parts: Annotated[tuple[_Part, ...], tyro.conf.Positional] = tuple(_MODULES),
    seconds: float = 600.0,
    seed: int | None = None,
    workers: int = 2,
) -> int:
    """Run parts of the campaign and print its faults and figures; 1 if there is a fault.

    Args:
        parts: What is tried.
        seconds: For all parts together; each tries as much as it has time for.
        seed: Seed of the order and of the damage; the time if not given.
        workers: Processes.
    """
    seed = int(time.time()) if seed is None else seed
    print(f"seed {seed}, {seconds:g} s", flush=True)
    share = seconds / sum(_MODULES[part][2] for part in parts)
    found: list[Part] = []
    for part in parts:
        module, function, weight = _MODULES[part]
        do = getattr(importlib.import_module(f"benchmarks.campaign.{module}"), function)
        began = time.monotonic()
        found += do(seed, share * weight, workers)
        print(f"{part}: {time.monotonic() - began:.0f} s", file=sys.stderr, flush=True)
    print(report(found))
    return int(any(part.faults for part in found))


if __name__ == "__main__":
    sys.exit(tyro.cli(main))
