import itertools

import numpy as np
import pytest
from dm_control.rl import control

from mpma_mj import load
from mpma_mj.agents import AGENTS, Agent, AgentSpec, RandomAgent, RandomConfig
from mpma_mj.kinematics import angles_from_posture
from mpma_mj.metrics import posture_error_percent
from mpma_mj.training.rollout import record_epoch

NAMES = ("random", "open_loop", "feedback_only")


def make(name: str, env: control.Environment, seed: int = 0) -> Agent:
    spec = AgentSpec(4, env.task.max_joint_speed, env.control_timestep())
    agent_type = AGENTS[name]
    return agent_type(agent_type.config_type(), spec, seed=seed)


def p_e(name: str, arms: str, noise: float = 0.01) -> float:
    env = load("ymca", arms=arms, repeats=1, reference_noise=noise)
    trace = record_epoch(env, make(name, env), 0)
    return posture_error_percent(trace.posture, trace.reference)


def test_open_loop_on_ideal_arms_tracks_to_rounding() -> None:
    assert p_e("open_loop", "kinematic", noise=0.0) < 1e-10


def test_open_loop_drifts_off_on_simulated_arms() -> None:
    assert p_e("open_loop", "physics") > 5 * p_e("feedback_only", "physics")


@pytest.mark.parametrize("arms", ["physics", "kinematic"])
def test_feedback_tracks_better_than_chance(arms: str) -> None:
    assert p_e("feedback_only", arms) < 0.2 * p_e("random", arms)


def test_feedback_on_ideal_arms_is_one_step_late() -> None:
    env = load("ymca", arms="kinematic", repeats=1, reference_noise=0.0)
    trace = record_epoch(env, make("feedback_only", env), 0)
    # Not the forearms: near a straight elbow the controller is told to hold back.
    posture, reference = (all_[:, np.r_[0:3, 6:9]] for all_ in (trace.posture, trace.reference))
    late, now = posture[1:] - reference[:-1], posture[1:] - reference[1:]
    assert np.abs(late).mean() < 0.2 * np.abs(now).mean()


def test_open_loop_does_not_depend_on_the_arms() -> None:
    env = load("ymca", arms="physics", repeats=1)
    agent, blind = make("open_loop", env), make("open_loop", env)
    timestep = env.reset()
    while not timestep.last():
        shown = {name: timestep.observation[name] for name in ("reference", "target")}
        action = agent.act(timestep.observation)
        np.testing.assert_array_equal(blind.act(shown), action)
        timestep = env.step(action)


def test_open_loop_catches_up_after_steps_beyond_the_largest_velocity() -> None:
    env = load("ymca", arms="kinematic", repeats=1, reference_noise=0.0)
    near, far = env.task.motion.posture[[0, 20]]
    agent = make("open_loop", env)
    actions = np.stack([agent.act({"reference": near, "target": far}) for _ in range(60)])
    start = angles_from_posture(near, near=np.zeros(8))
    way = actions.sum(axis=0) * env.task.max_joint_speed * env.control_timestep()
    assert np.abs(actions[0]).max() == 1.0
    np.testing.assert_allclose(way, angles_from_posture(far, near=start) - start, atol=1e-12)


def test_random_actions_fill_their_range_and_follow_seed_and_episode() -> None:
    def actions(seed: int, episode: int) -> np.ndarray:
        agent = RandomAgent(RandomConfig(), AgentSpec(4, np.ones(8), 0.05), seed=seed)
        agent.reset(episode)
        return np.stack([agent.act({}) for _ in range(500)])

    drawn = [actions(*which) for which in [(0, 0), (0, 1), (1, 0)]]
    np.testing.assert_array_equal(drawn[0], actions(0, 0))
    for one, other in itertools.combinations(drawn, 2):
        assert (one != other).all()
    assert drawn[0].shape == (500, 8)
    assert (np.abs(drawn[0]) <= 1.0).all()
    np.testing.assert_allclose(drawn[0].mean(axis=0), 0.0, atol=0.15)
    np.testing.assert_allclose(drawn[0].std(axis=0), 3**-0.5, atol=0.06)


@pytest.mark.parametrize("name", NAMES)
def test_episodes_do_not_depend_on_those_before(name: str) -> None:
    env = load("ymca", arms="kinematic", repeats=1)
    agent = make(name, env)
    first = record_epoch(env, agent, 3)
    record_epoch(env, agent, 4)
    again = record_epoch(env, agent, 3)
    first, again = first.to_arrays(), again.to_arrays()
    assert first.keys() == again.keys()
    for signal, values in first.items():
        np.testing.assert_array_equal(again[signal], values)


@pytest.mark.parametrize("name", NAMES)
def test_nothing_is_learned(name: str) -> None:
    agent = make(name, load("ymca"))
    assert agent.learn() == {}
    assert agent.state_dict() == {}
    agent.load_state_dict({})


def test_feedback_is_a_signal() -> None:
    env = load("ymca", repeats=1)
    agent = make("feedback_only", env)
    assert agent.signals().feedback is None
    trace = record_epoch(env, agent, 0)
    np.testing.assert_array_equal(trace.feedback, trace.action)
