"""A vector of environments: each is the single one, bit for bit."""

import copy
import pickle
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from numpy.typing import NDArray

import mpma_mj
from mpma_mj.envs.gym_env import FlatImitationEnv, ImitationEnv
from mpma_mj.envs.load import load
from mpma_mj.envs.make_vec import make_vec
from mpma_mj.envs.vector_env import VectorImitationEnv
from mpma_mj.errors import BadOptionError, StateError

HARD: dict[str, Any] = {
    **{"latency": 2, "observation_noise": 0.02, "perturbation": (2.0, 40.0), "payload": 1.0},
    **{
        "gravity_compensation": True,
        "actuator_strength": 0.7,
        "collisions": True,
        "random_start": True,
    },
    **{"termination_distance": 0.5, "reward_weights": {"left_forearm": 3}, "lookahead": 5},
    "phase": True,
}


# Diverges, or is too far off, at any time.
WILD: dict[str, Any] = {"perturbation": (20.0, 10_000.0), "latency": 1, "termination_distance": 0.5}


# Adaptive starts, and numbers that are drawn for each episode.
DRAWN: dict[str, Any] = {
    **{"random_start": "adaptive", "error_observation": True, "latency": (0, 2)},
    **{"actuator_gain": (0.6, 1.5), "observation_noise": (0, 0.05), "reference_noise": (0, 0.1)},
}


TINY: dict[str, Any] = {
    "termination_distance": 0.001,
    "reference_noise": 0.1,
}  # ends as soon as it has begun


Array = NDArray[np.float64]


@contextmanager
def many(num_envs: int, **options: Any) -> Iterator[VectorImitationEnv]:
    envs = make_vec(num_envs, **{"repeats": 1, **options})
    yield envs
    envs.close()


def at_random(steps: int, num_envs: int, seed: int = 0) -> Array:
    """Return actions, some beyond the bounds, that drive elbows into their limits too."""
    rng = np.random.default_rng(seed)
    return rng.uniform(-1.0, 1.0, (steps, num_envs, 8)).cumsum(axis=0).clip(-1.5, 1.5)


@pytest.mark.parametrize(
    ("num_envs", "options"),
    [(2, {}), (1, {"arms": "kinematic"}), (7, HARD), (2, WILD), (2, TINY)],
    ids=["physics", "kinematic", "hard", "wild", "tiny"],
)
def test_each_of_many_is_a_single_environment_bit_for_bit(
    num_envs: int, options: dict[str, Any]
) -> None:
    singles = [load("ymca", repeats=1, seed=4 + i, **options) for i in range(num_envs)]
    with many(num_envs, seed=4, **options) as envs:
        observations, _ = envs.reset()
        timesteps = [single.reset() for single in singles]
        begun = np.zeros(num_envs, int)
        for actions in at_random(160, num_envs):
            for i, timestep in enumerate(timesteps):
                assert list(observations) == list(timestep.observation)
                for name, values in timestep.observation.items():
                    np.testing.assert_array_equal(observations[name][i], values)
            observations, rewards, terminated, truncated, infos = envs.step(actions)
            timesteps = [s.step(a) for s, a in zip(singles, actions, strict=True)]
            for i, (single, timestep) in enumerate(zip(singles, timesteps, strict=True)):
                assert rewards[i] == (timestep.reward or 0.0)
                assert terminated[i] == (timestep.discount == 0.0)
                assert truncated[i] == (timestep.last() and timestep.discount == 1.0)
                assert (
                    infos["termination_reason"][i] == single.task.termination_reason.split(":")[0]
                )
                assert infos["clipped"][i] == single.task.clipped
                terms = single.task.reward_terms(single.physics)
                assert {k: v[i] for k, v in infos["reward_terms"].items() if k[0] != "_"} == terms
                begun[i] += timestep.first()
        assert (begun >= 1).all()


@pytest.mark.parametrize("mode", AutoresetMode)
@pytest.mark.parametrize(
    ("kind", "flat", "options"),
    [
        (ImitationEnv, False, {}),
        (FlatImitationEnv, True, {}),
        (ImitationEnv, False, HARD | {"plants": [{}, {"payload": 2.0}], "latency": (0, 3)}),
        (FlatImitationEnv, True, WILD),
        (ImitationEnv, False, DRAWN | {"payload": (0, 3), "damping": (0, 2)}),
        (FlatImitationEnv, True, DRAWN | {"arms": "kinematic", "termination_distance": 0.3}),
    ],
    ids=["dict", "flat", "hard", "wild", "drawn", "drawn kinematic"],
)
def test_gymnasiums_own_vector_environment_has_the_same_numbers(
    mode: AutoresetMode, kind: type[ImitationEnv], flat: bool, options: dict[str, Any]
) -> None:
    theirs = SyncVectorEnv(
        [lambda: kind(repeats=1, **options) for _ in range(3)], autoreset_mode=mode
    )
    ended = 0
    with many(3, flat=flat, autoreset_mode=mode, **options) as ours:
        assert ours.single_observation_space == theirs.single_observation_space
        assert ours.observation_space == theirs.observation_space
        assert ours.action_space == theirs.action_space
        assert ours.metadata["autoreset_mode"] == theirs.metadata["autoreset_mode"]
        assert ours.metadata["render_fps"] == theirs.metadata["render_fps"]
        one, other = ours.reset(seed=9), theirs.reset(seed=9)
        for actions in at_random(240, 3):
            assert one[0] in ours.observation_space
            assert_same(without_joints(one), without_joints(other))
            one, other = ours.step(actions), theirs.step(actions)
            over = one[2] | one[3]
            ended += over.sum()
            if mode is AutoresetMode.DISABLED and over.any():
                assert_same(without_joints(one), without_joints(other))
                with pytest.raises(gymnasium.error.ResetNeeded, match="are over; call reset, with"):
                    ours.step(actions)
                one = ours.reset(options={"reset_mask": over})
                other = theirs.reset(options={"reset_mask": over})
    assert ended >= 3


def without_joints(returned: Any) -> Any:
    """Return what a step returned without the names of the joints that diverged."""
    *rest, info = returned
    final = info.get("final_info", info)
    if "termination_reason" in final:
        reasons = final["termination_reason"]
        reasons[:] = [reason and reason.split(":")[0] for reason in reasons]
    return *rest, info


@pytest.mark.parametrize("name", ["SAME_STEP", "SameStep", AutoresetMode.SAME_STEP])
def test_modes_of_autoreset_have_names(name: Any) -> None:
    with many(2, arms="kinematic", autoreset_mode=name) as envs:
        assert envs.metadata["autoreset_mode"] is AutoresetMode.SAME_STEP


@pytest.mark.usefixtures("opengl")
@pytest.mark.parametrize(
    "plants",
    [{"plants": [{}, {"payload": 5.0}], "switch_every": (0.1, 0.2)}, {"payload": (0, 5)}],
    ids=["plants", "drawn"],
)
def test_pictures_are_those_of_single_environments(plants: dict[str, Any]) -> None:
    options: dict[str, Any] = {
        **{"render_mode": "rgb_array", "width": 120, "height": 90, "camera": "side"},
        **plants,
    }
    singles = [ImitationEnv(repeats=1, seed=i, **options) for i in range(3)]
    with many(3, **options) as envs:
        envs.reset(), [single.reset() for single in singles]
        for actions in at_random(5, 3):
            envs.step(actions), [s.step(a) for s, a in zip(singles, actions, strict=True)]
            pictures = envs.render()
            assert isinstance(pictures, tuple)
            for picture, single in zip(pictures, singles, strict=True):
                assert np.abs(picture.astype(int) - single.render()).mean() < 0.01
        assert np.abs(pictures[0].astype(int) - pictures[1]).mean() > 0.1
    for single in singles:
        single.close()


def test_rendering_without_a_mode_warns() -> None:
    with many(2, arms="kinematic") as envs, pytest.warns(UserWarning, match="nothing is drawn"):
        assert envs.render() is None


def assert_same(one: Any, other: Any) -> None:
    for a, b in zip(one, other, strict=True):
        if isinstance(a, dict):
            assert a.keys() == b.keys()
            assert_same(a.values(), [b[name] for name in a])
        elif a is None:
            assert b is None
        elif isinstance(a, str):
            assert a == b
        elif a.dtype == object:
            assert b.dtype == object
            assert_same(a, b)
        else:
            np.testing.assert_array_equal(a, b)
            assert a.dtype == b.dtype


def test_an_ended_episode_is_followed_by_the_next_while_others_go_on() -> None:
    with many(4, arms="kinematic", random_start=True, seed=3) as envs:
        envs.reset()
        over = np.zeros(4, bool)
        seen = set()
        for _ in range(400):
            _, rewards, terminated, truncated, _ = envs.step(np.zeros((4, 8)))
            assert not (terminated | truncated)[over].any()
            assert (rewards[over] == 0.0).all()
            assert (rewards[~over] > 0.0).all()
            over = terminated | truncated
            seen.add(tuple(over))
        assert any(0 < sum(pattern) < 4 for pattern in seen)


def test_seeds_one_for_all_or_one_for_each() -> None:
    with many(3, arms="kinematic", seed=5) as envs:
        by_option = envs.reset()[0]["target"]
        following = envs.reset()[0]["target"]
        np.testing.assert_array_equal(envs.reset(seed=5)[0]["target"], by_option)
        np.testing.assert_array_equal(envs.reset()[0]["target"], following)
        assert not np.array_equal(by_option, following)
        assert len({tuple(target) for target in by_option}) == 3
        same = envs.reset(seed=[5, 5, 7])[0]["target"]
        np.testing.assert_array_equal(same, by_option[[0, 0, 2]])
        envs.reset(seed=9)
        assert envs.np_random_seed == 9


def test_returned_arrays_are_not_touched_again() -> None:
    with many(2) as envs:
        envs.reset()
        first = envs.step(np.ones((2, 8)))
        kept = {name: values.copy() for name, values in first[0].items()}
        terms = first[4]["reward_terms"]["left_forearm"].copy()
        second = envs.step(-np.ones((2, 8)))
        for name, values in kept.items():
            np.testing.assert_array_equal(first[0][name], values)
            assert not np.shares_memory(first[0][name], second[0][name])
        np.testing.assert_array_equal(first[4]["reward_terms"]["left_forearm"], terms)
        second[0]["target"][:] = 9.0  # spoils nothing
        assert np.abs(envs.step(np.zeros((2, 8)))[0]["reference"]).max() <= 1.0


def test_attributes_are_those_of_a_single_environment() -> None:
    with many(2) as envs:
        single = load("ymca", repeats=1)
        np.testing.assert_array_equal(envs.max_joint_speed, single.task.max_joint_speed)
        assert envs.control_timestep == single.control_timestep()
        assert envs.steps == single.task.steps
        assert envs.metadata["autoreset_mode"] == AutoresetMode.NEXT_STEP
        assert mpma_mj.make_vec is make_vec


@pytest.mark.parametrize(
    ("actions", "message"),
    [
        (np.zeros((2, 7)), r"action has shape \(2, 7\); expected \(2, 8\)"),
        (np.zeros(8), r"action has shape \(8,\); expected \(2, 8\)"),
        (np.eye(2, 8) * np.nan, r"action\[0, 0\] is nan"),
        (np.where(np.eye(2, 8, 3)[::-1], -np.inf, 0.0), r"action\[0, 4\] is -inf"),
        (np.zeros((2, 8), complex), "action is of type complex128"),
    ],
)
def test_invalid_actions_are_refused_and_change_nothing(actions: Any, message: str) -> None:
    with many(2) as envs, many(2) as others:
        envs.reset(), others.reset()
        with pytest.raises(BadOptionError, match=message):
            envs.step(actions)
        one, other = envs.step(np.ones((2, 8))), others.step(np.ones((2, 8)))
        assert_same(one[:-1], other[:-1])


def test_no_step_before_a_reset() -> None:
    with many(2) as envs, pytest.raises(gymnasium.error.ResetNeeded):
        envs.step(np.zeros((2, 8)))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"num_envs": 0}, "num_envs is 0; expected a whole number from 1 to 100000"),
        ({"num_envs": 10**400}, "num_envs is 1000"),
        ({"threads": 100_001}, "threads is 100001; expected a whole number from 1 to 100000"),
        ({"num_envs": 2.0}, "num_envs is 2.0"),
        ({"num_envs": True}, "num_envs is True"),
        (
            {"num_envs": 2, "render_mode": "human"},
            "render_mode is 'human'; expected rgb_array, or None",
        ),
        (
            {"num_envs": 2, "autoreset_mode": "never"},
            "autoreset_mode is 'never'; expected NEXT_STEP, SAME_STEP or DISABLED",
        ),
        (
            {"num_envs": 2, "autoreset_mode": np.zeros(2)},
            r"autoreset_mode is array\(.*\); expected NEXT_STEP, SAME_STEP or DISABLED",
        ),
        ({"num_envs": 2, "seed": -3}, "seed is -3"),
    ],
)
def test_bad_options_are_one_line(options: dict[str, Any], message: str) -> None:
    with pytest.raises(BadOptionError, match=message):
        VectorImitationEnv(**options)


@pytest.mark.parametrize(
    ("seed", "message"),
    [
        (-1, "seed is -1; expected a whole number from 0 up"),
        ([0, 1], "seed has 2 entries; expected 3"),
        ([0, -1, 2], "seed is -1"),
        ([0, 0.5, 2], "seed is 0.5"),
        ("one", "seed is 'one'"),
        (np.array(0.5), "seed is 0.5"),
    ],
)
def test_invalid_seeds_are_refused_and_change_nothing(seed: Any, message: str) -> None:
    with many(3, seed=4) as envs, many(3, seed=4) as others:
        with pytest.raises(BadOptionError, match=message):
            envs.reset(seed=seed)
        assert_same([envs.reset()[0]], [others.reset()[0]])


@pytest.mark.parametrize("seed", [2**63 - 1, 2**64, np.uint64(5), np.int64(3), np.array(4)])
def test_seeds_are_whole_numbers_of_any_size_and_kind(seed: Any) -> None:
    with many(2, seed=int(seed)) as envs:
        by_option = envs.reset()[0]["target"]
        np.testing.assert_array_equal(envs.reset(seed=seed)[0]["target"], by_option)
    single = load("ymca", repeats=1, seed=int(seed) + 1).reset().observation["target"]
    np.testing.assert_array_equal(by_option[1], single)


def test_an_environment_without_a_new_seed_keeps_its_seed() -> None:
    with many(2, seed=4) as envs, many(2, seed=4) as others:
        first, following = others.reset()[0]["target"], others.reset()[0]["target"]
        envs.reset()
        np.testing.assert_array_equal(
            envs.reset(seed=[4, None])[0]["target"], [first[0], following[1]]
        )


def test_a_mask_resets_some_environments_only() -> None:
    with many(3, seed=1, arms="kinematic") as envs, many(3, seed=1, arms="kinematic") as others:
        for each in (envs, others):
            each.reset()
            for _ in range(5):
                before = each.step(np.full((3, 8), 0.1))[0]
        mask = np.array([False, True, False])
        after, info = envs.reset(seed=[9, 9, 9], options={"reset_mask": mask})
        assert info["termination_reason"].tolist() == [None, "", None]
        np.testing.assert_array_equal(info["_termination_reason"], mask)
        np.testing.assert_array_equal(after["posture"][~mask], before["posture"][~mask])
        first = load("ymca", repeats=1, arms="kinematic", seed=9).reset().observation
        np.testing.assert_array_equal(after["target"][1], first["target"])
        one, other = envs.step(np.zeros((3, 8)))[0], others.step(np.zeros((3, 8)))[0]
        np.testing.assert_array_equal(one["target"][~mask], other["target"][~mask])


def test_a_mask_leaves_an_ended_episode_ended() -> None:
    with many(2, arms="kinematic") as envs:
        envs.reset()
        while not envs.step(np.zeros((2, 8)))[3].all():
            pass
        info = envs.reset(options={"reset_mask": np.array([True, False])})[1]
        assert info["termination_reason"].tolist() == ["", None]
        _, rewards, *_ = envs.step(np.zeros((2, 8)))
        assert rewards[0] > 0.0
        assert rewards[1] == 0.0  # begins only now


@pytest.mark.parametrize(
    "options",
    [
        3,
        False,
        [],
        np.ones(2, bool),
        {"mask": [True, True]},
        {"reset_mask": [[True], [True, False]]},
        {"reset_mask": [True]},
        {"reset_mask": [1, 0]},
        {"reset_mask": 1},
        {"reset_mask": np.ones(2, bool), "mask": True},
    ],
)
def test_invalid_options_of_a_reset_are_refused(options: Any) -> None:
    message = "expected None, or a reset_mask of 2 booleans"
    with many(2, arms="kinematic") as envs, pytest.raises(BadOptionError, match=message):
        envs.reset(options=options)
    with pytest.raises(BadOptionError, match="reset has no options"):
        ImitationEnv(arms="kinematic").reset(options=options)


@pytest.mark.parametrize("again", [pickle.dumps, copy.deepcopy, copy.copy])
@pytest.mark.parametrize("arms", ["physics", "kinematic"])
def test_copies_are_refused(again: Any, arms: str) -> None:
    with many(2, arms=arms) as envs, pytest.raises(StateError, match="call make_vec again"):
        again(envs)


def test_flat_has_to_be_true_or_false() -> None:
    with pytest.raises(BadOptionError, match="flat is 'yes'; expected True or False"):
        make_vec(2, flat="yes")  # type: ignore[arg-type]


def test_closing_twice_is_allowed() -> None:
    envs = make_vec(2)
    envs.reset()
    envs.close()
    envs.close()
    for use in (envs.reset, lambda: envs.step(np.zeros((2, 8)))):
        with pytest.raises(gymnasium.error.ClosedEnvironmentError, match="create others"):
            use()
