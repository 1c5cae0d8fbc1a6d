from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from mpma_mj import kinematics
from mpma_mj.context import equal_segments
from mpma_mj.errors import BadOptionError
from mpma_mj.motions import Motion, ymca
from mpma_mj.motions.loader import import_motion
from mpma_mj.motions.options import ReadingOptions
from mpma_mj.motions.transforms import close_loop, repeat
from tests.conftest import WriteTsv, dancer, markers_of

Array = NDArray[np.float64]

SPEED = np.array([12.0, 12.0, 20.0, 15.0] * 2)  # rad/s
REST = np.tile([0.8, 0.2, 0.0, 1.0], 2)


def wander(frames: int, frequency: float, seed: int = 0) -> Array:
    """Return joint angles, rad at 20 Hz, that end elsewhere than they start."""
    phase = 2 * np.pi * frequency * np.arange(frames)[:, None] / 20.0
    return REST + 0.4 * np.sin(phase + np.random.default_rng(seed).uniform(0, 6, 8))


def segment_steps(posture: Array) -> Array:
    """Return how far each segment goes from one posture to the next, shape (T-1, 4)."""
    return np.linalg.norm(np.diff(posture, axis=0).reshape(-1, 4, 3), axis=2)


def motion(posture: Array) -> Motion:
    return Motion(posture, *equal_segments(len(posture), 2), 20.0, "loop", "a test")


frequencies = st.floats(0.1, 1.8)  # up to 4.5 rad/s
lengths = st.integers(20, 200)
seeds = st.integers(0, 999)


@settings(max_examples=30)
@given(frames=lengths, frequency=frequencies, seed=seeds)
def test_the_end_leads_into_the_start_as_fast_as_the_movement_is(
    frames: int, frequency: float, seed: int
) -> None:
    angles = wander(frames, frequency, seed)
    closed = close_loop(kinematics.posture_from_angles(angles), 20.0)
    found = kinematics.continuous_angles(closed, start=angles[0])
    step = np.abs(found[0] - found[-1])
    usual = np.abs(np.diff(angles, axis=0)).max(axis=0)
    # Of the way to the start a share of 10 / (n + 1)³ is left to the last step at most.
    left = 10.0 / (min(40, frames // 4) + 1) ** 3
    assert (step <= usual + left * 2.0).all()


@settings(max_examples=30)
@given(frames=lengths, frequency=frequencies, seed=seeds)
def test_a_loop_is_repeated_without_a_move_back(frames: int, frequency: float, seed: int) -> None:
    closed = close_loop(kinematics.posture_from_angles(wander(frames, frequency, seed)), 20.0)
    posture, context = repeat(motion(closed), 3, SPEED)
    assert len(posture) == len(context) == 3 * frames
    np.testing.assert_array_equal(posture, np.tile(closed, (3, 1)))


@settings(max_examples=30)
@given(frames=lengths, frequency=frequencies, seed=seeds)
def test_no_elbow_is_bent_farther_or_back(frames: int, frequency: float, seed: int) -> None:
    posture = kinematics.posture_from_angles(wander(frames, frequency, seed))
    was, found = (kinematics.continuous_angles(p) for p in (posture, close_loop(posture, 20.0)))
    assert (found[:, 3::4].min(axis=0) >= was[:, 3::4].min(axis=0) - 1e-9).all()
    assert (found[:, 3::4].max(axis=0) <= was[:, 3::4].max(axis=0) + 1e-9).all()
    # Had one been bent backwards, its arm would have been turned about by half a turn instead.
    assert np.abs(np.diff(found, axis=0)).max() < 1.0


def test_the_same_movement_is_brought_back_if_it_is_not_closed() -> None:
    posture = kinematics.posture_from_angles(wander(130, 0.5))
    assert len(repeat(motion(posture), 3, SPEED)[0]) > 390


@settings(max_examples=30)
@given(frames=st.integers(8, 400), frequency=frequencies, rate=st.sampled_from([10.0, 20.0, 60.0]))
def test_only_the_end_is_bent(frames: int, frequency: float, rate: float) -> None:
    posture = kinematics.posture_from_angles(wander(frames, frequency))
    closed = close_loop(posture, rate)
    untouched = frames - int(min(0.25 * frames, 2.0 * rate))
    assert closed.shape == posture.shape
    np.testing.assert_allclose(closed[:untouched], posture[:untouched], atol=1e-12)
    lengths = np.linalg.norm(closed.reshape(-1, 4, 3), axis=2)
    np.testing.assert_allclose(lengths, 1.0, atol=1e-12)


@settings(max_examples=30)
@given(turns=st.integers(1, 5), frames=st.integers(60, 200), seed=seeds)
def test_a_movement_that_is_closed_is_hardly_changed(turns: int, frames: int, seed: int) -> None:
    angles = wander(frames, 20.0 * turns / frames, seed)
    posture = kinematics.posture_from_angles(angles)
    found = kinematics.continuous_angles(close_loop(posture, 20.0), start=angles[0])
    # The end is guessed by going on straight: what the movement's own curve makes of one sample.
    curve = np.abs(np.diff(np.concatenate([angles, angles[:2]]), n=2, axis=0)).max()
    assert np.abs(found - angles).max() <= 1.01 * curve


def test_the_built_in_dance_is_closed_already() -> None:
    posture = ymca().posture
    np.testing.assert_allclose(close_loop(posture, 20.0), posture, atol=1e-9)


@pytest.mark.parametrize("frames", [2, 3, 5])
def test_hardly_any_postures_can_be_closed(frames: int) -> None:
    assert close_loop(kinematics.posture_from_angles(wander(frames, 0.5)), 20.0).shape == (
        frames,
        12,
    )


def test_a_recording_is_closed_if_that_is_asked_for(write_tsv: WriteTsv, tmp_path: Path) -> None:
    angles = REST + 0.4 * np.sin(2 * np.pi * 0.35 * np.arange(400)[:, None] / 60.0 + np.arange(8))
    path = write_tsv(markers_of(dancer(kinematics.posture_from_angles(angles))))
    plain = import_motion(path, ReadingOptions()).motion
    closed = import_motion(path, ReadingOptions(loop=True)).motion
    np.testing.assert_allclose(closed.posture[:100], plain.posture[:100], atol=1e-12)
    assert len(repeat(closed, 2, SPEED)[0]) == 2 * len(closed)
    assert len(repeat(plain, 2, SPEED)[0]) > 2 * len(plain)
    steps = segment_steps(np.concatenate([closed.posture, closed.posture[:1]]))
    assert (steps[-1] <= 1.2 * steps[:-1].max(axis=0)).all()


@pytest.mark.parametrize("frames", [1, 2])
def test_a_stored_movement_cut_short_is_closed_or_refused_in_words(frames: int) -> None:
    options = ReadingOptions(loop=True, end=0.05 * frames - 0.01)
    if frames == 1:
        with pytest.raises(BadOptionError, match="has 1 postures"):
            import_motion("ymca", options)
    else:
        assert len(import_motion("ymca", options).motion) == 2
