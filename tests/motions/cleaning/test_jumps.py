from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from mpma_mj.motions import ymca
from mpma_mj.motions.cleaning.jumps import off_at_end, single_frame_jumps
from mpma_mj.motions.loader import import_motion
from mpma_mj.motions.options import ReadingOptions
from tests.conftest import WriteTsv, dancer, doubts, markers_of

Array = NDArray[np.float64]

ARM = 550.0  # mm


def swing(speed: float, frequency: float, rate: float, frames: int = 600) -> Array:
    """Return a hand, mm, at the end of a stretched arm that swings up to a speed, rad/s."""
    phase = 2 * np.pi * frequency * np.arange(frames) / rate
    angle = speed / (2 * np.pi * frequency) * np.sin(phase)
    return ARM * np.stack([np.sin(angle), 0 * angle, -np.cos(angle)], axis=1)


def jumping() -> tuple[dict[str, Array], dict[str, Array]]:
    """Return markers, and the same with three jumps."""
    truth = markers_of(dancer(ymca(rate=60.0, tempo=0.5).posture))
    jumped = {name: track.copy() for name, track in truth.items()}
    jumped["Elbow_L"][100] += [0.0, 300.0, 0.0]
    jumped["Radius_R"][[50, 200]] += [0.0, 0.0, -250.0]
    return truth, jumped


@settings(max_examples=50)
@given(
    frames=st.sets(st.integers(1, 297).map(lambda i: i - i % 3 + 1), max_size=4),
    way=st.floats(120.0, 2000.0),
    seed=st.integers(0, 999),
)
def test_jumps_in_a_moving_arm_are_found_in_any_direction(
    frames: set[int], way: float, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    track = swing(5.0, 0.7, 60.0, 300) + rng.normal(0.0, 0.5, (300, 3))
    for frame in frames:
        direction = rng.normal(size=3)
        track[frame] += way * direction / np.linalg.norm(direction)
    np.testing.assert_array_equal(single_frame_jumps(track, ARM), sorted(frames))


@given(speed=st.floats(0.1, 15.0), frequency=st.floats(0.3, 3.0))
@pytest.mark.parametrize("rate", [60.0, 120.0])
def test_fast_arms_do_not_jump(rate: float, speed: float, frequency: float) -> None:
    assert not len(single_frame_jumps(swing(speed, frequency, rate), ARM))


def test_a_marker_that_shakes_all_the_time_does_not_jump() -> None:
    track = np.random.default_rng(0).normal(0.0, 50.0, (2000, 3))
    assert not len(single_frame_jumps(track, ARM))


def test_a_step_that_stays_is_no_jump() -> None:
    track = np.zeros((50, 3))
    track[20:, 0] = 300.0
    assert not len(single_frame_jumps(track, ARM))


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("frames", [0, 1, 2, 3, 4])
def test_hardly_any_frames_have_no_jumps(frames: int) -> None:
    assert not len(single_frame_jumps(np.full((frames, 3), np.nan), ARM))
    assert not len(single_frame_jumps(np.zeros((frames, 3)), ARM))


def test_jumps_are_told_with_marker_and_frame(write_tsv: WriteTsv) -> None:
    imported = import_motion(write_tsv(jumping()[1]), ReadingOptions())
    assert doubts(imported.report) == [
        "3 single-frame jumps (Elbow_L in frame 101; Radius_R in frame 51, 201); repair bridges"
        " them"
    ]


def test_frames_of_jumps_count_from_the_files_first(write_tsv: WriteTsv) -> None:
    imported = import_motion(write_tsv(jumping()[1]), ReadingOptions(start=1.0, end=3.0))
    assert doubts(imported.report) == [
        "1 single-frame jump (Elbow_L in frame 101); repair bridges them"
    ]


def test_jumps_are_repaired_only_if_that_is_asked_for(write_tsv: WriteTsv, tmp_path: Path) -> None:
    truth, jumped = jumping()
    whole = import_motion(write_tsv(truth, name="whole.tsv"), ReadingOptions(cutoff=6.0))
    path = write_tsv(jumped)
    left = import_motion(path, ReadingOptions(cutoff=6.0))
    repaired = import_motion(path, ReadingOptions(cutoff=6.0, repair=True))
    error = np.abs(left.motion.posture - whole.motion.posture).max()
    assert error > 0.1
    assert np.abs(repaired.motion.posture - whole.motion.posture).max() < 0.02 * error
    assert not doubts(repaired.report)
    assert any("3 single-frame jumps bridged" in step for step in repaired.report.steps)
    assert repaired.report.gaps["Elbow_L"] == [(pytest.approx(100 / 60), pytest.approx(101 / 60))]


def test_a_whole_recording_has_no_jumps(write_tsv: WriteTsv) -> None:
    assert not doubts(import_motion(write_tsv(), ReadingOptions()).report)


@given(frame=st.integers(3, 296), way=st.floats(30.0, 54.0), seed=st.integers(0, 999))
def test_a_wrong_digit_in_a_smooth_path_is_found(frame: int, way: float, seed: int) -> None:
    track = swing(3.0, 0.7, 100.0, 300)
    track += np.random.default_rng(seed).normal(0.0, 0.3, track.shape)
    track[frame, 1] += way
    np.testing.assert_array_equal(single_frame_jumps(track, ARM), [frame])


@pytest.mark.parametrize("frame", [0, 1, 2, -3, -2, -1])
def test_an_end_that_is_off_is_told(write_tsv: WriteTsv, frame: int) -> None:
    points = dancer(ymca(rate=60.0, tempo=0.5).posture)
    markers = markers_of(points)
    markers["Elbow_L"][frame, 1] += 20.0
    (warning,) = doubts(import_motion(write_tsv(markers), ReadingOptions()).report)
    number = 1 + frame % len(points["left_elbow"])
    assert warning.startswith(f"in frame {number}, at the end of the recording, the left elbow")


@given(speed=st.floats(0.1, 15.0), frequency=st.floats(0.3, 3.0), seed=st.integers(0, 999))
def test_the_end_of_a_movement_is_not_off(speed: float, frequency: float, seed: int) -> None:
    track = swing(speed, frequency, 100.0)[seed % 100 :]
    noise = np.random.default_rng(seed).normal(0.0, 0.3, track.shape)
    assert off_at_end(track + noise, ARM) is None
    assert off_at_end(track[:8] + noise[:8], ARM) is None


@given(frame=st.integers(0, 2), way=st.floats(9.0, 40.0), seed=st.integers(0, 999))
def test_a_wrong_digit_at_the_end_is_found(frame: int, way: float, seed: int) -> None:
    track = swing(1.0, 0.7, 100.0, 300)
    track += np.random.default_rng(seed).normal(0.0, 0.3, track.shape)
    track[frame, 1] += way
    assert off_at_end(track, ARM) == frame


@pytest.mark.parametrize("frame", [0, 1, 2])
def test_a_small_error_at_the_end_of_an_exact_path_is_found(frame: int) -> None:
    track = np.sin(np.arange(60.0) / 6.0)[:, None]
    assert off_at_end(track, 1.0) is None
    track[frame] += 0.03
    assert off_at_end(track, 1.0) == frame
