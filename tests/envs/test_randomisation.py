"""Options that are drawn for each episode: draws, arms, both kinds of environments, bad input."""

import copy
import json
import pickle
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray

from mpma_mj.envs.gym_env import ImitationEnv
from mpma_mj.envs.load import load
from mpma_mj.envs.make_vec import make_vec
from mpma_mj.envs.options import DRAWN_OPTIONS, EnvironmentOptions
from mpma_mj.envs.plants import PLANT_OPTIONS
from mpma_mj.envs.randomisation import Randomisation
from mpma_mj.errors import BadOptionError
from tests.envs.user_models import edited

ALL: dict[str, Any] = {
    "payload": (0, 3),
    "actuator_gain": (0.6, 1.5),
    "damping": (0, 2),
    "actuator_strength": (0.4, 1),
    "observation_noise": (0, 0.05),
    "reference_noise": (0.01, 0.1),
}
IDEAL = {name: ALL[name] for name in ("actuator_gain", "observation_noise", "reference_noise")}

Array = NDArray[np.float64]


def actions(steps: int, *batch: int, seed: int = 0) -> Array:
    """Return actions that wander, some beyond the bounds."""
    rng = np.random.default_rng(seed)
    return rng.uniform(-1.0, 1.0, (steps, *batch, 8)).cumsum(axis=0).clip(-1.2, 1.2)


def assert_equal(one: Any, other: Any) -> None:
    """Check that numbers are equal to the bit, in tuples and dictionaries."""
    assert [leaf.tobytes() for leaf in leaves(one)] == [leaf.tobytes() for leaf in leaves(other)]


def leaves(numbers: Any) -> list[Array]:
    """Return the arrays and numbers in tuples and dictionaries, as arrays."""
    if isinstance(numbers, dict):
        numbers = tuple(numbers.values())
    if isinstance(numbers, tuple):
        return [leaf for part in numbers for leaf in leaves(part)]
    return [np.array(np.nan if numbers is None else numbers, float)]


def test_options_are_uniform_in_their_ranges() -> None:
    randomisation = Randomisation(EnvironmentOptions(**ALL))
    drawn = np.array([randomisation.draw(0, episode) for episode in range(400)])
    ends = np.array([ALL[name] for name in randomisation.names])
    shares = (drawn - ends[:, 0]) / np.ptp(ends, axis=1)
    assert shares.min() >= 0.0
    assert shares.max() < 1.0
    np.testing.assert_allclose(np.sort(shares, axis=0)[::40].T, [np.arange(10) / 10] * 6, atol=0.12)
    assert np.abs(np.corrcoef(shares.T) - np.eye(6)).max() < 0.2


def test_an_option_depends_on_seed_episode_and_its_name_alone() -> None:
    both, one = (Randomisation(EnvironmentOptions(**o)) for o in (ALL, {"payload": (0, 3)}))
    assert both.by_name(both.draw(3, 7))["payload"] == one.by_name(one.draw(3, 7))["payload"]
    assert one.draw(3, 7) != one.draw(3, 8)
    assert one.draw(3, 7) != one.draw(4, 7)
    env, later = (load("ymca", seed=5, **ALL) for _ in range(2))
    for _ in range(3):
        env.reset()
    later.task.episode = 2
    later.reset()
    assert env.task.drawn == later.task.drawn
    assert env.task.drawn.keys() == set(DRAWN_OPTIONS)


@pytest.mark.parametrize(
    "shared", [{}, {"collisions": True, "gravity_compensation": True}], ids=str
)
@pytest.mark.parametrize("arms", ["physics", "kinematic"])
def test_an_episode_is_that_of_an_environment_with_its_drawn_options(
    arms: Any, shared: dict[str, Any]
) -> None:
    if arms == "kinematic":
        shared = {}
    env = load("ymca", arms=arms, repeats=1, **shared, **(ALL if arms == "physics" else IDEAL))
    for episode in range(3):
        timesteps = [env.reset(), *map(env.step, actions(40))]
        alone = load("ymca", arms=arms, repeats=1, **shared, **env.task.drawn)
        alone.task.episode = episode
        others = [alone.reset(), *map(alone.step, actions(40))]
        for one, other in zip(timesteps, others, strict=True):
            assert one.reward == other.reward
            for name, values in one.observation.items():
                np.testing.assert_array_equal(values, other.observation[name])


@pytest.mark.parametrize("own", [False, True])
def test_a_live_model_has_all_parameters_of_the_episodes_plant(own: bool, tmp_path: Path) -> None:
    shared = {"robot": edited(tmp_path / "arms.xml")} if own else {}
    options = {name: ALL[name] for name in PLANT_OPTIONS} | {"collisions": True}
    env = load("ymca", **options, **shared)
    for _ in range(4):
        env.reset()
        alone = load("ymca", **(options | env.task.drawn), **shared).physics.model.ptr
        found = [np.zeros(mujoco.mj_sizeModel(alone), np.uint8) for _ in range(2)]
        for model, numbers in zip((env.physics.model.ptr, alone), found, strict=True):
            mujoco.mj_saveModel(model, None, numbers)
        np.testing.assert_array_equal(*found)


@pytest.mark.parametrize(
    "options",
    [
        ALL,
        {"payload": (0, 3), "random_start": True, "collisions": True},
        {"payload": (1, 3), "latency": (0, 3), "perturbation": (5.0, 60.0)},
        {"observation_noise": (0, 0.1), "plants": [{}, {"payload": 3.0}], "switch_every": (0.1, 1)},
        {"arms": "kinematic", **IDEAL, "termination_distance": 0.5},
    ],
    ids=["all", "collisions", "perturbed", "plants", "kinematic"],
)
def test_each_of_many_is_a_single_environment_bit_for_bit(options: dict[str, Any]) -> None:
    singles = [load("ymca", repeats=1, seed=4 + i, **options) for i in range(3)]
    envs = make_vec(3, "ymca", repeats=1, seed=4, **options)
    observations, infos = envs.reset()
    timesteps = [single.reset() for single in singles]
    seen: set[float] = set()
    for action in actions(160, 3):
        for i, (single, timestep) in enumerate(zip(singles, timesteps, strict=True)):
            assert {name: infos[name][i] for name in single.task.drawn} == single.task.drawn
            for name, values in timestep.observation.items():
                np.testing.assert_array_equal(observations[name][i], values)
        observations, rewards, *_, infos = envs.step(action)
        timesteps = [s.step(a) for s, a in zip(singles, action, strict=True)]
        assert rewards.tolist() == [timestep.reward or 0.0 for timestep in timesteps]
        for name, numbers in envs.drawn.items():
            np.testing.assert_array_equal(infos[name], numbers)
            assert infos[f"_{name}"].all()
            seen |= set(numbers.tolist())
    assert len(seen) > 6  # each environment has begun two episodes or more
    envs.close()


def test_info_contains_the_drawn_options_of_the_episode() -> None:
    env = ImitationEnv("ymca", repeats=1, payload=(0, 3), observation_noise=(0.0, 0.1))
    found = [env.reset(seed=3)[1]["payload"], env.step(np.zeros(8))[-1]["payload"]]
    assert found[0] == found[1] == env.reset(seed=3)[1]["payload"]
    info = env.reset()[1]
    assert type(info["payload"]) is float
    assert info["payload"] != found[0]
    assert 0.0 <= info["observation_noise"] <= 0.1
    assert "damping" not in info


@pytest.mark.parametrize("numbers", [(0.0, 1.0, 0.0, 1.0, 0.0, 0.01), (2.5, 0.7, 1, 0.5, 0.02, 0)])
def test_a_range_of_equal_ends_is_its_number_bit_for_bit(numbers: tuple[float, ...]) -> None:
    number: dict[str, Any] = dict(zip(ALL, numbers, strict=True))
    single, other = load("ymca", repeats=1, **number), make_vec(2, repeats=1, **number)
    point = {name: (value, value) for name, value in number.items()}
    ranged, others = load("ymca", repeats=1, **point), make_vec(2, repeats=1, **point)
    for _ in range(2):
        assert_equal(single.reset(), ranged.reset())
        assert ranged.task.drawn == number
        for action in actions(30):
            assert_equal(single.step(action), ranged.step(action))
    assert_equal(other.reset()[0], others.reset()[0])
    for action in actions(160, 2):
        assert_equal(other.step(action)[:4], others.step(action)[:4])
    for envs in (other, others):
        envs.close()


def test_info_leaves_out_options_that_are_one_number() -> None:
    assert load("ymca", payload=2.0).task.drawn == {}
    envs = make_vec(2, "ymca", payload=2.0)
    assert envs.drawn == {}
    assert "payload" not in envs.reset()[1]
    envs.close()


def test_drawn_options_are_never_observed() -> None:
    bare, env = load("ymca"), load("ymca", **{name: ALL[name] for name in PLANT_OPTIONS})
    assert env.observation_spec() == bare.observation_spec()
    for name, values in bare.reset().observation.items():
        np.testing.assert_array_equal(values, env.reset().observation[name])
        env.task.episode = 0


def test_a_copy_of_gymnasiums_environment_continues_with_the_same_drawn_options() -> None:
    env = ImitationEnv("ymca", repeats=1, **ALL)
    for _ in range(2):
        env.reset()
    env.step(np.zeros(8))
    for again in (copy.deepcopy(env), pickle.loads(pickle.dumps(env))):
        one, other = copy.deepcopy(env), again
        for action in actions(30):
            mine, its = one.step(action), other.step(action)
            np.testing.assert_array_equal(mine[0]["joint_angles"], its[0]["joint_angles"])
            assert mine[-1] == its[-1]


def test_ranges_are_kept_as_plain_values_and_survive_a_file() -> None:
    options = EnvironmentOptions(payload=np.array([0, 3]), damping=[1, np.float32(2)])  # type: ignore[arg-type]
    assert (options.payload, options.damping) == ((0.0, 3.0), (1.0, 2.0))
    assert options.ranges == {"payload": (0.0, 3.0), "damping": (1.0, 2.0)}
    again = EnvironmentOptions(**json.loads(json.dumps(vars(options))))
    assert again == options
    assert hash(again) == hash(options)


MASS = "expected 0 to 1000, in kg, or a range of two, the lowest first"


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"payload": (3, 0)}, f"payload is (3, 0); {MASS}"),
        ({"payload": (-1, 2)}, f"payload is (-1, 2); {MASS}"),
        ({"payload": (0, 2000)}, f"payload is (0, 2000); {MASS}"),
        ({"payload": (0, np.nan)}, f"payload is (0, nan); {MASS}"),
        ({"payload": (0, True)}, f"payload is (0, True); {MASS}"),
        ({"payload": (0, "3")}, f"payload is (0, '3'); {MASS}"),
        ({"payload": (1,)}, f"payload is (1,); {MASS}"),
        ({"payload": ()}, f"payload is (); {MASS}"),
        ({"payload": (0, 1, 2)}, f"payload is (0, 1, 2); {MASS}"),
        ({"payload": ((0, 1), (2, 3))}, f"payload is ((0, 1), (2, 3)); {MASS}"),
        ({"payload": None}, f"payload is None; {MASS}"),
        ({"actuator_gain": (0, 1)}, "actuator_gain is (0, 1); expected 0.01 to 100, 1 leaves the"),
        ({"actuator_strength": (1, 0.5)}, "actuator_strength is (1, 0.5); expected 0.01 to 100"),
        ({"damping": (-1, 1)}, "damping is (-1, 1); expected 0 to 1000, in N m s/rad, or a range"),
        ({"observation_noise": (0.1, 0)}, "observation_noise is (0.1, 0); expected 0 to 1, such"),
        (
            {"reference_noise": (0, 2)},
            "reference_noise is (0, 2); expected 0 to 1, such as 0.01, or",
        ),
        (
            {"payload": (0, 3), "plants": [{}, {"payload": 1.0}]},
            "payload is (0.0, 3.0); plants have one each: give one number, or leave plants out",
        ),
        (
            {"actuator_gain": (0.5, 1), "plants": [{}, {"damping": 1.0}]},
            "actuator_gain is (0.5, 1.0); plants have one each: give one number, or leave plants",
        ),
        ({"plants": [{"payload": (0, 3)}]}, "plants[0]: payload is (0, 3); expected 0 to 1000, in"),
        (
            {"arms": "kinematic", "payload": (0, 3)},
            "payload is (0.0, 3.0); ideal arms have no mass: leave payload out, or choose arms",
        ),
    ],
)
def test_bad_ranges_are_one_line(options: dict[str, Any], message: str) -> None:
    for make in (load, lambda *words, **given: make_vec(2, *words, **given)):
        with pytest.raises(BadOptionError) as caught:
            make("ymca", **options)
        assert str(caught.value).startswith(message)
        assert "\n" not in str(caught.value)
