"""Reachability: deviations of an arm from postures of people."""

import dataclasses

import numpy as np
import pytest

from mpma_mj.robots.reachability import PROBES, both_arms, deviation, reachable_share
from tests.robots.known_chains import LEFT, RIGHT


def test_arms_without_ranges_reach_everything() -> None:
    assert reachable_share(LEFT, PROBES) == 1.0
    assert reachable_share(RIGHT, both_arms()[:, 6:]) == 1.0


def test_an_elbow_that_hardly_bends_reaches_straight_arms_only() -> None:
    lowest, highest = LEFT.lowest.copy(), LEFT.highest.copy()
    lowest[3], highest[3] = 0.0, 0.2
    stiff = dataclasses.replace(LEFT, lowest=lowest, highest=highest)
    bend = np.degrees(np.arccos(np.vecdot(PROBES[:, :3], PROBES[:, 3:])))
    assert reachable_share(stiff, PROBES) == pytest.approx(np.mean(np.isclose(bend, 10.0)))


def test_the_deviation_is_that_of_the_worse_segment() -> None:
    hanging = np.array([0.0, 0.0, -1.0] * 2)
    angles = np.radians([[0.0, 0.0, 0.0, 0.0], [20.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 30.0]])
    np.testing.assert_allclose(deviation(LEFT, angles, hanging), [0.0, 20.0, 30.0], atol=1e-12)
