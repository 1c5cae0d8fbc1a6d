"""Paired models of which modules are switched off."""

import dataclasses
from typing import Any

import numpy as np
import pytest

from mpma_mj import MPMAConfig, load, make_agent, make_vec
from mpma_mj.agents.paired_models import PairedModels
from mpma_mj.agents.wrappers import AlteredContext, Frozen, paired_models_of
from mpma_mj.errors import BadOptionError
from mpma_mj.training.rollout import record_epoch

MODULES = 4  # as many as YMCA has labels, the number that HAMMER has
SMALL = MPMAConfig(nodes=10, modules=MODULES)
POSTURE = dataclasses.replace(SMALL, models="posture", rule="gated")
KINDS = ["mpma", "gated", "mosaic", "hammer"]

State = dict[str, np.ndarray]


@pytest.fixture(scope="module")
def env() -> Any:
    return load("ymca", arms="kinematic", repeats=1)


def made(env: Any, kind: str, seed: Any = 0) -> Any:
    config, name = (POSTURE, "mpma") if kind == "gated" else (SMALL, kind)
    agent = make_agent(env, config, kind=name, seed=seed)
    assert isinstance(agent, PairedModels)
    return agent


@pytest.fixture(scope="module")
def learned(env: Any) -> dict[str, State]:
    """Return the states of trained agents of each kind."""
    states = {}
    for kind in KINDS:
        agent = made(env, kind)
        for epoch in range(5):
            record_epoch(env, agent, epoch)
            agent.learn()
        states[kind] = agent.state_dict()
    return states


def trained(env: Any, learned: dict[str, State], kind: str) -> Any:
    agent = made(env, kind)
    agent.load_state_dict(learned[kind])
    return agent


def without(env: Any, learned: dict[str, State], kind: str, *off: int) -> Any:
    agent = trained(env, learned, kind)
    agent.set_enabled_modules([module not in off for module in range(MODULES)])
    return agent


@pytest.mark.parametrize("kind", KINDS)
def test_switching_no_module_off_changes_no_bit(
    env: Any, learned: dict[str, State], kind: str
) -> None:
    one, other = trained(env, learned, kind), without(env, learned, kind)
    for epoch in (5, 6):
        danced, same = record_epoch(env, one, epoch), record_epoch(env, other, epoch)
        for name, signal in danced.to_arrays().items():
            np.testing.assert_array_equal(same.to_arrays()[name], signal, err_msg=name)
        one.learn()
        other.learn()
    state = other.state_dict()
    for name, value in one.state_dict().items():
        np.testing.assert_array_equal(state[name], value, err_msg=name)


@pytest.mark.parametrize("kind", KINDS)
def test_remaining_modules_take_their_first_step_as_before(
    env: Any, learned: dict[str, State], kind: str
) -> None:
    whole, part = trained(env, learned, kind), without(env, learned, kind, 1)
    env.task.episode = 7
    observation = env.reset().observation
    for agent in (whole, part):
        agent.reset(7)
        agent.act(observation)
    intact, after = whole.signals().modules, part.signals().modules
    np.testing.assert_array_equal(after.module_actions, intact.module_actions)
    assert (after.prior[:, 1] == 0.0).all()
    assert (after.responsibility[:, 1] == 0.0).all()
    if kind != "hammer":  # in which one has all
        share = intact.responsibility.copy()
        share[:, 1] = 0.0
        np.testing.assert_allclose(after.responsibility, share / share.sum(), atol=1e-12)


@pytest.mark.parametrize("kind", ["mpma", "gated", "mosaic"])
def test_remaining_modules_learn_and_the_others_stay_as_they_are(
    env: Any, learned: dict[str, State], kind: str
) -> None:
    agent = without(env, learned, kind, 0, 2)
    trace = record_epoch(env, agent, 5)
    responsibility = trace.modules.responsibility
    np.testing.assert_allclose(responsibility.sum(axis=1), 1.0)
    assert not responsibility[:, [0, 2]].any()
    agent.learn()
    before, after = learned[kind], agent.state_dict()
    for name in ("inverse.weights", "forward.weights"):
        change = after[name] - before[name]
        assert (np.abs(change[[1, 3]]).max(axis=(1, 2)) > 1e-5).all()
        if kind == "gated":  # fitted to their own outputs
            features = agent._features(())[name.replace(".weights", "_features")]
            outputs = np.einsum("mkf,tmf->tmk", change, features)
            assert np.abs(outputs[:, [0, 2]]).max() < 0.1 * np.abs(outputs[:, [1, 3]]).max()
        else:
            assert not change[[0, 2]].any()


def test_what_a_module_knew_it_knows_when_it_is_back(env: Any, learned: dict[str, State]) -> None:
    agent = without(env, learned, "mpma", 0)
    record_epoch(env, agent, 5)
    agent.learn()
    after = agent.state_dict()
    for name in ("preferences", "variance"):
        np.testing.assert_array_equal(after[name][0, ..., 0], learned["mpma"][name][0, ..., 0])
    agent.set_enabled_modules([True] * MODULES)
    assert (record_epoch(env, agent, 6).modules.responsibility[:, 0] > 0.5).any()


def test_a_module_that_is_switched_off_in_a_step_changes_the_movement(
    env: Any, learned: dict[str, State]
) -> None:
    whole, part = trained(env, learned, "mpma"), without(env, learned, "mpma", 0)
    danced, other = record_epoch(env, whole, 5), record_epoch(env, part, 5)
    assert np.abs(danced.posture - other.posture).max() > 1e-4


@pytest.mark.parametrize("kind", KINDS)
def test_switching_modules_of_a_batch_off_equals_that_of_each_run(kind: str) -> None:
    envs = make_vec(2, "ymca", arms="kinematic", repeats=1)
    together = made(envs, kind, [3, 5])
    for epoch in range(2):
        record_epoch(envs, together, epoch)
        together.learn()
    alone = made(load("ymca", arms="kinematic", repeats=1), kind, 5)
    alone.load_state_dict({name: value[1] for name, value in together.state_dict().items()})
    for agent in (together, alone):
        agent.set_enabled_modules([True, False, True, False])
    trace = record_epoch(envs, together, 4).of_run(1)
    expected = record_epoch(load("ymca", arms="kinematic", repeats=1, seed=1), alone, 4)
    for name, signal in expected.to_arrays().items():
        np.testing.assert_array_equal(trace.to_arrays()[name], signal, err_msg=name)
    together.learn()
    alone.learn()
    state = together.state_dict()
    for name, value in alone.state_dict().items():
        np.testing.assert_array_equal(state[name][1], value, err_msg=name)


@pytest.mark.parametrize("kind", KINDS)
def test_with_all_modules_off_the_feedback_controller_is_left(
    env: Any, learned: dict[str, State], kind: str
) -> None:
    agent = without(env, learned, kind, *range(MODULES))
    trace = record_epoch(env, agent, 5)
    assert not trace.modules.responsibility.any()
    assert not trace.modules.prior.any()
    assert not trace.learned.any()
    np.testing.assert_array_equal(trace.action, np.clip(trace.feedback, -1, 1))


@pytest.mark.parametrize("kind", KINDS)
def test_which_modules_are_enabled_is_a_copy(
    env: Any, learned: dict[str, State], kind: str
) -> None:
    agent = trained(env, learned, kind)
    np.testing.assert_array_equal(agent.enabled_modules, [True] * MODULES)
    agent.set_enabled_modules(np.array([True, False, True, True]))
    np.testing.assert_array_equal(agent.enabled_modules, [True, False, True, True])
    agent.enabled_modules[:] = False  # a copy
    np.testing.assert_array_equal(agent.enabled_modules, [True, False, True, True])


def imitated(env: Any, agent: Any, masks: dict[int, Any], *, steps: int = 60) -> list[Any]:
    """Return λ, prior, module actions and action of each step; masks are given by their step.

    The arms are driven by a controller of their own, so that they move alike whatever is off.
    """
    env.task.episode = 7
    agent.reset(7)
    timestep, driver = env.reset(), make_agent(env, kind="resolved_rate")
    found = []
    for step in range(steps):
        for mask in masks.get(step, ()):
            agent.set_enabled_modules(mask)
        executed = driver.act(timestep.observation)
        action = agent.act(timestep.observation, executed=executed)
        found.append(
            (agent.responsibility, *(agent._steps.last(n) for n in ("prior", "module_actions")))
        )
        found[-1] = (*(part.copy() for part in found[-1]), action)
        timestep = env.step(executed)
    return found


ALL, WITHOUT_0 = [True] * MODULES, [False, True, True, True]


def assert_alike(found: list[Any], expected: list[Any]) -> None:
    for step, (one, other) in enumerate(zip(found, expected, strict=True)):
        for part, same in zip(one, other, strict=True):
            np.testing.assert_array_equal(part, same, err_msg=f"step {step}")


@pytest.mark.parametrize("off", [WITHOUT_0, [False] * MODULES])
@pytest.mark.parametrize("kind", KINDS)
def test_a_mask_that_is_taken_away_before_the_next_step_changes_no_bit(
    env: Any, learned: dict[str, State], kind: str, off: list[bool]
) -> None:
    expected = imitated(env, trained(env, learned, kind), {})
    found = imitated(env, trained(env, learned, kind), dict.fromkeys((0, 20, 40), (off, ALL)))
    assert_alike(found, expected)


@pytest.mark.parametrize("off", [WITHOUT_0, [False] * MODULES])
@pytest.mark.parametrize("kind", KINDS)
def test_a_module_that_is_on_again_is_as_if_it_had_never_been_off(
    env: Any, learned: dict[str, State], kind: str, off: list[bool]
) -> None:
    expected = imitated(env, trained(env, learned, kind), {})
    found = imitated(env, trained(env, learned, kind), {20: (off,), 35: (ALL,)})
    assert_alike(found[:20] + found[35:], expected[:20] + expected[35:])
    disabled = ~np.array(off)
    for responsibility, prior, module_actions, action in found[20:35]:
        assert not responsibility[disabled].any()
        assert not prior[disabled].any()
        assert responsibility.sum() == pytest.approx(float(any(off)))
        assert module_actions[disabled].any()  # they go on
        assert np.isfinite(action).all()


@pytest.mark.parametrize("kind", KINDS)
def test_another_module_leads_a_label_whose_module_is_switched_off_in_an_episode(
    env: Any, learned: dict[str, State], kind: str
) -> None:
    whole = imitated(env, trained(env, learned, kind), {})
    leading = int(whole[30][0].argmax())
    mask = [module != leading for module in range(MODULES)]
    part = imitated(env, trained(env, learned, kind), {30: (mask,)})
    assert_alike(part[:30], whole[:30])
    other = int(part[30][0].argmax())
    assert other != leading
    assert part[30][0][other] > max(whole[30][0][other], 1.0 / MODULES)


@pytest.mark.parametrize(
    "mask", [[True] * 3, [True] * 5, [], True, ["on"] * 4, [0.5] * 4, [[True], [True, False]]]
)
@pytest.mark.parametrize("kind", ["mpma", "hammer"])
def test_a_mask_of_other_modules_is_refused(
    env: Any, learned: dict[str, State], kind: str, mask: Any
) -> None:
    with pytest.raises(BadOptionError, match="expected 4 truth values, one for each module"):
        trained(env, learned, kind).set_enabled_modules(mask)


def test_without_a_pair_of_hammer_the_others_keep_their_labels(env: Any) -> None:
    agent = made(env, "hammer")
    agent.set_enabled_modules([True, False, True, True])
    trace = record_epoch(env, agent, 0)
    label = trace.context[:-1].argmax(axis=1)
    for own, row in enumerate([[1, 0, 0, 0], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]):
        assert (trace.modules.responsibility[label == own] == row).all()
        assert (label == own).any()
    agent.learn()
    # No pair learns from the label of the one that is off.
    assert not agent._readouts.forward.weights[1].any()
    assert agent._readouts.forward._steps.tolist() == [
        (label == own).sum() if own != 1 else 0 for own in range(4)
    ]


def test_inside_all_wrappers_is_the_agent_with_paired_models(env: Any) -> None:
    inner = make_agent(env, dataclasses.replace(SMALL, modules=2))
    heard = AlteredContext(inner, "nothing", env.task.context, env.task.period, 0)
    assert (
        paired_models_of(inner)
        is paired_models_of(heard)
        is paired_models_of(Frozen(heard))
        is inner
    )
    with pytest.raises(
        BadOptionError, match="agent is 'FeedbackOnly'; expected an agent with forward models"
    ):
        paired_models_of(Frozen(make_agent(env, kind="feedback_only")))
