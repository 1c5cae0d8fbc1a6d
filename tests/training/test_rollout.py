"""What is recorded of an epoch."""

import numpy as np

import mpma_mj
from mpma_mj.training.rollout import record_epoch


def test_postures_are_those_of_the_arms_however_they_are_observed() -> None:
    traces = {}
    for noise in (0.0, 0.1):
        options = {"repeats": 1, "observation_noise": noise}
        envs, env = mpma_mj.make_vec(2, "ymca", **options), mpma_mj.load("ymca", **options)
        # It does not look at the arms, so that what they do is the same.
        agents = mpma_mj.make_agent(envs, kind="open_loop")
        batch = record_epoch(envs, agents, 0)
        first, other = batch.of_run(0).to_arrays(), batch.of_run(1)
        alone = record_epoch(env, mpma_mj.make_agent(env, kind="open_loop"), 0)
        for name, signal in alone.to_arrays().items():
            np.testing.assert_array_equal(first[name], signal, name)
        assert not np.array_equal(other.posture, alone.posture)
        traces[noise] = alone
    np.testing.assert_array_equal(traces[0.0].posture, traces[0.1].posture)
    assert np.std(traces[0.0].joint_angles - traces[0.1].joint_angles) > 0.05
