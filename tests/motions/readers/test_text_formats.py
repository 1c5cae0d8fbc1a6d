"""Points written as each format of text, or as npz, come back as they were."""

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mpma_mj.errors import MotionFileError
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.readers.recognise import open_recording
from mpma_mj.motions.readers.recording import Recording, Tracks
from tests.motions.readers import writers

Edit = Callable[[str], str]

TEXTS: dict[str, Callable[[writers.Points], str]] = {
    "Qualisys": writers.qualisys_text,
    "Qualisys with frame": lambda p: writers.qualisys_text(p, lead=["Frame"]),
    "Qualisys with frame and time": lambda p: writers.qualisys_text(p, lead=["Frame", "Time"]),
    "TRC": writers.trc_text,
    "TRC with commas": lambda p: writers.trc_text(p, separator=","),
    "header row": writers.header_row_text,
    "header row with tabs": lambda p: writers.header_row_text(p, separator="\t"),
    "header row with spaces": lambda p: writers.header_row_text(p, separator=" "),
    "header row with dots": lambda p: writers.header_row_text(p, title="{}.{}"),
    "header row with units": lambda p: writers.header_row_text(p, title="{} {} (mm)"),
    "Vicon": writers.vicon_text,
    "Vicon with tabs": lambda p: writers.vicon_text(p, separator="\t"),
    "Captury": writers.captury_text,
    "OptiTrack": writers.optitrack_text,
}
TOLD = {  # format, rate, unit, up and number of frames that the file itself tells
    "Qualisys": ("Qualisys TSV", 100.0, 0.001, "z", 60),
    "TRC": ("TRC", 100.0, 0.001, None, 60),
    "header row": ("table", 100.0, None, None, None),
    "header row with units": ("table", 100.0, 0.001, None, None),
    "Vicon": ("table", 100.0, 0.001, None, None),
    "Captury": ("table", None, 0.001, None, 60),
    "OptiTrack": ("table", 120.0, 0.001, "y", 60),
}


def read(path: Path) -> tuple[Recording, Tracks, ImportReport]:
    report = ImportReport()
    recording = open_recording(path, report)
    return recording, recording.load(recording.names), report


def assert_same(tracks: Tracks, points: writers.Points, atol: float = 1e-9) -> None:
    assert [name.removesuffix("Positions") for name in tracks] == list(points)
    for track, known in zip(tracks.values(), points.values(), strict=True):
        np.testing.assert_allclose(track, known, rtol=0, atol=atol)


@pytest.mark.parametrize("kind", TEXTS)
def test_points_come_back(tmp_path: Path, points: writers.Points, kind: str) -> None:
    path = tmp_path / "dance"
    path.write_text(TEXTS[kind](points))
    _, tracks, report = read(path)
    assert_same(tracks, points)
    assert not report.warnings


@pytest.mark.parametrize("kind", TOLD)
def test_what_the_file_tells_is_found(tmp_path: Path, points: writers.Points, kind: str) -> None:
    path = tmp_path / "dance"
    path.write_text(TEXTS[kind](points))
    recording, _, _ = read(path)
    told = (recording.format, recording.rate, recording.unit, recording.up, recording.frames)
    assert told == TOLD[kind]


def test_an_archive_of_points_comes_back(tmp_path: Path, points: writers.Points) -> None:
    recording, tracks, _ = read(writers.write_npz(tmp_path / "dance", points, rate=48.0))
    assert_same(tracks, points, atol=0.0)
    assert (recording.rate, recording.unit, recording.up) == (48.0, 0.001, "z")


@pytest.mark.parametrize("name", ["fps", "FPS", "framerate", "frame_rate", "mocap_framerate"])
def test_rates_in_an_archive_have_many_names(
    tmp_path: Path, points: writers.Points, name: str
) -> None:
    np.savez(tmp_path / "dance.npz", **points, **{name: 48})  # type: ignore[arg-type]
    assert read(tmp_path / "dance.npz")[0].rate == 48.0


def test_points_without_finite_places_in_an_archive_are_missing(tmp_path: Path) -> None:
    points = writers.arm_points()
    points["LELB"][3], points["RELB"][4, 1] = 0.0, np.inf
    _, tracks, _ = read(writers.write_npz(tmp_path / "dance.npz", points))
    missing = {n: np.flatnonzero(np.isnan(t).all(axis=1)).tolist() for n, t in tracks.items()}
    assert {n: frames for n, frames in missing.items() if frames} == {"LELB": [3], "RELB": [4]}


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        ({"LSHO": np.ones((5, 2)), "rate": 3.0}, r"expected arrays of shape \(T, 3\)"),
        ({"LSHO": np.ones((5, 3)), "LELB": np.ones((6, 3))}, "with one T"),
        ({"LSHO": np.ones((5, 3)), "rate": "fast"}, "rate is 'fast'; expected a number above 0"),
        ({"LSHO": np.ones((5, 3)), "rate": np.nan}, "rate is 'nan'"),
        ({"LSHO": np.ones((5, 3)), "fps": 30, "rate": 60}, "fps 30 and rate 60, which contradict"),
    ],
)
def test_archives_of_something_else_are_refused(
    tmp_path: Path, arrays: dict[str, np.ndarray], message: str
) -> None:
    np.savez(tmp_path / "dance.npz", **arrays)
    with pytest.raises(MotionFileError, match=message):
        read(tmp_path / "dance.npz")


@pytest.mark.parametrize("kind", ["Qualisys", "TRC", "OptiTrack"])
def test_content_tells_the_format_not_the_name(
    tmp_path: Path, points: writers.Points, kind: str
) -> None:
    for extension in (".c3d", ".bvh", ".txt", ".npz", ".csv"):
        path = tmp_path / f"dance{extension}"
        path.write_text(TEXTS[kind](points))
        assert read(path)[0].format == TOLD[kind][0]


def test_a_table_that_begins_with_sp_is_no_c3d(tmp_path: Path) -> None:
    points = writers.arm_points(names=("SPINE", "LELB", "LWRI", "RSHO", "RELB", "RWRI"))
    text = writers.header_row_text(points)
    path = tmp_path / "dance.csv"
    path.write_text("\n".join(line.partition(",")[2] for line in text.splitlines()) + "\n")
    _, tracks, _ = read(path)
    assert_same(tracks, points)


@pytest.mark.parametrize("kind", TEXTS)
def test_ends_of_lines_do_not_matter(tmp_path: Path, points: writers.Points, kind: str) -> None:
    path = tmp_path / "dance"
    text = TEXTS[kind](points)
    blank_lines_at_the_end, no_end_of_line = text + "\n\n", text[:-1]
    crlf, cr = text.replace("\n", "\r\n"), text.replace("\n", "\r")
    for edited in (crlf, cr, blank_lines_at_the_end, no_end_of_line):
        path.write_bytes(edited.encode())
        _, tracks, report = read(path)
        assert_same(tracks, points)
        assert not report.warnings


@pytest.mark.parametrize("kind", TEXTS)
def test_names_may_have_any_letters(tmp_path: Path, kind: str) -> None:
    names = ("Schulter_ü", "Ellbogen_ß", "Poignet_é", "Épaule", "Coude", "Muñeca")
    points = writers.arm_points(names=names)
    path = tmp_path / "dance"
    for encoding in ("utf-8", "utf-8-sig", "utf-16", "latin-1"):
        path.write_bytes(TEXTS[kind](points).encode(encoding))
        assert_same(read(path)[1], points)


@pytest.mark.parametrize(
    "kind", ["Qualisys", "Qualisys with frame", "TRC", "header row with tabs", "Vicon with tabs"]
)
def test_separators_may_end_the_rows(tmp_path: Path, points: writers.Points, kind: str) -> None:
    points["RWRI"][[0, 7, 59]] = np.nan  # the last cells, in the first row too
    path = tmp_path / "dance"
    path.write_text(TEXTS[kind](points).replace("\n", "\t\n"))
    assert_same(read(path)[1], points)


@pytest.mark.parametrize("kind", ["Qualisys", "header row with tabs", "Vicon with tabs"])
def test_a_cell_that_is_lost_before_an_ending_separator_is_refused(
    tmp_path: Path, points: writers.Points, kind: str
) -> None:
    lines = TEXTS[kind](points).splitlines()
    lines[-9] = "\t".join(lines[-9].split("\t")[:-1])
    path = tmp_path / "dance"
    path.write_text("\t\n".join(lines) + "\t\n")
    with pytest.raises(MotionFileError, match=rf"line {len(lines) - 8} has \d+ columns, expected"):
        read(path)


@pytest.mark.parametrize(
    "edit",
    [
        lambda t: t.replace(".", ","),
        lambda t: t.replace(".", ",").replace("0,000", "0"),
        lambda t: t.replace("0.000", "0"),
    ],
    ids=["commas", "commas, but not in whole numbers", "points, but not in whole numbers"],
)
@pytest.mark.parametrize("kind", ["Qualisys", "TRC", "header row with tabs", "Captury"])
def test_decimals_may_follow_a_comma(
    tmp_path: Path, points: writers.Points, kind: str, edit: Edit
) -> None:
    path = tmp_path / "dance"
    path.write_text(edit(TEXTS[kind](points)))
    assert_same(read(path)[1], points)


@pytest.mark.parametrize("decimal", [".", ","])
def test_cells_may_be_quoted(tmp_path: Path, points: writers.Points, decimal: str) -> None:
    rows = writers.header_row_text(points).splitlines()
    quoted = [",".join(f'"{cell}"' for cell in row.split(",")) for row in rows]
    path = tmp_path / "dance.csv"
    path.write_text("\n".join(quoted).replace(".", decimal) + "\n")
    assert_same(read(path)[1], points)


@pytest.mark.parametrize("kind", ["Qualisys", "TRC with commas", "Vicon", "OptiTrack"])
def test_missing_places_may_be_written_in_many_ways(
    tmp_path: Path, points: writers.Points, kind: str
) -> None:
    marked = {name: track.copy() for name, track in points.items()}
    marked["LELB"][20:23] = 77777.777
    points["LELB"][20:23] = np.nan
    path = tmp_path / "dance"
    text = TEXTS[kind](marked)
    for word in ("", "NaN", "nan", "null", "N/A", "-"):
        path.write_text(text.replace("77777.777", word))
        assert_same(read(path)[1], points)


def test_a_place_of_exact_zeros_is_missing(tmp_path: Path, points: writers.Points) -> None:
    points["LELB"][5] = 0.0
    path = tmp_path / "dance"
    path.write_text(writers.qualisys_text(points))
    assert np.flatnonzero(np.isnan(read(path)[1]["LELB"]).all(axis=1)).tolist() == [5]


@pytest.mark.parametrize("kind", ["Qualisys", "header row with tabs"])
def test_a_row_in_which_nothing_is_seen_is_a_gap(tmp_path: Path, kind: str) -> None:
    points = writers.arm_points()
    for track in points.values():
        track[30:33] = np.nan
    path = tmp_path / "dance"
    path.write_text(TEXTS[kind](points))
    _, tracks, report = read(path)
    assert_same(tracks, points)
    assert not report.warnings


def test_rows_without_numbers_at_the_end_are_left_out(tmp_path: Path) -> None:
    points = writers.arm_points()
    empty = "\t" * (3 * len(points) - 1) + "\n"
    path = tmp_path / "dance"
    path.write_text(writers.qualisys_text(points) + 5 * empty)
    _, tracks, report = read(path)
    assert_same(tracks, points)
    assert report.steps == ["the last 5 lines have no numbers; they are not used"]


def test_frames_that_are_left_out_are_gaps(tmp_path: Path, points: writers.Points) -> None:
    lines = writers.trc_text(points).splitlines()
    del lines[6 + 10 : 6 + 13]
    path = tmp_path / "dance.trc"
    path.write_text("\n".join(lines) + "\n")
    _, tracks, report = read(path)
    for name, track in points.items():
        track[10:13] = np.nan
        np.testing.assert_array_equal(tracks[name], track)
    assert report.warnings == [
        "3 frames are missing, the first after line 16; they are treated as gaps"
    ]


def test_frame_numbers_that_stand_still_are_reported(
    tmp_path: Path, points: writers.Points
) -> None:
    lines = writers.trc_text(points).splitlines()
    lines[6:] = ["7\t0.5\t" + line.split("\t", 2)[2] for line in lines[6:]]
    path = tmp_path / "dance.trc"
    path.write_text("\n".join(lines) + "\n")
    _, tracks, report = read(path)
    assert_same(tracks, points)
    assert "the column of times does not ascend throughout" in report.warnings[0]
    assert "the frame numbers jump at line 8" in report.warnings[1]


def test_times_count_for_more_than_numbers_that_go_on_where_frames_were_dropped(
    tmp_path: Path, points: writers.Points
) -> None:
    lines = writers.trc_text(points).splitlines()
    kept = lines[:20] + lines[26:]
    numbered = [f"{i}\t{line.partition(chr(9))[2]}" for i, line in enumerate(kept[6:], 1)]
    path = tmp_path / "dance.trc"
    path.write_text("\n".join(kept[:6] + numbered) + "\n")
    _, tracks, report = read(path)
    (warning, *_) = [w for w in report.warnings if "missing" in w]
    assert warning.startswith("6 frames are missing, the first after line 20")
    assert {len(track) for track in tracks.values()} == {len(points["LELB"])}


def test_times_that_are_rounded_are_even(tmp_path: Path, points: writers.Points) -> None:
    path = tmp_path / "dance.csv"
    lines = writers.header_row_text(points, 60.0).splitlines()
    rows = [line.split(",", 1) for line in lines[1:]]
    rounded = [f"{i / 60:.2f},{rest}" for i, (_, rest) in enumerate(rows)]
    path.write_text("\n".join([lines[0], *rounded]) + "\n")
    recording, tracks, report = read(path)
    assert recording.rate == pytest.approx(60.0, rel=0.01)
    assert_same(tracks, points, atol=1e-5)
    assert not report.warnings


def test_other_sections_before_vicons_trajectories_are_passed_over(
    tmp_path: Path, points: writers.Points
) -> None:
    path = tmp_path / "nexus.csv"
    devices = ["Devices", "1000", ",,Force", "Frame,Sub Frame,Fx,Fy,Fz", ",,N,N,N"]
    devices += [f"{i},0,1,2,3" for i in range(100)]
    outputs = [
        "Model Outputs",
        "100",
        ",,A:LElbowAngles,,",
        "Frame,Sub Frame,X,Y,Z",
        ",,deg,deg,deg",
    ]
    outputs += [f"{i},0,10,20,30" for i in range(100)]
    for sections in (devices, outputs, [*devices, "", *outputs]):
        path.write_text("\n".join([*sections, "", writers.vicon_text(points)]))
        recording, tracks, _ = read(path)
        assert recording.rate == 100.0
        assert_same(tracks, points, atol=1e-3)


def test_lines_after_an_empty_one_are_reported(tmp_path: Path, points: writers.Points) -> None:
    lines = writers.vicon_text(points).splitlines()
    lines.insert(5 + 40, "")
    path = tmp_path / "dance.csv"
    path.write_text("\n".join(lines) + "\n")
    _, tracks, report = read(path)
    assert_same(tracks, {name: track[:40] for name, track in points.items()})
    assert report.warnings == ["line 46 is empty; the 20 lines after it are not read"]


@pytest.mark.parametrize("kind", ["Qualisys", "Captury", "TRC", "header row", "OptiTrack"])
def test_a_header_without_rows_is_refused(tmp_path: Path, kind: str) -> None:
    text = TEXTS[kind](writers.arm_points())
    path = tmp_path / "dance"
    path.write_text("\n".join(text.splitlines()[:-60]) + "\n")
    with pytest.raises(MotionFileError, match="has a header but no frames"):
        read(path)


@pytest.mark.parametrize("kind", TEXTS)
def test_rows_of_another_length_are_refused(tmp_path: Path, kind: str) -> None:
    lines = TEXTS[kind](writers.arm_points()).splitlines()
    separator = next(s for s in "\t;, " if s in lines[-1])
    cells = lines[-20].split(separator)
    path = tmp_path / "dance"
    message = rf"line {len(lines) - 19} has \d+ columns, expected"
    for changed in (cells[:-1], [*cells, "1.0"]):
        lines[-20] = separator.join(changed)
        path.write_text("\n".join(lines) + "\n")
        with pytest.raises(MotionFileError, match=message):
            read(path)


def test_a_header_with_a_column_less_than_the_rows_is_refused(tmp_path: Path) -> None:
    text = writers.header_row_text(writers.arm_points())
    path = tmp_path / "dance.csv"
    path.write_text(text.removeprefix("time,"))  # as R writes row names
    with pytest.raises(MotionFileError, match="line 2 has 19 columns, but the header names 18"):
        read(path)


def test_decimal_commas_between_commas_are_refused(tmp_path: Path) -> None:
    lines = writers.header_row_text(writers.arm_points()).splitlines()
    path = tmp_path / "dance.csv"
    path.write_text("\n".join([lines[0], *(line.replace(".", ",") for line in lines[1:])]) + "\n")
    with pytest.raises(MotionFileError, match="line 2 has 38 columns, but the header names 19"):
        read(path)


def test_rows_may_go_on_after_the_last_title(tmp_path: Path, points: writers.Points) -> None:
    lines = writers.captury_text(points).splitlines()
    path = tmp_path / "dance.csv"
    path.write_text("\n".join([*lines[:5], *(f"{line};1;2;3" for line in lines[5:])]) + "\n")
    assert_same(read(path)[1], points)


def test_a_real_table_is_read_whole(mocap: Path) -> None:
    path = mocap / "markerless_csv" / "shots_Shoulder_Elbow.csv"
    recording, tracks, report = read(path)
    assert (recording.unit, recording.frames, recording.rate) == (0.001, 1933, None)
    np.testing.assert_array_equal(
        tracks["LWristPositions"][0], [375.266083, 961.726929, -201.124939]
    )
    assert len(tracks["LWristPositions"]) == 1933
    assert report.warnings == ["line 1939 is empty; the 10 lines after it are not read"]


@pytest.mark.parametrize("cell", ["x7", "1.2.3", "12a", "1_000"])
def test_cells_that_are_no_numbers_are_named(tmp_path: Path, cell: str) -> None:
    lines = writers.qualisys_text(writers.arm_points()).splitlines()
    cells = lines[25].split("\t")
    lines[25] = "\t".join([*cells[:4], cell, *cells[5:]])
    path = tmp_path / "dance.tsv"
    path.write_text("\n".join(lines) + "\n")
    with pytest.raises(MotionFileError, match=f"line 26, column 5: '{cell}' is not a number"):
        read(path)


@given(rate=st.floats(20.0, 500.0), frames=st.integers(100, 400))
def test_times_tell_the_rate(
    tmp_path_factory: pytest.TempPathFactory, rate: float, frames: int
) -> None:
    path = tmp_path_factory.mktemp("rates") / "dance.csv"
    path.write_text(writers.header_row_text(writers.arm_points(frames), rate))
    found, _, _ = read(path)
    assert found.rate is not None
    assert abs(found.rate - rate) * frames / rate < 0.5  # frames, at the recording's end


@pytest.mark.parametrize("rate", [59.94, 62.5, 23.976, 119.88])
def test_rates_are_not_rounded_where_times_tell_them_well(tmp_path: Path, rate: float) -> None:
    path = tmp_path / "dance.csv"
    path.write_text(writers.header_row_text(writers.arm_points(2000), rate))
    assert read(path)[0].rate == pytest.approx(rate, rel=1e-5)


def test_a_rate_that_the_times_contradict_is_reported(
    tmp_path: Path, points: writers.Points
) -> None:
    text = writers.trc_text(points, 100.0).replace("\n100\t100\t", "\n200\t200\t")
    path = tmp_path / "dance.trc"
    path.write_text(text)
    recording, _, report = read(path)
    assert recording.rate == pytest.approx(100.0)
    assert "the header declares 200 Hz, the times of the frames 100 Hz" in report.warnings[0]


def test_times_in_milliseconds_are_not_taken_for_seconds(
    tmp_path: Path, points: writers.Points
) -> None:
    path = tmp_path / "dance.csv"
    path.write_text(writers.header_row_text(points, 0.1))
    recording, _, report = read(path)
    assert recording.rate == pytest.approx(100.0)
    assert report.warnings[0].startswith("the times are read as milliseconds, which gives 100 Hz;")


def test_rows_that_the_times_leave_out_are_gaps(tmp_path: Path, points: writers.Points) -> None:
    path = tmp_path / "dance.csv"
    lines = writers.header_row_text(points, 100.0).splitlines(keepends=True)
    path.write_text("".join(lines[:11] + lines[16:]))
    _, tracks, report = read(path)
    (warning,) = report.warnings
    assert warning.startswith("5 frames are missing, the first after line 11")
    for name, track in tracks.items():
        gone = np.isnan(track).any(axis=1)
        assert np.flatnonzero(gone).tolist() == [10, 11, 12, 13, 14]
        np.testing.assert_allclose(track[~gone], points[name][~gone], atol=1e-5)


@pytest.mark.parametrize("later", [1.0, 1.4, 2.0])
def test_time_is_right_where_the_rate_changes_in_the_middle(tmp_path: Path, later: float) -> None:
    steps = np.repeat([1 / 30, later / 30], [5000, 1000])
    times = np.concatenate([[0.0], np.cumsum(steps)])
    names = list(writers.arm_points())
    rows = [",".join(["time", *(f"{n}_{a}" for n in names for a in "xyz")])]
    rows += [",".join([f"{t:.6f}", *([f"{t + 1:.6f}"] * 3 * len(names))]) for t in times]
    path = tmp_path / "webcam.csv"
    path.write_text("\n".join(rows) + "\n")
    recording, tracks, _ = read(path)
    assert recording.rate is not None
    for track in tracks.values():
        seen = ~np.isnan(track).any(axis=1)
        even = np.arange(len(track)) / recording.rate
        np.testing.assert_allclose(track[seen, 0], even[seen] + 1, atol=0.6 / 30)
        assert even[-1] == pytest.approx(times[-1], abs=2 / 30)


def test_uneven_frames_are_interpolated_to_even_ones(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    times = np.cumsum(rng.uniform(0.02, 0.045, 200)) + 1.7e9
    straight = {
        name: np.outer(times - times[0], [1, 2, 3]) + track[0]
        for name, track in writers.arm_points().items()
    }
    rows = [",".join(["time", *(f"{n}_{a}" for n in straight for a in "xyz")])]
    rows += [
        ",".join([f"{t:.6f}", *(f"{v:.9f}" for p in straight.values() for v in p[i])])
        for i, t in enumerate(times)
    ]
    path = tmp_path / "webcam.csv"
    path.write_text("\n".join(rows) + "\n")
    recording, tracks, report = read(path)
    assert "unevenly spaced" in report.warnings[0]
    assert recording.rate is not None
    for name, track in tracks.items():
        even = np.arange(len(track)) / recording.rate
        expected = np.outer(even, [1, 2, 3]) + straight[name][0]
        np.testing.assert_allclose(track, expected, atol=1e-4)


@pytest.mark.parametrize("number", ["inf", "nan", "1e400", "-3", "0"])
def test_headers_without_sense_are_no_crash(tmp_path: Path, number: str) -> None:
    path = tmp_path / "dance"
    for kind, old in (("TRC", "100\t100\t60"), ("OptiTrack", "120.000000"), ("Captury", "60\n;")):
        text = TEXTS[kind](writers.arm_points())
        assert old in text
        path.write_text(text.replace(old, old.replace("60", number).replace("100", number), 1))
        recording, tracks, _ = read(path)
        assert recording.rate is None or math.isfinite(recording.rate)
        assert len(next(iter(tracks.values()))) == 60


def test_angles_are_no_places(tmp_path: Path, points: writers.Points) -> None:
    path = tmp_path / "dance.csv"
    path.write_text(writers.captury_text(points))
    assert not any("Angles" in name for name in read(path)[0].names)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "is empty"),
        (b" \n\n", "is empty"),
        (b"\0" * 3000, "is binary"),
        (bytes(range(256)) * 9, "is binary"),
        (b"time,x,y\n0,1,2\n", "no recording of a known format"),
        (b"hello\n", "no recording of a known format"),
    ],
)
def test_what_is_no_recording_is_refused(tmp_path: Path, content: bytes, message: str) -> None:
    path = tmp_path / "dance.c3d"
    path.write_bytes(content)
    with pytest.raises(MotionFileError, match=message):
        read(path)


def test_a_point_without_its_y_is_told(tmp_path: Path) -> None:
    path = tmp_path / "dance.csv"
    text = writers.header_row_text(writers.arm_points() | {"pelvis": np.zeros((60, 3))})
    path.write_text(text.replace("pelvis_y", "pelv_y"))
    report = ImportReport()
    open_recording(path, report)
    assert report.warnings == ["pelvis has a z, but not both x and y; check the titles"]
    path.write_text(text.replace("pelvis_z", "pelvis_c"))  # places in a picture, and a confidence
    report = ImportReport()
    open_recording(path, report)
    assert not report.warnings
