"""Scenes: which moments are shown, and what is between two steps."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mpma_mj.envs.soundtrack import Soundtrack
from mpma_mj.motions import ymca
from mpma_mj.training.run_folder import RunFolder
from mpma_mj.visualization.episode import EpisodeArms
from mpma_mj.visualization.scene import Scene, ideal_scene

MOTION = ymca()
IDEAL = ideal_scene(MOTION)


def test_without_a_rate_each_step_has_a_picture() -> None:
    np.testing.assert_array_equal(IDEAL.moments, np.arange(len(MOTION) - 1))


@given(st.floats(0.1, 1000.0))
def test_pictures_are_as_far_apart_as_their_rate_says_until_the_end(fps: float) -> None:
    moments = replace(IDEAL, fps=fps).moments
    steps = len(IDEAL.trace)
    np.testing.assert_allclose(moments, np.arange(len(moments)) * MOTION.rate / fps, rtol=1e-12)
    assert moments[-1] < steps
    assert len(moments) == pytest.approx(max(1.0, steps * fps / MOTION.rate), abs=1.0)


@pytest.mark.parametrize("fps", [30.0, 40.0, 60.0])
def test_moments_of_steps_are_whole(fps: float) -> None:
    moments = replace(IDEAL, fps=fps).moments
    whole = moments[np.isclose(moments, np.round(moments))]
    np.testing.assert_array_equal(whole, np.round(whole))
    assert len(whole) == math.ceil(len(moments) * math.gcd(int(fps), 20) / fps)


@given(st.integers(0, len(IDEAL.trace) - 1), st.floats(0.0, 1.0))
def test_between_two_steps_the_arms_are_between_their_angles(step: int, share: float) -> None:
    arms = EpisodeArms(IDEAL.trace)
    ghost = arms.pose(step + share)
    before, after = IDEAL.trace.joint_angles[step : step + 2]
    expected = before + share * (after - before)
    np.testing.assert_allclose(arms.physics.joint_angles(), expected, atol=1e-9)
    lengths = np.linalg.norm(ghost.reshape(4, 3), axis=1)
    np.testing.assert_allclose(lengths, 1.0, atol=1e-6)


def test_at_a_step_the_arms_and_the_ghost_are_exactly_there() -> None:
    arms = EpisodeArms(IDEAL.trace)
    np.testing.assert_array_equal(arms.pose(7.0), MOTION.posture[7])
    np.testing.assert_array_equal(arms.physics.joint_angles(), MOTION.joint_angles[7])


def test_a_part_has_its_steps_its_times_and_its_sound(small_run: Path) -> None:
    folder = RunFolder(small_run)
    trace, motion = folder.read_trace(), folder.read_motion()
    sound = Soundtrack.of(Path("a.wav"), motion, len(trace), 3)
    part = Scene(trace, motion, sound=sound).cut(1.0, 2.5)
    assert len(part.trace) == 30
    np.testing.assert_array_equal(part.trace.posture, trace.posture[20:51])
    np.testing.assert_array_equal(
        part.trace.with_modules().responsibility, trace.with_modules().responsibility[20:50]
    )
    np.testing.assert_allclose(part.displayed_times[[0, -1]], [1.0, 2.5])
    assert part.sound is not None
    assert (part.sound.begin, part.sound.duration) == (1.0, 1.5)
    assert len(Scene(trace, motion).cut(0.0, math.inf).trace) == len(trace)


def test_shares_without_modules_are_those_of_labels() -> None:
    shares, names = IDEAL.shares
    assert names == MOTION.labels
    np.testing.assert_array_equal(shares, MOTION.context[:-1])
    assert [IDEAL.labels[0], IDEAL.labels[-1]] == ["Y", "A"]
