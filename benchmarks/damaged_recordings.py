"""Damage recordings at random, read them, and count what becomes of them, as Markdown.

python -m benchmarks.damaged_recordings --seed 1
python -m benchmarks.damaged_recordings --seed 1 --checkout OTHER    # the package of another one
"""

from __future__ import annotations

import json
import os
import select
import subprocess
import sys
import tempfile
import zlib
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import tyro
from numpy.typing import NDArray

from benchmarks.damage.layouts import LAYOUTS
from benchmarks.damage.mangling import mangle
from mpma_mj.utils.text import markdown_table

Array = NDArray[np.float64]
Answer = dict[str, Any]

RESULTS = ("right", "warned", "refused", "silently wrong", "traceback", "timeout")
SECONDS = 20.0  # for a file
WRONG = 0.01  # of a posture
TELLING = ("bridged", "cut ", "missing")  # words in a step that says what was lost
SKELETON = 0.2  # share of the damage that is the skeleton's, where it is a file of its own
TABLES = (".csv", ".tsv", ".trc")
ROOT = Path(__file__).parent.parent


class Outcome(NamedTuple):
    """What became of a damaged file: how it was damaged, one of RESULTS, and its largest error."""

    damage: str
    result: str
    error: float = 0.0


class Reader:
    """A process that reads recordings with the package of a checkout."""

    def __init__(self, checkout: Path) -> None:
        """Start the process; `checkout` is the folder of the package."""
        self._checkout = checkout
        self._process = self._start()

    def _start(self) -> subprocess.Popen[str]:
        process = subprocess.Popen(
            [sys.executable, str(ROOT / "benchmarks" / "damage" / "reader.py")],
            env=os.environ | {"PYTHONPATH": str(self._checkout)},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        )
        assert process.stdout is not None
        process.stdout.readline()  # it is ready; on a busy machine that may take longer than a file
        return process

    def read(self, path: Path, rate: float, options: dict[str, Any]) -> Answer | None:
        """Read a recording; see `damage.reader.answer`. None if it takes too long."""
        process = self._process
        assert process.stdin is not None
        assert process.stdout is not None
        request = {"path": str(path), "rate": rate, "options": options}
        process.stdin.write(json.dumps(request) + "\n")
        process.stdin.flush()
        in_time = bool(select.select([process.stdout], [], [], SECONDS)[0])
        line = process.stdout.readline() if in_time else ""
        if line:
            return dict(json.loads(line))
        self.stop()
        self._process = self._start()
        return {"error": "the process ended", "own": False} if in_time else None

    def stop(self) -> None:
        """End the process."""
        self._process.kill()
        self._process.communicate()


def main(
    layouts: tyro.conf.Positional[tuple[str, ...]] = tuple(LAYOUTS),
    seed: int = 0,
    files: int = 300,
    checkout: Path = ROOT,
    keep: Path | None = None,
    workers: int = 2,
) -> None:
    """Print a table of what becomes of damaged files of each layout.

    Args:
        layouts: Kinds of files, as the table names them.
        seed: Seed of the damage.
        files: Damaged files of each layout.
        checkout: Folder of the package that reads them.
        keep: Folder that gets the files that are read wrongly, or end in a traceback or timeout.
        workers: Processes.
    """

    def tried(layout: str) -> list[Outcome]:
        return list(try_layout(layout, seed, files, checkout.absolute(), keep))

    with ThreadPoolExecutor(workers) as pool:
        outcomes = dict(zip(layouts, pool.map(tried, layouts), strict=True))
    print(f"Seed {seed}, {files} files of each layout.\n")
    print(markdown_table(("layout", *RESULTS), table(outcomes)))
    kinds = Counter(o.damage for of in outcomes.values() for o in of if o.result == RESULTS[3])
    print(f"\nSilently wrong: {', '.join(f'{n} {kind}' for kind, n in kinds.most_common())}")


def table(outcomes: dict[str, list[Outcome]]) -> list[list[str]]:
    """Return a row of counts for each layout, and their sums."""
    read = [outcome for of in outcomes.values() for outcome in of]
    rows = []
    for name, of in (outcomes | {"all": read}).items():
        counts = Counter(outcome.result for outcome in of)
        rows.append([name, *(str(counts[result]) if of else "not read" for result in RESULTS)])
    return rows


def try_layout(
    name: str, seed: int, files: int, checkout: Path = ROOT, keep: Path | None = None
) -> Iterator[Outcome]:
    """Damage a file of a layout in many ways and read it each time; none if it cannot be read.

    Args:
        name: One of LAYOUTS.
        seed: Seed of the damage.
        files: How many times.
        checkout: Folder of the package that reads them.
        keep: Folder that gets what was read wrongly.
    """
    layout, rng = LAYOUTS[name], np.random.default_rng([seed, zlib.crc32(name.encode())])
    options = {} if layout.declared else {"rate_in": layout.rate}
    reader = Reader(checkout)
    with tempfile.TemporaryDirectory() as folder:
        path = layout.make(Path(folder))
        contents = {file: file.read_bytes() for file in (path, *Path(folder).glob("*.asf"))}
        whole_path = layout.make(_subfolder(folder, "whole"))
        whole = reader.read(whole_path, layout.rate, options)
        for number in range(files if whole and "posture" in whole else 0):
            assert whole is not None
            target = path if len(contents) == 1 or rng.random() > SKELETON else max(contents)
            damage, data = mangle(contents[target], rng, is_table=target.suffix in TABLES)
            target.write_bytes(data)
            found = reader.read(path, layout.rate, options)
            result, error = _judge(reader, whole_path, whole, found, layout.rate, options)
            target.write_bytes(contents[target])
            if keep is not None and result in RESULTS[3:]:
                place = keep / name.replace("/", "-") / f"{number} {damage} {error:.3f}"
                place.mkdir(parents=True, exist_ok=True)
                for file, content in contents.items():
                    (place / file.name).write_bytes(data if file == target else content)
            yield Outcome(damage, result, error)
    reader.stop()


def _subfolder(folder: str, name: str) -> Path:
    path = Path(folder) / name
    path.mkdir()
    return path


def _judge(
    reader: Reader,
    whole_path: Path,
    whole: Answer,
    found: Answer | None,
    rate: float,
    options: dict[str, Any],
) -> tuple[str, float]:
    """Return one of RESULTS, and how far the posture is off, if it is wrong."""
    if found is None:
        return "timeout", 0.0
    if "error" in found:
        return ("refused" if found["own"] else "traceback"), 0.0
    if _is_told(whole, found):
        return "warned", 0.0
    expected, posture = np.array(whole["posture"]), np.array(found["posture"])
    error, first = _largest_error(expected, posture)
    if not error <= WRONG and 1 < len(posture) < len(expected):
        # Filters know of the frames that are cut off, so that the same part is read again.
        times = np.array(whole["times"])[[first, first + len(posture) - 1]]
        part = {"start": max(0.0, times[0]), "end": times[1] + 0.5 / rate}
        cut = reader.read(whole_path, rate, options | part)
        if cut is not None and "posture" in cut:
            error = min(error, _largest_error(np.array(cut["posture"]), posture)[0])
    return ("right" if error <= WRONG else "silently wrong"), error


def _is_told(whole: Answer, found: Answer) -> bool:
    """Return whether a warning or a step tells of damage."""
    steps = set(found["steps"]) - set(whole["steps"])
    return bool(set(found["warnings"]) - set(whole["warnings"])) or any(
        word in step for step in steps for word in TELLING
    )


def _largest_error(expected: Array, posture: Array) -> tuple[float, int]:
    """Return by how much postures differ at most, and the frame at which the second begin.

    They begin where they fit best: a file that lacks its first frames is right.
    """
    count = min(len(expected), len(posture))
    errors = [
        float(np.abs(expected[first : first + count] - posture[:count]).max(initial=0.0))
        for first in range(len(expected) - count + 1)
    ]
    typical = [
        float(np.median(np.abs(expected[first : first + count] - posture[:count])))
        for first in range(len(expected) - count + 1)
    ]
    best = int(np.argmin(typical))
    return errors[best], best


if __name__ == "__main__":
    tyro.cli(main)
