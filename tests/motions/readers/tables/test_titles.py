"""Titles of columns say what they hold, however they are written."""

import pytest

from mpma_mj.motions.readers.tables import titles


@pytest.mark.parametrize(
    ("title", "expected"),
    [
        *(
            (t, ("left_wrist", "x"))
            for t in ("left_wrist_x", "left_wrist.X", "left_wrist [x]", "left_wrist_px")
        ),
        *(
            (t, ("left_wrist", "y"))
            for t in ("left_wrist_y_mm", "left_wrist y (mm)", "y_left_wrist")
        ),
        *((t, ("LWrist", "z")) for t in ("LWristZ", "LWrist:Z", "z.LWrist")),
        *((t, ("11", "x")) for t in ("x11", "x_11", "x[11]", "11_x", "X11")),
        *((t, ("", "x")) for t in ("x", "X (m)", "x position", "tx")),
        *(
            (t, ("", ""))
            for t in ("index", "LELBOX", "Fx", "qx", "apex", "time", "max", "", "xylophone")
        ),
    ],
)
def test_axes_are_set_off_from_names(title: str, expected: tuple[str, str]) -> None:
    assert titles.split_axis(title) == expected


@pytest.mark.parametrize(
    ("title", "unit"),
    [
        *(("Time (Seconds)", 1.0), ("Capture Time", None), ("timestamp_ms", 1e-3), ("t", None)),
        *(("TimeStamp", None), ("elapsed_us", 1e-6), ("Elapsed Time [s]", 1.0), ("msec", 1e-3)),
        *(("unix_time_ns", 1e-9), ("rosTime", None), ("Zeit", None)),
    ],
)
def test_times_and_their_units_are_recognised(title: str, unit: float | None) -> None:
    assert titles.is_time(title)
    assert titles.time_unit(title) == unit


@pytest.mark.parametrize("title", ["", "s", "lifetime", "time_of_flight", "left_wrist_x", "start"])
def test_other_columns_are_no_times(title: str) -> None:
    assert not titles.is_time(title)


@pytest.mark.parametrize("title", ["Frame", "frame#", "Field #", "frame_idx", "Frame Number"])
def test_numbers_of_frames_are_recognised(title: str) -> None:
    assert titles.is_frame(title)
    assert not titles.is_frame("Sub Frame")


@pytest.mark.parametrize(
    "title", ["person_id", "Subject", "ID", "bodyId", "skeleton", "track id", "dancers", "Take"]
)
def test_columns_of_people_are_recognised(title: str) -> None:
    assert titles.is_person(title)
    assert not titles.is_person("tracked")


@pytest.mark.parametrize("title", ["keypoint", "Joint Name", "marker", "landmark_id", "bodypart"])
def test_columns_of_points_are_recognised(title: str) -> None:
    assert titles.is_point(title)
    assert not titles.is_point("left_wrist")


@pytest.mark.parametrize(
    ("cell", "unit"),
    [
        ("mm", 1e-3),
        ("Meters", 1.0),
        ("x (cm)", 1e-2),
        ("LWRI_x_mm", 1e-3),
        ("deg", None),
        ("", None),
    ],
)
def test_units_of_length_are_recognised(cell: str, unit: float | None) -> None:
    assert titles.length_unit(cell) == unit
