import numpy as np
import pytest

from mpma_mj.analysis.repetition import laid_over, recurrence


def test_repetitions_lie_over_each_other_and_the_last_may_be_cut_short() -> None:
    over = laid_over(np.stack([np.arange(11.0)] * 2, axis=1), 4)
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
