"""Recruitment: when a module is added, and what an agent that grows is."""

import copy
import dataclasses
import math

import hypothesis
import numpy as np
import pytest
from hypothesis import strategies as some

import mpma_mj
from mpma_mj.agents import MPMA, AgentSpec, GrowingConfig, GrowingMPMA, MPMAConfig
from mpma_mj.agents.growing import EPOCHS, LEAST_GAIN, Recruitment, with_added_module
from mpma_mj.agents.learning_rules import Epoch, WeightedRule
from mpma_mj.envs.load import load
from mpma_mj.errors import BadOptionError
from mpma_mj.training.factory import make_agent
from mpma_mj.training.rollout import record_epoch

SMALL = GrowingConfig(nodes=10, modules=4)
PARTS = ("inverse", "forward", "predictor")


def grown(errors: dict[int, float], most: int = 12) -> Recruitment:
    """Return where growth ends if each number of modules has a prediction error of its own."""
    growth = Recruitment()
    for _ in range(EPOCHS * (most + 1)):
        growth = growth.after(errors[growth.modules], most)
    return growth


def numbered(errors: list[float]) -> dict[int, float]:
    return dict(enumerate(errors, start=1))


def test_growth_ends_where_more_modules_do_not_help() -> None:
    growth = grown(numbered([2.0, 1.5, 1.2, *[1.19] * 9]))
    assert growth.over
    assert growth.modules == 3
    assert growth.best_error == pytest.approx(1.2)


def test_modules_that_never_help_leave_one() -> None:
    assert grown(numbered([1.0] * 12)).modules == 1


def test_growth_that_always_helps_ends_at_the_largest_number() -> None:
    assert grown(numbered([0.5**n for n in range(12)])).modules == 12
    assert grown({1: 2.0}, most=1).modules == 1


def test_the_first_module_that_does_not_help_ends_growth() -> None:
    assert grown(numbered([2.0, 2.0, *[1.0] * 10])).modules == 1


def test_help_is_a_share_of_the_error() -> None:
    enough, too_little = 1.0 - 1.01 * LEAST_GAIN, 1.0 - 0.99 * LEAST_GAIN
    assert grown(numbered([1.0, enough, *[9.0] * 10])).modules == 2
    assert grown(numbered([1.0, too_little, *[9.0] * 10])).modules == 1


def test_the_first_epoch_of_a_number_does_not_count() -> None:
    growth = Recruitment()
    for error in [99.0, *[1.0] * (EPOCHS - 1)]:
        growth = growth.after(error, 12)
    assert growth.modules == 2
    assert growth.best_error == pytest.approx(1.0)


@hypothesis.given(
    some.lists(some.floats(0.01, 100.0), min_size=60, max_size=60), some.integers(1, 9)
)
def test_for_any_errors_growth_ends_at_an_allowed_number(errors: list[float], most: int) -> None:
    growth = Recruitment()
    for error in errors:
        growth = growth.after(error, most)
        assert 1 <= growth.modules <= most
        assert Recruitment.of_row(growth.as_row()) == growth
    assert growth.over
    assert growth.after(0.0, most) == growth


def test_the_first_state_can_be_read_from_its_row() -> None:
    assert Recruitment.of_row(Recruitment().as_row()) == Recruitment()
    assert Recruitment().best_error == math.inf


def agent(enabled: int, **changes: object) -> GrowingMPMA:
    """Return an agent of which so many modules are enabled."""
    own = GrowingMPMA(dataclasses.replace(SMALL, **changes), AgentSpec(4, np.full(8, 12.0), 0.05))
    state = own.state_dict()
    own.load_state_dict(state | {"growth": Recruitment(modules=enabled).as_row()})
    return own


@pytest.mark.parametrize("changes", [{}, {"responsibility_predictors": False}])
@pytest.mark.parametrize("enabled", [1, 2, 4])
def test_enabled_modules_share_all_responsibility(enabled: int, changes: dict[str, bool]) -> None:
    env = load("ymca", arms="kinematic", repeats=1)
    dancer = agent(enabled, **changes)
    trace = record_epoch(env, dancer, 0)
    np.testing.assert_allclose(trace.modules.responsibility.sum(axis=1), 1.0)
    assert (trace.modules.responsibility[:, :enabled] > 0.0).all()
    assert (trace.modules.responsibility[:, enabled:] == 0.0).all()
    action = np.einsum("tm,tmj->tj", trace.modules.responsibility, trace.modules.module_actions)
    gains = dancer.gains
    mixed = np.clip(gains.inverse * action + trace.feedback, -1.0, 1.0)
    np.testing.assert_allclose(trace.action, mixed, atol=1e-12)


def test_with_all_modules_enabled_it_is_mpma() -> None:
    env = load("ymca", arms="kinematic", repeats=1)
    plain = MPMA(MPMAConfig(nodes=10, modules=4), AgentSpec(4, env.task.max_joint_speed, 0.05))
    growing = agent(4)
    growing.spec = plain.spec
    for epoch in range(2):
        traces = [record_epoch(env, own, epoch) for own in (plain, growing)]
        np.testing.assert_array_equal(traces[0].action, traces[1].action)
        for own in (plain, growing):
            own.learn()
        env.task.episode = 0


def trained(
    epochs: int, seed: int = 0, most: int = 3
) -> tuple[GrowingMPMA, list[dict[str, np.ndarray]]]:
    env = load("ymca", arms="kinematic", repeats=1)
    dancer = make_agent(env, dataclasses.replace(SMALL, modules=most), kind="growing", seed=seed)
    assert isinstance(dancer, GrowingMPMA)
    logged = []
    for epoch in range(epochs):
        record_epoch(env, dancer, epoch)
        logged.append(dancer.learn())
    return dancer, logged


def test_growth_begins_with_one_module_when_control_has_passed() -> None:
    _, logged = trained(16)
    enabled = [row["modules_enabled"] for row in logged]
    passed = [row["gain_inverse"] for row in logged].index(1.0)
    assert enabled[: passed + EPOCHS] == [1.0] * (passed + EPOCHS)
    assert enabled[passed + EPOCHS] == 2.0
    assert logged[0]["growing"] == 1.0


def test_growth_ends_and_is_repeatable() -> None:
    one, logged = trained(30)
    other, _ = trained(30)
    assert logged[-1]["growing"] == 0.0
    assert one.enabled.sum() == logged[-1]["modules_enabled"]
    for name, value in one.state_dict().items():
        np.testing.assert_array_equal(value, other.state_dict()[name], err_msg=name)


def test_only_enabled_modules_learn() -> None:
    dancer, logged = trained(8)
    assert logged[-1]["modules_enabled"] == 1.0
    state = dancer.state_dict()
    for part in ("inverse", "forward"):
        assert np.any(state[f"{part}.gram"][0])
        assert not np.any(state[f"{part}.gram"][1:])
        assert not np.any(state[f"{part}.weights"][1:])


def test_a_recruitment_that_did_not_help_is_undone() -> None:
    env = load("ymca", arms="kinematic", repeats=1)
    dancer, _ = trained(12)
    learned = dancer.state_dict()
    helped = {name.removeprefix("helped."): v for name, v in learned.items() if "helped." in name}
    last_chance = Recruitment(2, EPOCHS - 1, 999.0, 1.0)
    dancer.load_state_dict(learned | {"growth": last_chance.as_row()})
    record_epoch(env, dancer, 12)
    dancer.learn()
    now = dancer.state_dict()
    assert Recruitment.of_row(now["growth"]) == Recruitment(1, best_error=1.0, over=True)
    for name, value in helped.items():
        np.testing.assert_array_equal(now[name], value, err_msg=name)
    assert not np.array_equal(learned["forward.weights"], now["forward.weights"])


def episode(steps: int = 6, modules: int = 3) -> Epoch:
    """Return an epoch of two labels, of which the second is predicted badly by module 1."""
    rng = np.random.default_rng(0)
    label = np.arange(steps) >= steps // 2
    posture = rng.random((steps, 12))
    predictions = np.repeat(posture[:, None], modules, axis=1)
    predictions[label] += 0.5
    return Epoch(
        **{f"{part}_features": rng.random((steps, modules, 4)) for part in PARTS},
        **{name: rng.random((steps, 8)) for name in ("action", "feedback", "next_feedback")},
        context=np.eye(2)[label.astype(int)],
        responsibility=np.eye(modules)[np.zeros(steps, int)],
        predictions=predictions,
        next_posture=posture,
        module_actions=rng.random((steps, modules, 8)),
        prior=rng.random((steps, modules)),
        feedback_gain=0.3,
    )


def test_a_new_module_gets_half_of_the_label_that_is_predicted_worst() -> None:
    before = episode()
    after = with_added_module(before, 1)
    np.testing.assert_array_equal(after.responsibility[:3], before.responsibility[:3])
    np.testing.assert_array_equal(after.responsibility[3:], [[0.5, 0.5, 0.0]] * 3)


def test_a_new_module_begins_with_the_common_output_and_leaves_the_others() -> None:
    before = episode()
    kept = copy.deepcopy(before)
    after = with_added_module(before, 2)
    for name in ("module_actions", "predictions"):
        replaced, own = getattr(after, name), getattr(before, name)
        np.testing.assert_array_equal(replaced[:, :2], own[:, :2])
        np.testing.assert_allclose(replaced[:, 2], own[:, 0])  # whose λ is 1
    for name, value in vars(before).items():
        np.testing.assert_array_equal(value, getattr(kept, name))


def test_without_context_a_new_module_gets_half_of_all() -> None:
    silent = dataclasses.replace(episode(), context=np.zeros((6, 2)))
    np.testing.assert_array_equal(with_added_module(silent, 1).responsibility, [[0.5, 0.5, 0]] * 6)


def test_an_epoch_of_the_first_modules_has_their_signals_only() -> None:
    cut = episode().first_modules(2)
    assert cut.responsibility.shape == (6, 2)
    assert cut.predictions.shape == (6, 2, 12)
    assert cut.forward_features.shape == (6, 2, 4)
    assert cut.next_posture.shape == (6, 12)


def test_growth_in_a_batch_is_growth_alone() -> None:
    seeds = [3, 5]
    envs = mpma_mj.make_vec(2, "ymca", arms="kinematic", repeats=1)
    envs.reset(seed=seeds)
    config = dataclasses.replace(SMALL, modules=2)
    together = make_agent(envs, config, kind="growing", seed=seeds)
    assert isinstance(together, GrowingMPMA)
    for epoch in range(14):
        record_epoch(envs, together, epoch)
        together.learn()
    together.select_runs(np.array([1]))
    env = load("ymca", arms="kinematic", repeats=1, seed=5)
    alone = make_agent(env, config, kind="growing", seed=5)
    for epoch in range(14):
        record_epoch(env, alone, epoch)
        alone.learn()
    for name, value in alone.state_dict().items():
        np.testing.assert_array_equal(together.state_dict()[name][0], value, err_msg=name)
    assert alone.state_dict()["growth"][0] == 2


def test_a_rule_that_learns_at_every_step_does_not_grow() -> None:
    class Online(WeightedRule):
        online = True

    with pytest.raises(BadOptionError, match=r"rule is .*Online.*; expected a rule that learns af"):
        agent(1, rule=Online())
