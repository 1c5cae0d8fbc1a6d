"""Moments to which environments go back."""

import numpy as np
import pytest

from mpma_mj.envs.moment import EnvironmentMoment
from tests.envs.test_interventions import OPTIONS, actions, made


@pytest.mark.parametrize("kind", OPTIONS)
def test_from_a_moment_it_goes_on_to_the_bit(kind: str) -> None:
    env = made(**OPTIONS[kind])
    env.task.episode = 2
    timesteps, moments = [env.reset()], []
    all_actions = actions(env.task.steps)
    for action in all_actions:
        moments.append(EnvironmentMoment.of(env))
        timesteps.append(env.step(action))
    assert timesteps[-1].last()
    errors = env.task.tracking_errors(env.physics)
    for step in (len(moments) - 1, 30, 1):
        moments[step].restore(env)
        time = env.physics.data.time
        for after in range(step, len(all_actions)):
            timestep, expected = env.step(all_actions[after]), timesteps[after + 1]
            assert timestep.step_type == expected.step_type
            assert timestep.reward == expected.reward
            for name, array in expected.observation.items():
                np.testing.assert_array_equal(timestep.observation[name], array, err_msg=name)
        assert env.task.tracking_errors(env.physics) == errors
        assert time == pytest.approx(step * env.control_timestep())
    env.reset()
    assert env.task.episode == 4
