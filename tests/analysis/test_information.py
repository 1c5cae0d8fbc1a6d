import numpy as np
import pytest
from numpy.typing import NDArray

from mpma_mj.analysis.information import (
    ResponsibilityInformation,
    entropy_bits,
    estimate,
    information_bits,
    posture_regions,
    readout_r2,
    responsibility_information,
)

Array = NDArray[np.float64]

PERIOD = 80
RNG = np.random.default_rng(0)


def repeated(signal: Array) -> Array:
    """Return three repetitions, the last cut short by a step, as episodes are."""
    return np.concatenate([signal] * 3)[:-1]


def smooth(columns: int) -> Array:
    """Return a course that comes back to where it began, shape (PERIOD, columns)."""
    turn = 2 * np.pi * np.arange(PERIOD)[:, None] / PERIOD
    waves = range(1, 4)
    return sum(
        RNG.normal(size=columns) * np.sin(n * turn + RNG.uniform(0, 6, columns)) for n in waves
    )


def test_a_linear_function_of_posture_is_read_out_entirely() -> None:
    posture = repeated(smooth(12))
    responsibility = 0.3 + posture @ RNG.normal(size=(12, 3))
    assert readout_r2(responsibility, posture, PERIOD) == pytest.approx(np.ones(4))


def test_what_is_independent_is_not_read_out() -> None:
    r2 = readout_r2(RNG.uniform(size=(6000, 2)), RNG.normal(size=(6000, 12)), 2000)
    assert np.abs(r2).max() < 0.02


def test_the_readout_is_tested_on_repetitions_that_it_has_not_seen() -> None:
    steps = 30  # fewer than there are signals: fitted and tested on the same it would be 1
    noise = RNG.normal(size=(2 * steps, 100))
    assert readout_r2(RNG.uniform(size=(2 * steps, 1)), noise, steps)[0] < 0.2


def test_all_modules_together_count_by_their_variance() -> None:
    posture = RNG.normal(size=(2000, 1))
    told, other = 10.0 * posture[:, 0], RNG.normal(size=2000)
    together, first, second = readout_r2(np.stack([told, other], axis=1), posture, 500)
    assert first == pytest.approx(1.0)
    assert second == pytest.approx(0.0, abs=0.02)
    assert together == pytest.approx(1.0 - 1.0 / 101.0, abs=0.003)


def test_without_a_second_repetition_or_variance_there_is_no_r2() -> None:
    posture = smooth(12)
    assert np.isnan(readout_r2(posture[:-1, :2], posture[:-1], PERIOD)).all()
    constant = np.stack([np.ones(3 * PERIOD - 1), repeated(posture)[:, 0]], axis=1)
    together, first, second = readout_r2(constant, repeated(posture), PERIOD)
    assert np.isnan(first)
    assert second == pytest.approx(1.0)
    assert together == pytest.approx(1.0)


def test_the_information_of_equal_labels_is_their_entropy() -> None:
    label = np.arange(400) % 4
    assert entropy_bits(label) == pytest.approx(2.0)
    assert information_bits(label, label) == pytest.approx(2.0)
    assert information_bits(label, (label + 1) % 4) == pytest.approx(2.0)
    assert information_bits(label, label // 2) == pytest.approx(1.0)


def test_a_constant_has_no_information() -> None:
    assert entropy_bits(np.zeros(10, int)) == pytest.approx(0.0)
    assert information_bits(np.arange(10) % 2, np.zeros(10, int)) == pytest.approx(0.0)


def test_two_signals_can_tell_together_what_neither_tells_alone() -> None:
    first, second = np.repeat([0, 1], 200), np.tile([0, 1], 200)
    either = first ^ second
    assert information_bits(either, first) == pytest.approx(0.0)
    assert information_bits(either, first, second) == pytest.approx(1.0)


def test_the_bias_of_the_estimate_is_in_what_chance_gives() -> None:
    symbols, other = RNG.integers(8, size=100), RNG.integers(8, size=100)
    told = estimate(lambda x: np.array(information_bits(symbols, x)), other, 100)
    bias = 49 / (2 * 100 * np.log(2))  # Miller (1955)
    assert told.value > 0.2
    assert told.by_chance == pytest.approx(bias, rel=0.25)
    assert told.value - told.by_chance == pytest.approx(0.0, abs=0.1)


def test_chance_is_the_mean_over_other_times() -> None:
    told = estimate(lambda x: x[:1], np.arange(4.0), 4)
    assert told.value == pytest.approx(0.0)
    assert told.by_chance == pytest.approx(2.0)  # of 3, 2, 1


def test_regions_part_postures_that_lie_apart_and_are_numbered_as_they_come() -> None:
    centres = 10.0 * np.eye(12)[:8]
    order = np.repeat([5, 2, 7, 0, 1, 3, 4, 6], 5)
    region = posture_regions(centres[order] + 0.01 * RNG.normal(size=(40, 12)))
    assert region.tolist() == np.repeat(np.arange(8), 5).tolist()


def test_fewer_postures_than_regions_are_a_region_each() -> None:
    assert posture_regions(np.eye(12)[[0, 0, 3, 3, 3]]).tolist() == [0, 0, 1, 1, 1]


def of_signals(
    responsibility: Array, posture: Array, label: NDArray[np.int_]
) -> ResponsibilityInformation:
    region = (posture[:, 0] > 0).astype(int)
    return responsibility_information(
        responsibility, posture, np.eye(4)[label], region, label, PERIOD
    )


def test_modules_that_go_by_context_and_modules_that_go_by_posture_are_distinguished() -> None:
    label = repeated(np.arange(PERIOD) * 4 // PERIOD)
    posture = repeated(np.sin(2 * np.pi * 7 * np.arange(PERIOD) / PERIOD + 0.1)[:, None])
    by_context = of_signals(np.eye(2)[label // 2], posture, label)
    by_posture = of_signals(np.eye(2)[(posture[:, 0] > 0).astype(int)], posture, label)
    for told, by, other in (
        (by_context, "context", "posture"),
        (by_posture, "posture", "context"),
    ):
        assert told.entropy_bits == pytest.approx(np.ones(3), abs=0.01)
        assert told.bits[by].value == pytest.approx(told.entropy_bits)
        assert told.bits[f"{by} beyond {other}"].value[0] > 0.9
        assert told.bits[f"{other} beyond {by}"].value[0] == pytest.approx(0.0, abs=1e-9)
        assert told.r2[by].value[0] > 0.75
        assert told.r2[by].value[0] > told.r2[by].by_chance[0] + 0.25
        assert told.r2[f"{other} beyond {by}"].value[0] < 0.05
