"""Latency that is a range: schedule, acting commands, both kinds of environments, bad input."""

import copy
import json
import pickle
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from mpma_mj.envs.gym_env import ImitationEnv
from mpma_mj.envs.load import load
from mpma_mj.envs.make_vec import make_vec
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.envs.schedules import LatencySchedule
from mpma_mj.envs.step_rules import delayed
from mpma_mj.errors import BadOptionError

RATE = 20.0
OFTEN = (0.1, 0.4)
JUMPING: dict[str, Any] = {"latency": (0, 5), "latency_every": OFTEN}

Array = NDArray[np.float64]


def actions(steps: int, *batch: int, seed: int = 0) -> Array:
    """Return actions that wander, some beyond the bounds."""
    rng = np.random.default_rng(seed)
    return rng.uniform(-1.0, 1.0, (steps, *batch, 8)).cumsum(axis=0).clip(-1.2, 1.2)


def schedule(
    seed: int = 0, episode: int = 0, start: int = 0, steps: int = 2000, **options: Any
) -> NDArray[np.intp]:
    chosen = EnvironmentOptions(**(options or JUMPING))
    drawn = LatencySchedule(chosen, RATE).draw(seed, episode, start, steps)
    assert drawn is not None
    return drawn


@pytest.mark.parametrize("latency", [(0, 5), (2, 3), (4, 4), (7, 60)])
def test_an_episode_has_one_latency_of_the_range(latency: tuple[int, int]) -> None:
    drawn = np.array([schedule(episode=k, steps=50, latency=latency) for k in range(300)])
    assert (drawn == drawn[:, :1]).all()
    found = np.bincount(drawn[:, 0] - latency[0], minlength=latency[1] - latency[0] + 1)
    assert len(found) == latency[1] - latency[0] + 1
    if len(found) < 10:
        assert found.min() > 200 // len(found)  # uniform


def test_jumps_lead_to_any_other_value_of_the_range_after_times_of_the_range() -> None:
    drawn = np.concatenate([schedule(episode=k) for k in range(10)])
    assert set(drawn) == set(range(6))
    jumps = np.flatnonzero(np.diff(schedule()))
    assert set(np.diff(jumps)) == set(range(2, 9))
    followed = np.zeros((6, 6))
    np.add.at(followed, (drawn[:-1], drawn[1:]), 1.0)
    np.fill_diagonal(followed, 0.0)
    shares = followed / followed.sum(axis=1, keepdims=True)
    np.testing.assert_allclose(shares[~np.eye(6, dtype=bool)], 0.2, atol=0.05)


def test_equal_seeds_and_episodes_have_equal_schedules_and_others_do_not() -> None:
    np.testing.assert_array_equal(schedule(seed=3, episode=2), schedule(seed=3, episode=2))
    assert not np.array_equal(schedule(seed=3), schedule(seed=4))
    assert not np.array_equal(schedule(episode=0), schedule(episode=1))


def test_an_episode_that_starts_later_has_whole_times_too() -> None:
    drawn = schedule(start=3, steps=40, latency=(0, 5), latency_every=(0.2, 0.2))
    np.testing.assert_array_equal(np.flatnonzero(np.diff(drawn)), np.arange(6, 39, 4))


@pytest.mark.parametrize("options", [{"latency": (1, 4)}, JUMPING], ids=["drawn", "jumping"])
@pytest.mark.parametrize("arms", ["physics", "kinematic"])
def test_the_acting_command_is_that_of_so_many_steps_ago(
    arms: Any, options: dict[str, Any]
) -> None:
    late, plain = (load("ymca", arms=arms, repeats=1, **o) for o in (options, {}))
    for _ in range(3):
        late.reset(), plain.reset()
        given: list[Array] = []
        for action in actions(75):  # all steps of an episode
            latency = late.task.latency
            given.append(action)
            acting = given[-1 - latency] if latency < len(given) else np.zeros(8)
            got, expected = late.step(action).observation, plain.step(acting).observation
            np.testing.assert_array_equal(got["joint_velocities"], expected["joint_velocities"])


def test_an_action_acts_twice_where_latency_rises_and_some_never_where_it_falls() -> None:
    pending, acted = np.zeros((2, 8)), []
    for step, latency in enumerate([0, 1, 2, 2, 0, 0]):
        due, pending = delayed(pending, np.full(8, 1.0 + step), np.intp(latency))
        acted.append(due[0])
    assert acted == [1, 1, 1, 2, 5, 6]


def test_a_range_of_one_number_is_that_number_to_the_bit() -> None:
    one, other = (load("ymca", repeats=1, latency=latency) for latency in (2, (2, 2)))
    one.reset(), other.reset()
    for action in actions(60):
        a, b = one.step(action), other.step(action)
        for name, values in a.observation.items():
            np.testing.assert_array_equal(values, b.observation[name])


@pytest.mark.parametrize(
    "options",
    [
        {"latency": (0, 4)},
        JUMPING,
        {**JUMPING, "random_start": True, "perturbation": (5.0, 60.0)},
        {**JUMPING, "plants": [{}, {"payload": 3.0}], "switch_every": OFTEN},
        {**JUMPING, "arms": "kinematic", "termination_distance": 0.5},
    ],
    ids=["drawn", "jumping", "random start", "plants", "kinematic"],
)
def test_each_of_many_is_a_single_environment_bit_for_bit(options: dict[str, Any]) -> None:
    singles = [load("ymca", repeats=1, seed=4 + i, **options) for i in range(3)]
    envs = make_vec(3, "ymca", repeats=1, seed=4, **options)
    observations, infos = envs.reset()
    timesteps = [single.reset() for single in singles]
    seen = set()
    for action in actions(160, 3):
        assert infos["_latency"].all()
        assert envs.latency is not None
        np.testing.assert_array_equal(infos["latency"], envs.latency)
        for i, (single, timestep) in enumerate(zip(singles, timesteps, strict=True)):
            assert infos["latency"][i] == single.task.latency
            for name, values in timestep.observation.items():
                np.testing.assert_array_equal(observations[name][i], values)
        observations, rewards, *_, infos = envs.step(action)
        timesteps = [s.step(a) for s, a in zip(singles, action, strict=True)]
        assert rewards.tolist() == [timestep.reward or 0.0 for timestep in timesteps]
        seen |= set(infos["latency"].tolist())
    assert len(seen) > 1
    envs.close()


def test_a_copy_of_gymnasiums_environment_continues_with_the_same_pending_actions() -> None:
    env = ImitationEnv("ymca", **JUMPING)
    env.reset(seed=3)
    for number, action in enumerate(actions(60)):
        again = None
        if number % 10 == 5:
            again = copy.deepcopy(env) if number % 20 == 5 else pickle.loads(pickle.dumps(env))
        observation, *_, info = env.step(action)
        assert info["latency"] in range(6)
        if again is not None:
            other, *_, same = again.step(action)
            np.testing.assert_array_equal(observation["joint_angles"], other["joint_angles"])
            assert same == info


@pytest.mark.parametrize("arms", ["physics", "kinematic"])
def test_latency_is_never_observed(arms: Any) -> None:
    bare, env = load("ymca", arms=arms), load("ymca", arms=arms, **JUMPING)
    assert env.observation_spec() == bare.observation_spec()
    first, other = bare.reset().observation, env.reset().observation
    for name, values in first.items():
        np.testing.assert_array_equal(values, other[name])


@pytest.mark.parametrize("latency", [0, 3])
def test_of_a_latency_that_is_one_number_nothing_is_said(latency: int) -> None:
    env = ImitationEnv("ymca", latency=latency)
    assert "latency" not in env.reset()[1]
    assert load("ymca", latency=latency).task.latency is None
    envs = make_vec(2, "ymca", latency=latency)
    assert "latency" not in envs.reset()[1]
    assert envs.latency is None
    envs.close()


def test_ranges_are_kept_as_plain_values_and_survive_a_file() -> None:
    options = EnvironmentOptions(
        latency=np.array([0, 5]),  # type: ignore[arg-type]
        latency_every=[1, np.float64(4)],  # type: ignore[arg-type]
    )
    assert (options.latency, options.latency_every) == ((0, 5), (1.0, 4.0))
    again = EnvironmentOptions(**json.loads(json.dumps(vars(options))))
    assert again == options
    assert hash(again) == hash(options)
    assert type(EnvironmentOptions(latency=np.uint8(3)).latency) is int  # type: ignore[arg-type]
    assert [o.longest_latency for o in (options, EnvironmentOptions(latency=7))] == [5, 7]


STEPS = "expected a whole number from 0 to 100, or a range of two, the lowest first"


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"latency": (5, 0)}, f"latency is (5, 0); {STEPS}"),
        ({"latency": (-1, 4)}, f"latency is (-1, 4); {STEPS}"),
        ({"latency": (0, 101)}, f"latency is (0, 101); {STEPS}"),
        ({"latency": (0.5, 4)}, f"latency is (0.5, 4); {STEPS}"),
        ({"latency": (0, True)}, f"latency is (0, True); {STEPS}"),
        ({"latency": (1, 2, 3)}, f"latency is (1, 2, 3); {STEPS}"),
        ({"latency": "3"}, f"latency is '3'; {STEPS}"),
        ({"latency": None}, f"latency is None; {STEPS}"),
        (
            {"latency_every": (1, 2)},
            "latency_every is (1.0, 2.0); that needs a range: give latency",
        ),
        (
            {"latency": 3, "latency_every": (1, 2)},
            "latency_every is (1.0, 2.0); that needs a range",
        ),
        ({"latency": (3, 3), "latency_every": (1, 2)}, "give latency two numbers that differ, or"),
        (
            {"latency": (0, 3), "latency_every": 2},
            "latency_every is 2; expected two times, 0 < low",
        ),
        (
            {"latency": (0, 3), "latency_every": (2, 1)},
            "latency_every is (2, 1); expected two times",
        ),
        (
            {"latency": (0, 3), "latency_every": (0, 1)},
            "latency_every is (0, 1); expected two times",
        ),
        (
            {"latency": (0, 3), "latency_every": (0.01, 1)},
            "latency_every is (0.01, 1.0); expected a range from 0.05 s up, one control step, with",
        ),
        (
            {"latency": (0, 3), "latency_every": (0.06, 0.09)},
            "latency_every is (0.06, 0.09); expect",
        ),
    ],
)
def test_bad_latencies_are_reported_in_one_line(options: dict[str, Any], message: str) -> None:
    with pytest.raises(BadOptionError) as caught:
        load("ymca", **options)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)
    with pytest.raises(BadOptionError, match=f"{next(reversed(options))} is "):
        make_vec(2, "ymca", **options)
