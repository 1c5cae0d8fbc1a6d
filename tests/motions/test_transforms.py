import dataclasses
from itertools import groupby
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from mpma_mj import joint_paths, kinematics
from mpma_mj.context import equal_segments
from mpma_mj.errors import BadOptionError
from mpma_mj.motions import Motion, ymca
from mpma_mj.motions.feasibility import beyond_limits
from mpma_mj.motions.feasible_motion import fitted
from mpma_mj.motions.loader import import_motion
from mpma_mj.motions.options import ReadingOptions
from mpma_mj.motions.synthetic import synthetic_motion
from mpma_mj.motions.transforms import (
    PEAK_SPEED,
    at_rate,
    close_loop,
    join,
    minimum_jerk,
    mirrored,
    move_between,
    repeat,
    with_context_of,
)
from tests.conftest import WriteTsv, dancer, markers_of
from tests.motions.known_motions import LIMITS, SPEED, check_equal, raising
from tests.robots.humanoid import (
    check_limits,
    cut,
    humanoid_limits,
    short_dance,
    without_two_arm,
)


def test_mirrored_twice_is_the_same() -> None:
    dance = ymca()
    once = mirrored(dance)
    np.testing.assert_array_equal(mirrored(once).posture, dance.posture)
    assert np.abs(once.posture - dance.posture).max() > 0.5
    np.testing.assert_array_equal(once.context, dance.context)


def test_a_mirrored_dance_has_the_joint_angles_of_the_other_arm() -> None:
    dance = ymca()
    left, right = np.split(kinematics.angles_from_posture(dance.posture), 2, axis=1)
    mirror = kinematics.angles_from_posture(mirrored(dance).posture)
    np.testing.assert_allclose(kinematics.wrap(mirror - np.hstack([right, left])), 0.0, atol=1e-9)


def test_anothers_music_is_heard_for_the_same_shares_of_the_time() -> None:
    dance, music = synthetic_motion(number=3), ymca()
    danced = with_context_of(dance, music)
    np.testing.assert_array_equal(danced.posture, dance.posture)
    assert danced.labels == music.labels
    np.testing.assert_allclose(danced.context.mean(axis=0), music.context.mean(axis=0), atol=0.02)
    assert np.all(np.diff(danced.context.argmax(axis=1)) >= 0)
    same = with_context_of(music, music)
    np.testing.assert_array_equal(same.context, music.context)


def test_minimum_jerk_is_at_rest_at_both_ends_and_fastest_half_way() -> None:
    phase = np.linspace(-0.2, 1.2, 14001)
    way = minimum_jerk(phase)
    speed, acceleration = np.gradient(way, phase), np.gradient(np.gradient(way, phase), phase)
    assert way[0] == 0.0
    assert way[-1] == 1.0
    assert speed.max() == pytest.approx(PEAK_SPEED, rel=1e-6)
    assert phase[speed.argmax()] == pytest.approx(0.5, abs=1e-3)
    ends = np.isclose(phase, 0.0, atol=1e-9) | np.isclose(phase, 1.0, atol=1e-9)
    np.testing.assert_allclose(speed[ends], 0.0, atol=1e-6)
    np.testing.assert_allclose(acceleration[ends], 0.0, atol=0.02)


Array = NDArray[np.float64]


@given(
    rate=st.floats(5.0, 120.0),
    own_rate=st.sampled_from([20.0, 60.0, 200.0]),
    tempo=st.floats(0.1, 3.0),
)
def test_at_another_rate_vectors_have_length_1_and_time_is_kept(
    rate: float, own_rate: float, tempo: float
) -> None:
    motion = ymca(rate=own_rate)
    found = at_rate(motion, rate, tempo)
    assert found.rate == rate
    assert found.tempo == tempo
    lengths = np.linalg.norm(found.posture.reshape(-1, 4, 3), axis=2)
    np.testing.assert_allclose(lengths, 1.0, atol=1e-12)
    last = (len(motion) - 1) / own_rate / tempo
    assert 0.0 <= last + 1e-6 - (len(found) - 1) / rate < 1.0 / rate + 2e-6
    # Every label is danced for as long, but for a posture at either end.
    was, now = motion.context.sum(axis=0) / own_rate / tempo, found.context.sum(axis=0) / rate
    np.testing.assert_allclose(now, was, atol=1.01 * (1 / rate + 1 / own_rate / tempo))
    np.testing.assert_array_equal(found.context.sum(axis=1), 1.0)


def test_at_the_same_rate_and_tempo_it_is_the_same() -> None:
    assert at_rate(ymca(), 20.0, 1.0) is not None
    check_equal(at_rate(ymca(), 20.0, 1.0), ymca())


@pytest.mark.parametrize("own_rate", [40.0, 50.0, 120.0])
def test_a_tremor_that_the_new_rate_cannot_show_is_gone(own_rate: float) -> None:
    angles = np.tile([0.5, 0.2, 0.0, 0.8], (round(10 * own_rate), 2))
    angles[:, 3] += 0.1 * np.sin(2 * np.pi * 15.0 * np.arange(len(angles)) / own_rate)
    posture = kinematics.posture_from_angles(angles)
    motion = Motion(posture, np.ones((len(posture), 1)), ("1",), own_rate, "tremor", "a test")
    elbow = kinematics.angles_from_posture(at_rate(motion, 20.0, 1.0).posture)[:, 3]
    assert np.abs(elbow[5:-5] - 0.8).max() < 0.1 * 0.1


def test_a_slow_movement_is_the_same_at_every_rate() -> None:
    fine = ymca(rate=120.0, tempo=0.25)
    found = at_rate(fine, 20.0, 1.0)
    assert np.abs(found.posture - fine.posture[::6]).max() < 0.01


REST = np.tile([0.8, 0.2, 0.0, 1.0], 2)


def wander(frames: int, frequency: float, seed: int = 0) -> Array:
    """Return joint angles, rad at 20 Hz, that end elsewhere than they start."""
    phase = 2 * np.pi * frequency * np.arange(frames)[:, None] / 20.0
    return REST + 0.4 * np.sin(phase + np.random.default_rng(seed).uniform(0, 6, 8))


def segment_steps(posture: Array) -> Array:
    """Return how far each segment goes from one posture to the next, shape (T-1, 4)."""
    return np.linalg.norm(np.diff(posture, axis=0).reshape(-1, 4, 3), axis=2)


def as_motion(posture: Array) -> Motion:
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
    found = joint_paths.continuous_angles(closed, start=angles[0])
    step = np.abs(found[0] - found[-1])
    usual = np.abs(np.diff(angles, axis=0)).max(axis=0)
    # Of the way to the start a share of 10 / (n + 1)³ is left to the last step at most.
    left = 10.0 / (min(40, frames // 4) + 1) ** 3
    assert (step <= usual + left * 2.0).all()


@settings(max_examples=30)
@given(frames=lengths, frequency=frequencies, seed=seeds)
def test_a_loop_is_repeated_without_a_move_back(frames: int, frequency: float, seed: int) -> None:
    closed = close_loop(kinematics.posture_from_angles(wander(frames, frequency, seed)), 20.0)
    posture, context, _ = repeat(as_motion(closed), 3, SPEED)
    assert len(posture) == len(context) == 3 * frames
    np.testing.assert_array_equal(posture, np.tile(closed, (3, 1)))


@settings(max_examples=30)
@given(frames=lengths, frequency=frequencies, seed=seeds)
def test_no_elbow_is_bent_farther_or_back(frames: int, frequency: float, seed: int) -> None:
    posture = kinematics.posture_from_angles(wander(frames, frequency, seed))
    was, found = (joint_paths.continuous_angles(p) for p in (posture, close_loop(posture, 20.0)))
    assert (found[:, 3::4].min(axis=0) >= was[:, 3::4].min(axis=0) - 1e-9).all()
    assert (found[:, 3::4].max(axis=0) <= was[:, 3::4].max(axis=0) + 1e-9).all()
    # Had one been bent backwards, its arm would have been turned about by half a turn instead.
    assert np.abs(np.diff(found, axis=0)).max() < 1.0


def test_the_same_movement_is_brought_back_if_it_is_not_closed() -> None:
    posture = kinematics.posture_from_angles(wander(130, 0.5))
    assert len(repeat(as_motion(posture), 3, SPEED)[0]) > 390


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
    found = joint_paths.continuous_angles(close_loop(posture, 20.0), start=angles[0])
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
        with pytest.raises(
            BadOptionError, match=r"ymca has 1 posture\(s\) from 0 to 0\.04 s; give"
        ):
            import_motion("ymca", options)
    else:
        assert len(import_motion("ymca", options).motion) == 2


def test_a_movement_that_ends_where_it_starts_is_joined_as_it_is() -> None:
    motion = ymca()
    posture, context, _ = repeat(motion, 3, SPEED)
    np.testing.assert_array_equal(posture, np.tile(motion.posture, (3, 1)))
    np.testing.assert_array_equal(context, np.tile(motion.context, (3, 1)))


def test_arms_return_within_reach_where_a_movement_ends_elsewhere() -> None:
    motion = raising(4.0, frames=20)
    posture, context, _ = repeat(motion, 3, SPEED)
    assert len(posture) > 60
    assert len(posture) == len(context)
    speed = np.abs(np.diff(joint_paths.continuous_angles(posture), axis=0)) * 20.0
    assert (speed.max(axis=0) <= 0.55 * SPEED).all()
    assert speed[:, 0].max() > 0.4 * SPEED[0]
    np.testing.assert_array_equal(posture[-20:], motion.posture)
    np.testing.assert_array_equal(posture[:20], motion.posture)
    np.testing.assert_array_equal(context[20], motion.context[0])


def test_once_is_the_movement_itself() -> None:
    np.testing.assert_array_equal(repeat(raising(4.0), 1, SPEED)[0], raising(4.0).posture)


def wandering(seed: int, frames: int, name: str) -> Motion:
    rng = np.random.default_rng(seed)
    rest = np.tile([0.6, 0.2, 0.0, 1.0], 2) + rng.uniform(-0.3, 0.3, 8)
    phase = np.arange(frames)[:, None] / rng.uniform(5.0, 15.0, 8)
    posture = kinematics.posture_from_angles(rest + 0.3 * np.sin(phase + rng.uniform(0, 6, 8)))
    return Motion(posture, *equal_segments(frames, 2), 20.0, name, f"source of {name}")


def parts(motion: Motion) -> list[slice]:
    """Return the stretch of each label in turn."""
    found, first = [], 0
    for _, same in groupby(motion.context.argmax(axis=1)):
        length = len(list(same))
        found.append(slice(first, first + length))
        first += length
    return found


@settings(max_examples=30)
@given(lengths=st.lists(st.integers(2, 60), min_size=1, max_size=5), seed=st.integers(0, 99))
def test_every_movement_is_there_untouched_with_its_one_label(
    lengths: list[int], seed: int
) -> None:
    motions = [wandering(seed + i, length, f"dance{i}") for i, length in enumerate(lengths)]
    joined = join(motions, SPEED)
    np.testing.assert_array_equal(joined.context.sum(axis=1), 1.0)
    assert joined.labels == tuple(motion.name for motion in motions)
    assert (np.diff(joined.context.argmax(axis=1)) >= 0).all()
    found = parts(joined)
    assert len(found) == len(motions)
    for motion, part in zip(motions, found, strict=True):
        np.testing.assert_array_equal(joined.posture[part][-len(motion) :], motion.posture)
    assert found[0] == slice(0, lengths[0])  # nothing is before the first


@settings(max_examples=30)
@given(lengths=st.lists(st.integers(2, 40), min_size=2, max_size=4), seed=st.integers(0, 99))
def test_the_ways_between_are_within_the_joints_speed(lengths: list[int], seed: int) -> None:
    motions = [wandering(seed + i, length, f"dance{i}") for i, length in enumerate(lengths)]
    joined = join(motions, SPEED)
    speed = np.abs(np.diff(joint_paths.continuous_angles(joined.posture), axis=0)) * 20.0
    for motion, part in zip(motions[1:], parts(joined)[1:], strict=True):
        way = speed[part.start - 1 : part.stop - len(motion)]
        assert (way <= 0.55 * SPEED).all()
    assert not beyond_limits(joined, LIMITS)


def test_movements_that_lead_into_each_other_are_joined_as_they_are() -> None:
    joined = join([ymca(), dataclasses.replace(ymca(), name="again")], SPEED)
    np.testing.assert_array_equal(joined.posture, np.tile(ymca().posture, (2, 1)))
    assert joined.labels == ("ymca", "again")


@pytest.mark.parametrize(
    ("names", "labels"),
    [
        ("abc", ("a", "b", "c")),
        ("aba", ("a 1", "b", "a 2")),
        ("aaa", ("a 1", "a 2", "a 3")),
        (("a", "a", "a 1"), ("a 2", "a 3", "a 1")),
        (("a 1", "a", "a"), ("a 1", "a 2", "a 3")),
        (("a 1", "a 1", "a", "a"), ("a 1 1", "a 1 2", "a 2", "a 3")),
    ],
)
def test_names_that_stand_twice_are_numbered(names: str, labels: tuple[str, ...]) -> None:
    motions = [wandering(i, 5, name) for i, name in enumerate(names)]
    assert join(motions, SPEED).labels == labels


def test_the_sources_of_all_are_reported() -> None:
    joined = join([wandering(0, 5, "a"), wandering(1, 5, "b")], SPEED)
    assert joined.source == "source of a; source of b"
    assert joined.rate == 20.0


def test_a_robot_moves_to_the_joint_angles_with_which_it_goes_on() -> None:
    limits, dance = humanoid_limits(), short_dance()
    following = dataclasses.replace(dance, feasible_angles=0.8 * dance.joint_angles)
    way = move_between(dance, following, limits.max_speed, limits.kinematics)
    steps = np.diff([dance.joint_angles[-1], *way, following.joint_angles[0]], axis=0)
    assert len(way) > 5
    assert (np.abs(steps[[0, -1]]) <= 0.5 * np.abs(steps).max(axis=0)).all()


def test_a_robot_repeats_a_motion_that_leads_on_as_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    limits, there = humanoid_limits(), cut(ymca(), 10, 40)
    posture, context = (
        np.concatenate([rows, rows[-2:0:-1]]) for rows in (there.posture, there.context)
    )
    motion = fitted(dataclasses.replace(there, posture=posture, context=context), limits)[0]
    without_two_arm(monkeypatch)
    repeated = repeat(motion, 2, limits.max_speed, limits.kinematics)
    np.testing.assert_array_equal(repeated.posture, np.tile(motion.posture, (2, 1)))
    assert repeated.angles is not None
    np.testing.assert_array_equal(repeated.angles, np.tile(motion.joint_angles, (2, 1)))
    check_limits(repeated.angles, motion.rate)
