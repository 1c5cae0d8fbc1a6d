"""Long tables, of one point a row, come back as they were."""

import random
from pathlib import Path

import numpy as np
import pytest

from mpma_mj.errors import MotionFileError
from tests.motions.readers import writers
from tests.motions.readers.test_text_formats import assert_same, read

TITLES = ["frame", "time", "keypoint", "x", "y", "z"]


def rows_of(points: writers.Points, rate: float = 60.0) -> list[list[str]]:
    """Return the cells of `TITLES` for every frame and point."""
    return [
        [str(i), f"{i / rate:.4f}", name, *map(str, track[i])]
        for i in range(60)
        for name, track in points.items()
    ]


def write(path: Path, rows: list[list[str]], titles: list[str] = TITLES, sep: str = ",") -> Path:
    path.write_text("\n".join(map(sep.join, [titles, *rows])) + "\n")
    return path


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "dance.csv"


@pytest.mark.parametrize(
    "title", ["keypoint", "Marker Name", "bodypart", "Gelenk", "child_frame_id"]
)
@pytest.mark.parametrize("separator", [",", "\t"])
def test_points_come_back(path: Path, points: writers.Points, title: str, separator: str) -> None:
    titles = [*TITLES[:2], title, *TITLES[3:]]
    recording, tracks, report = read(write(path, rows_of(points), titles, separator))
    assert_same(tracks, points)
    assert (recording.format, recording.rate) == ("long table", 60.0)
    assert not report.warnings


def test_rotations_of_frames_are_left_out(path: Path, points: writers.Points) -> None:
    titles = [*TITLES[1:3], *(f"transform.{what}.{a}" for what in ("t", "rotation") for a in "xyz")]
    rows = [[*row[1:], "0", "0", "1"] for row in rows_of(points)]
    recording, tracks, _ = read(write(path, rows, titles))
    assert_same(tracks, points)
    assert recording.format == "long table"


@pytest.mark.parametrize("order", [[2, 5, 4, 3, 1], [0, 2, 3, 4, 5], [3, 4, 5, 2, 1, 0]])
def test_columns_may_be_in_any_order(path: Path, points: writers.Points, order: list[int]) -> None:
    rows = [[row[i] for i in order] for row in rows_of(points)]
    assert_same(read(write(path, rows, [TITLES[i] for i in order]))[1], points)


def test_rows_may_be_in_any_order_and_missing_ones_are_gaps(
    path: Path, points: writers.Points
) -> None:
    rows = rows_of(points)
    del rows[6 * 30 + 1]
    points["LELB"][30] = np.nan
    random.Random(0).shuffle(rows)
    _, tracks, _ = read(write(path, rows))
    assert_same({name: tracks[name] for name in points}, points)


def test_frames_that_are_left_out_are_gaps(path: Path, points: writers.Points) -> None:
    _, tracks, report = read(write(path, [r for r in rows_of(points) if r[0] not in ("7", "8")]))
    for name, track in points.items():
        track[[7, 8]] = np.nan
        np.testing.assert_array_equal(tracks[name], track)
    assert report.warnings == [
        "2 frames are missing, the first after frame 6; they are treated as gaps"
    ]


def test_a_name_counts_for_more_than_a_number(path: Path, points: writers.Points) -> None:
    rows = [[row[0], row[1], str(i % 6), *row[2:]] for i, row in enumerate(rows_of(points))]
    titles = ["frame", "time", "joint_id", "joint_name", "x", "y", "z"]
    assert_same(read(write(path, rows, titles))[1], points)


def test_people_are_refused(path: Path, points: writers.Points) -> None:
    rows = rows_of(points)
    with pytest.raises(MotionFileError, match="line 362 has LSHO again in the same frame"):
        read(write(path, rows + rows))
    both = [[*row, person] for person in "01" for row in rows]
    with pytest.raises(MotionFileError, match="column person has 0, 1"):
        read(write(path, both, [*TITLES, "person"]))


def test_a_table_without_frames_is_refused(path: Path, points: writers.Points) -> None:
    rows = [row[2:] for row in rows_of(points)]
    with pytest.raises(MotionFileError, match="no column of its frame or time"):
        read(write(path, rows, TITLES[2:]))
    rows = rows_of(points)
    rows[9][0] = ""
    with pytest.raises(MotionFileError, match="line 11 has no frame or time"):
        read(write(path, rows))
