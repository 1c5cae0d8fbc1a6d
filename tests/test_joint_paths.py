import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from mpma_mj.joint_paths import (
    continuation,
    continuous_angles,
    held_angles,
    nearest_turn,
    unwound,
)
from mpma_mj.kinematics import posture_from_angles, wrap

angles_anywhere = arrays(np.float64, 8, elements=st.floats(-7.0, 7.0))


def test_arms_that_circle_overhead_do_not_jump() -> None:
    turn = np.linspace(0.0, 4 * np.pi, 400)
    circling = np.zeros((400, 8))
    circling[:, 0] = circling[:, 4] = turn
    circling[:, 1], circling[:, 3::4] = 0.3, 0.5
    circling[:, 5] = 0.3
    found = continuous_angles(posture_from_angles(circling), start=circling[0])
    np.testing.assert_allclose(found, circling, atol=1e-9)


def test_arms_that_swing_through_straight_forward_do_not_jump() -> None:
    swinging = np.tile([0.3, 0.0, 0.2, 0.8], (200, 2))
    swinging[:, 1] = swinging[:, 5] = np.linspace(0.0, np.pi, 200)
    found = continuous_angles(posture_from_angles(swinging), start=swinging[0])
    np.testing.assert_allclose(found, swinging, atol=1e-9)


@given(angles_anywhere, angles_anywhere)
def test_the_nearest_turn_leads_to_the_same_posture_and_is_no_longer(
    angles: np.ndarray, near: np.ndarray
) -> None:
    step = nearest_turn(angles, near)
    posture = posture_from_angles(near + step)
    np.testing.assert_allclose(posture, posture_from_angles(angles), atol=1e-12)
    assert np.linalg.norm(step) <= np.linalg.norm(wrap(angles - near)) + 1e-12
    assert (step >= -np.pi).all()
    assert (step < np.pi + 1e-9).all()


def test_the_other_branch_is_taken_where_it_is_shorter() -> None:
    near = np.array([0.1, 1.5, 0.2, 0.5] * 2)
    other = near + [np.pi, np.pi - 2 * 1.5, np.pi, 0.0] * 2
    np.testing.assert_allclose(nearest_turn(other + 2 * np.pi, near)[[0, 1, 2]], 0.0, atol=1e-12)


@given(angles_anywhere, angles_anywhere)
def test_a_continuation_is_the_nearest_turn(angles: np.ndarray, near: np.ndarray) -> None:
    sign, offset = continuation(angles, near)
    np.testing.assert_allclose(sign * angles + offset, near + nearest_turn(angles, near), atol=1e-9)


def test_angles_that_are_not_seen_are_held() -> None:
    rng = np.random.default_rng(0)
    angles = np.tile([0.3, 0.2, 0.4, 1.0] * 2, (60, 1))
    angles[10:50, 3] = 0.0
    angles[20:40, 5] = np.pi / 2
    posture = posture_from_angles(angles).reshape(-1, 4, 3) + rng.normal(0.0, 1e-3, (60, 4, 3))
    posture = (posture / np.linalg.norm(posture, axis=2, keepdims=True)).reshape(60, 12)
    found = held_angles(posture)
    assert np.ptp(continuous_angles(posture)[:, 2]) > 3.0
    assert np.ptp(continuous_angles(posture)[:, 4]) > 1.0
    assert np.ptp(found[:, [2, 4, 6]], axis=0).max() < 0.1
    cosines = np.sum((posture_from_angles(found) * posture).reshape(-1, 4, 3), axis=2)
    assert np.degrees(np.arccos(cosines.clip(-1.0, 1.0))).max() < 1.0


def test_angles_that_are_seen_are_the_continuous_ones() -> None:
    times = np.linspace(0.0, 6.0, 100)[:, None]
    posture = posture_from_angles(
        np.tile([0.5, 0.2, 0.4, 1.0], 2) + 0.4 * np.sin(times + np.arange(8))
    )
    np.testing.assert_array_equal(held_angles(posture), continuous_angles(posture))


@pytest.mark.parametrize("seed", range(5))
def test_noise_of_arms_that_begin_straight_forward_does_not_turn_them_over(seed: int) -> None:
    angles = np.tile([0.1, 0.5 * np.pi, 0.1, 0.5] * 2, (100, 1))
    angles[40:, 1::4] = np.linspace(0.5 * np.pi, 0.0, 60)[:, None]
    noise = np.random.default_rng(seed).normal(0.0, 0.01, (100, 12))
    found = held_angles(posture_from_angles(angles) + noise)
    np.testing.assert_allclose(found[-1], angles[-1], atol=0.1)


def test_a_rotation_that_is_never_seen_is_0() -> None:
    posture = np.tile([0.0, 0.6, -0.8], (5, 4))
    np.testing.assert_array_equal(held_angles(posture)[:, [2, 6]], 0.0)


def test_whole_turns_are_left_out_of_a_path_and_no_jump_is_made() -> None:
    path = np.linspace([-1.0, -30.0, 0.0, 3.0], [1.0, -28.0, 14.0, 4.0], 50)
    found = unwound(path)
    np.testing.assert_allclose(found, path + 2 * np.pi * np.array([0, 5, -1, -1]), atol=1e-9)
