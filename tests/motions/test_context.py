from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import mpma_mj
from mpma_mj import kinematics
from mpma_mj.context import Span
from mpma_mj.errors import BadOptionError, MotionFileError, RecordingWarning
from mpma_mj.motions import read_motion, ymca
from mpma_mj.motions.context import change_points, label_motion, read_labels
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.loader import import_motion
from mpma_mj.motions.options import ReadingOptions
from tests.conftest import WriteTsv

Array = NDArray[np.float64]


WriteLabels = Callable[[str], str]


POSTURE = ymca().posture


TIMES = np.arange(len(POSTURE)) / 20.0


@pytest.fixture
def write_labels(tmp_path: Path) -> WriteLabels:
    def write(text: str) -> str:
        path = tmp_path / "labels.csv"
        path.write_text(text)
        return str(path)

    return write


def labelled(
    options: ReadingOptions, events: tuple[Span, ...] = (), times: Array = TIMES
) -> tuple[Array, tuple[str, ...], ImportReport]:
    report = ImportReport()
    return (*label_motion(POSTURE, times, events, options, "dance.x", report), report)


def test_labels_are_1_where_they_are_danced(write_labels: WriteLabels) -> None:
    path = write_labels("start,end,label\n0,1,Y\n1,2.5,M\n2.5,9,Y\n")
    context, labels, report = labelled(ReadingOptions(labels=path))
    assert labels == ("Y", "M")
    middle = (TIMES >= 1.0) & (TIMES < 2.5)
    np.testing.assert_array_equal(context, np.stack([~middle, middle], axis=1))
    assert report.steps == ["2 labels, which begin at 1.00, 2.50 s"]
    assert not report.warnings


def test_labels_that_overlap_are_both_1(write_labels: WriteLabels) -> None:
    path = write_labels("0,2,Y\n1,9,M\n")
    context, _, report = labelled(ReadingOptions(labels=path))
    both = (TIMES >= 1.0) & (TIMES < 2.0)
    np.testing.assert_array_equal(context.sum(axis=1), np.where(both, 2.0, 1.0))
    assert not report.warnings


def test_where_no_label_is_the_context_is_0_and_that_is_reported(write_labels: WriteLabels) -> None:
    path = write_labels("0,1,Y\n1.95,9,M\n")
    context, _, report = labelled(ReadingOptions(labels=path))
    silent = (TIMES >= 1.0) & (TIMES < 1.95)
    np.testing.assert_array_equal(context.sum(axis=1) == 0, silent)
    assert report.warnings == ["25 % of the motion has no label; its context is 0"]


def test_labels_outside_are_left_out_or_refused(write_labels: WriteLabels) -> None:
    context, labels, _ = labelled(ReadingOptions(labels=write_labels("-9,0,A\n0,9,Y\n9,10,B\n")))
    assert labels == ("Y",)
    assert (context == 1).all()
    path = write_labels("100,200,Y\n")
    with pytest.raises(MotionFileError) as caught:
        labelled(ReadingOptions(labels=path))
    assert str(caught.value) == (
        f"{path}: no label lies between 0.00 and 3.75 s, the time of the motion; times of labels"
        " count from the recording's first frame"
    )


@pytest.mark.parametrize("segments", [1, 2, 4, 5, 76])
def test_parts_are_equal(segments: int) -> None:
    context, labels, _ = labelled(ReadingOptions(segments=segments))
    assert labels == tuple(str(i + 1) for i in range(segments))
    counts = context.sum(axis=0)
    assert counts.max() - counts.min() <= 1
    assert (np.diff(context.argmax(axis=1)) >= 0).all()
    np.testing.assert_array_equal(context.sum(axis=1), 1.0)


@pytest.mark.parametrize("name", ["auto", "equal", "changes"])
def test_more_parts_than_postures_are_refused(name: str) -> None:
    options = ReadingOptions(segments=77, context=name)  # type: ignore[arg-type]
    with pytest.raises(
        BadOptionError, match=r"^segments is 77; expected fewer, as dance\.x gives 76"
    ):
        labelled(options)


def test_changes_are_those_of_the_movement_and_are_told_in_its_seconds() -> None:
    times = 10.0 + TIMES
    context, labels, report = labelled(ReadingOptions(context="changes"), times=times)
    np.testing.assert_array_equal(context, ymca().context)
    assert labels == ("1", "2", "3", "4")
    starts = times[np.flatnonzero(np.diff(ymca().context.argmax(axis=1))) + 1]
    told = ", ".join(f"{start:.2f}" for start in starts)
    assert report.steps == [f"the motion changes at {told} s"]


def test_events_of_the_recording_label_it_if_that_is_asked_for() -> None:
    events = (Span(-np.inf, 1.0, "start"), Span(1.0, np.inf, "Right step"))
    context, labels, _ = labelled(ReadingOptions(context="events"), events)
    assert labels == ("start", "Right step")
    np.testing.assert_array_equal(context[:, 1], TIMES >= 1.0)
    with pytest.raises(
        MotionFileError, match=r"has no events; label the motion with labels or segm"
    ):
        labelled(ReadingOptions(context="events"))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (
            {"labels": "a.csv", "context": "changes"},
            "labels already give the context; leave out audio and",
        ),
        (
            {"labels": "a.csv", "audio": "a.wav"},
            "labels already give the context; leave out audio and",
        ),
        ({"context": "bars"}, "context bars needs audio; give it with audio"),
        ({"context": "sections"}, "context sections needs audio; give it with audio"),
        ({"context": "equal", "audio": "a.wav"}, "audio has bars and sections, not equal"),
        ({"context": "letters"}, "context is 'letters'; expected one of auto, equal, changes"),
        ({"labels": "a.csv", "segments": 5}, "segments divide a motion without labels"),
        ({"audio": "a.wav", "segments": 5}, "segments divide a motion without labels"),
        ({"context": "events", "segments": 5}, "segments divide a motion without labels"),
        ({"segments": 0}, "segments is 0; expected a whole number from 1 to"),
    ],
)
def test_options_that_contradict_each_other_are_refused(
    options: dict[str, object], message: str
) -> None:
    with pytest.raises(BadOptionError, match=f"^{message}[^\n]*$"):
        ReadingOptions(**options).check()  # type: ignore[arg-type]


def test_labels_count_in_seconds_of_the_recording(
    write_tsv: WriteTsv, write_labels: WriteLabels
) -> None:
    path = write_labels("0,1.5,before\n1.5,2,Y\n2,9,M\n")
    for tempo in (0.5, 1.0, 2.0):
        options = ReadingOptions(labels=path, start=1.0, end=3.0, tempo=tempo)
        imported = import_motion(write_tsv(), options)
        assert imported.motion.labels == ("before", "Y", "M")
        np.testing.assert_allclose(
            imported.report.times, 1.0 + np.arange(len(imported.motion)) * tempo / 20.0
        )
        counts = imported.motion.context.sum(axis=0) / 20.0 * tempo
        np.testing.assert_allclose(counts[:2], 0.5, atol=0.051 * tempo)


def test_a_stored_movement_keeps_its_labels_unless_others_are_asked_for(
    write_labels: WriteLabels,
) -> None:
    assert read_motion("ymca").labels == ("Y", "M", "C", "A")
    for options, labels in (
        ({"context": "equal"}, ("1", "2", "3", "4")),
        ({"segments": 6}, ("1", "2", "3", "4", "5", "6")),
        ({"context": "changes", "segments": 2}, ("1", "2")),
        ({"labels": write_labels("0,1,a\n1,9,b\n")}, ("a", "b")),
    ):
        assert read_motion("ymca", **options).labels == labels


def test_observations_have_as_many_entries_as_there_are_labels(
    write_tsv: WriteTsv, write_labels: WriteLabels
) -> None:
    path = write_tsv()
    labels = write_labels("0,1,Y\n1,2.5,M\n2.5,9,C\n")
    for options, count in (({}, 4), ({"segments": 7}, 7), ({"labels": labels}, 3)):
        motion = read_motion(path, **options)
        env = mpma_mj.load(motion)
        assert env.observation_spec()["context"].shape == (count,)
        assert env.reset().observation["context"].shape == (count,)


def test_what_may_be_wrong_with_labels_is_a_warning(
    write_tsv: WriteTsv, write_labels: WriteLabels
) -> None:
    path = write_tsv()
    with pytest.warns(RecordingWarning, match=r"dance\.tsv: \d+ % of the motion has no label"):
        read_motion(path, labels=write_labels("0,1,Y\n"))


SPANS = (Span(0.0, 1.5, "Y"), Span(1.5, 2.25, "M"), Span(2.0, 3.0, "Y"))


@pytest.mark.parametrize(
    "text",
    [
        "0,1.5,Y\n1.5,2.25,M\n2,3,Y\n",
        "start,end,label\n0,1.5,Y\n1.5,2.25,M\n2,3,Y",
        "Start;End;Label\n0;1.5;Y\n1.5;2.25;M\n2;3;Y\n",
        "0;1,5;Y\n1,5;2,25;M\n2;3;Y\n",
        "0\t1.5\tY\n1.5\t2.25\tM\n2\t3\tY\n",
        "0\t1,5\tY\n1,5\t2,25\tM\n2\t3\tY\n",
        "\n0, 1.5, Y\n\n1.5, 2.25, M\n2 ,3 ,Y\n\n",
        '"start","end","label"\r\n"0","1.5","Y"\r\n"1.5","2.25","M"\r\n"2","3","Y"\r\n',
        "\ufeffstart,end,label\n0,1.5,Y\n1.5,2.25,M\n2,3,Y\n",
        ",,\n0,1.5,Y\n1.5,2.25,M\n2,3,Y\n",
    ],
)
def test_rows_are_read_however_they_are_written(tmp_path: Path, text: str) -> None:
    path = tmp_path / "labels.csv"
    path.write_text(text, encoding="utf-8", newline="")
    assert read_labels(path) == SPANS


numbers = st.floats(-1e3, 1e6).map(lambda x: round(x, 3))


names = st.text("abcXYZ äß;.-'_ 0123", min_size=1).map(str.strip).filter(bool)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(rows=st.lists(st.tuples(numbers, st.floats(0.001, 1e3), names), min_size=1, max_size=8))
def test_what_is_written_is_read(tmp_path: Path, rows: list[tuple[float, float, str]]) -> None:
    spans = tuple(Span(start, start + length, name) for start, length, name in rows)
    path = tmp_path / "labels.csv"
    lines = [f"{span.start!r},{span.end!r},{span.label}" for span in spans]
    path.write_text("\n".join(lines), encoding="utf-8")
    assert read_labels(path) == spans


def test_a_label_may_have_separators_in_it(tmp_path: Path) -> None:
    path = tmp_path / "labels.csv"
    path.write_text('0,1,"arms up, down"\n1,2,left; right\n')
    assert [span.label for span in read_labels(path)] == ["arms up, down", "left; right"]


def test_a_label_may_last_to_the_end_of_time(tmp_path: Path) -> None:
    path = tmp_path / "labels.csv"
    path.write_text("0,inf,Y\n")
    assert read_labels(path) == (Span(0.0, np.inf, "Y"),)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("0,1,Y\n1,2\n", "line 2: '1,2' is not start,end,label, such as 0,2.5,Y"),
        ("0,1,Y\n1,2,M,C\n", "line 2: '1,2,M,C' is not"),
        ("0,1,Y\n1,2,\n", "line 2: '1,2,' is not"),
        ("0,1,Y\n1,two,M\n", "line 2: '1,two,M' is not"),
        ("o,1,Y\n1,2,M\n", "line 1: 'o,1,Y' is not"),  # no header: half of it is numbers
        ("start,end,label\nstart,end,label\n", "line 2: 'start,end,label' is not"),
        ("0,1,Y\n2,2,M\n", "line 2: the span from 2 to 2 s has no length"),
        ("0,1,Y\n3,2,M\n", "line 2: the span from 3 to 2 s has no length"),
        ("nan,1,Y\n", "line 1: the span from nan to 1 s has no length"),
        ("0,nan,Y\n", "line 1: the span from 0 to nan s has no length"),
        ("-inf,1,Y\n", "line 1: the span from -inf to 1 s has no length"),
        ("", "contains no rows of start,end,label"),
        ("start,end,label\n\n", "contains no rows of start,end,label"),
        ("0,1,Y\n1,2," + "M" * 200_000, "line 2: '1,2,MMMM"),
        ("1_0,20,Y\n0,1,Y\n", "line 1: '1_0,20,Y' is not"),
    ],
)
def test_bad_rows_are_one_line_that_names_them(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "labels.csv"
    path.write_text(text)
    with pytest.raises(MotionFileError) as caught:
        read_labels(path)
    assert str(caught.value).startswith(f"{path}: {message}")
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < len(str(path)) + 200


def test_what_is_no_text_file_is_one_line(tmp_path: Path) -> None:
    binary = tmp_path / "labels.csv"
    binary.write_bytes(b"\0\1\2" * 100)
    for path, problem in {
        binary: "is not a text file; expected rows of start,end,label in seconds",
        tmp_path / "missing.csv": "no such file; check the path",
        tmp_path: "is a folder; give the path of a file in it",
    }.items():
        with pytest.raises(MotionFileError) as caught:
            read_labels(path)
        assert str(caught.value) == f"{path}: {problem}"


Index = NDArray[np.int_]


REST = np.tile([0.8, 0.2, 0.0, 1.0], 2)  # rad


def rhythms(lengths: list[int], seed: int = 0) -> tuple[Array, Index]:
    """Return a movement of one rhythm after the other, and which is danced when."""
    rng = np.random.default_rng(seed)
    label = np.repeat(np.arange(len(lengths)), lengths)
    phase = 2 * np.pi * np.cumsum(rng.uniform(0.4, 1.6, len(lengths))[label]) / 20.0
    centre = (REST + rng.uniform(-0.3, 0.3, (len(lengths), 8)))[label]
    amplitude = rng.uniform(0.1, 0.6, (len(lengths), 8))[label]
    angles = centre + amplitude * np.sin(phase[:, None] + rng.uniform(0, 6, 8))
    return kinematics.posture_from_angles(angles), label


@pytest.mark.parametrize("rate", [10.0, 20.0, 60.0])
def test_the_letters_are_found_from_the_start_of_the_move_towards_them(rate: float) -> None:
    motion = ymca(rate=rate)
    np.testing.assert_array_equal(change_points(motion.posture, 4), motion.context.argmax(axis=1))


def test_letters_that_are_danced_twice_are_found_twice() -> None:
    motion = ymca(rate=20.0)
    label = motion.context.argmax(axis=1)
    found = change_points(np.tile(motion.posture, (2, 1)), 8)
    np.testing.assert_array_equal(found, [*label, *(label + 4)])


@pytest.mark.parametrize("seed", range(5))
def test_rhythms_are_told_apart_within_a_second(seed: int) -> None:
    posture, label = rhythms([120, 180, 100, 200], seed)
    found = change_points(posture, 4)
    edges = np.flatnonzero(np.diff(found))
    np.testing.assert_allclose(edges, np.flatnonzero(np.diff(label)), atol=20)


def test_a_rhythm_of_another_speed_is_another_rhythm() -> None:
    label = np.repeat([0, 1, 2], [200, 150, 250])
    phase = 2 * np.pi * np.cumsum(np.array([0.5, 1.4, 0.8])[label]) / 20.0
    posture = kinematics.posture_from_angles(REST + 0.4 * np.sin(phase[:, None] + np.arange(8)))
    assert (change_points(posture, 3) == label).mean() > 0.98


def test_a_long_movement_is_cut_as_well() -> None:
    posture, label = rhythms([20_001, 30_000, 15_000])
    assert (change_points(posture, 3) == label).mean() > 0.99


def test_a_movement_reversed_in_space_is_cut_at_the_same_places() -> None:
    posture, _ = rhythms([120, 180, 100])
    np.testing.assert_array_equal(change_points(-posture, 3), change_points(posture, 3))


@pytest.mark.parametrize(
    ("frames", "segments"), [(1, 1), (50, 1), (2, 2), (5, 5), (76, 30), (2001, 7)]
)
def test_every_part_is_there_and_in_order(frames: int, segments: int) -> None:
    posture, _ = rhythms([frames])
    found = change_points(posture, segments)
    assert found.shape == (frames,)
    np.testing.assert_array_equal(np.unique(found), np.arange(segments))
    assert (np.diff(found) >= 0).all()


@pytest.mark.filterwarnings("error")
def test_arms_that_rest_are_cut_all_the_same() -> None:
    found = change_points(np.tile(kinematics.posture_from_angles(REST), (40, 1)), 4)
    np.testing.assert_array_equal(np.unique(found), np.arange(4))


@pytest.mark.parametrize(("frames", "segments"), [(3, 4), (4001, 1500), (10, 0), (10, -1)])
def test_parts_that_there_cannot_be_are_refused(frames: int, segments: int) -> None:
    with pytest.raises(BadOptionError, match=rf"^segments is {segments}; expected at [^\n]*$"):
        change_points(rhythms([frames])[0], segments)
