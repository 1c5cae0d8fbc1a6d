import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray

from mpma_mj.analysis.modules import (
    group_share,
    joint_share,
    recurrence,
    repetitions,
    segment_movement,
    segment_share,
)
from mpma_mj.kinematics import posture_from_angles

Array = NDArray[np.float64]

outputs = arrays(np.float64, (6, 3, 8), elements=st.floats(-1, 1))
permutations = st.permutations(range(3))


def test_joint_share_is_the_part_of_the_absolute_output() -> None:
    output = np.zeros((2, 2, 8))
    output[:, 0, 0] = [0.3, -0.3]
    output[:, 1, 0] = [0.0, 0.2]
    output[:, 1, 1] = 0.5
    share = joint_share(output)
    assert share[:, 0] == pytest.approx([0.75, 0.25])
    assert share[:, 1] == pytest.approx([0.0, 1.0])
    assert np.isnan(share[:, 2:]).all()


def test_one_module_has_all() -> None:
    assert joint_share(np.full((4, 1, 8), -0.1)) == pytest.approx(np.ones((1, 8)))
    assert group_share(np.ones((4, 1)), np.array([0, 0, 1, 1]), 2) == pytest.approx(1.0)
    assert segment_share(np.ones((4, 1)), np.full((4, 4), 0.2)) == pytest.approx(1.0)


@given(outputs, permutations)
def test_shares_sum_to_one_and_follow_the_order_of_modules(output: Array, order: list[int]) -> None:
    share = joint_share(output)
    some = np.abs(output).sum(axis=(0, 1)) > 0
    assert share.sum(axis=0)[some] == pytest.approx(1.0)
    assert np.isnan(share[:, ~some]).all()
    np.testing.assert_allclose(joint_share(output[:, order]), share[order], rtol=1e-12)


def test_group_share_is_the_mean_responsibility_in_a_group() -> None:
    responsibility = np.array([[1.0, 0.0], [0.5, 0.5], [0.2, 0.8], [0.0, 1.0]])
    share = group_share(responsibility, np.array([0, 0, 1, -1]), 3)
    assert share[:, 0] == pytest.approx([0.75, 0.25])
    assert share[:, 1] == pytest.approx([0.2, 0.8])
    assert np.isnan(share[:, 2]).all()


def test_a_module_that_is_responsible_while_one_arm_moves_has_that_arm() -> None:
    movement = np.zeros((4, 4))
    movement[:2, :2] = 0.1  # the left arm, then the right one
    movement[2:, 2:] = 0.2
    responsibility = np.array([[1.0, 0.0]] * 2 + [[0.0, 1.0]] * 2)
    assert segment_share(responsibility, movement) == pytest.approx(
        np.array([[1.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 1.0]])
    )


def test_segment_movement_is_the_angle_through_which_a_segment_turns() -> None:
    angles = np.zeros((4, 8))
    angles[:, 0] = [0.0, 0.1, 0.4, 0.4]  # left abduction takes both segments along
    angles[:, 7] = [0.0, 0.0, 0.0, 1.0]  # the right elbow turns its forearm alone
    movement = segment_movement(posture_from_angles(angles))
    expected = [[0.1, 0.1, 0.0, 0.0], [0.3, 0.3, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]]
    assert movement == pytest.approx(np.array(expected))


@given(arrays(np.float64, (6, 3), elements=st.floats(0.01, 1)), permutations)
def test_shares_of_groups_and_segments_follow_the_order_of_modules(
    responsibility: Array, order: list[int]
) -> None:
    group, movement = np.array([0, 0, 1, 1, 1, -1]), np.arange(24.0).reshape(6, 4)
    for share_of in (
        lambda r: group_share(r, group, 2),
        lambda r: segment_share(r, movement),
    ):
        share = share_of(responsibility)
        assert share.sum(axis=0) == pytest.approx(1.0)
        np.testing.assert_allclose(share_of(responsibility[:, order]), share[order], rtol=1e-12)


def test_the_last_repetition_may_be_cut_short() -> None:
    over = repetitions(np.stack([np.arange(11.0)] * 2, axis=1), 4)
    assert over.shape == (3, 4, 2)
    assert over[1, :, 0].tolist() == [4, 5, 6, 7]
    assert np.isnan(over[2, 3]).all()
    assert np.isfinite(over).sum() == 22


def test_modules_that_take_turns_come_back_after_one_round() -> None:
    responsibility = np.tile(np.repeat(np.eye(3), 2, axis=0), (4, 1))  # a round of 6 steps
    likeness = recurrence(responsibility, 13)
    assert likeness[[0, 6, 12]] == pytest.approx(1.0)
    assert likeness[[2, 3, 4, 8]] == pytest.approx(0.0)
    assert likeness[1] == pytest.approx(0.5, abs=0.03)


def test_constant_responsibility_is_always_like_itself() -> None:
    assert recurrence(np.full((20, 4), 0.25), 15) == pytest.approx(1.0)
    assert recurrence(np.ones((20, 1)), 20) == pytest.approx(1.0)


def test_the_order_of_modules_and_a_common_factor_do_not_matter() -> None:
    responsibility = np.random.default_rng(0).dirichlet(np.ones(4), size=30)
    expected = recurrence(responsibility, 10)
    assert recurrence(responsibility[:, [2, 0, 3, 1]], 10) == pytest.approx(expected)
    assert recurrence(7.0 * responsibility, 10) == pytest.approx(expected)
