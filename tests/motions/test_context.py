from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import mpma_mj
from mpma_mj.context import Span
from mpma_mj.errors import BadOptionError, MotionFileError, RecordingWarning
from mpma_mj.motions import read_motion, ymca
from mpma_mj.motions.context import label_motion
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


def test_where_no_label_is_the_context_is_0_and_that_is_told(write_labels: WriteLabels) -> None:
    path = write_labels("0,1,Y\n1.95,9,M\n")
    context, _, report = labelled(ReadingOptions(labels=path))
    silent = (TIMES >= 1.0) & (TIMES < 1.95)
    np.testing.assert_array_equal(context.sum(axis=1) == 0, silent)
    assert report.warnings == ["25 % of the movement has no label; its context is 0"]


def test_labels_outside_are_left_out_or_refused(write_labels: WriteLabels) -> None:
    context, labels, _ = labelled(ReadingOptions(labels=write_labels("-9,0,A\n0,9,Y\n9,10,B\n")))
    assert labels == ("Y",)
    assert (context == 1).all()
    path = write_labels("100,200,Y\n")
    with pytest.raises(MotionFileError) as caught:
        labelled(ReadingOptions(labels=path))
    assert str(caught.value) == (
        f"{path}: no label falls between 0.00 and 3.75 s, where the movement is; times count from"
        " the recording's first frame"
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
    assert report.steps == [f"the movement changes at {told} s"]


def test_events_of_the_recording_label_it_if_that_is_asked_for() -> None:
    events = (Span(-np.inf, 1.0, "start"), Span(1.0, np.inf, "Right step"))
    context, labels, _ = labelled(ReadingOptions(context="events"), events)
    assert labels == ("start", "Right step")
    np.testing.assert_array_equal(context[:, 1], TIMES >= 1.0)
    with pytest.raises(MotionFileError, match=r"has no events; label it with labels or segm"):
        labelled(ReadingOptions(context="events"))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"labels": "a.csv", "context": "changes"}, "labels are the context; drop audio and"),
        ({"labels": "a.csv", "audio": "a.wav"}, "labels are the context; drop audio and"),
        ({"context": "bars"}, "context bars needs the music; give it with audio"),
        ({"context": "sections"}, "context sections needs the music; give it with audio"),
        ({"context": "equal", "audio": "a.wav"}, "audio gives bars or sections, not equal"),
        ({"context": "letters"}, "context is 'letters'; expected one of auto, equal, changes"),
        ({"labels": "a.csv", "segments": 5}, "segments are parts of a movement without labels"),
        ({"audio": "a.wav", "segments": 5}, "segments are parts of a movement without labels"),
        ({"context": "events", "segments": 5}, "segments are parts of a movement without labels"),
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
    with pytest.warns(RecordingWarning, match=r"dance\.tsv: \d+ % of the movement has no label"):
        read_motion(path, labels=write_labels("0,1,Y\n"))
