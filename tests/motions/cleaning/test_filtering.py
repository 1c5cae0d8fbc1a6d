import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from mpma_mj.motions import ymca
from mpma_mj.motions.cleaning.filtering import data_cutoff, looked_at, low_pass, resample
from mpma_mj.motions.loader import import_motion
from mpma_mj.motions.options import ReadingOptions
from tests.conftest import WriteTsv, dancer, markers_of

Array = NDArray[np.float64]


def movement(
    bandwidth: float, *, rate: float = 60.0, seconds: float = 20.0, seed: int = 0
) -> Array:
    """Return two points, mm, that move by 100 mm at all frequencies up to one, Hz."""
    rng = np.random.default_rng(seed)
    time = np.arange(round(seconds * rate))[:, None] / rate
    waves = [
        np.sin(2 * np.pi * frequency * time + rng.uniform(0, 2 * np.pi, 6))
        for frequency in np.linspace(0.1, bandwidth, 12)
    ]
    return 100.0 * np.mean(waves, axis=0)


def wave(frequency: float, rate: float = 60.0, seconds: float = 20.0) -> Array:
    return np.sin(2 * np.pi * frequency * np.arange(round(seconds * rate)) / rate)


@pytest.mark.parametrize("rate", [60.0, 120.0])
@pytest.mark.parametrize(("frequency", "gain"), [(2.0, 0.988), (6.0, 0.5), (12.0, 0.04)])
def test_the_filter_is_butterworths_both_ways(rate: float, frequency: float, gain: float) -> None:
    middle = low_pass(wave(frequency, rate), rate, 6.0)[300:-300]
    ratio = np.tan(np.pi * frequency / rate) / np.tan(np.pi * 6.0 / rate)
    assert 1 / (1 + ratio**4) == pytest.approx(gain, abs=0.02)
    assert np.sqrt(2) * middle.std() == pytest.approx(1 / (1 + ratio**4), rel=0.02)


@given(seed=st.integers(0, 999), cutoff=st.floats(1.0, 20.0))
def test_the_filter_has_no_delay(seed: int, cutoff: float) -> None:
    points = movement(5.0, seconds=5.0, seed=seed)
    backwards = low_pass(points[::-1], 60.0, cutoff)[::-1]
    np.testing.assert_allclose(
        low_pass(points, 60.0, cutoff)[100:-100], backwards[100:-100], atol=2.0
    )
    shifts = [np.sum(low_pass(wave(2.0), 60.0, cutoff) * np.roll(wave(2.0), s)) for s in (-1, 0, 1)]
    assert np.argmax(shifts) == 1


@given(
    frames=st.integers(1, 200),
    cutoff=st.floats(0.1, 100.0),
    shift=st.floats(-1e4, 1e4),
)
def test_what_does_not_move_is_not_changed(frames: int, cutoff: float, shift: float) -> None:
    still = np.full((frames, 3), shift)
    np.testing.assert_allclose(low_pass(still, 60.0, cutoff), still, atol=1e-6)


def test_above_half_the_rate_there_is_nothing_to_remove() -> None:
    np.testing.assert_array_equal(low_pass(wave(10.0), 60.0, 30.0), wave(10.0))


@settings(max_examples=20)
@given(
    bandwidth=st.floats(0.3, 12.0),
    noise=st.sampled_from([0.0, 0.1, 1.0, 10.0]),
    rate=st.sampled_from([10.0, 30.0, 60.0, 120.0, 240.0]),
)
def test_the_cutoff_is_that_of_human_movement(bandwidth: float, noise: float, rate: float) -> None:
    rng = np.random.default_rng(0)
    points = movement(bandwidth, rate=rate, seconds=5.0)
    assert 4.0 <= data_cutoff(points + rng.normal(0.0, noise, points.shape), rate) <= 10.0


@pytest.mark.parametrize("rate", [60.0, 120.0])
@pytest.mark.parametrize("noise", [0.5, 1.0, 2.0])
def test_the_cutoff_rises_with_the_bandwidth(rate: float, noise: float) -> None:
    rng = np.random.default_rng(0)
    found = []
    for bandwidth in (0.5, 2.0, 3.0, 4.0, 5.0, 8.0):
        points = movement(bandwidth, rate=rate)
        found.append(data_cutoff(points + rng.normal(0.0, noise, points.shape), rate))
    assert found == sorted(found)
    assert found[0] <= 5.0
    assert found[-1] >= 8.0


@pytest.mark.parametrize("bandwidth", [2.0, 4.0, 6.0])
def test_filtering_at_the_cutoff_is_nearer_to_the_truth_than_the_data(bandwidth: float) -> None:
    truth = movement(bandwidth)
    rng = np.random.default_rng(1)
    for noise in (2.0, 5.0):
        data = truth + rng.normal(0.0, noise, truth.shape)
        error = low_pass(data, 60.0, data_cutoff(data, 60.0)) - truth
        assert error[60:-60].std() < 0.8 * noise


@pytest.mark.parametrize("rate", [20.0, 30.0, 60.0])
def test_noise_alone_is_cut_off_as_low_as_can_be(rate: float) -> None:
    noise = np.random.default_rng(0).normal(size=(1200, 18))
    assert data_cutoff(noise, rate) == 4.0


@pytest.mark.parametrize(("noise", "cutoff"), [(0.0, 10.0), (20.0, 4.0)])
def test_a_low_rate_leaves_motion_unless_there_is_more_noise(noise: float, cutoff: float) -> None:
    points = movement(6.0, rate=20.0)
    points = points + np.random.default_rng(0).normal(0.0, noise, points.shape)
    assert data_cutoff(points, 20.0) == cutoff


def test_only_the_start_of_a_long_recording_decides() -> None:
    points = movement(3.0, seconds=80.0) + np.random.default_rng(0).normal(size=(4800, 6))
    assert data_cutoff(points, 60.0) == data_cutoff(points[: looked_at(60.0)], 60.0)


@given(
    frames=st.integers(2, 300),
    rate=st.floats(10.0, 240.0),
    new_rate=st.floats(5.0, 100.0),
)
def test_resampling_reads_a_parabola_exactly(frames: int, rate: float, new_rate: float) -> None:
    def parabola(time: Array) -> Array:
        return np.stack([3.0 + 2.0 * time, 1.0 - 4.0 * time + (time**2 if frames > 2 else 0)], 1)

    found = resample(parabola(np.arange(frames) / rate), rate, new_rate)
    np.testing.assert_allclose(found, parabola(np.arange(len(found)) / new_rate), atol=1e-7)
    duration = (frames - 1) / rate
    assert (len(found) - 1) / new_rate <= duration + 1e-6
    assert len(found) / new_rate > duration - 1e-6


@pytest.mark.parametrize("new_rate", [20.0, 17.3, 60.0, 144.0])
def test_a_long_recording_is_read_as_by_one_spline(new_rate: float) -> None:
    points = np.cumsum(np.random.default_rng(0).normal(size=(30_000, 3)), axis=0)
    found = resample(points, 50.0, new_rate)
    assert len(found) > 2 * 4096  # more than one block
    at = np.arange(len(found)) * 50.0 / new_rate
    whole = CubicSpline(np.arange(len(points)), points)(at)
    np.testing.assert_allclose(found, whole, atol=1e-9)


def test_the_same_rate_leaves_every_sample_as_it_is() -> None:
    points = movement(3.0)
    np.testing.assert_array_equal(resample(points, 60.0, 60.0), points)


def trembling(frequency: float) -> dict[str, Array]:
    markers = markers_of(dancer(np.tile(ymca().posture[:1], (600, 1))))
    for name in ("Radius_L", "Ulna_L"):
        markers[name][:, 0] += 10.0 * np.sin(2 * np.pi * frequency * np.arange(600) / 60.0)
    return markers


@pytest.mark.parametrize("frequency", [12.0, 14.0, 21.0])
@pytest.mark.parametrize("cutoff", [None, 8.0, 25.0])
def test_a_tremor_that_the_new_rate_cannot_show_is_gone(
    write_tsv: WriteTsv, frequency: float, cutoff: float | None
) -> None:
    path = write_tsv(trembling(frequency))
    posture = import_motion(path, ReadingOptions(cutoff=cutoff)).motion.posture
    # 10 mm at a forearm of 250 mm are 0.04 rad; 1.5 % is what is left of 12 Hz.
    assert np.abs(posture[5:-5, 3] - np.median(posture[5:-5, 3])).max() < 0.015 * 0.04


@pytest.mark.parametrize("tempo", [0.5, 1.0, 2.0])
def test_what_a_tempo_would_alias_is_filtered(write_tsv: WriteTsv, tempo: float) -> None:
    options = ReadingOptions(tempo=tempo, cutoff=6.0)
    posture = import_motion(write_tsv(trembling(4.5)), options).motion.posture
    ratio = np.tan(np.pi * 4.5 / 60) / np.tan(np.pi * 6.0 / 60)
    # At twice the tempo 4.5 Hz become 9 of 20 Hz, at half of it 30 Hz become 20.
    alias = np.tan(np.pi * 4.5 / 60) / np.tan(np.pi * 8.0 / tempo / 60)
    whole = np.std(0.04 * np.sin(np.linspace(0, 2 * np.pi, 100)))
    forward = posture[20:-20, 3]
    across = np.sqrt(1 - np.median(forward) ** 2)  # of the forearm, which 10 mm forward turn
    assert forward.std() == pytest.approx(
        whole / (1 + ratio**4) / (1 + alias**12) * across**2, rel=0.05
    )


def test_the_cutoff_is_told_and_where_it_comes_from(write_tsv: WriteTsv) -> None:
    slow = markers_of(dancer(ymca(rate=60.0, tempo=0.1).posture))
    rng = np.random.default_rng(0)
    slow = {name: track + rng.normal(0.0, 2.0, track.shape) for name, track in slow.items()}
    path = write_tsv(slow)
    for cutoff, told in {
        None: "low-pass filter at 4 Hz, from the data",
        3.0: "low-pass filter at 3 Hz, as given",
        50.0: "no low-pass filter",
    }.items():
        steps = import_motion(path, ReadingOptions(cutoff=cutoff)).report.steps
        assert f"{told}; resampled from 60 Hz to 20 Hz" in steps


@pytest.mark.parametrize("rate", [60.0, 240.0, 1000.0])
def test_the_ends_of_a_recording_are_as_exact_at_any_rate(rate: float) -> None:
    time = np.arange(0.0, 5.0, 1 / rate)
    sway = np.sin(2 * np.pi * 0.8 * time)[:, None]
    assert np.abs(low_pass(sway, rate, 4.0) - sway).max() < 0.015
