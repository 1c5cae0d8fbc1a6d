"""Agents from which the demonstration is taken away."""

from typing import Any

import numpy as np
import pytest

from mpma_mj import MPMAConfig, load, make_agent
from mpma_mj.agents.wrappers import AlteredContext, FreeRunning
from mpma_mj.errors import BadOptionError
from mpma_mj.training.rollout import record_epoch

SMALL = MPMAConfig(nodes=10, modules=2)
LEAD_IN = 20


class Noted(FreeRunning):
    """A freed agent that notes what its pairs are shown."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.shown: list[dict[str, np.ndarray]] = []
        act = self._pairs.act
        self._pairs.act = lambda seen: (self.shown.append(seen), act(seen))[1]  # type: ignore[method-assign]


def trained(kind: str = "mpma") -> tuple[Any, Any]:
    env = load("ymca", arms="kinematic", repeats=1)
    agent = make_agent(env, SMALL, kind=kind)
    for epoch in range(2):
        record_epoch(env, agent, epoch)
        agent.learn()
    return env, agent


@pytest.mark.parametrize("kind", ["mpma", "growing", "mosaic", "hammer", "single"])
def test_after_the_lead_in_its_own_prediction_is_all_that_it_is_shown(kind: str) -> None:
    env, agent = trained(kind)
    freed = Noted(agent, LEAD_IN)
    trace = record_epoch(env, freed, 2)
    expected = np.einsum("tm,tmd->td", trace.modules.responsibility, trace.modules.predictions)
    for step, seen in enumerate(freed.shown):
        np.testing.assert_array_equal(seen["posture"], trace.posture[step])
        np.testing.assert_array_equal(seen["context"], trace.context[step])
        if step < LEAD_IN:
            np.testing.assert_array_equal(seen["reference"], trace.reference[step])
        else:
            np.testing.assert_allclose(seen["reference"], expected[step - 1], atol=1e-12)
            np.testing.assert_array_equal(seen["target"], seen["reference"])


def test_the_lead_in_is_danced_as_if_never_freed() -> None:
    env, agent = trained()
    free = record_epoch(env, FreeRunning(agent, LEAD_IN), 2)
    held = record_epoch(env, agent, 2)
    np.testing.assert_array_equal(free.action[:LEAD_IN], held.action[:LEAD_IN])
    assert not np.array_equal(free.action, held.action)


def test_nothing_is_learned_not_even_by_one_that_learns_at_every_step() -> None:
    env, agent = trained("mosaic")
    before = agent.state_dict()
    record_epoch(env, FreeRunning(agent, LEAD_IN), 2)
    for name, value in agent.state_dict().items():
        np.testing.assert_array_equal(value, before[name], err_msg=name)


def test_an_agent_that_hears_otherwise_can_be_freed_too() -> None:
    env, agent = trained()
    freed = FreeRunning(
        AlteredContext(agent, "constant", env.task.context, env.task.period, 0), LEAD_IN
    )
    assert record_epoch(env, freed, 2).action.shape == (env.task.steps, 8)


def test_agents_without_forward_models_are_refused() -> None:
    agent = make_agent(load("ymca"), kind="feedback_only")
    with pytest.raises(
        BadOptionError, match=r"agent is 'FeedbackOnly'; expected .* forward models"
    ):
        FreeRunning(agent, LEAD_IN)
