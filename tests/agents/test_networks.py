"""Networks in long episodes, whose features are replayed instead of kept."""

from typing import Any

import numpy as np
import pytest

from mpma_mj import MPMAConfig, load, make_agent, make_vec
from mpma_mj.agents import networks
from mpma_mj.agents.episode_buffer import EpisodeBuffer
from mpma_mj.esn import reservoir
from mpma_mj.training.rollout import record_epoch

SMALL = MPMAConfig(nodes=10, modules=4)
SETTINGS: list[dict[str, Any]] = [
    *({"kind": kind} for kind in ("mpma", "mosaic", "hammer", "oracle")),
    {
        "config": MPMAConfig(
            nodes=10, modules=3, models="posture", rule="gated", efference_copy="module"
        )
    },
]


def learned(**settings: Any) -> dict[str, np.ndarray]:
    """Return the state of an agent after some epochs."""
    env = load("ymca", arms="kinematic", repeats=1)
    agent = make_agent(env, **{"config": SMALL} | settings)
    for epoch in range(6):
        record_epoch(env, agent, epoch)
        agent.learn()
    return agent.state_dict()


@pytest.mark.parametrize("settings", SETTINGS, ids=lambda s: str(s.get("kind", "gated")))
def test_replayed_features_give_the_bits_of_kept_ones(
    settings: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    kept = learned(**settings)
    monkeypatch.setattr(networks, "_MOST_KEPT", 2000)  # bytes: some steps
    replayed = learned(**settings)
    assert kept.keys() == replayed.keys()
    for name, array in kept.items():
        np.testing.assert_array_equal(array, replayed[name])


def test_each_run_of_a_batch_replays_its_own_features(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(networks, "_MOST_KEPT", 2000)
    envs = make_vec(2, "ymca", arms="kinematic", repeats=1)
    agents: Any = make_agent(envs, SMALL)
    env = load("ymca", arms="kinematic", repeats=1, seed=1)
    alone = make_agent(env, SMALL, seed=1)
    for epoch in range(3):
        record_epoch(envs, agents, epoch)
        agents.learn()
        record_epoch(env, alone, epoch)
        alone.learn()
    for name, array in alone.state_dict().items():
        np.testing.assert_array_equal(agents.state_dict()[name][1], array)


def test_several_blocks_give_what_one_does(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = learned()
    monkeypatch.setattr(reservoir, "_BLOCK", 20)
    in_blocks = learned()
    name = "forward.gram"
    np.testing.assert_allclose(in_blocks[name], whole[name], rtol=1e-4, atol=1e-3)
    monkeypatch.setattr(networks, "_MOST_KEPT", 2000)
    for name, array in learned().items():
        np.testing.assert_array_equal(array, in_blocks[name])


def test_only_the_last_steps_of_a_limited_array_are_kept() -> None:
    buffer = EpisodeBuffer()
    for step in range(700):
        buffer.reserve("large", (3,), np.float32, most=300)[...] = step
        buffer.append({"small": np.asarray(float(step))})
        assert buffer.last("large")[0] == step
    assert buffer.episode().keys() == {"small"}
    buffer.clear()
    for step in range(300):
        buffer.reserve("large", (3,), np.float32, most=300)[...] = step
        buffer.append({"small": np.asarray(float(step))})
    np.testing.assert_array_equal(buffer.episode()["large"][:, 1], np.arange(300))
