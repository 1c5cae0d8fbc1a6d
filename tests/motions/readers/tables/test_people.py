"""Rows of several people are never read as those of one."""

from pathlib import Path

import numpy as np
import pytest

from mpma_mj.errors import MotionFileError
from mpma_mj.motions.readers.recording import Tracks
from mpma_mj.motions.readers.tables.people import refuse_alternating, refuse_several
from tests.motions.readers import writers

PATH = Path("dance.csv")


def where(row: int) -> str:
    return f"line {row + 2}"


def rows_of(people: int, *, apart: float = 2000.0, order: list[int] | None = None) -> Tracks:
    """Return points, mm, of people whose rows alternate, or stand in this order."""
    moved = [
        {
            name: np.roll(track, 7 * i, axis=0) + np.array([0.0, i * apart, 0.0])
            for name, track in points
        }
        for i, points in enumerate([writers.arm_points().items()] * people)
    ]
    rows = order or [person for _ in range(60) for person in range(people)]
    frames = [rows[:i].count(person) for i, person in enumerate(rows)]
    return {
        name: np.array([moved[p][name][t] for p, t in zip(rows, frames, strict=True)])
        for name in moved[0]
    }


@pytest.mark.parametrize("people", [2, 3, 5])
def test_people_whose_rows_alternate_are_refused(people: int) -> None:
    with pytest.raises(MotionFileError, match=f"the rows of {people} people seem to alternate"):
        refuse_alternating(PATH, rows_of(people), None, where)


def test_people_who_come_and_go_are_refused_by_equal_times() -> None:
    order = [person for t in range(60) for person in ([0, 1] if 30 < t < 34 else [0])]
    times = np.repeat(np.arange(60), [2 if 30 < t < 34 else 1 for t in range(60)])
    tracks = rows_of(2, order=order)
    refuse_alternating(PATH, tracks, None, where)
    with pytest.raises(MotionFileError, match="line 33 and line 34 have the same time"):
        refuse_alternating(PATH, tracks, times / 60, where)


def test_people_relative_to_themselves_are_refused_by_equal_times() -> None:
    tracks = rows_of(2, apart=0.0)  # the shoulders stand still, and do not alternate
    with pytest.raises(MotionFileError, match="line 4 and line 5 have the same time"):
        refuse_alternating(PATH, tracks, np.repeat(np.arange(60), 2) / 60, where)


def test_one_person_is_read_with_coarse_times_and_fast_arms() -> None:
    points = writers.arm_points()
    refuse_alternating(PATH, points, np.arange(60) // 3, where)
    rounded = {name: np.round(track, -1) for name, track in points.items()}  # to a centimetre
    refuse_alternating(PATH, rounded, np.arange(60) // 30, where)
    nobody_moves = {name: 0.0 * track + track[:1] for name, track in points.items()}
    rounded = {name: track.round(-1) for name, track in nobody_moves.items()}
    for track in rounded.values():  # rounded up in every other row, as another person is not
        track[::2] += 10.0
    refuse_alternating(PATH, rounded, None, where)
    points["LWRI"][::2] += 300.0
    points["RWRI"][::2] += 300.0
    refuse_alternating(PATH, points, np.arange(60), where)
    points["LELB"][:] = np.nan
    refuse_alternating(PATH, points, None, where)


def test_a_column_of_people_has_one_or_counts_rows() -> None:
    refuse_several(PATH, "id", ["7"] * 60)
    refuse_several(PATH, "id", ["7", "nan", ""] * 20)
    refuse_several(PATH, "id", [str(i) for i in range(60)])
    with pytest.raises(MotionFileError, match="has rows of 2 people or takes, as column who has"):
        refuse_several(PATH, "who", ["Anna", "Ben"] * 30)
