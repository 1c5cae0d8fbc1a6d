import itertools

import numpy as np
import pytest
from dm_control.rl import control

from mpma_mj import MPMAConfig, load, make_agent, make_vec
from mpma_mj.agents import AGENTS, Agent, AgentSpec, RandomAgent, RandomConfig
from mpma_mj.kinematics import angles_from_posture
from mpma_mj.metrics import posture_error_percent
from mpma_mj.training.history import part_metrics
from mpma_mj.training.rollout import record_epoch

NAMES = ("random", "open_loop", "feedback_only", "resolved_rate")


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


def test_the_resolved_rate_command_and_a_seventh_of_the_feedback_are_the_action() -> None:
    env = load("ymca", repeats=1)
    agent = make("resolved_rate", env)
    timestep = env.reset()
    for _ in range(40):
        seen = timestep.observation
        feedback, command = (
            agent.spec.feedback(seen["joint_angles"], seen[name])
            for name in ("reference", "target")
        )
        action = agent.act(seen)
        np.testing.assert_allclose(action, np.clip(command + 0.14 * feedback, -1, 1), atol=1e-15)
        np.testing.assert_array_equal(agent.signals().feedback[-1], 0.14 * feedback)
        assert action.shape == (8,)
        timestep = env.step(action)
    assert agent.signals().learned is None
    agent.reset(1)
    assert agent.signals().feedback is None


@pytest.mark.parametrize("arms", ["physics", "kinematic"])
def test_the_resolved_rate_is_far_better_than_feedback(arms: str) -> None:
    assert p_e("resolved_rate", arms) < 0.3 * p_e("feedback_only", arms)


@pytest.mark.parametrize("name", ["feedback_only", "resolved_rate", "open_loop"])
def test_a_batch_equals_each_run_alone_to_the_bit(name: str) -> None:
    envs = make_vec(2, "ymca", repeats=1)
    env = load("ymca", repeats=1, seed=1)
    together, alone = make(name, env), make(name, env)
    for episode in range(2):
        trace = record_epoch(envs, together, episode).of_run(1).to_arrays()
        expected = record_epoch(env, alone, episode).to_arrays()
        assert expected.keys() == trace.keys()
        for signal, values in expected.items():
            np.testing.assert_array_equal(trace[signal], values, err_msg=signal)


def test_of_the_resolved_rate_command_nothing_is_learned() -> None:
    env = load("ymca", repeats=1)
    trace = record_epoch(env, make("resolved_rate", env), 0)
    measures = part_metrics(trace, np.ones(len(trace), bool))
    assert "learned_share" not in measures
    assert 0.0 < measures["feedback_ratio"] < 0.2
    untrained = make_agent(env, MPMAConfig(nodes=5))
    trace = record_epoch(env, untrained, 0)
    assert part_metrics(trace, np.ones(len(trace), bool))["learned_share"] < 1e-12
