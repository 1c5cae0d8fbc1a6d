"""Tables in other orders of columns, with other rates, times and names, come back as they were."""

import datetime
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest

from mpma_mj.errors import MotionFileError
from mpma_mj.motions.loader import import_motion
from mpma_mj.motions.options import ReadingOptions
from tests.motions.readers import writers
from tests.motions.readers.test_text_formats import assert_same, read

RATE = 60.0


def write(
    path: Path,
    points: writers.Points,
    columns: Sequence[tuple[str, str]],
    *,
    lead: dict[str, Sequence[object]] | None = None,
    above: Sequence[str] = (),
) -> Path:
    """Write a table whose columns of coordinates are in an order of names and axes."""
    lead = {"time": [f"{i / RATE:.4f}" for i in range(60)]} if lead is None else lead
    titles = [*lead, *(f"{name}_{axis}" for name, axis in columns)]
    cells = [points[name][:, "xyz".index(axis)] for name, axis in columns]
    rows = (",".join(map(str, row)) for row in zip(*lead.values(), *cells, strict=True))
    path.write_text("\n".join([*above, ",".join(titles), *rows]) + "\n")
    return path


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "dance.csv"


@pytest.mark.parametrize("axes", ["xyz", "zyx", "yzx", "xzy"])
def test_axes_may_be_grouped_or_in_any_order(path: Path, points: writers.Points, axes: str) -> None:
    together = [(name, axis) for name in points for axis in axes]
    grouped = [(name, axis) for axis in axes for name in points]
    for columns in (together, grouped):
        _, tracks, report = read(write(path, points, columns))
        assert_same(tracks, points)
        assert not report.warnings


def test_the_last_cell_of_the_first_row_may_be_empty(path: Path, points: writers.Points) -> None:
    columns = [(name, axis) for axis in "xyz" for name in points]
    lines = write(path, points, columns).read_text().splitlines()
    lines[1] = lines[1].rpartition(",")[0] + ","
    path.write_text("\n".join(lines) + "\n")
    points["RWRI"][0] = np.nan
    assert_same(read(path)[1], points)


@pytest.mark.parametrize("axes", ["zyx", "yzx", "xzy"])
def test_axes_below_names_may_be_in_any_order(
    path: Path, points: writers.Points, axes: str
) -> None:
    turned = {name: track[:, ["xyz".index(a) for a in axes]] for name, track in points.items()}
    text = writers.vicon_text(turned)
    path.write_text(text.replace("X,Y,Z", ",".join(axes.upper())))
    assert_same(read(path)[1], points)


def test_names_may_stand_above_the_middle_axis(path: Path, points: writers.Points) -> None:
    lines = writers.vicon_text(points).splitlines()
    lines[2] = ",," + ",".join(f",{name}," for name in points)
    path.write_text("\n".join(lines) + "\n")
    assert_same(read(path)[1], points)


def test_names_that_are_shifted_are_reported(path: Path, points: writers.Points) -> None:
    lines = motive(points, {}, {}).splitlines()
    cells = lines[3].split(",")
    lines[3] = ",".join([*cells[:2], *cells[3:]])
    path.write_text("\n".join(lines) + "\n")
    _, _, report = read(path)
    assert "Skel:LSHO are not above an x, a y and a z each" in report.warnings[0]


def test_titles_that_changed_places_are_reported(path: Path, points: writers.Points) -> None:
    lines = writers.header_row_text(points).splitlines()
    titles = lines[0].split(",")
    titles[4], titles[13] = titles[13], titles[4]
    path.write_text("\n".join([",".join(titles), *lines[1:]]) + "\n")
    (warning,) = read(path)[2].warnings
    assert "the columns of RELB, LELB are in another order than those of other points" in warning


def test_rows_of_another_width_than_the_header_are_refused(
    path: Path, points: writers.Points
) -> None:
    header, *rows = writers.header_row_text(points, separator="\t").splitlines()
    for change in ("1\t{}", "{}\t1"):  # R's names of the rows; a title that is missing
        path.write_text("\n".join([header, *map(change.format, rows)]) + "\n")
        with pytest.raises(MotionFileError, match="line 2 has 20 columns, but the header names 19"):
            read(path)
    path.write_text("\n".join([header, *(row.rpartition("\t")[0] for row in rows)]) + "\n")
    with pytest.raises(MotionFileError, match="line 2 has 18 columns, but the header names 19"):
        read(path)


def test_a_number_that_is_no_coordinate_is_refused(path: Path, points: writers.Points) -> None:
    points["LWRI"][7, 1] = 1e12
    with pytest.raises(MotionFileError, match=r"line 9, column \d+: 1e\+12 is not a coordinate"):
        read(write(path, points, [(name, axis) for name in points for axis in "xyz"]))


def test_places_in_a_picture_are_refused(path: Path, points: writers.Points) -> None:
    with pytest.raises(MotionFileError, match="has x and y of points, but no z"):
        read(write(path, points, [(name, axis) for name in points for axis in "xy"]))


def test_names_may_stand_below_axes(path: Path, points: writers.Points) -> None:
    rows = [["", *(axis for axis in "xyz" for _ in points)], ["time", *[*points] * 3]]
    cells = [track[:, axis] for axis in range(3) for track in points.values()]
    rows += [[f"{i / RATE:.4f}", *map(str, row)] for i, row in enumerate(zip(*cells, strict=True))]
    path.write_text("\n".join(map(",".join, rows)) + "\n")
    recording, tracks, _ = read(path)
    assert_same(tracks, points)
    assert recording.rate == RATE


def stamps(form: Callable[[datetime.datetime], str]) -> list[str]:
    midnight = datetime.datetime(2024, 5, 1, 23, 59, 59, 500_000)
    return [form(midnight + datetime.timedelta(seconds=i / RATE)) for i in range(60)]


@pytest.mark.parametrize(
    "form",
    [
        lambda time: time.isoformat(" ", "milliseconds"),
        lambda time: time.isoformat("T", "microseconds") + "+02:00",
        lambda time: time.strftime("%H:%M:%S.%f"),
        lambda time: time.strftime("%m/%d/%Y %I:%M:%S.%f %p"),
    ],
    ids=["ISO 8601", "with zone", "time of day", "of twelve hours"],
)
def test_clocks_show_the_rate_past_midnight(
    path: Path, points: writers.Points, form: Callable[[datetime.datetime], str]
) -> None:
    columns = [(name, axis) for name in points for axis in "xyz"]
    recording, tracks, report = read(write(path, points, columns, lead={"timestamp": stamps(form)}))
    assert recording.rate == RATE
    assert_same(tracks, points)
    assert not report.warnings


@pytest.mark.parametrize(
    "title",
    [
        *("{}_{} (m/s)", "{}_vel_{}", "{}_rotation_{}", "{}_{} (deg)"),
        *("{}_{}_px", "{}_{} [pixels]", "{}.orientation.{}"),
    ],
)
def test_what_is_no_place_is_left_out_or_refused(
    path: Path, points: writers.Points, title: str
) -> None:
    columns = [(name, axis) for name in points for axis in "xyz"]
    lines = write(path, points, columns).read_text().splitlines()
    others = ",".join(title.format(name, axis) for name, axis in columns)
    both = [f"{line},{line.partition(',')[2]}" for line in lines[1:]]
    path.write_text("\n".join([f"{lines[0].partition(',')[0]},{others}", *lines[1:]]) + "\n")
    with pytest.raises(MotionFileError, match="hold rotations, speeds or pixels"):
        read(path)
    placed = ",".join(f"{name}_{axis}_world" for name, axis in columns)
    path.write_text("\n".join([f"time,{others},{placed}", *both]) + "\n")
    assert_same(read(path)[1], points)


def test_parents_called_x_are_no_axes(path: Path, points: writers.Points) -> None:
    text = writers.vicon_text(points)
    path.write_text("parent," + ",".join("x" * len(points)) + "\n" + text)
    assert_same(read(path)[1], points)


def test_times_that_cannot_be_read_are_not_used(path: Path, points: writers.Points) -> None:
    columns = [(name, axis) for name in points for axis in "xyz"]
    smpte = stamps(lambda time: time.strftime("%H:%M:%S:") + "07")
    recording, tracks, report = read(write(path, points, columns, lead={"timecode": smpte}))
    assert recording.rate is None
    assert_same(tracks, points)
    assert "the times are neither numbers nor h:m:s" in report.warnings[0]


@pytest.mark.parametrize(
    "title", ["Temps [s]", "Tiempo (s)", "Datum Uhrzeit", "ts", "stamp", "elapsed"]
)
def test_times_are_found_by_titles_in_other_languages(
    path: Path, points: writers.Points, title: str
) -> None:
    columns = [(name, axis) for name in points for axis in "xyz"]
    lead = {"Date": ["2024-05-01"] * 60, title: [f"{i / RATE:.4f}" for i in range(60)]}
    if title in ("stamp", "elapsed"):
        del lead["Date"]
    recording, _, report = read(write(path, points, columns, lead=lead))
    assert recording.rate == RATE
    assert not report.warnings


@pytest.mark.parametrize(
    ("title", "seconds", "start"),
    [("Zeit [min]", 60.0, 0.0), ("time_h", 3600.0, 0.0), ("Date", 86400.0, 45413.4)],
)
def test_times_may_be_in_longer_units(
    path: Path, points: writers.Points, title: str, seconds: float, start: float
) -> None:
    columns = [(name, axis) for name in points for axis in "xyz"]
    lead = {title: [f"{start + i / RATE / seconds:.11f}" for i in range(60)]}
    recording, _, _ = read(write(path, points, columns, lead=lead))
    assert recording.rate == pytest.approx(RATE, rel=1e-4)


def test_timecodes_show_their_rate_if_a_second_ends(path: Path, points: writers.Points) -> None:
    columns = [(name, axis) for name in points for axis in "xyz"]
    frames = [*range(5, 40), *range(42, 67)]
    lead = {"Timecode": [f"01:02:{i // 30:02}:{i % 30:02}" for i in frames]}
    recording, tracks, report = read(write(path, points, columns, lead=lead))
    assert recording.rate == 30.0
    assert len(next(iter(tracks.values()))) == 62
    assert "2 frames are missing, the first after line 36" in report.warnings[0]


@pytest.mark.parametrize("title", ["sample", ""])
def test_a_column_that_may_hold_times_is_named(
    path: Path, points: writers.Points, title: str
) -> None:
    columns = [(name, axis) for name in points for axis in "xyz"]
    write(path, points, columns, lead={title: [f"{i / RATE:.4f}" for i in range(60)]})
    with pytest.raises(MotionFileError, match=r"\(column 1, .* rises evenly; .* call it time\)"):
        import_motion(path, ReadingOptions())
    recording, _, _ = read(path)
    assert recording.rate is None


def test_a_word_amid_times_is_named(path: Path, points: writers.Points) -> None:
    lines = writers.header_row_text(points).splitlines()
    path.write_text("\n".join(lines[:31] + lines[:1] + lines[31:]) + "\n")
    with pytest.raises(MotionFileError, match="line 32, column 1: 'time' is not a number"):
        read(path)


@pytest.mark.parametrize(
    "line",
    [
        *(
            "60,Hz",
            "60 Hz",
            "60",
            "fps,60",
            "FPS: 60",
            "# framerate=60",
            "Sampling Frequency,60,Hz",
        ),
        *("Frame Rate (Hz),60", "frames per second,60", "SampleRate;60", "Camera Rate: 60 Hz"),
    ],
)
def test_rates_are_declared_in_many_ways(path: Path, points: writers.Points, line: str) -> None:
    columns = [(name, axis) for name in points for axis in "xyz"]
    assert read(write(path, points, columns, lead={}, above=[line]))[0].rate == RATE


@pytest.mark.parametrize("line", ["filter,6 Hz", "take,60", "2024-05-01", "60,70", "version: 60"])
def test_other_numbers_are_no_rates(path: Path, points: writers.Points, line: str) -> None:
    columns = [(name, axis) for name in points for axis in "xyz"]
    assert read(write(path, points, columns, lead={}, above=[line]))[0].rate is None


def test_the_unit_in_the_title_of_times_counts(path: Path, points: writers.Points) -> None:
    columns = [(name, axis) for name in points for axis in "xyz"]
    times = {"time_ms": [f"{1000 * i / RATE:.3f}" for i in range(60)]}
    recording, _, report = read(write(path, points, columns, lead=times))
    assert recording.rate == RATE
    assert not report.warnings


def test_rows_of_people_are_refused(path: Path, points: writers.Points) -> None:
    columns = [(name, axis) for name in points for axis in "xyz"]
    lead = {"time": [i // 2 / RATE for i in range(60)], "person_id": [i % 2 for i in range(60)]}
    with pytest.raises(MotionFileError, match="2 people or takes, as column person_id has 0, 1"):
        read(write(path, points, columns, lead=lead))
    write(path, points, columns, lead=lead | {"person_id": [3] * 60})
    assert_same(read(path)[1], points)


def test_numbers_above_the_header_are_refused(path: Path, points: writers.Points) -> None:
    lines = writers.header_row_text(points).splitlines()
    path.write_text("\n".join(lines[1:6] + lines) + "\n")
    with pytest.raises(MotionFileError, match="line 1 has numbers above the header in line 6"):
        read(path)
    counted = ",".join(map(str, range(19)))
    path.write_text("\n".join([counted, *lines]) + "\n")
    assert_same(read(path)[1], points)


def motive(points: writers.Points, markers: writers.Points, parents: dict[str, str]) -> str:
    """Write bones and markers of a skeleton as Motive does."""
    both = [*points.items(), *markers.items()]
    kinds = ["Bone"] * len(points) + ["Bone Marker"] * len(markers)
    rows = [
        ["", "Type", *(kind for kind in kinds for _ in "XYZ")],
        ["", "Name", *(f"Skel:{name}" for name, _ in both for _ in "XYZ")],
        ["", "Parent", *(parents.get(name, "Skel:Skel") for name, _ in both for _ in "XYZ")],
        ["", "", *["Position"] * 3 * len(both)],
        ["Frame", "Time (Seconds)", *"XYZ" * len(both)],
    ]
    values = np.concatenate([track for _, track in both], axis=1)
    rows += [[str(i), f"{i / RATE:.6f}", *map(str, row)] for i, row in enumerate(values)]
    top = "Format Version,1.25,Rotation Type,Quaternion,Length Units,Millimeters"
    return "\n".join([top, "", *map(",".join, rows)]) + "\n"


def test_a_bone_counts_for_more_than_its_marker(path: Path, points: writers.Points) -> None:
    markers = {"LELB": points["LELB"] + 50.0}
    path.write_text(motive(points, markers, {}))
    recording, tracks, _ = read(path)
    assert recording.names == (*(f"Skel:{name}" for name in points), "Skel:LELB Bone Marker")
    np.testing.assert_array_equal(tracks["Skel:LELB"], points["LELB"])
    np.testing.assert_array_equal(tracks["Skel:LELB Bone Marker"], markers["LELB"])


@pytest.mark.parametrize("separator", [":", "_"])
def test_the_root_of_a_skeleton_is_its_pelvis(
    path: Path, points: writers.Points, separator: str
) -> None:
    root = "Skel:Skel" if separator == ":" else "Skel"
    bones = {"Skel": np.ones((60, 3)) * [1.0, 2.0, 900.0], **points}
    text = motive(bones, {}, {"Skel": "Root"}).replace("Skel:Skel", root)
    path.write_text(text.replace("Skel:", f"Skel{separator}") if separator == "_" else text)
    recording, _, report = read(path)
    assert recording.names[0] == f"Skel{separator}Hips"
    assert report.steps == [f"{root}, the root of its skeleton, is called {recording.names[0]}"]
    without_parents = [line for line in text.splitlines() if not line.startswith(",Parent")]
    if separator == ":":  # then the name alone tells
        path.write_text("\n".join(without_parents) + "\n")
        assert read(path)[0].names[0] == "Skel:Hips"
    with_hips = {"Skel": bones["Skel"], "Hips": bones["Skel"], **points}
    path.write_text(motive(with_hips, {}, {"Skel": "Root"}))
    assert read(path)[0].names[:2] == ("Skel:Skel", "Skel:Hips")
