from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from mpma_mj import kinematics
from mpma_mj.motions import ymca
from mpma_mj.motions.cleaning.calibration_pose import calibration_frames
from mpma_mj.motions.loader import import_motion
from mpma_mj.motions.options import ReadingOptions
from tests.conftest import WriteTsv, dancer, doubts, markers_of

Array = NDArray[np.float64]

T_POSE = np.tile([[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]], 2).reshape(2, 2, 3).ravel()
HANGING = kinematics.posture_from_angles(np.tile([0.1, 0.1, 0.0, 0.3], 2))


def dance(frames: int = 240, rate: float = 60.0) -> Array:
    phase = 2 * np.pi * 0.8 * np.arange(frames)[:, None] / rate
    return kinematics.posture_from_angles(
        np.tile([0.4, 0.2, 0.0, 0.8], 2) + 0.4 * np.sin(phase + np.arange(8))
    )


def after_t_pose(count: int, ramp: int = 0) -> Array:
    """Return T-pose frames, a jump half-way and some frames of a fast ramp, and a dance."""
    end = dance()
    share = np.linspace(0.5, 1.0, ramp, endpoint=False)[:, None]
    way = ((1 - share) * T_POSE + share * end[0]).reshape(-1, 4, 3)
    way /= np.linalg.norm(way, axis=2, keepdims=True)
    return np.concatenate([np.tile(T_POSE, (count, 1)), way.reshape(-1, 12), end])


@settings(max_examples=20)
@given(count=st.integers(1, 140), rate=st.sampled_from([50.0, 60.0, 120.0, 240.0]))
def test_a_still_pose_and_a_jump_out_of_it_are_start_up(count: int, rate: float) -> None:
    assert calibration_frames(dancer(after_t_pose(count)), rate) == count


@pytest.mark.parametrize("noise", [0.1, 1.0, 3.0])  # mm
def test_a_pose_is_still_though_its_markers_are_noisy(noise: float) -> None:
    rng = np.random.default_rng(0)
    for count, rate in ((1, 60.0), (100, 60.0), (100, 240.0)):
        points = dancer(after_t_pose(count))
        noisy = {name: p + rng.normal(0.0, noise, p.shape) for name, p in points.items()}
        assert calibration_frames(noisy, rate) == count


@pytest.mark.parametrize("count", [1, 5, 100])
@pytest.mark.parametrize("ramp", [1, 2])
def test_a_fast_ramp_after_the_jump_is_start_up_too(count: int, ramp: int) -> None:
    assert calibration_frames(dancer(after_t_pose(count, ramp)), 240.0) == count + ramp


@pytest.mark.parametrize("count", [1, 40])
@pytest.mark.parametrize("ramp", [2, 5, 20])
def test_a_ramp_that_runs_out_unsteadily_is_start_up_whole(count: int, ramp: int) -> None:
    posture = after_t_pose(count)
    # Not faster than human arms: up to 6° a frame, at 120 Hz.
    away = 0.1 * np.tile([1.0, 0.2, 0.8, 0.3, 0.6], 4)[:ramp] * np.linspace(1.0, 0.5, ramp)
    start = np.tile([0.4, 0.2, 0.0, 0.8], 2) + 0.4 * np.sin(np.arange(8))  # of the dance
    angles = start + np.cumsum(away[::-1])[::-1, None] * np.eye(8)[3]
    ramped = [posture[:count], kinematics.posture_from_angles(angles), dance(400, rate=120.0)]
    assert calibration_frames(dancer(np.concatenate(ramped)), 120.0) == count + ramp


@settings(max_examples=30)
@given(
    still=st.integers(0, 120),
    speed=st.floats(0.5, 15.0),
    rate=st.sampled_from([30.0, 60.0, 120.0]),
)
def test_a_dancer_who_starts_from_rest_is_left_whole(still: int, speed: float, rate: float) -> None:
    swing = np.tile([0.2, 0.1, 0.0, 0.5], (300, 2))
    swing[still:, 0] += speed / 12.0 * (1 - np.cos(12.0 * np.arange(300 - still) / rate))
    assert calibration_frames(dancer(kinematics.posture_from_angles(swing)), rate) == 0


def test_arms_that_are_never_moved_are_left_whole() -> None:
    assert calibration_frames(dancer(np.tile(T_POSE, (300, 1))), 60.0) == 0
    assert calibration_frames(dancer(T_POSE[None]), 60.0) == 0


def test_a_t_pose_that_is_left_as_people_do_is_left_whole() -> None:
    share = 0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, 40))[:, None]
    way = ((1 - share) * T_POSE + share * HANGING).reshape(-1, 4, 3)
    way = (way / np.linalg.norm(way, axis=2, keepdims=True)).reshape(-1, 12)
    posture = np.concatenate([np.tile(T_POSE, (100, 1)), way, np.tile(HANGING, (100, 1))])
    assert calibration_frames(dancer(posture), 60.0) == 0


def test_a_jump_within_the_dance_is_no_start_up() -> None:
    posture = np.concatenate([dance(100), dance(100) * np.tile([1.0, -1.0, 1.0], 4)])
    assert calibration_frames(dancer(posture), 60.0) == 0


def test_what_is_cut_is_told_and_time_still_counts_from_the_files_first_frame(
    write_tsv: WriteTsv, tmp_path: Path
) -> None:
    plain = import_motion(
        write_tsv(markers_of(dancer(dance())), name="plain.tsv"), ReadingOptions(cutoff=6.0)
    )
    labels = tmp_path / "labels.csv"
    labels.write_text("0,3,before\n3,9,after\n")
    path = write_tsv(markers_of(dancer(after_t_pose(90))))
    cut = import_motion(path, ReadingOptions(cutoff=6.0, labels=str(labels)))
    np.testing.assert_allclose(cut.motion.posture, plain.motion.posture, atol=1e-9)
    assert doubts(cut.report) == ["the first 90 frames are cut: a calibration pose"]
    np.testing.assert_allclose(cut.report.times, 1.5 + np.arange(len(cut.motion)) / 20.0)
    assert cut.motion.context[:, 0].sum() == 30


def test_frames_that_are_cut_count_as_in_the_file(write_tsv: WriteTsv) -> None:
    path = write_tsv(markers_of(dancer(after_t_pose(90))))
    imported = import_motion(path, ReadingOptions(start=1.0))
    assert doubts(imported.report) == ["frames 61 to 90 are cut: a calibration pose"]


@pytest.mark.parametrize("tempo", [0.2, 1.0])
def test_the_built_in_dance_is_left_whole(tempo: float) -> None:
    assert calibration_frames(dancer(ymca(rate=60.0, tempo=tempo).posture), 60.0) == 0


@pytest.mark.parametrize("sway", [0.05, 0.2])
def test_a_t_pose_in_a_body_that_sways_is_cut_too(sway: float) -> None:
    posture = after_t_pose(40).reshape(-1, 4, 3).copy()
    turn = sway * np.sin(np.arange(40) / 7)[:, None]
    posture[:40, :, 0] += turn
    posture /= np.linalg.norm(posture, axis=2, keepdims=True)
    assert calibration_frames(dancer(posture.reshape(-1, 12)), 60.0) == 40


def test_a_marker_that_jumps_and_comes_back_is_no_start_up() -> None:
    points = dancer(dance())
    points["left_wrist"][10, 0] += 400.0
    assert calibration_frames(points, 60.0) == 0


def test_noise_at_a_high_rate_is_no_start_up() -> None:
    rng = np.random.default_rng(0)
    still = np.tile(dance()[:1], (4000, 1))
    points = dancer(np.concatenate([still, dance(1000, rate=1000.0)]))
    noisy = {name: track + rng.normal(0.0, 1.0, track.shape) for name, track in points.items()}
    assert calibration_frames(noisy, 1000.0) == 0


def test_a_fast_jab_out_of_stillness_is_no_start_up() -> None:
    share = np.concatenate([np.zeros(100), 0.5 - 0.5 * np.cos(np.linspace(0, np.pi, 12)), [1] * 60])
    angles = np.tile([0.3, 0.2, 0.0, 2.4], 2) + share[:, None] * np.tile([0, 1.0, 0, -2.2], 2)
    assert calibration_frames(dancer(kinematics.posture_from_angles(angles)), 100.0) == 0
