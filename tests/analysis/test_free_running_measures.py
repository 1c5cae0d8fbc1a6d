"""How long and how well a dance goes on: known cases."""

import dataclasses

import numpy as np
import pytest

from mpma_mj.analysis.free_running import FreeRun
from mpma_mj.analysis.free_running_report import HOLDING, as_markdown, measure, nearest_over_time
from mpma_mj.metrics import error_over_time

PERIOD, RATE = 40, 20.0


def turning(turns: np.ndarray) -> np.ndarray:
    """Return postures whose four segments turn in a plane, shape (T, 12)."""
    one = np.stack([np.cos(turns), np.sin(turns), np.zeros_like(turns)], axis=1)
    return np.tile(one, 4)


PHASE = 2.0 * np.pi * np.arange(3 * PERIOD) / PERIOD
SHOWN = turning(PHASE)
LABEL = np.arange(3 * PERIOD) % PERIOD * 2 // PERIOD


def danced(posture: np.ndarray, label: np.ndarray = LABEL) -> FreeRun:
    return FreeRun(posture, SHOWN, label, PERIOD, RATE)


def test_the_demonstration_itself_is_held_to_the_end() -> None:
    measures = measure(danced(SHOWN))
    assert measures.held_s == measures.near_s == len(SHOWN) / RATE
    assert set(measures.p_e_percent.values()) == {0.0}
    assert measures.nearest_percent == 0.0
    assert measures.speed == pytest.approx(1.0)
    assert measures.amplitude == pytest.approx(1.0)
    assert measures.change == pytest.approx(0.0, abs=1e-12)
    assert measures.ending == "cycle"


def test_arms_that_stay_where_they_are_are_their_own_measure() -> None:
    measures = measure(danced(np.repeat(SHOWN[:1], len(SHOWN), axis=0)))
    assert measures.p_e_percent == measures.still_percent
    assert measures.nearest_percent == measures.still_nearest_percent
    assert measures.ending == "standstill"
    assert measures.speed == 0.0


def test_chance_is_the_distance_of_two_postures_drawn_at_random() -> None:
    shown = np.zeros((20, 12))
    shown[::2] = 0.4  # two postures, 20 % of the range apart, of which a half of pairs differ
    free = FreeRun(shown, shown, np.zeros(20, int), 10, RATE)
    assert measure(free).chance_percent == pytest.approx(10.0)


def test_an_error_of_known_size_is_lost_when_it_comes() -> None:
    posture = SHOWN.copy()
    posture[30:] += 0.02 * HOLDING * 1.01  # 2 is the range
    free = danced(posture)
    np.testing.assert_allclose(error_over_time(free.posture, free.reference)[30:], 1.01 * HOLDING)
    assert measure(free).held_s == 30 / RATE
    assert measure(free).p_e_percent["1 s"] == 0.0
    assert measure(free).p_e_percent["2 s"] == pytest.approx(0.25 * 1.01 * HOLDING)


def test_nearness_does_not_mind_the_time_but_the_label() -> None:
    one_label = np.zeros(len(SHOWN), int)
    late = np.roll(SHOWN, 5, axis=0)
    np.testing.assert_allclose(nearest_over_time(danced(late, one_label), late), 0.0, atol=1e-12)
    assert measure(danced(late, one_label)).held_s < measure(danced(late, one_label)).near_s
    other_half = np.roll(SHOWN, PERIOD // 2, axis=0)
    assert nearest_over_time(danced(other_half), other_half).mean() > HOLDING


def test_a_dance_of_another_period_wanders() -> None:
    assert measure(danced(turning(0.7 * PHASE))).ending == "wandering"
    assert measure(danced(turning(0.7 * PHASE))).speed == pytest.approx(0.7, rel=1e-2)


def test_a_smaller_dance_has_its_amplitude() -> None:
    measures = measure(danced(0.3 * SHOWN))
    assert measures.amplitude == pytest.approx(0.3)
    assert measures.ending == "cycle"


def test_a_dance_shorter_than_a_window_has_none() -> None:
    short = dataclasses.replace(
        danced(SHOWN[:30]), reference=SHOWN[:30], label=LABEL[:30], period=10
    )
    measures = measure(short)
    assert set(measures.p_e_percent) == {"1 s", "all"}
    row = as_markdown({"a run": measures}).splitlines()[2]
    assert row.startswith("| a run | 1.50 | 1.50 | 0.00 (")
    assert row.count("| – |") == 1
    assert row.count("–") == 2
