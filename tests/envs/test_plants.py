"""Plants that change unannounced: schedule, switches, both kinds of environments, bad input."""

import copy
import json
import pickle
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from dm_control.rl import control
from numpy.typing import NDArray

from mpma_mj.envs.gym_env import ImitationEnv
from mpma_mj.envs.load import load
from mpma_mj.envs.make_vec import make_vec
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.envs.plants import Plant
from mpma_mj.envs.schedules import PlantSchedule
from mpma_mj.errors import BadOptionError
from tests.envs.user_models import edited

PLANTS: list[dict[str, float]] = [
    {},
    {"payload": 3.0},
    {"actuator_gain": 0.6, "damping": 2.0},
    {"actuator_gain": 1.5, "actuator_strength": 0.4},
]
GAINS: list[dict[str, float]] = [{}, {"actuator_gain": 0.5}, {"actuator_gain": 1.5}]
OFTEN = (0.1, 0.4)
RATE = 20.0

Array = NDArray[np.float64]


def actions(steps: int, *batch: int, seed: int = 0) -> Array:
    """Return actions that wander, some beyond the bounds."""
    rng = np.random.default_rng(seed)
    return rng.uniform(-1.0, 1.0, (steps, *batch, 8)).cumsum(axis=0).clip(-1.2, 1.2)


def plants_of(env: control.Environment, steps: int) -> list[int]:
    """Return the plant at the beginning of an episode and after each step."""
    env.reset()
    return [env.task.plant] + [
        env.task.plant for action in actions(steps) if not env.step(action).last()
    ]


def dwells(schedule: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return the steps from each change to the next."""
    return np.diff(np.flatnonzero(np.diff(schedule)))


def schedule(
    number: int = 4, low: float = 0.1, high: float = 0.4, seed: int = 0, episode: int = 0
) -> NDArray[np.intp]:
    plants = tuple(Plant(payload=float(mass)) for mass in range(number))
    options = EnvironmentOptions(plants=plants, switch_every=(low, high))
    drawn = PlantSchedule(options, RATE).draw(seed, episode, 0, 4000)
    assert drawn is not None
    return drawn


def test_equal_seeds_have_equal_schedules_and_others_do_not() -> None:
    np.testing.assert_array_equal(schedule(seed=3), schedule(seed=3))
    assert not np.array_equal(schedule(seed=3), schedule(seed=4))
    assert not np.array_equal(schedule(episode=0), schedule(episode=1))
    one, other = (load("ymca", repeats=1, plants=PLANTS, switch_every=OFTEN) for _ in range(2))
    assert plants_of(one, 60) == plants_of(other, 60)


@pytest.mark.parametrize(
    ("low", "high", "steps"), [(0.1, 0.4, range(2, 9)), (0.26, 0.34, [6]), (0.3, 0.3, [6])]
)
def test_every_time_between_two_switches_is_in_the_range(
    low: float, high: float, steps: Any
) -> None:
    found = dwells(schedule(low=low, high=high))
    assert sorted(set(found.tolist())) == list(steps)
    assert (found / RATE >= low - 1e-9).all()
    assert (found / RATE <= high + 1e-9).all()


def test_any_plant_begins_and_any_other_follows_with_equal_probability() -> None:
    drawn = np.concatenate([schedule(episode=k) for k in range(20)])
    followed = np.zeros((4, 4))
    np.add.at(followed, (drawn[:-1], drawn[1:]), 1.0)
    np.fill_diagonal(followed, 0.0)
    shares = followed / followed.sum(axis=1, keepdims=True)
    np.testing.assert_allclose(shares[~np.eye(4, dtype=bool)], 1.0 / 3.0, atol=0.02)
    first = np.bincount([schedule(episode=k)[0] for k in range(200)], minlength=4)
    assert first.min() > 30


def test_two_plants_alternate() -> None:
    drawn = schedule(number=2)
    assert set(np.abs(np.diff(drawn))) == {0, 1}
    assert len(dwells(drawn)) > 500


def test_an_episode_that_starts_later_has_whole_times_too() -> None:
    options = EnvironmentOptions(plants=PLANTS, switch_every=(0.2, 0.2))  # type: ignore[arg-type]
    drawn = PlantSchedule(options, RATE).draw(0, 0, 3, 40)
    assert drawn is not None
    assert len(set(drawn[:7])) == 1
    np.testing.assert_array_equal(np.flatnonzero(np.diff(drawn)), np.arange(6, 39, 4))


def test_without_switches_plants_take_turns_by_episodes() -> None:
    env = load("ymca", arms="kinematic", repeats=1, plants=GAINS, epochs_per_plant=2)
    found = [set(plants_of(env, 30)) for _ in range(8)]
    assert found == [{0}, {0}, {1}, {1}, {2}, {2}, {0}, {0}]
    env.task.episode = 5
    env.reset()
    assert env.task.plant == 2
    with_default = load("ymca", plants=[{}, {"payload": 1.0}])
    assert [plants_of(with_default, 1)[0] for _ in range(4)] == [0, 0, 0, 1]


def switches(env: control.Environment, steps: int = 80) -> Iterator[tuple[int, Array]]:
    """Yield the plant at each step and the next action, which is taken afterwards."""
    env.reset()
    for action in actions(steps):
        yield env.task.plant, action
        env.step(action)


@pytest.mark.parametrize("options", [{}, {"collisions": True}, {"gravity_compensation": True}])
def test_arms_move_exactly_as_those_that_always_were_the_plant(options: dict[str, Any]) -> None:
    env = load("ymca", repeats=1, plants=PLANTS, switch_every=OFTEN, **options)
    alone = [load("ymca", repeats=1, **options, **plant) for plant in PLANTS]
    for other in alone:
        other.reset()
    seen = set()
    for plant, action in switches(env):
        other = alone[plant].physics
        angles, velocities = env.physics.joint_angles(), env.physics.joint_velocities()
        other.set_joint_state(angles, velocities)
        other.set_control(np.clip(action, -1.0, 1.0) * env.task.max_joint_speed)
        other.step(10)
        env.physics.set_control(np.clip(action, -1.0, 1.0) * env.task.max_joint_speed)
        env.physics.step(10)
        np.testing.assert_array_equal(env.physics.joint_angles(), other.joint_angles())
        np.testing.assert_array_equal(env.physics.joint_velocities(), other.joint_velocities())
        env.physics.set_joint_state(angles, velocities)
        seen.add(plant)
    assert seen == {0, 1, 2, 3}


def test_a_switch_leaves_state_and_positions_as_they_are() -> None:
    physics = load("ymca", plants=PLANTS, switch_every=OFTEN).physics
    physics.set_joint_state(np.linspace(0.1, 0.8, 8), np.linspace(-3.0, 3.0, 8))
    kept = copy.deepcopy([physics.data.ptr.qpos, physics.data.ptr.qvel, physics.posture()])
    masses = set()
    for plant in (1, 0, 3, 2, 1):
        physics.set_plant(plant)
        found = [physics.data.ptr.qpos, physics.data.ptr.qvel, physics.posture()]
        np.testing.assert_array_equal(np.concatenate(found), np.concatenate(kept))
        masses.add(float(physics.model.body_mass.sum()))
    assert len(masses) == 2


def test_a_live_model_becomes_each_plant_in_all_its_numbers() -> None:
    models = load("ymca", plants=PLANTS, collisions=True).physics.compiled_plants
    sizes = mujoco.mj_sizeModel(models.live)
    for plant in (3, 1, 2, 0):
        models.use(plant)
        live, own = (np.zeros(sizes, np.uint8) for _ in range(2))
        mujoco.mj_saveModel(models.live, None, live)
        mujoco.mj_saveModel(models.models[plant], None, own)
        np.testing.assert_array_equal(live, own)


@pytest.mark.parametrize(
    "options",
    [
        {"plants": PLANTS, "switch_every": OFTEN},
        {"plants": PLANTS, "epochs_per_plant": 1},
        {"plants": PLANTS, "switch_every": OFTEN, "random_start": True, "collisions": True},
        {"plants": PLANTS, "switch_every": OFTEN, "perturbation": (5.0, 60.0), "latency": 1},
        {"plants": GAINS, "switch_every": OFTEN, "arms": "kinematic"},
    ],
    ids=["switched", "in turns", "collisions", "perturbed", "kinematic"],
)
def test_each_of_many_is_a_single_environment_bit_for_bit(options: dict[str, Any]) -> None:
    singles = [load("ymca", repeats=1, seed=4 + i, **options) for i in range(3)]
    envs = make_vec(3, "ymca", repeats=1, seed=4, **options)
    observations, infos = envs.reset()
    timesteps = [single.reset() for single in singles]
    seen = set()
    for action in actions(160, 3):
        for i, (single, timestep) in enumerate(zip(singles, timesteps, strict=True)):
            assert infos["plant"][i] == single.task.plant
            for name, values in timestep.observation.items():
                np.testing.assert_array_equal(observations[name][i], values)
        observations, rewards, *_, infos = envs.step(action)
        timesteps = [s.step(a) for s, a in zip(singles, action, strict=True)]
        assert rewards.tolist() == [timestep.reward or 0.0 for timestep in timesteps]
        assert infos["_plant"].all()
        seen |= set(infos["plant"].tolist())
    assert len(seen) > 1
    envs.close()


def test_a_gain_on_kinematic_arms_is_a_factor_on_the_command() -> None:
    for gain in (0.5, 1.5):
        one, other = (
            load("ymca", arms="kinematic", repeats=1, actuator_gain=g) for g in (gain, 1.0)
        )
        one.reset(), other.reset()
        for action in 0.6 * actions(60).clip(-1.0, 1.0):
            a, b = one.step(action).observation, other.step(gain * action).observation
            np.testing.assert_allclose(a["joint_angles"], b["joint_angles"], atol=1e-12)
            np.testing.assert_allclose(a["joint_velocities"], b["joint_velocities"], atol=1e-9)


def test_velocity_actuators_aim_at_gain_times_the_command() -> None:
    env = load("ymca", gravity_compensation=True, actuator_gain=1.5)
    env.reset()
    env.physics.set_joint_state(np.zeros(8), np.zeros(8))
    env.physics.set_control(np.array([0, 0, 20.0, 0] * 2))  # rotation, at its top speed
    env.physics.step(100)
    kv, damping = 20.0, 0.3
    expected = 1.5 * 20.0 * kv / (kv + damping)  # of the hanging arm, which nothing else turns
    np.testing.assert_allclose(env.physics.joint_velocities()[[2, 6]], expected, rtol=0.01)


def test_damping_is_added_to_each_joint() -> None:
    bare, damped = (load("ymca", damping=d).physics.model.dof_damping for d in (0.0, 2.5))
    np.testing.assert_allclose(damped - bare, 2.5)


def test_plants_replace_the_environments_own_options() -> None:
    options = EnvironmentOptions(
        payload=2.0,
        damping=1.0,
        plants=({}, {"payload": 0.5}),  # type: ignore[arg-type]
        switch_every=(1, 2),
    )
    assert [(own.payload, own.damping) for own in options.of_plants()] == [(2.0, 1.0), (0.5, 1.0)]
    assert [own.plants for own in options.of_plants()] == [None, None]
    assert EnvironmentOptions().of_plants() == (EnvironmentOptions(),)


@pytest.mark.parametrize("arms", ["physics", "kinematic"])
def test_a_plant_is_never_observed(arms: str) -> None:
    bare = load("ymca", arms=arms)  # type: ignore[arg-type]
    env = load("ymca", arms=arms, plants=GAINS, switch_every=OFTEN)  # type: ignore[arg-type]
    assert env.observation_spec() == bare.observation_spec()
    assert env.action_spec() == bare.action_spec()
    first = bare.reset().observation
    assert {tuple(env.reset().observation) for _ in range(3)} == {tuple(first)}
    for gain in GAINS:
        env = load("ymca", arms=arms, plants=[gain])  # type: ignore[arg-type]
        for name, values in env.reset().observation.items():
            np.testing.assert_array_equal(values, first[name])


def test_without_plants_nothing_is_said_of_them() -> None:
    env = ImitationEnv("ymca", repeats=1)
    assert "plant" not in env.reset()[1]
    assert load("ymca").task.plant is None
    envs = make_vec(2, "ymca", repeats=1)
    assert "plant" not in envs.reset()[1]
    assert envs.plant is None
    envs.close()


def test_a_copy_of_gymnasiums_environment_continues_as_the_same_plant() -> None:
    env = ImitationEnv("ymca", plants=PLANTS, switch_every=OFTEN)
    plant, seen = env.reset(seed=3)[1]["plant"], set()
    for action in actions(80):
        again = pickle.loads(pickle.dumps(env)) if plant not in seen else None
        seen.add(plant)
        one = env.step(action)
        plant = one[-1]["plant"]
        if again is not None:
            other = again.step(action)
            np.testing.assert_array_equal(one[0]["joint_angles"], other[0]["joint_angles"])
            assert one[-1] == other[-1]
    assert seen == {0, 1, 2, 3}


def test_an_own_model_may_change_its_plant(tmp_path: Path) -> None:
    path = edited(tmp_path / "arms.xml")
    env = load("ymca", robot=path, repeats=1, plants=PLANTS, switch_every=OFTEN)
    assert len(set(plants_of(env, 60))) > 1


def test_plants_are_kept_as_plain_immutable_values() -> None:
    given = [{}, {"payload": np.float32(3)}]
    options = EnvironmentOptions(plants=given, switch_every=[1, np.float64(3)])  # type: ignore[arg-type]
    given[1]["payload"] = np.float32(9)
    assert options.plants == (Plant(), Plant(payload=3.0))
    assert options.switch_every == (1.0, 3.0)
    other = EnvironmentOptions(plants=(Plant(), Plant(payload=3)), switch_every=(1, 3))
    assert options == other
    assert hash(options) == hash(other)
    assert json.dumps(vars(options.plants[1])) != json.dumps(vars(options.plants[0]))
    assert [str(plant) for plant in options.plants] == ["default", "payload=3"]


TWO: list[dict[str, float]] = [{}, {"payload": 3.0}]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"plants": []}, "plants is []; expected options of at least one plant, such as [{}, {'pa"),
        ({"plants": "payload"}, "plants is 'payload'; expected options of at least one plant"),
        ({"plants": {"payload": 3.0}}, "plants is {'payload': 3.0}; expected options of at least"),
        ({"plants": [{}, 3]}, "plants[1] is 3; expected options by name, such as {'payload': 3.0}"),
        ({"plants": [{}, {"paylod": 1}]}, "plants[1] has no option 'paylod'; did you mean payload"),
        (
            {"plants": [{"latency": 1}]},
            "plants[0] has no option 'latency'; expected one or more of pay",
        ),
        (
            {"plants": [{3: 1}]},
            "plants[0] has no option '3'; expected one or more of payload, actuator_g",
        ),
        ({"plants": [{}, {"payload": -1}]}, "plants[1]: payload is -1; expected 0 to 1000, in kg"),
        ({"plants": [{"damping": True}]}, "plants[0]: damping is True; expected 0 to 1000, in N"),
        ({"plants": [{"actuator_gain": 0}]}, "plants[0]: actuator_gain is 0; expected 0.01 to 100"),
        ({"plants": [{}, {}]}, "plants[0] and plants[1] are the same; leave one out of plants"),
        (
            {"payload": 3.0, "plants": [{"damping": 1.0}, *TWO]},
            "plants[1] and plants[2] are the same; leave one out of plants; options not given are",
        ),
        ({"plants": TWO, "switch_every": 2}, "switch_every is 2; expected two times, 0 < low <= h"),
        ({"plants": TWO, "switch_every": (3, 1)}, "switch_every is (3, 1); expected two times"),
        ({"plants": TWO, "switch_every": (0, 1)}, "switch_every is (0, 1); expected two times"),
        ({"plants": TWO, "switch_every": (1, np.nan)}, "switch_every is (1, nan); expected two"),
        ({"plants": TWO, "switch_every": (1, 2, 3)}, "switch_every is (1, 2, 3); expected two"),
        (
            {"plants": TWO, "switch_every": (0.01, 1.0)},
            "switch_every is (0.01, 1.0); expected a range from 0.05 s up, one control step, with",
        ),
        ({"plants": TWO, "switch_every": (0.06, 0.09)}, "switch_every is (0.06, 0.09); expected a"),
        (
            {"plants": [{}], "switch_every": (1, 2)},
            "switch_every is (1.0, 2.0); that needs two plants or more: add some to plants, or lea",
        ),
        (
            {"switch_every": (1, 2)},
            "switch_every is (1.0, 2.0); give plants too, or leave switch_every out",
        ),
        (
            {"epochs_per_plant": 4},
            "epochs_per_plant is 4; give plants too, or leave epochs_per_plant out",
        ),
        ({"plants": TWO, "epochs_per_plant": 0}, "epochs_per_plant is 0; expected a whole number"),
        (
            {"arms": "kinematic", "plants": TWO},
            "plants[1]: payload is 3.0; ideal arms have no mass: leave payload out, or choose arms",
        ),
        ({"arms": "kinematic", "damping": 1.0}, "damping is 1.0; ideal arms have no mass: leave"),
        ({"damping": -1}, "damping is -1; expected 0 to 1000, in N m s/rad"),
        ({"actuator_gain": "high"}, "actuator_gain is 'high'; expected 0.01 to 100"),
    ],
)
def test_bad_plants_are_one_line(options: dict[str, Any], message: str) -> None:
    for make in (load, lambda *words, **given: make_vec(2, *words, **given)):
        with pytest.raises(BadOptionError) as caught:
            make("ymca", **options)
        assert str(caught.value).startswith(message)
        assert "\n" not in str(caught.value)
