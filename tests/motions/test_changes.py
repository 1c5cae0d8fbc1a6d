import numpy as np
import pytest
from numpy.typing import NDArray

from mpma_mj import kinematics
from mpma_mj.errors import BadOptionError
from mpma_mj.motions.context import change_points
from mpma_mj.motions.synthetic import ymca

Array = NDArray[np.float64]
Index = NDArray[np.int_]

REST = np.tile([0.8, 0.2, 0.0, 1.0], 2)  # rad


def rhythms(lengths: list[int], seed: int = 0) -> tuple[Array, Index]:
    """Return a movement of one rhythm after the other, and which is danced when."""
    rng = np.random.default_rng(seed)
    label = np.repeat(np.arange(len(lengths)), lengths)
    phase = 2 * np.pi * np.cumsum(rng.uniform(0.4, 1.6, len(lengths))[label]) / 20.0
    centre = (REST + rng.uniform(-0.3, 0.3, (len(lengths), 8)))[label]
    amplitude = rng.uniform(0.1, 0.6, (len(lengths), 8))[label]
    angles = centre + amplitude * np.sin(phase[:, None] + rng.uniform(0, 6, 8))
    return kinematics.posture_from_angles(angles), label


@pytest.mark.parametrize("rate", [10.0, 20.0, 60.0])
def test_the_letters_are_found_from_the_start_of_the_move_towards_them(rate: float) -> None:
    motion = ymca(rate=rate)
    np.testing.assert_array_equal(change_points(motion.posture, 4), motion.context.argmax(axis=1))


def test_letters_that_are_danced_twice_are_found_twice() -> None:
    motion = ymca(rate=20.0)
    label = motion.context.argmax(axis=1)
    found = change_points(np.tile(motion.posture, (2, 1)), 8)
    np.testing.assert_array_equal(found, [*label, *(label + 4)])


@pytest.mark.parametrize("seed", range(5))
def test_rhythms_are_told_apart_within_a_second(seed: int) -> None:
    posture, label = rhythms([120, 180, 100, 200], seed)
    found = change_points(posture, 4)
    edges = np.flatnonzero(np.diff(found))
    np.testing.assert_allclose(edges, np.flatnonzero(np.diff(label)), atol=20)


def test_a_rhythm_of_another_speed_is_another_rhythm() -> None:
    label = np.repeat([0, 1, 2], [200, 150, 250])
    phase = 2 * np.pi * np.cumsum(np.array([0.5, 1.4, 0.8])[label]) / 20.0
    posture = kinematics.posture_from_angles(REST + 0.4 * np.sin(phase[:, None] + np.arange(8)))
    assert (change_points(posture, 3) == label).mean() > 0.98


def test_a_long_movement_is_cut_as_well() -> None:
    posture, label = rhythms([20_001, 30_000, 15_000])
    assert (change_points(posture, 3) == label).mean() > 0.99


def test_a_movement_reversed_in_space_is_cut_at_the_same_places() -> None:
    posture, _ = rhythms([120, 180, 100])
    np.testing.assert_array_equal(change_points(-posture, 3), change_points(posture, 3))


@pytest.mark.parametrize(
    ("frames", "segments"), [(1, 1), (50, 1), (2, 2), (5, 5), (76, 30), (2001, 7)]
)
def test_every_part_is_there_and_in_order(frames: int, segments: int) -> None:
    posture, _ = rhythms([frames])
    found = change_points(posture, segments)
    assert found.shape == (frames,)
    np.testing.assert_array_equal(np.unique(found), np.arange(segments))
    assert (np.diff(found) >= 0).all()


@pytest.mark.filterwarnings("error")
def test_arms_that_rest_are_cut_all_the_same() -> None:
    found = change_points(np.tile(kinematics.posture_from_angles(REST), (40, 1)), 4)
    np.testing.assert_array_equal(np.unique(found), np.arange(4))


@pytest.mark.parametrize(("frames", "segments"), [(3, 4), (4001, 1500), (10, 0), (10, -1)])
def test_parts_that_there_cannot_be_are_refused(frames: int, segments: int) -> None:
    with pytest.raises(BadOptionError, match=rf"^segments is {segments}; expected at [^\n]*$"):
        change_points(rhythms([frames])[0], segments)
