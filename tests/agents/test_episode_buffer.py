"""The buffer of an episode's signals, for episodes of any length."""

import numpy as np
import pytest

from mpma_mj.agents.episode_buffer import EpisodeBuffer


def filled(
    steps: int, buffer: EpisodeBuffer | None = None, shape: tuple[int, ...] = (2,)
) -> EpisodeBuffer:
    buffer = buffer or EpisodeBuffer()
    buffer.clear()
    for t in range(steps):
        buffer.append({"time": np.asarray(float(t)), "place": np.full(shape, 10.0 * t)})
    return buffer


@pytest.mark.parametrize("steps", [1, 255, 256, 257, 512, 513, 1300])
def test_every_step_is_kept_for_any_number_of_steps(steps: int) -> None:
    buffer = filled(steps)
    assert len(buffer) == steps
    episode = buffer.episode()
    np.testing.assert_array_equal(episode["time"], np.arange(steps))
    np.testing.assert_array_equal(episode["place"], 10.0 * np.arange(steps)[:, None] * [1, 1])
    np.testing.assert_array_equal(buffer.last("place"), 10.0 * (steps - 1))


def test_a_shorter_episode_leaves_nothing_of_a_longer_one() -> None:
    buffer = filled(3, filled(600))
    assert len(buffer) == 3
    np.testing.assert_array_equal(buffer.episode()["time"], [0, 1, 2])


def test_an_episode_of_other_shapes_takes_the_place_of_the_last() -> None:
    buffer = filled(300, filled(300), shape=(4, 3))
    assert buffer.episode()["place"].shape == (300, 4, 3)
    np.testing.assert_array_equal(buffer.last("place"), 2990.0)


def test_arrays_keep_their_precision() -> None:
    buffer = EpisodeBuffer()
    for kind in (np.float32, np.float64):
        buffer.clear()
        buffer.append({"number": np.asarray(1.0 / 3.0, kind)})
        assert buffer.last("number") == kind(1.0 / 3.0)
        assert buffer.episode()["number"].dtype == kind
