"""Recruitment of plants in training: what the modules of each learn, in batches and alone."""

import dataclasses
from typing import Any

import numpy as np
import pytest

from mpma_mj import MPMAConfig, load, make_agent, make_vec
from mpma_mj.training.rollout import record_epoch

Array = np.ndarray
State = dict[str, Array]

SMALL = MPMAConfig(nodes=10, modules=3, max_plants=3)
ONE: dict[str, Any] = {"arms": "kinematic", "repeats": 1}
OF_PLANTS = {  # how many each plant has
    "plants.gram": 1,
    "plants.moment": 1,
    "plants.weights": 1,
    "state_models.weights": 1,
    "inverse.weights": 3,
    "forward.weights": 3,
    "variance": 3,
}
TWO: dict[str, Any] = ONE | {"plants": [{}, {"actuator_gain": 0.5}], "epochs_per_plant": 3}


def trained(env: Any, epochs: int, config: MPMAConfig = SMALL, **options: Any) -> Any:
    agent = make_agent(env, config, **options)
    for epoch in range(epochs):
        record_epoch(env, agent, epoch)
        agent.learn()
    return agent


def made(options: dict[str, Any]) -> tuple[Any, dict[str, Any]]:
    """Return an agent and the environment for which it is made, of options of both."""
    own = {name: value for name, value in options.items() if name != "latency"}
    env = ONE | {"lookahead": 2, "latency": options.get("latency", 0)}
    return make_agent(load("ymca", **env), dataclasses.replace(SMALL, **own)), env


@pytest.fixture(scope="module")
def two_plants() -> State:
    """Return the state of a run after three epochs in each of two plants."""
    state: State = trained(load("ymca", **TWO), 6).state_dict()
    assert state["plants.recruited"] == 2
    return state


def test_a_second_plant_has_modules_for_the_same_labels(two_plants: State) -> None:
    division = two_plants["preferences"].argmax(axis=2)
    np.testing.assert_array_equal(division[1], division[0])
    assert len(set(division[0].tolist())) == 3
    np.testing.assert_allclose(two_plants["preferences"][:2].sum(axis=2), 1.0)
    assert not two_plants["preferences"][2].any()


@pytest.mark.parametrize(
    ("options", "late"),
    [({}, False), ({"state_estimate": True}, True), ({"latency": 1}, True)],
)
def test_where_senses_are_late_only_a_plant_that_is_recruited_learns_in_that_epoch(
    options: dict[str, Any], late: bool
) -> None:
    agent, env = made(options)
    for epoch in range(2):
        record_epoch(load("ymca", **env), agent, epoch)
        agent.learn()
    both = {"plants": [{}, {"actuator_gain": 0.3}], "switch_every": (1.0, 2.0)}
    record_epoch(load("ymca", **env, **both), agent, 2)
    before = agent.state_dict()
    agent.learn()
    after = agent.state_dict()
    assert (before["plants.recruited"], after["plants.recruited"]) == (1, 2)
    for name, count in OF_PLANTS.items():
        same = [np.array_equal(after[name][k], before[name][k]) for k in range(count)]
        assert same == count * [late], name
        if name != "variance":  # modules of the new plant have predicted nothing yet
            assert not np.array_equal(after[name][count:], before[name][count:]), name


@pytest.mark.parametrize(
    ("options", "late"),
    [
        ({"latency": (0, 1)}, True),
        ({"latency": 1, "max_latency": 0}, False),
        ({"latency": 1, "max_latency": 0, "state_estimate": True}, True),
    ],
)
def test_recruitment_is_guarded_where_a_latency_is_made_up_for_or_the_state_is_estimated(
    options: dict[str, Any], late: bool
) -> None:
    assert made(options)[0]._gate.models.guarded_recruitment is late


def test_each_plants_modules_learn_in_their_plant_only(two_plants: State) -> None:
    agent = make_agent(load("ymca", **TWO), SMALL)
    agent.load_state_dict(two_plants)
    env = load("ymca", **ONE)  # the first plant
    trace = record_epoch(env, agent, 6)
    assert trace.modules is not None
    assert trace.modules.responsibility.shape[1] == 6
    assert trace.modules.responsibility[3:, :3].sum(axis=1).min() > 0.99
    agent.learn()
    after = agent.state_dict()
    for name in ("inverse.weights", "forward.weights", "variance"):
        change = np.abs(after[name] - two_plants[name]).reshape(9, -1).max(axis=1)
        assert (change[:3] > 0.0).all()
        assert (change[3:] < 1e-6).all(), name


def test_widths_are_those_of_predictions_weighted_with_what_modules_learned() -> None:
    env = load("ymca", **ONE)
    agent = trained(env, 2)
    record_epoch(env, agent, 2)
    predictions = agent._steps.episode()["predictions"].copy()
    outcome = agent._epoch(()).outcome
    steps_before = agent.state_dict()["forward.steps"]
    agent.learn()
    state = agent.state_dict()
    total = (state["forward.steps"] - steps_before)[:3]
    assert total.sum() == pytest.approx(len(outcome))
    # The context has one label at a time, so that most weights are nearly 0 or 1.
    assert ((state["variance"][:3] * total[:, None]).sum(axis=0) > 0).all()
    squares = ((predictions - outcome[:, None]) ** 2).min(axis=1).sum(axis=0)
    assert (squares <= (state["variance"][:3] * total[:, None]).sum(axis=0) + 1e-4 * 75).all()
    np.testing.assert_array_equal(state["variance"][3:], 0.25)  # never used


def assert_same(one: Any, other: Any) -> None:
    assert one.keys() == other.keys()
    for name, value in one.items():
        np.testing.assert_array_equal(other[name], value, err_msg=name)


@pytest.mark.parametrize("modules", [1, 3])
def test_a_batch_equals_each_run_alone_also_where_only_some_have_a_second_plant(
    modules: int,
) -> None:
    config, runs = MPMAConfig(nodes=10, modules=modules, max_plants=3), range(3)
    state = trained(make_vec(3, "ymca", **ONE), 4, config).state_dict()
    other = trained(make_vec(3, "ymca", **TWO), 4, config).state_dict()
    for name, value in state.items():
        value[1] = other[name][1]
    assert state["plants.recruited"].tolist() == [1, 2, 1]
    envs = make_vec(3, "ymca", **TWO)
    together = make_agent(envs, config)
    together.load_state_dict(state)
    envs_alone = [load("ymca", seed=run, **TWO) for run in runs]
    alone = [make_agent(env, config, seed=run) for run, env in enumerate(envs_alone)]
    for run, agent in enumerate(alone):
        agent.load_state_dict({name: value[run] for name, value in state.items()})
    # Back in the first plant, and in the second, which the others recruit now.
    for epoch in (2, 3, 4, 6):
        trace = record_epoch(envs, together, epoch)
        for run, agent in enumerate(alone):
            expected = record_epoch(envs_alone[run], agent, epoch).to_arrays()
            assert_same(expected, trace.of_run(run).to_arrays())
            agent.learn()
        together.learn()
        found = together.state_dict()
        for run, agent in enumerate(alone):
            assert_same(agent.state_dict(), {name: value[run] for name, value in found.items()})
        if epoch == 2:
            assert found["plants.recruited"].tolist() == [1, 2, 1]
    assert found["plants.recruited"].tolist() == [2, 2, 2]


def test_a_copy_of_the_state_continues_to_the_bit(two_plants: State) -> None:
    env = load("ymca", **TWO)
    agent, copy = trained(env, 6), make_agent(env, SMALL)
    copy.load_state_dict(two_plants)
    for epoch in (6, 7, 9):
        expected = record_epoch(env, agent, epoch).to_arrays()
        assert_same(expected, record_epoch(env, copy, epoch).to_arrays())
        assert_same(agent.learn(), copy.learn())
    assert_same(agent.state_dict(), copy.state_dict())


def test_an_agent_with_two_plants_can_return_to_a_state_with_one(two_plants: State) -> None:
    env = load("ymca", **TWO)
    early = trained(env, 3)
    late, state = make_agent(env, SMALL), early.state_dict()
    late.load_state_dict(two_plants)
    record_epoch(env, late, 3)
    late.load_state_dict(state)
    for epoch in (3, 4):  # recruits the plant again
        expected = record_epoch(env, early, epoch).to_arrays()
        assert_same(expected, record_epoch(env, late, epoch).to_arrays())
        early.learn()
        late.learn()
    assert_same(early.state_dict(), late.state_dict())


def test_selected_runs_with_fewer_plants_continue_as_they_would_alone() -> None:
    envs = make_vec(2, "ymca", **TWO)
    state = trained(make_vec(2, "ymca", **ONE), 4).state_dict()
    other = trained(envs, 4).state_dict()
    for name, value in state.items():
        value[0] = other[name][0]
    both, alone = make_agent(envs, SMALL), make_agent(load("ymca", **TWO), SMALL, seed=1)
    both.load_state_dict(state)
    record_epoch(envs, both, 4)
    alone.load_state_dict({name: value[1] for name, value in state.items()})
    both.select_runs(np.array([1]))
    for epoch in (4, 5):
        # One run of the second seed, in a batch of its own.
        left = make_vec(1, "ymca", seed=1, **TWO)
        expected = record_epoch(load("ymca", seed=1, **TWO), alone, epoch).to_arrays()
        assert_same(expected, record_epoch(left, both, epoch).of_run(0).to_arrays())
        both.learn()
        alone.learn()


def test_modules_of_each_plant_can_be_switched_off(two_plants: State) -> None:
    env = load("ymca", **ONE)
    agent: Any = make_agent(env, SMALL)
    agent.load_state_dict(two_plants)
    assert agent.enabled_modules.shape == (6,)
    whole = record_epoch(env, agent, 6)
    agent.set_enabled_modules([True] * 3 + [False] * 3)
    first = record_epoch(env, agent, 6)
    agent.set_enabled_modules([False] * 3 + [True] * 3)
    second = record_epoch(env, agent, 6)
    errors = [np.abs(t.posture - t.reference).mean() for t in (whole, first, second)]
    assert errors[1] < 1.1 * errors[0]
    assert errors[2] > 3.0 * errors[0]
    agent.learn()
    state = agent.state_dict()
    for name in ("inverse.weights", "forward.weights", "preferences"):
        own = slice(0, 3) if name != "preferences" else 0
        np.testing.assert_array_equal(state[name][own], two_plants[name][own])


def test_a_plant_that_is_on_again_is_believed_in_as_if_it_had_never_been_off(
    two_plants: State,
) -> None:
    env = load("ymca", **ONE)

    def beliefs(*masks: tuple[int, list[bool]]) -> list[np.ndarray]:
        agent: Any = make_agent(env, SMALL)
        agent.load_state_dict(two_plants)
        agent.reset(6)
        env.task.episode = 6
        timestep, driver, found = env.reset(), make_agent(env, kind="resolved_rate"), []
        for step in range(50):
            for when, mask in masks:
                if step == when:
                    agent.set_enabled_modules(mask)
            executed = driver.act(timestep.observation)
            agent.act(timestep.observation, executed=executed)
            found.append(agent.responsibility.reshape(2, 3).sum(axis=1))
            timestep = env.step(executed)
        return found

    whole, on = beliefs(), [True] * 6
    for off in ([False] * 3 + [True] * 3, [True] * 3 + [False] * 3, [False] * 6):
        found = beliefs((10, off), (30, on))
        np.testing.assert_array_equal(found[:10] + found[30:], whole[:10] + whole[30:])
        for shares in found[10:30]:
            np.testing.assert_allclose(shares, np.array([off[0], off[3]], float), atol=1e-12)
        np.testing.assert_array_equal(beliefs((10, off), (10, on)), whole)


@pytest.mark.parametrize("off", [[True] * 3 + [False] * 3, [False] * 3 + [True] * 3])
def test_switching_modules_in_an_episode_of_a_batch_equals_that_of_each_run(
    off: list[bool],
) -> None:
    envs = make_vec(2, "ymca", **TWO)
    state = trained(make_vec(2, "ymca", **ONE), 4).state_dict()  # of one plant
    both_plants = trained(envs, 4).state_dict()
    for name, value in state.items():
        value[0] = both_plants[name][0]
    agents: list[Any] = [make_agent(envs, SMALL)]
    agents[0].load_state_dict(state)
    for run in range(2):
        agents.append(make_agent(load("ymca", **TWO), SMALL, seed=run))
        agents[-1].load_state_dict({name: value[run] for name, value in state.items()})
    observations, driver = [], make_agent(envs, kind="resolved_rate")
    observation, _ = envs.reset()
    for agent in agents:
        agent.reset(0)
    for step in range(30):
        observations.append(observation)
        executed = driver.act(observation)
        for agent, own in zip(agents, (slice(None), 0, 1), strict=True):
            number = len(agent.enabled_modules)
            if step in (10, 20):
                agent.set_enabled_modules((off if step == 10 else [True] * 6)[:number])
            mine = {name: array[own] for name, array in observation.items()}
            agent.act(mine, executed=executed[own])
        together = agents[0].responsibility
        for run, agent in enumerate(agents[1:]):
            alone = agent.responsibility
            np.testing.assert_array_equal(together[run, : len(alone)], alone, err_msg=str(step))
            assert not together[run, len(alone) :].any()
        observation, *_ = envs.step(executed)
