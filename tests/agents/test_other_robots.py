"""Agents of robots other than two_arm, none of which uses the kinematics of two_arm."""

import dataclasses
from typing import Any

import numpy as np
import pytest

from mpma_mj import load, make_agent
from mpma_mj.agents import AGENTS
from mpma_mj.agents.config import CONFIG_TYPES
from mpma_mj.metrics import posture_error_percent
from mpma_mj.training.rollout import record_epoch
from tests.robots.humanoid import HUMANOID, short_dance, without_two_arm

SMALL = {"nodes": 5, "modules": 2, "expert_episodes": 1, "demonstrations": 2}
LATE = {"latency": 1}
VARYING = {"latency": (0, 2), "observation_noise": 0.01}


@pytest.mark.parametrize(
    ("kind", "config", "options"),
    [
        *((kind, {}, {}) for kind in AGENTS),
        ("bc", {}, {"lookahead": 2}),
        ("single", {"models": "posture", "rule": "gated"}, {}),
        ("single", {}, LATE),
        ("single", {}, LATE | {"lookahead": 2}),
        ("mpma", {"state_estimate": True}, VARYING),
        ("mpma", {"state_estimate": True}, VARYING | {"lookahead": 3}),
        ("mpma", {"state_estimate": True}, {"observation_noise": 0.01}),
    ],
)
def test_agents_act_and_learn_with_the_kinematics_of_the_robot(
    kind: str, config: dict[str, Any], options: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    motion = short_dance()
    config_type = CONFIG_TYPES[kind]
    fields = {field.name for field in dataclasses.fields(config_type)}
    small = {name: value for name, value in SMALL.items() if name in fields}
    without_two_arm(monkeypatch)
    env = load(motion, robot=HUMANOID, arms="kinematic", repeats=2, **options)
    agent = make_agent(env, config_type(**(small | config)))
    for epoch in range(max(2, agent.config.least_epochs)):
        trace = record_epoch(env, agent, epoch)
        agent.learn()
        assert (np.abs(trace.action) <= 1.0).all()


def test_postures_without_joint_angles_are_followed_too(monkeypatch: pytest.MonkeyPatch) -> None:
    motion, shown = short_dance(), []
    without_two_arm(monkeypatch)
    env = load(motion, robot=HUMANOID, arms="kinematic", repeats=1, reference_noise=0.0)
    agent, timestep = make_agent(env, kind="open_loop"), env.reset()
    agent.reset(0)
    while not timestep.last():
        postures = dict(timestep.observation)
        del postures["reference_angles"], postures["target_angles"]
        timestep = env.step(agent.act(postures))
        shown.append(timestep.observation["posture"])
    feasible = env.task.kinematics.posture(motion.joint_angles[1:])
    unavoidable = posture_error_percent(feasible, motion.posture[1:])
    assert posture_error_percent(np.array(shown), motion.posture[1:]) < unavoidable + 0.2
