"""What agents remember of an episode, however long it is."""

import numpy as np
import pytest

from mpma_mj.agents.episode_buffer import EpisodeBuffer


def remembered(
    steps: int, memory: EpisodeBuffer | None = None, shape: tuple[int, ...] = (2,)
) -> EpisodeBuffer:
    memory = memory or EpisodeBuffer()
    memory.clear()
    for t in range(steps):
        memory.append({"time": np.asarray(float(t)), "place": np.full(shape, 10.0 * t)})
    return memory


@pytest.mark.parametrize("steps", [1, 255, 256, 257, 512, 513, 1300])
def test_every_step_is_kept_for_any_number_of_steps(steps: int) -> None:
    memory = remembered(steps)
    assert len(memory) == steps
    episode = memory.episode()
    np.testing.assert_array_equal(episode["time"], np.arange(steps))
    np.testing.assert_array_equal(episode["place"], 10.0 * np.arange(steps)[:, None] * [1, 1])
    np.testing.assert_array_equal(memory[-1]["place"], 10.0 * (steps - 1))


def test_a_shorter_episode_leaves_nothing_of_a_longer_one() -> None:
    memory = remembered(3, remembered(600))
    assert len(memory) == 3
    np.testing.assert_array_equal(memory.episode()["time"], [0, 1, 2])
    with pytest.raises(IndexError):
        memory[3]


def test_an_episode_of_other_shapes_takes_the_place_of_the_last() -> None:
    memory = remembered(300, remembered(300), shape=(4, 3))
    assert memory.episode()["place"].shape == (300, 4, 3)
    np.testing.assert_array_equal(memory[-1]["place"], 2990.0)


def test_arrays_keep_their_precision() -> None:
    memory = EpisodeBuffer()
    for kind in (np.float32, np.float64):
        memory.clear()
        memory.append({"number": np.asarray(1.0 / 3.0, kind)})
        assert memory.last("number") == kind(1.0 / 3.0)
        assert memory.episode()["number"].dtype == kind
