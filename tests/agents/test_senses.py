"""Senses of what is observed as it is."""

import numpy as np

from mpma_mj.agents.base import AgentSpec
from mpma_mj.agents.senses import ModelledSenses, Senses

SPEC = AgentSpec(2, np.array([12.0, 12.0, 20.0, 15.0] * 2), 0.05)
RNG = np.random.default_rng(0)
OBSERVED = {"joint_angles": RNG.normal(size=8), "joint_velocities": RNG.normal(size=8)}


def test_senses_change_nothing() -> None:
    for made in (Senses(), ModelledSenses(SPEC, (), 1)):
        predictions, action = RNG.normal(size=(3, 8)), RNG.normal(size=8)
        made.reset(0)
        assert made(OBSERVED, 0) is OBSERVED
        assert made.present(OBSERVED) is OBSERVED
        assert made.of_last_move(predictions) is predictions
        assert made.of_last_move(None) is None
        assert made.acting(OBSERVED, action) == (OBSERVED, action)
        assert made.effects(predictions) is predictions
        assert not made.late


def test_aligned_steps_are_followed_by_the_next() -> None:
    angles, posture = RNG.normal(size=(5, 8)), RNG.normal(size=(5, 12))
    steps = {"joint_angles": angles[:4], "posture": posture[:4], "action": angles[:4]}
    aligned = Senses().aligned(steps, {"joint_angles": angles[4], "posture": posture[4]}, ())
    np.testing.assert_array_equal(aligned["next_joint_angles"], angles[1:])
    np.testing.assert_array_equal(aligned["next_posture"], posture[1:])
    for name, array in steps.items():
        assert aligned[name] is array


def test_senses_that_learn_nothing_have_no_state() -> None:
    made = Senses()
    made.learn({}, np.ones((3, 1)), ())
    made.select_runs(np.array([0]))
    made.load_state_dict({"anything": np.ones(3)})
    assert made.state_dict() == {}


def test_modelled_senses_learn_of_each_run_how_the_state_follows_a_command() -> None:
    made, reach = ModelledSenses(SPEC, (2,), 1), SPEC.control_timestep * SPEC.max_joint_speed
    action = RNG.uniform(-1, 1, (200, 2, 8))
    gain = np.array([1.0, 0.5])[:, None]  # of the two runs' arms
    angles = np.concatenate([np.zeros((1, 2, 8)), (gain * action).cumsum(axis=0)]) * reach
    velocities = np.concatenate([np.zeros((1, 2, 8)), gain * action]) * SPEC.max_joint_speed
    made.reset(0)
    for now, speed in zip(angles[:-1], velocities[:-1], strict=True):
        made({"joint_angles": now, "joint_velocities": speed}, np.zeros(2, np.intp))
    for run in range(2):
        steps = {"joint_angles": angles[:-1, run], "action": action[:, run]}
        last = {"joint_angles": angles[-1, run], "joint_velocities": velocities[-1, run]}
        blank = {"posture": np.zeros((200, 12))}
        aligned = made.aligned(steps | blank, last | {"posture": np.zeros(12)}, (run,))
        np.testing.assert_array_equal(aligned["next_joint_velocities"], velocities[1:, run])
        made.learn(aligned, np.ones((200, 1)), (run,))
    weights = made.state_dict()["state_models.weights"][:, 0]
    np.testing.assert_allclose(weights[0, :8, :8], np.eye(8), atol=0.01)
    np.testing.assert_allclose(weights[1, :8, :8], 0.5 * np.eye(8), atol=0.01)
    np.testing.assert_allclose(weights[1, 8:, :8], 0.5 * np.eye(8), atol=0.01)
