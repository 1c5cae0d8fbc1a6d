"""Means over seeds and how sure they are."""

import math

import hypothesis
import hypothesis.strategies as st
import numpy as np
import pytest

from mpma_mj.evaluation.statistics import Interval, MeanStd, interval, mean_std

VALUES = st.lists(st.floats(-100, 100).map(lambda x: round(x, 3)), min_size=2, max_size=8)


@hypothesis.given(found=VALUES)
@hypothesis.settings(max_examples=20)
def test_the_interval_is_around_the_mean_and_within_the_values(found: list[float]) -> None:
    one = interval(found)
    rounding = 1e-9
    assert min(found) - rounding <= one.low <= one.mean + rounding
    assert one.mean - rounding <= one.high <= max(found) + rounding
    assert interval(found) == one


def test_it_is_as_wide_as_the_normal_one_where_there_are_many_values() -> None:
    found = np.random.default_rng(1).normal(3.0, 2.0, 400)
    one = interval(found.tolist())
    error = found.std(ddof=1) / 20
    assert one.low == pytest.approx(found.mean() - 1.96 * error, abs=0.1 * error)
    assert one.high == pytest.approx(found.mean() + 1.96 * error, abs=0.1 * error)


def test_equal_values_are_a_point_and_one_value_has_no_interval() -> None:
    assert interval([0.1, 0.1, 0.1]) == Interval(0.1, 0.1, 0.1)
    one, none = interval([0.1]), interval([])
    assert one.mean == 0.1
    assert all(map(math.isnan, (one.low, one.high, none.mean)))


def test_it_is_shown_with_as_many_digits_as_asked_for() -> None:
    assert Interval(0.126, 0.1, 0.2).text(2) == "0.13 [0.10, 0.20]"
    assert Interval(0.126, -0.1, 0.2).text(1, "+") == "+0.1 [-0.1, +0.2]"
    assert interval([2.0, 2.0]).text(1) == interval([2.0]).text(1) == "2.0"
    assert interval([]).text(1) == "–"


@pytest.mark.parametrize(
    ("found", "excluded"),
    [([1.0, 2.0], True), ([-2.0, -1.0], True), ([-1.0, 1.0], False), ([0.0] * 2, False)],
)
def test_zero_is_excluded_by_intervals_on_one_side_of_it(
    found: list[float], excluded: bool
) -> None:
    assert interval(found).excludes_zero is excluded


def test_one_value_excludes_nothing() -> None:
    assert not interval([5.0]).excludes_zero


def test_the_deviation_is_that_of_the_sample() -> None:
    assert mean_std([1.0, 3.0]) == MeanStd(2.0, pytest.approx(math.sqrt(2.0)))
    assert mean_std([1.0, 3.0]).text(2) == "2.00 ± 1.41"


def test_a_mean_or_deviation_of_too_few_values_is_a_dash() -> None:
    assert mean_std([0.2]).text(2) == "0.20 ± –"
    assert mean_std([]).text(1, "/") == "–/–"
