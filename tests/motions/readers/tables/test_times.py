"""Times and numbers of frames show the rate, and where frames are missing."""

import numpy as np
import pytest

from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.readers.tables.times import arrangement, rate_of

TRACK = np.arange(60.0).reshape(20, 3)


def where(row: int) -> str:
    return f"line {row + 2}"


def test_times_that_count_frames_show_no_rate() -> None:
    report = ImportReport()
    assert rate_of(np.arange(20.0), None, report) is None
    assert rate_of(np.arange(20.0), 50.0, report) == 50.0
    assert rate_of(2.0 * np.arange(20.0), None, report) is None
    assert len(report.warnings) == 3
    assert rate_of(np.arange(20.0), None, report, 1e-3) == 1000.0
    assert rate_of(np.arange(20.0) / 25.0, None, report) == 25.0


def test_whole_seconds_show_the_rate_by_the_frames_between_them() -> None:
    report = ImportReport()
    assert rate_of(np.arange(50, 239) // 60 * 1.0, None, report) == 60.0
    assert "too coarse" in report.warnings[0]
    report.settle("rate_in")
    assert not report.warnings


def test_numbers_that_leave_frames_out_are_gaps() -> None:
    report = ImportReport()
    arrange = arrangement(None, np.delete(np.arange(22.0), [7, 8]), where, report)
    assert arrange is not None
    assert np.flatnonzero(np.isnan(arrange(TRACK)).any(axis=1)).tolist() == [7, 8]
    assert arrange(np.zeros((20, 4, 3))).shape == (22, 4, 3)
    assert report.warnings == [
        "2 frames are missing, the first after line 8; they are treated as gaps"
    ]


@pytest.mark.parametrize(
    ("numbers", "message"),
    [
        ([*range(19), 10**6], "the frame numbers omit 999981 frames"),
        ([*range(19), 3], "the frame numbers jump at line 21"),
    ],
)
def test_numbers_that_cannot_be_are_not_used(numbers: list[int], message: str) -> None:
    report = ImportReport()
    assert arrangement(None, np.array(numbers, float), where, report) is None
    assert report.warnings[0].startswith(message)


def test_uneven_times_are_interpolated_whatever_the_shape() -> None:
    times = np.arange(20) + 0.3 * np.sin(5.0 * np.arange(20))
    report = ImportReport()
    arrange = arrangement(times, None, where, report)
    assert arrange is not None
    line = times[:, None, None] * np.ones((20, 2, 3))
    even = arrange(line)
    assert even.shape[1:] == (2, 3)
    np.testing.assert_allclose(np.diff(even[:, 1, 2]), np.diff(even[:, 1, 2])[0])


def test_numbers_of_frames_that_are_not_whole_are_warned_of() -> None:
    report, numbers = ImportReport(), np.arange(20.0) + 0.25
    assert arrangement(np.arange(20.0) / 25.0, numbers, where, report) is None
    assert report.warnings[0].startswith("the numbers of frames are not whole, the first at line 2")
    assert arrangement(np.arange(20.0) / 25.0, np.round(numbers), where, report) is None
    assert len(report.warnings) == 1
