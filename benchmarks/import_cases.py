"""Read every recording of a folder and compare the postures with the true ones, as Markdown.

python benchmarks/import_cases.py FOLDER

FOLDER/truth.csv has a row for each frame: its time, s, and the directions of left upper arm, left
forearm, right upper arm and right forearm in the torso's frame, x, y and z of each.
"""

from __future__ import annotations

import math
import warnings
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import tyro
from numpy.typing import NDArray

from mpma_mj.envs.load import arm_limits
from mpma_mj.errors import MpmaError
from mpma_mj.kinematics import SEGMENT_NAMES
from mpma_mj.motions.feasibility import demand_lines
from mpma_mj.motions.loader import ImportedMotion, import_motion
from mpma_mj.motions.options import ReadingOptions
from mpma_mj.utils.text import markdown_table

Array = NDArray[np.float64]

TRUTH = "truth.csv"
NO_ERRORS = (np.empty(0),) * len(SEGMENT_NAMES)
NO_CASES = (".md", ".png")
HEAD = (
    *("file", "result"),
    *(f"{name.replace('_', ' ')}, °" for name in SEGMENT_NAMES),
    *("range, rad", "message"),
)
SAME_LENGTH = 0.1  # part by which durations may differ


class Case(NamedTuple):
    """What became of a recording.

    Attributes:
        name: Name of the file.
        result: "read", "warned", "refused" or "failed".
        message: Error or warnings, and whether the arms can follow it.
        errors: Angles between directions and true ones for each segment, each shape (T,), degrees;
            empty where the recording has not the true motion's length.
        joint_range: Largest range of a joint, rad.
    """

    name: str
    result: str
    message: str
    errors: Sequence[Array] = NO_ERRORS
    joint_range: float = math.nan

    def cells(self) -> list[str]:
        """Return the row of the table: an error is "median, largest"."""
        errors = (f"{np.median(e):.2f}, {e.max():.2f}" if len(e) else "–" for e in self.errors)
        joint_range = "–" if math.isnan(self.joint_range) else f"{self.joint_range:.2f}"
        return [self.name, self.result, *errors, joint_range, self.message.replace("|", "/")]


def main(folder: tyro.conf.Positional[Path]) -> None:
    """Print a table of all recordings: result, errors and message.

    Args:
        folder: Folder with the recordings and truth.csv.
    """
    cases = list(read_all(folder))
    print(markdown_table(HEAD, [case.cells() for case in cases]))
    counts = Counter(case.result for case in cases)
    print(f"\n{len(cases)} files: {', '.join(f'{n} {result}' for result, n in counts.items())}")
    largest = {case.name: np.concatenate(case.errors).max(initial=0.0) for case in cases}
    worst = max(largest, key=largest.__getitem__)
    print(f"largest error: {largest[worst]:.2f}° of {worst}")


def read_all(folder: Path) -> Iterator[Case]:
    """Read each recording of a folder."""
    truth = np.loadtxt(folder / TRUTH, delimiter=",", skiprows=1)
    for path in sorted(folder.iterdir()):
        if path.is_file() and path.name != TRUTH and path.suffix not in NO_CASES:
            yield read(path, truth)


def read(path: Path, truth: Array) -> Case:
    """Read a recording at the rate of the true motion.

    Args:
        path: The recording.
        truth: Time and true posture of each frame, shape (T, 13).
    """
    limits = arm_limits("physics")
    rate = round(1.0 / float(np.diff(truth[:, 0]).mean()), 3)
    with warnings.catch_warnings(record=True) as issued:
        warnings.simplefilter("always")
        try:
            imported = import_motion(path, ReadingOptions(), rate=rate, limits=limits)
        except MpmaError as error:
            return Case(path.name, "refused", str(error).removeprefix(f"{path}: "))
        except Exception as error:  # which is what the table is to show
            return Case(path.name, "failed", repr(error))
    doubts = [*imported.report.warnings, *(str(warning.message) for warning in issued)]
    return Case(
        path.name,
        "warned" if doubts else "read",
        "; ".join([*doubts, demand_lines(imported.motion, limits)[-1]]),
        angular_errors(imported, truth),
        float(np.ptp(imported.motion.joint_angles, axis=0).max()),
    )


def angular_errors(imported: ImportedMotion, truth: Array) -> Sequence[Array]:
    """Return the errors of a motion, as of `Case`.

    Postures belong to the same frame, or to the same time where the file has not as many frames.
    """
    motion, report = imported
    times, frames = truth[:, 0], len(truth)
    if report.frames == frames:
        places = report.times * report.rate
    elif abs(report.frames / report.rate / (times[-1] - times[0]) - 1.0) < SAME_LENGTH:
        places = np.interp(report.times, times, np.arange(frames), right=frames)
    else:
        return NO_ERRORS
    inside = places <= frames - 1
    found = motion.posture[inside].reshape(-1, len(SEGMENT_NAMES), 3)
    columns = (np.interp(places[inside], np.arange(frames), column) for column in truth[:, 1:].T)
    true = np.stack(list(columns), axis=1).reshape(found.shape)
    sine = np.linalg.norm(np.cross(found, true), axis=2)
    return list(np.degrees(np.arctan2(sine, np.sum(found * true, axis=2))).T)


if __name__ == "__main__":
    tyro.cli(main)
