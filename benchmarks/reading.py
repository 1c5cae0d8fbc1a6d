"""Time readers on files of a known size, and the memory that a long recording takes.

python benchmarks/reading.py
"""

from __future__ import annotations

import resource
import statistics
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import ezc3d
import numpy as np
import tyro

from mpma_mj.kinematics import SIDES
from mpma_mj.motions.body import ARM_POINTS
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.loader import import_motion
from mpma_mj.motions.marker_sets import choose_markers
from mpma_mj.motions.options import ReadingOptions
from mpma_mj.motions.readers.recognise import open_recording

NAMES = [f"{side[0].upper()}{name}" for side in SIDES for name in ("SHO", "ELB", "WRA", "WRB")]
JOINTS = ("Shoulder", "Arm", "ForeArm", "Hand")
MEGABYTE = 1e6


def main(hours: float = 10.0) -> None:
    """Print reading times and the memory that a long Qualisys TSV takes.

    Args:
        hours: Length of the long recording, 60 Hz, arms alone.
    """
    print("| file | goal, s | median of 5, s | of the goal |\n|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for name, goal, write in (
            ("C3D, 5,000 frames, 41 markers", 0.2, write_c3d),
            ("BVH, 3,000 frames, 57 joints", 0.5, write_bvh),
        ):
            path = write(Path(folder))
            taken = statistics.median(seconds(path) for _ in range(5))
            print(f"| {name} | {goal:g} | {taken:.3f} | {100 * taken / goal:.0f} % |")
        path = write_long_tsv(Path(folder), hours)
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        began = time.perf_counter()
        _, report = import_motion(path, ReadingOptions())
        grown = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) * 1024
        own = report.frames * len(ARM_POINTS) * 3 * 8
        print(
            f"\n{hours:g} h, {report.frames} frames, {path.stat().st_size / MEGABYTE:.0f} MB of"
            f" text: {time.perf_counter() - began:.0f} s; memory grew by {grown / MEGABYTE:.0f} MB,"
            f" {grown / own:.2f} times the six points' {own / MEGABYTE:.0f} MB"
        )


def seconds(path: Path) -> float:
    """Return how long it takes to open a file and read the arms."""
    began = time.perf_counter()
    recording = open_recording(path, ImportReport())
    groups = choose_markers(path, recording.names, {})
    recording.load(sorted({name for group in groups.values() for name in group}))
    return time.perf_counter() - began


def write_c3d(folder: Path) -> Path:
    """Write 41 markers at random places."""
    names = NAMES + [f"M{i}" for i in range(41 - len(NAMES))]
    file = ezc3d.c3d()
    file["parameters"]["POINT"]["RATE"]["value"] = [120]
    file["parameters"]["POINT"]["LABELS"]["value"] = names
    file["data"]["points"] = np.random.default_rng(0).normal(0, 500, (4, len(names), 5000))
    file.write(str(folder / "x.c3d"))
    return folder / "x.c3d"


def write_bvh(folder: Path) -> Path:
    """Write a spine with arms and many fingers."""

    def joint(name: str, children: Callable[[], Iterator[str]]) -> Iterator[str]:
        yield from (f"JOINT {name}", "{", "OFFSET 0 10 0")
        yield "CHANNELS 3 Zrotation Xrotation Yrotation"
        yield from children()
        yield "}"

    def end() -> Iterator[str]:
        yield from ("End Site", "{", "OFFSET 0 5 0", "}")

    def arm(side: str, index: int = 0) -> Iterator[str]:
        if index == len(JOINTS):
            for finger in range(23):
                yield from joint(f"{side}Finger{finger}", end)
        else:
            yield from joint(f"{side}{JOINTS[index]}", lambda: arm(side, index + 1))

    lines = ["HIERARCHY", "ROOT Hips", "{", "OFFSET 0 0 0"]
    lines.append("CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation")
    lines += [*joint("Neck", end), *joint("Head", end), *arm("Left"), *arm("Right"), "}"]
    lines += ["MOTION", "Frames: 3000", "Frame Time: 0.0083333"]
    values = np.random.default_rng(0).normal(0, 30, (3000, 6 + 3 * 56))
    path = folder / "x.bvh"
    with path.open("w") as file:
        file.write("\n".join(lines) + "\n")
        np.savetxt(file, values, fmt="%.4f")
    return path


def write_long_tsv(folder: Path, hours: float) -> Path:
    """Write slowly swinging arms, 60 Hz, six markers."""
    frames = int(hours * 3600 * 60)
    path = folder / "long.tsv"
    names = [f"{p}_{s[0].upper()}" for s in SIDES for p in ("Shoulder", "Elbow", "Wrist")]
    with path.open("w") as file:
        file.write(f"NO_OF_FRAMES\t{frames}\nFREQUENCY\t60\nMARKER_NAMES\t" + "\t".join(names))
        file.write("\n")
        for first in range(0, frames, 100_000):
            swing = 0.5 * np.sin(np.arange(first, min(first + 100_000, frames)) / 60)
            one = np.ones_like(swing)
            rows = []
            for y in (180.0, -180.0):
                reach = 300 * np.stack([np.sin(swing), 0.1 * one, -np.cos(swing)], 1)
                shoulder = np.stack([0 * one, y * one, 1400 * one], 1)
                rows += [shoulder, shoulder + reach, shoulder + reach * [1.9, 2, 1.8]]
            np.savetxt(file, np.concatenate(rows, axis=1), fmt="%.3f", delimiter="\t")
    return path


if __name__ == "__main__":
    tyro.cli(main)
