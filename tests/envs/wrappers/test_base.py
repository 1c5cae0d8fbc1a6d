"""The base class of wrappers."""

import copy

import dm_env
import numpy as np
import pytest

from mpma_mj import load
from mpma_mj.envs.gym_env import ImitationEnv
from mpma_mj.envs.wrappers import Evaluate, FeedbackAssist, Wrapper
from mpma_mj.errors import (
    BadOptionError,
)


def ymca(arms: str = "physics", repeats: int = 1) -> dm_env.Environment:
    return load("ymca", arms=arms, repeats=repeats)


def test_wrappers_forward_attributes() -> None:
    env = ymca()
    wrapped = Evaluate(FeedbackAssist(Wrapper(env), gain=0.5))
    assert isinstance(wrapped, dm_env.Environment)
    assert wrapped.task is env.task
    assert wrapped.physics is env.physics
    assert wrapped.control_timestep() == env.control_timestep()
    assert wrapped.gain == 0.5
    for spec in ("action_spec", "observation_spec", "reward_spec", "discount_spec"):
        assert getattr(wrapped, spec)() == getattr(env, spec)()
    with pytest.raises(AttributeError, match="nonsense"):
        _ = wrapped.nonsense
    assert not hasattr(Evaluate(env), "gain")


def test_a_wrapper_without_environment_has_no_attributes() -> None:
    with pytest.raises(AttributeError):
        _ = Wrapper.__new__(Wrapper).task
    assert copy.copy(Wrapper(ymca())).task is not None


@pytest.mark.parametrize("wrap", [Wrapper, Evaluate, FeedbackAssist])
def test_other_interfaces_are_refused(wrap: type[Wrapper]) -> None:
    for other in (ImitationEnv(), None):
        with pytest.raises(
            BadOptionError, match=r"expected an environment of mpma_mj\.load; for Gym"
        ):
            wrap(other)


def test_a_copy_goes_on_identically() -> None:
    env = ymca()
    env.reset()
    env.step(np.ones(8))
    other = copy.deepcopy(env)
    for _ in range(5):
        one, two = env.step(np.ones(8)), other.step(np.ones(8))
        np.testing.assert_array_equal(one.observation["posture"], two.observation["posture"])


def test_closing_closes_the_environment_inside() -> None:
    class Door(Wrapper):
        closed = False

        def close(self) -> None:
            self.closed = True

    door = Door(ymca())
    with Evaluate(FeedbackAssist(door)):
        assert not door.closed
    assert door.closed
