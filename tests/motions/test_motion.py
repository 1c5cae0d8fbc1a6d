import dataclasses
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from mpma_mj.errors import BadOptionError, MotionFileError
from mpma_mj.motions import Motion, read_motion, ymca
from mpma_mj.motions.loader import import_motion
from mpma_mj.motions.motion import load_motion, save_motion
from mpma_mj.motions.options import ReadingOptions
from tests.motions.known_motions import check_equal


def test_a_motion_knows_its_duration() -> None:
    motion = ymca()
    assert motion.duration == pytest.approx(len(motion) / 20.0)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"posture": np.ones((1, 12)) / np.sqrt(3)}, "at least two"),
        ({"posture": np.ones((76, 11))}, r"posture has shape \(76, 11\), expected \(76, 12\)"),
        ({"posture": np.ones((76, 12))}, "length is not 1"),
        ({"posture": np.full((76, 12), np.nan)}, "not finite"),
        ({"context": np.ones((76, 3))}, r"context has shape \(76, 3\), expected \(76, 4\)"),
    ],
)
def test_what_is_no_motion_is_refused(change: dict[str, np.ndarray], message: str) -> None:
    with pytest.raises(MotionFileError, match=message):
        dataclasses.replace(ymca(), **change)


def test_a_motion_cannot_be_changed() -> None:
    with pytest.raises(dataclasses.FrozenInstanceError):
        ymca().rate = 10.0  # type: ignore[misc]


def test_motion_is_exported() -> None:
    import mpma_mj

    assert mpma_mj.Motion is Motion


Array = NDArray[np.float64]


def save(path: Path, **arrays: object) -> Path:
    np.savez(path, **arrays)  # type: ignore[arg-type]
    return path


@pytest.mark.parametrize(
    "motion",
    [
        ymca(),
        ymca(rate=33.3, tempo=0.7),
        dataclasses.replace(ymca(), name="Tänze; 2", labels=("Y", "ü", "two words", "")),
    ],
)
def test_what_is_written_is_read_exactly(tmp_path: Path, motion: Motion) -> None:
    path = tmp_path / "motion.npz"
    save_motion(path, motion)
    check_equal(load_motion(path), motion)


def test_a_written_movement_is_read_as_any_recording(tmp_path: Path) -> None:
    save_motion(tmp_path / "motion.npz", ymca())
    check_equal(read_motion(tmp_path / "motion.npz"), ymca())


def test_posture_and_rate_are_enough(tmp_path: Path) -> None:
    path = save(tmp_path / "mine.npz", posture=ymca().posture, rate=20)
    motion = read_motion(path)
    np.testing.assert_array_equal(motion.posture, ymca().posture)
    np.testing.assert_array_equal(motion.context, np.ones((len(motion), 1)))
    assert motion.labels == ("1",)
    assert (motion.name, motion.rate, motion.tempo) == ("mine", 20.0, 1.0)


def test_context_without_labels_is_numbered(tmp_path: Path) -> None:
    path = save(tmp_path / "a.npz", posture=ymca().posture, rate=20.0, context=ymca().context)
    assert read_motion(path).labels == ("1", "2", "3", "4")


def test_a_motion_of_another_format_is_refused(tmp_path: Path) -> None:
    path = save(tmp_path / "a.npz", posture=ymca().posture, rate=20.0, format=99)
    with pytest.raises(
        MotionFileError, match=r"a\.npz: written by another version of this program"
    ):
        read_motion(path)


def test_points_are_no_movement(tmp_path: Path) -> None:
    assert load_motion(save(tmp_path / "a.npz", left_wrist=np.ones((5, 3)), rate=60)) is None
    text = tmp_path / "a.tsv"
    text.write_text("NO_OF_FRAMES\t1\n")
    assert load_motion(text) is None


POSTURE = ymca().posture


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        ({"posture": POSTURE}, "lacks rate"),
        ({"posture": POSTURE, "rate": 0.0}, "rate is 0"),
        ({"posture": POSTURE, "rate": np.nan}, "rate is nan"),
        ({"posture": POSTURE, "rate": "fast"}, "expected posture (T, 12), context"),
        ({"posture": POSTURE, "rate": [20.0, 20.0]}, "expected posture (T, 12), context"),
        ({"posture": POSTURE, "rate": 20.0, "tempo": 0.0}, "tempo is 0; expected a number above"),
        ({"posture": POSTURE, "rate": 20.0, "tempo": np.inf}, "tempo is inf; expected a number"),
        ({"posture": POSTURE[:, :11], "rate": 20.0}, "posture has shape (76, 11)"),
        ({"posture": POSTURE.reshape(-1, 4, 3), "rate": 20.0}, "posture has shape (76, 4, 3)"),
        ({"posture": 1.0, "rate": 20.0}, "expected posture (T, 12), context"),
        ({"posture": POSTURE[:1], "rate": 20.0}, "has 1 posture"),
        ({"posture": POSTURE[:0], "rate": 20.0}, "has 0 posture"),
        ({"posture": 2 * POSTURE, "rate": 20.0}, "vectors whose length is not 1"),
        ({"posture": np.nan * POSTURE, "rate": 20.0}, "not finite"),
        ({"posture": np.full((76, 12), "x"), "rate": 20.0}, "expected posture (T, 12), context"),
        ({"posture": POSTURE, "rate": 20.0, "context": np.ones(76)}, "expected posture (T, 12)"),
        ({"posture": POSTURE, "rate": 20.0, "context": np.ones((9, 1))}, "context has shape (9"),
        ({"posture": POSTURE, "rate": 20.0, "context": np.ones((76, 0))}, "has no label"),
        ({"posture": POSTURE, "rate": 20.0, "labels": ["a", "b"]}, "context has shape (76, 1)"),
        ({"posture": POSTURE, "rate": 20.0, "labels": 3}, "expected posture (T, 12), context"),
    ],
)
def test_bad_files_are_one_line_that_names_them(
    tmp_path: Path, arrays: dict[str, object], message: str
) -> None:
    with pytest.raises(MotionFileError) as caught:
        read_motion(save(tmp_path / "mine.npz", **arrays))
    assert message in str(caught.value)
    assert "mine" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_damaged_file_is_one_line(tmp_path: Path) -> None:
    path = tmp_path / "mine.npz"
    save_motion(path, ymca())
    whole = path.read_bytes()
    for damaged in (whole[:100], whole[: len(whole) // 2], whole[:500] + b"xx" + whole[502:]):
        path.write_bytes(damaged)
        with pytest.raises(MotionFileError, match=r"mine\.npz: is a damaged archive[^\n]*$"):
            read_motion(path)


def test_a_file_that_would_run_code_is_not_opened(tmp_path: Path) -> None:
    path = save(tmp_path / "mine.npz", posture=np.array([object()]), rate=20.0)
    with pytest.raises(MotionFileError, match="not one of NumPy arrays"):
        read_motion(path)


def test_options_that_only_a_recording_has_a_use_for_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "mine.npz"
    save_motion(path, ymca())
    for options, name in (
        ({"map": "left_wrist=LWRI"}, "map"),
        ({"unit": "mm"}, "unit"),
        ({"up": "z"}, "up"),
        ({"rate_in": 60.0}, "rate_in"),
        ({"max_gap": 1.0}, "max_gap"),
        ({"longest": True}, "longest"),
        ({"repair": True}, "repair"),
        ({"cutoff": 5.0}, "cutoff"),
        ({"skeleton": "a.asf"}, "skeleton"),
    ):
        for source in ("ymca", path):
            with pytest.raises(
                BadOptionError, match=f"^ymca is a complete .*; leave out {name}, which"
            ):
                read_motion(source, **options)


@pytest.mark.parametrize("tempo", [0.5, 1.0])
def test_a_stored_movement_is_cut_in_its_own_seconds(tmp_path: Path, tempo: float) -> None:
    path = tmp_path / "mine.npz"
    save_motion(path, ymca())
    whole = import_motion(path, ReadingOptions(tempo=tempo))
    cut = import_motion(path, ReadingOptions(tempo=tempo, start=1.0, end=2.0))
    inside = (whole.report.times >= 1.0) & (whole.report.times < 2.0)
    np.testing.assert_array_equal(cut.motion.posture, whole.motion.posture[inside])
    heard = whole.motion.context[inside].any(axis=0)
    np.testing.assert_array_equal(cut.motion.context, whole.motion.context[inside][:, heard])
    assert cut.motion.labels == tuple(np.array(whole.motion.labels)[heard])
    np.testing.assert_array_equal(cut.report.times, whole.report.times[inside])
    with pytest.raises(
        BadOptionError, match=r"^start is 9\.0; expected less, as .* lasts 3\.[78]\d* s$"
    ):
        read_motion(path, start=9.0, tempo=tempo)
