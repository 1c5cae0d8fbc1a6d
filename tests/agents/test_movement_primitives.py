"""ProMP and DMP."""

from typing import Any

import numpy as np
import pytest

from mpma_mj import load, make_agent
from mpma_mj.agents import DMPConfig, ProMPConfig
from mpma_mj.agents.movement_primitives import MovementPrimitive, basis
from mpma_mj.errors import BadOptionError, CheckpointError, StateError
from mpma_mj.training.checkpoints import load_state
from mpma_mj.training.config import RunConfig
from mpma_mj.training.dataset import read_motions
from mpma_mj.training.rollout import record_epoch
from mpma_mj.training.trainer import train_batch
from tests.agents.batches import IDEAL, assert_batch_equals_alone

FEW = {"promp": ProMPConfig(demonstrations=3), "dmp": DMPConfig(demonstrations=3)}


def primitive(env: Any, kind: str, seed: Any = 0) -> MovementPrimitive:
    agent = make_agent(env, FEW[kind], seed=seed)
    assert isinstance(agent, MovementPrimitive)
    return agent


def trained(kind: str, epochs: int = 3, **options: Any) -> tuple[Any, MovementPrimitive]:
    env = load("ymca", **IDEAL | options)
    agent = primitive(env, kind)
    for epoch in range(epochs):
        record_epoch(env, agent, epoch)
        agent.learn()
    return env, agent


def path(steps: int = 40) -> np.ndarray:
    """Return a smooth movement from rest, shape (T + 1, 8)."""
    time = np.linspace(0.0, 1.0, steps + 1)[:, None]
    return np.arange(1.0, 9.0) * np.sin(2.0 * time) * time**2


def test_basis_functions_sum_to_one_and_each_leads_once() -> None:
    values = basis(40, 2.0)
    assert values.shape == (41, 21)
    np.testing.assert_allclose(values.sum(axis=1), 1.0)
    np.testing.assert_array_equal(values[::2].argmax(axis=1), np.arange(21))


def test_promp_is_the_mean_and_trusts_what_is_shown_as_far_as_movements_differ() -> None:
    agent = primitive(load("ymca", **IDEAL), "promp")
    rng = np.random.default_rng(0)
    smooth, offsets = path(), rng.normal(0.0, 0.2, (3, 1, 8))
    noise = rng.normal(0.0, 0.1, (3, 41, 8))
    agent._moments = 41
    shown = smooth + offsets + noise
    learned = np.array([agent.parameters(one) for one in shown])
    mean, variance = learned.mean(axis=0), learned.var(axis=0, ddof=1)
    movement = agent.begin(mean, variance, smooth[0])
    assert np.abs(movement - shown.mean(axis=0)).max() < 0.15
    agent._movement = movement
    target = movement[7] + 1.0
    spread, left = variance[7], mean[-1]
    np.testing.assert_allclose(
        agent.next_angles(7, target) - movement[7], spread / (spread + left), rtol=1e-9
    )
    # Movements that are all the same leave no doubt, so that nothing else is followed.
    agent.begin(mean, np.zeros_like(variance), smooth[0])
    np.testing.assert_array_equal(agent.next_angles(7, target), movement[7])


def test_dmp_reproduces_a_demonstration_and_leads_to_its_goal_from_elsewhere() -> None:
    agent = primitive(load("ymca", **IDEAL), "dmp")
    shown = path()
    agent._moments = len(shown)
    learned = agent.parameters(shown)
    np.testing.assert_array_equal(learned[-1], shown[-1])
    again = agent.begin(learned, np.zeros_like(learned), shown[0])
    assert np.abs(again - shown).max() < 0.02 * np.abs(shown).max()
    elsewhere = agent.begin(learned, np.zeros_like(learned), shown[0] + 1.0)
    np.testing.assert_allclose(elsewhere[-1], shown[-1], atol=0.1)
    assert np.abs(elsewhere - again)[-10:].max() < 0.01  # the beginning is forgotten


@pytest.mark.parametrize("kind", FEW)
def test_what_is_learned_does_not_contain_the_noise_of_one_demonstration(kind: str) -> None:
    noisy = {"reference_noise": 0.03}
    env, agent = trained(kind, **noisy)
    clean = load("ymca", **IDEAL | {"reference_noise": 0.0})
    reference = record_epoch(clean, make_agent(clean, kind="resolved_rate"), 0).reference
    follower = make_agent(env, kind="resolved_rate")

    def off(someone: Any) -> float:
        return float(np.abs(record_epoch(env, someone, 3).posture - reference).mean())

    assert off(agent) < 0.9 * off(follower)


@pytest.mark.parametrize("kind", FEW)
def test_it_follows_what_is_shown_until_it_has_learned(kind: str) -> None:
    env, other = load("ymca", **IDEAL), load("ymca", **IDEAL)
    agent, follower = primitive(env, kind), make_agent(other, kind="resolved_rate")
    for epoch in range(4):
        acts = epoch == 3
        action = record_epoch(env, agent, epoch).action
        shown = record_epoch(other, follower, epoch).action
        assert np.array_equal(action, shown) == (not acts)
        assert agent.learn() == {
            "learner_acts": float(acts),
            "calibrating": float(not acts),
        }


@pytest.mark.parametrize(("agent", "most"), [("promp", 0.6), ("dmp", 0.7)])
def test_twenty_demonstrations_of_ymca_with_physics(agent: str, most: float) -> None:
    config = RunConfig.of(agent=agent)
    (run,) = train_batch([config], read_motions(config), 21)
    assert run["converged"]
    assert run["best_epoch"] == 21
    assert run["p_e_percent"] < most


@pytest.mark.parametrize("kind", FEW)
def test_a_batch_equals_each_run_alone_to_the_bit(kind: str) -> None:
    assert_batch_equals_alone(lambda env, seed: primitive(env, kind, seed), epochs=4)


def test_episodes_of_another_length_are_refused() -> None:
    _, agent = trained("dmp", 1)
    record_epoch(load("ymca", **IDEAL | {"repeats": 2}), agent, 1)
    with pytest.raises(StateError, match=r"an episode has 151 steps, those before 75; a movement"):
        agent.learn()


@pytest.mark.parametrize("kind", FEW)
def test_a_longer_episode_holds_the_end(kind: str) -> None:
    _, agent = trained(kind)
    trace = record_epoch(load("ymca", **IDEAL | {"repeats": 2}), agent, 3)
    assert np.abs(trace.action).max() <= 1.0
    if kind == "dmp":
        np.testing.assert_allclose(trace.joint_velocities[-1], 0.0, atol=1e-6)


def test_a_damaged_state_is_refused() -> None:
    _, agent = trained("promp")
    state = agent.state_dict()
    with pytest.raises(CheckpointError, match="does not fit its config"):
        load_state(agent, state | {"squares": state["squares"][1:]}, None)
    of_a_batch = {name: state[name][None] for name in ("sums", "squares")}
    with pytest.raises(CheckpointError, match="does not fit its config"):
        load_state(agent, state | of_a_batch, None)
    of_fewer_joints = {name: state[name][..., 1:] for name in ("sums", "squares")}
    with pytest.raises(CheckpointError, match="does not fit its config"):
        load_state(agent, state | of_fewer_joints, None)
    with pytest.raises(CheckpointError, match="lacks moments"):
        load_state(agent, {n: a for n, a in state.items() if n != "moments"}, None)


@pytest.mark.parametrize("number", [0, 1, 1001])
def test_numbers_of_demonstrations_out_of_bounds_are_refused(number: int) -> None:
    with pytest.raises(BadOptionError, match=f"demonstrations is {number}; expected a whole"):
        ProMPConfig(demonstrations=number)
