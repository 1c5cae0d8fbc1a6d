"""Mangled recordings, as `benchmarks.damaged_recordings` makes and judges them."""

from __future__ import annotations

import zlib
from collections.abc import Sequence

from benchmarks.campaign.faults import Fault, Part
from benchmarks.campaign.workers import spread
from benchmarks.damage.layouts import LAYOUTS
from benchmarks.damaged_recordings import RESULTS, WRONG, try_layout

__all__ = ["mangle_recordings"]

_FILES = 25  # of a layout at a time
_ROUNDS = 10
_SILENT = RESULTS[3]
_FEW = 2  # that chance may bring into a short campaign (choice)
_ALLOWED = 15 / 4200  # share of files that may give another posture without a warning


def mangle_recordings(seed: int, seconds: float, workers: int) -> list[Part]:
    """Mangle recordings of all layouts, until time is up.

    Args:
        seed: Seed of the damage.
        seconds: For all.
        workers: Processes.
    """
    tries = [(name, number) for number in range(_ROUNDS) for name in LAYOUTS]

    def do(one: tuple[str, int]) -> list[Fault]:
        name, number = one
        own = zlib.crc32(f"{seed} {number}".encode())
        again = f"python -m benchmarks.damaged_recordings '{name}' --seed {own} --files {_FILES}"
        outcomes = list(try_layout(name, own, _FILES))
        faults = [
            Fault(f"{outcome.result}: {name}, {outcome.damage}, {outcome.error:.2f}", again)
            for outcome in outcomes
            if outcome.result in RESULTS[3:]
        ]
        return faults if outcomes else [Fault(f"{name}: the whole file is not read", again)]

    done, faults = spread(tries, do, workers=workers, seconds=seconds)
    files = done * _FILES
    silent = [fault for fault in faults if fault.what.startswith(_SILENT)]
    counted: Sequence[Fault] = faults
    allowed = max(_FEW, round(_ALLOWED * files))
    if len(silent) <= allowed:
        counted = [fault for fault in faults if fault not in silent]
    note = f"{len(silent)} silently wrong by more than {WRONG:g}, of {allowed} allowed"
    return [Part("mangled recordings", files, len(tries) * _FILES, counted, note)]
