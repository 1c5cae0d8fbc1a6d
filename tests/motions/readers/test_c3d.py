"""Our own C3D reader against the usual library, and against files of every processor."""

from pathlib import Path

import ezc3d
import numpy as np
import pytest

from mpma_mj.context import Span
from mpma_mj.errors import MotionFileError
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.marker_sets import choose_markers
from mpma_mj.motions.readers.recognise import open_recording
from mpma_mj.motions.readers.recording import Recording, Tracks
from tests.motions.readers import writers

REAL = {
    "qualisys_c3d/Qualisys.c3d": 200.0,
    "hdm05/HDM_dg_06-03_03_120.c3d": 120.0,
    "vicon_trc/markers_analogs.c3d": 100.0,
}


def read(path: Path) -> tuple[Recording, Tracks]:
    recording = open_recording(path, ImportReport())
    return recording, recording.load(recording.names)


def with_gaps() -> writers.Points:
    points = writers.arm_points()
    points["LELB"][10:14] = np.nan
    points["RWRI"][-1] = np.nan
    return points


def test_points_that_the_usual_library_wrote_come_back(tmp_path: Path) -> None:
    points = with_gaps()
    recording, tracks = read(writers.write_c3d(tmp_path / "dance.c3d", points, rate=75.0))
    assert (recording.format, recording.rate, recording.unit) == ("C3D", 75.0, 0.001)
    assert recording.frames == 60
    assert list(tracks) == list(points)
    for name, track in tracks.items():
        np.testing.assert_allclose(track, points[name], rtol=1e-6)


@pytest.mark.parametrize("whole_numbers", [True, False], ids=["integers", "floats"])
@pytest.mark.parametrize("processor", ["intel", "dec", "mips"])
def test_every_processors_numbers_are_read(
    tmp_path: Path, processor: str, whole_numbers: bool
) -> None:
    points = with_gaps()
    path = tmp_path / "dance.c3d"
    writers.write_c3d_of(path, points, processor, whole_numbers=whole_numbers)
    recording, tracks = read(path)
    assert (recording.rate, recording.unit, recording.up, recording.frames) == (100, 1e-3, "z", 60)
    for name, track in tracks.items():
        precision = 0.026 if whole_numbers else 1e-3  # mm: half of the unit
        np.testing.assert_allclose(track, points[name], rtol=0, atol=precision)


def test_the_library_reads_what_our_writer_wrote(tmp_path: Path) -> None:
    points = writers.arm_points()
    path = writers.write_c3d_of(tmp_path / "d.c3d", points, "intel", whole_numbers=False)
    places = ezc3d.c3d(str(path))["data"]["points"]
    for i, track in enumerate(points.values()):
        np.testing.assert_allclose(places[:3, i].T, track, atol=1e-3)


@pytest.mark.parametrize("file", REAL)
def test_real_files_read_as_by_the_usual_library(mocap: Path, file: str) -> None:
    recording, tracks = read(mocap / file)
    theirs = ezc3d.c3d(str(mocap / file))
    labels = theirs["parameters"]["POINT"]["LABELS"]["value"]
    places = theirs["data"]["points"]
    residuals = theirs["data"]["meta_points"]["residuals"][0]
    assert recording.rate == REAL[file]
    assert set(recording.names) <= set(labels)
    assert len(recording.names) > 10
    for name, track in tracks.items():
        known = places[:3, labels.index(name)].T
        missing = np.isnan(known).any(axis=1) | (residuals[labels.index(name)] < 0)
        missing |= (known == 0.0).all(axis=1)
        np.testing.assert_array_equal(np.isnan(track).any(axis=1), missing)
        np.testing.assert_allclose(track[~missing], known[~missing], rtol=1e-6)


def test_events_become_spans(tmp_path: Path) -> None:
    events = [("jump", 0.4), ("turn", 0.1)]
    path = writers.write_c3d(tmp_path / "dance.c3d", writers.arm_points(), events=events)
    starts = [(span.label, round(span.start, 6)) for span in read(path)[0].spans]
    assert starts == [("start", -np.inf), ("Left turn", 0.1), ("Left jump", 0.4)]


def test_each_span_ends_where_the_next_one_begins(tmp_path: Path) -> None:
    events = [("a", 0.1), ("b", 0.2), ("c", 61.5)]
    path = writers.write_c3d(tmp_path / "dance.c3d", writers.arm_points(), events=events)
    spans = read(path)[0].spans
    assert all(isinstance(span, Span) for span in spans)
    assert [s.end for s in spans[:-1]] == [s.start for s in spans[1:]]
    assert spans[-1].start == pytest.approx(61.5)
    assert spans[-1].end == np.inf


def test_a_file_without_events_has_no_spans(tmp_path: Path) -> None:
    path = writers.write_c3d(tmp_path / "dance.c3d", writers.arm_points())
    assert read(path)[0].spans == ()


def test_events_that_are_damaged_are_told_and_not_used(tmp_path: Path) -> None:
    file = ezc3d.c3d(str(writers.write_c3d(tmp_path / "whole.c3d", writers.arm_points())))
    file.add_parameter("EVENT", "LABELS", ["a"])
    file.add_parameter("EVENT", "TIMES", ["soon"])
    file.write(str(tmp_path / "dance.c3d"))
    report = ImportReport()
    assert open_recording(tmp_path / "dance.c3d", report).spans == ()
    assert report.warnings == ["its events are damaged; they are not used"]


def test_events_count_from_the_first_frame_that_is_there(tmp_path: Path) -> None:
    file = ezc3d.c3d(str(writers.write_c3d(tmp_path / "whole.c3d", writers.arm_points())))
    rate = file["parameters"]["POINT"]["RATE"]["value"][0]
    file["header"]["points"]["first_frame"] = 30  # counted from 0
    file.add_parameter("EVENT", "LABELS", ["clap"])
    file.add_parameter("EVENT", "TIMES", np.array([[0.0], [40 / rate]]))
    file.write(str(tmp_path / "dance.c3d"))
    recording = open_recording(tmp_path / "dance.c3d", ImportReport())
    assert [span.label for span in recording.spans] == ["start", "clap"]
    assert recording.spans[1].start == pytest.approx(10 / rate)


def long_points() -> writers.Points:
    """Return points of more frames than the header can tell: 70,000."""
    points = {n: np.tile(t, (1400, 1)) for n, t in writers.arm_points(50).items()}
    points["LELB"][-1] = [1.0, 2.0, 3.0]
    return points


def test_a_long_recording_that_tells_its_length_is_read_whole(tmp_path: Path) -> None:
    points, path = long_points(), tmp_path / "dance.c3d"
    file = ezc3d.c3d(str(writers.write_c3d(path, points)))
    path.unlink()
    whole = np.stack([track.T for track in points.values()], axis=1)
    file["data"]["points"] = np.concatenate([whole, np.ones((1, 6, 70_000))])
    file["data"]["analogs"] = np.ones((1, 1, 140_000))
    del file["data"]["meta_points"]
    file.add_parameter("TRIAL", "ACTUAL_START_FIELD", [1, 0])
    file.add_parameter("TRIAL", "ACTUAL_END_FIELD", [70_000 - 65_536, 1])
    file.write(str(path))
    report = ImportReport()
    recording = open_recording(path, report)
    assert recording.frames == 70_000
    assert not report.warnings
    np.testing.assert_allclose(recording.load(["LELB"])["LELB"], points["LELB"], rtol=1e-6)


def test_a_long_recording_that_cannot_tell_its_length_is_read_whole(tmp_path: Path) -> None:
    points, report = long_points(), ImportReport()
    path = writers.write_c3d(tmp_path / "dance.c3d", points)
    track = open_recording(path, report).load(["LELB"])["LELB"]
    seen = track[: len(points["LELB"])]
    np.testing.assert_allclose(seen, points["LELB"], rtol=1e-6)
    assert np.isnan(track[len(seen) :]).all()  # the last block's rest
    assert report.warnings


def test_a_point_with_a_negative_residual_is_missing_in_whole_numbers(tmp_path: Path) -> None:
    path = tmp_path / "dance.c3d"
    writers.write_c3d_of(path, with_gaps(), "mips", whole_numbers=True, first=300)
    recording, tracks = read(path)
    assert recording.frames == 60
    assert np.flatnonzero(np.isnan(tracks["LELB"]).all(axis=1)).tolist() == [10, 11, 12, 13]


@pytest.mark.parametrize("kept", [1, 300, 511, 600, 1000])
def test_a_file_cut_in_its_header_is_refused(tmp_path: Path, kept: int) -> None:
    path = writers.write_c3d(tmp_path / "dance.c3d", writers.arm_points())
    path.write_bytes(path.read_bytes()[:kept])
    with pytest.raises(MotionFileError):
        read(path)


def test_a_file_cut_in_its_frames_keeps_the_whole_ones(tmp_path: Path) -> None:
    points = writers.arm_points()
    path = writers.write_c3d_of(tmp_path / "d.c3d", points, "intel", whole_numbers=False)
    frame = 6 * 16
    path.write_bytes(path.read_bytes()[: -10 * frame - 7])
    recording, tracks = read(path)
    assert recording.frames == 60
    assert {len(track) for track in tracks.values()} == {49}
    np.testing.assert_allclose(tracks["RWRI"], points["RWRI"][:49], atol=1e-3)


def write_segments(path: Path, points: writers.Points, *, analog: bool = False) -> None:
    """Write poses of segments instead of points, as Theia3D does."""
    file = ezc3d.c3d()
    parameters = file["parameters"]
    parameters["POINT"]["RATE"]["value"] = [50.0]
    frames = len(next(iter(points.values())))
    file["data"]["points"] = np.zeros((4, 0, frames))
    if analog:
        parameters["ANALOG"]["RATE"]["value"] = [100.0]
        parameters["ANALOG"]["LABELS"]["value"] = ["Fz"]
        file["data"]["analogs"] = np.ones((1, 1, 2 * frames))
    else:
        file.add_parameter("ROTATION", "LABELS", [f"{name}_4X4" for name in points])
        file.add_parameter("ROTATION", "RATE", [50.0])
        file.add_parameter("ROTATION", "RATIO", [1])
        poses = np.tile(np.eye(4)[:, :, None, None], (1, 1, len(points), frames))
        poses[:3, :3, 0] = np.diag([-1.0, -1.0, 1.0])[..., None]
        poses[:3, 3] = np.stack([track.T for track in points.values()], axis=1)
        file["data"]["rotations"] = poses
    file.write(str(path))


def test_segments_without_points_are_where_they_begin(tmp_path: Path) -> None:
    names = [f"{side}_{part}" for side in "lr" for part in ("uarm", "larm", "hand")]
    points = writers.arm_points(names=names) | {"torso": np.full((60, 3), 7.0)}
    write_segments(tmp_path / "dance.c3d", points)
    recording, tracks = read(tmp_path / "dance.c3d")
    assert (recording.names, recording.rate, recording.frames) == (tuple(points), 50.0, 60)
    for name, track in tracks.items():
        np.testing.assert_allclose(track, points[name], rtol=1e-6)
    assert choose_markers(recording.path, recording.names, {})["right_wrist"] == ("r_hand",)


def test_a_segment_that_is_not_seen_is_a_gap(tmp_path: Path) -> None:
    path = tmp_path / "dance.c3d"
    write_segments(path, writers.arm_points())
    data = bytearray(path.read_bytes())
    floats = np.frombuffer(data, "<f4", offset=len(data) - 60 * 6 * 17 * 4).reshape(60, 6, 17)
    floats[10:12, 1, 16] = -1.0
    path.write_bytes(data)
    lost = np.isnan(read(path)[1]["LELB"]).all(axis=1)
    assert np.flatnonzero(lost).tolist() == [10, 11]


def test_segments_that_begin_nowhere_are_no_points(tmp_path: Path) -> None:
    path = tmp_path / "dance.c3d"
    write_segments(path, writers.arm_points())
    data = bytearray(path.read_bytes())
    value = data.rindex(b"DATA_START") + len("DATA_START") + 2
    value += 2 + data[value + 1]  # after the type and the sizes
    data[value : value + 2] = bytes(2)
    path.write_bytes(data)
    with pytest.raises(MotionFileError, match="has no points"):
        read(path)


def test_a_file_of_forces_has_no_points(tmp_path: Path) -> None:
    write_segments(tmp_path / "force.c3d", writers.arm_points(), analog=True)
    with pytest.raises(MotionFileError, match="has no points; export the C3D with its traj"):
        read(tmp_path / "force.c3d")


def test_two_rates_that_differ_are_reported(tmp_path: Path) -> None:
    path = tmp_path / "dance.c3d"
    writers.write_c3d_of(path, writers.arm_points(), "intel", whole_numbers=False)
    data = bytearray(path.read_bytes())
    data[20:24] = np.array([50.0], "<f4").tobytes()
    path.write_bytes(data)
    report = ImportReport()
    assert open_recording(path, report).rate == 100.0
    assert "the header declares 50 Hz, the parameters 100 Hz, which is used" in report.warnings[0]


def test_a_block_that_is_doubled_is_warned_of(tmp_path: Path) -> None:
    path = writers.write_c3d_of(
        tmp_path / "dance.c3d", writers.arm_points(), "intel", whole_numbers=False
    )
    report = ImportReport()
    open_recording(path, report)
    assert not report.warnings
    data, frames = path.read_bytes(), 3 * 6 * 4 * 4  # bytes of three frames
    path.write_bytes(data[:-1000] + data[-1000 - frames : -1000] + data[-1000:])
    open_recording(path, report)
    assert "288 bytes after the 60 frames that it declares" in report.warnings[0]
