from itertools import pairwise

import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from numpy.typing import NDArray

from mpma_mj.motions.cleaning.gaps import interpolate, runs
from mpma_mj.motions.cleaning.trajectories import missing

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

masks = arrays.arrays(bool, st.integers(2, 60))


@st.composite
def seen_at_both_ends(draw: st.DrawFn) -> Mask:
    mask = draw(masks)
    mask[[0, -1]] = False
    return mask


@given(masks)
def test_runs_are_the_mask(mask: Mask) -> None:
    found = runs(mask)
    rebuilt = np.zeros_like(mask)
    for first, end in found:
        rebuilt[first:end] = True
    np.testing.assert_array_equal(rebuilt, mask)
    edges = [edge for run in found for edge in run]
    assert all(a < b for a, b in pairwise(edges))  # apart, in order


def test_one_missing_coordinate_is_a_missing_marker() -> None:
    track = np.zeros((5, 3))
    track[1, 2] = track[3, 0] = np.nan
    np.testing.assert_array_equal(missing(track), [False, True, False, True, False])


@given(seen_at_both_ends(), st.integers(0, 1000))
def test_a_straight_line_is_bridged_exactly(gone: Mask, seed: int) -> None:
    start, step = np.random.default_rng(seed).normal(0.0, 1000.0, (2, 3))
    line = start + step * np.arange(len(gone))[:, None]
    track = np.where(gone[:, None], np.nan, line)
    interpolate(track)
    np.testing.assert_allclose(track, line, atol=1e-8)


@given(seen_at_both_ends(), st.integers(0, 1000))
def test_a_bridge_stays_between_its_ends_and_touches_nothing_else(gone: Mask, seed: int) -> None:
    assume(gone.any())
    truth = np.cumsum(np.random.default_rng(seed).normal(0.0, 10.0, (len(gone), 3)), axis=0)
    track = np.where(gone[:, None], np.nan, truth)
    interpolate(track)
    np.testing.assert_array_equal(track[~gone], truth[~gone])
    for first, end in runs(gone):
        ends = truth[[first - 1, end]]
        assert (track[first:end] >= ends.min(axis=0) - 1e-9).all()
        assert (track[first:end] <= ends.max(axis=0) + 1e-9).all()


def test_a_curve_is_bridged_better_than_by_a_line() -> None:
    time = np.arange(120) / 60.0
    truth = np.stack([np.cos(3 * time), np.sin(3 * time), time**2], axis=1)
    track = truth.copy()
    track[70:82] = np.nan
    interpolate(track)
    line = truth[69] + np.arange(1, 13)[:, None] / 13 * (truth[82] - truth[69])
    assert np.abs(track - truth).max() < 0.5 * np.abs(line - truth[70:82]).max()
