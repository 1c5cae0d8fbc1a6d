"""Anticipation of a demonstration that is periodic."""

from typing import Any

import numpy as np

from mpma_mj.agents.anticipation import Anticipation
from mpma_mj.kinematics import posture_from_angles

Array = np.ndarray

LABELS = 2
MOST, STEPS, PERIOD = 3, 160, 40


def postures(count: int = STEPS + MOST + 2) -> Array:
    """Return postures of a periodic motion, shape (T, 12)."""
    phase = 2 * np.pi * np.arange(count)[:, None] / PERIOD + np.arange(8)
    return posture_from_angles(0.5 + 0.4 * np.sin(phase))


def observation(t: int, shape: tuple[int, ...] = ()) -> dict[str, Array]:
    motion, half = postures(), t % PERIOD < PERIOD // 2
    shown = {
        "reference": motion[t],
        "target": motion[t + 1],
        "context": np.array([half, not half], float),
    }
    return {name: np.broadcast_to(row, (*shape, len(row))) for name, row in shown.items()}


def episode(agent: Anticipation, number: int, shape: tuple[int, ...] = ()) -> Array:
    agent.reset(number)
    return np.array([agent(observation(t, shape)) for t in range(STEPS)])


def error(found: Array) -> float:
    """Return the mean difference from the targets that came, of those that were not shown."""
    motion = postures()
    came = np.stack([motion[1 + j : 1 + j + STEPS] for j in range(1, MOST + 1)], axis=1)
    return float(np.abs(found[:, 1:] - came).mean())


def test_before_learning_the_target_is_held() -> None:
    found = episode(Anticipation(LABELS, 0, MOST), 0)
    assert found.shape == (STEPS, MOST + 1, 12)
    expected = np.repeat(postures()[1 : STEPS + 1, None], MOST + 1, axis=1)
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_a_periodic_demonstration_is_learned() -> None:
    agent = Anticipation(LABELS, 0, MOST)
    held = error(episode(agent, 0))
    agent.learn(())
    for number in range(1, 3):
        found = episode(agent, number)
        agent.learn(())
    assert error(found) < held / 4
    np.testing.assert_array_equal(found[:, 0], postures()[1 : STEPS + 1])
    lengths = np.linalg.norm(found.reshape(STEPS, MOST + 1, 4, 3), axis=-1)
    np.testing.assert_allclose(lengths, 1.0)


def test_an_episode_that_is_too_short_is_not_learned_from() -> None:
    agent = Anticipation(LABELS, 0, MOST)
    for t in range(MOST):
        agent(observation(t))
    agent.learn(())
    assert not any(array.any() for array in agent.state_dict().values())


def test_runs_of_a_batch_learn_as_alone_and_selected_ones_stay() -> None:
    batch = Anticipation(LABELS, [0, 1, 2], MOST)
    episode(batch, 0, (3,))
    for run in range(3):
        batch.learn((run,))
    batch.select_runs(np.array([2, 0]))
    together = episode(batch, 1, (2,))
    for row, seed in enumerate((2, 0)):
        alone = Anticipation(LABELS, seed, MOST)
        episode(alone, 0)
        alone.learn(())
        np.testing.assert_array_equal(episode(alone, 1), together[:, row])


def test_a_state_dict_round_trip_continues_to_the_bit() -> None:
    agents: list[Any] = [Anticipation(LABELS, 0, MOST) for _ in range(2)]
    episode(agents[0], 0)
    agents[0].learn(())
    agents[1].load_state_dict(agents[0].state_dict())
    for number in (1, 2):
        first, second = (episode(agent, number) for agent in agents)
        np.testing.assert_array_equal(first, second)
        for agent in agents:
            agent.learn(())
