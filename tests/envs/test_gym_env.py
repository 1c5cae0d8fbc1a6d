"""Gymnasium's interface: its own checker, the same numbers as dm_env's, pickles."""

import copy
import pickle
import warnings
from collections.abc import Iterator
from contextlib import closing, contextmanager
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AsyncVectorEnv
from numpy.typing import NDArray

from mpma_mj import metrics
from mpma_mj.envs.gym_env import ImitationEnv
from mpma_mj.envs.load import load
from mpma_mj.errors import BadOptionError, MpmaError
from mpma_mj.motions import ymca
from tests.envs.gym_episodes import FLAT, NAMES, actions, assert_same, make

ARMS = ("physics", "kinematic")


MOTION = ymca()


Array = NDArray[np.float64]


@contextmanager
def warnings_are_errors() -> Iterator[None]:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        # Angles and velocities have no bound, as in Gymnasium's own environments.
        warnings.filterwarnings("ignore", ".*space (minimum|maximum) value is -?infinity")
        yield


@pytest.mark.parametrize("arms", ARMS)
@pytest.mark.parametrize("name", NAMES)
def test_gymnasiums_checker_finds_nothing(name: str, arms: str) -> None:
    with warnings_are_errors(), closing(make(name, arms=arms)) as env:
        # Rendering apart: the mode for people needs a display.
        check_env(env.unwrapped, skip_render_check=True)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.usefixtures("opengl")
def test_gymnasiums_checker_takes_the_pictures(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(ImitationEnv.metadata, "render_modes", ["rgb_array"])
    with warnings_are_errors(), closing(make(name, render_mode="rgb_array")) as env:
        check_env(env.unwrapped)


@pytest.mark.parametrize("arms", ARMS)
@pytest.mark.parametrize("name", NAMES)
def test_numbers_are_those_of_dm_env(name: str, arms: str) -> None:
    plain = load(MOTION, arms=arms, repeats=1, seed=7)
    env = make(name, motion=MOTION, arms=arms)
    for episode in range(2):
        observation, info = env.reset(seed=7) if episode == 0 else env.reset()
        timestep = plain.reset()
        for action in actions(1000, episode):
            expected = timestep.observation
            if name == FLAT:
                expected = np.concatenate(list(expected.values()))
            assert observation in env.observation_space
            assert_same([observation], [expected])
            observation, reward, terminated, truncated, info = env.step(action)
            timestep = plain.step(action)
            assert reward == timestep.reward
            assert np.mean(list(info["reward_terms"].values())) == pytest.approx(reward)
            assert (terminated, truncated) == (False, timestep.last())
            if truncated:
                break
        assert timestep.last()
        assert timestep.discount == 1.0


def test_a_simulation_that_diverges_terminates_and_says_why() -> None:
    with warnings_are_errors():
        env = make()
        env.reset()
        assert env.step(np.zeros(8))[4]["termination_reason"] == ""
        env.unwrapped._env.physics.data.qvel[3] = 1e12
        observation, reward, terminated, truncated, info = env.step(np.zeros(8))
        assert observation in env.observation_space
        assert (reward, terminated, truncated) == (0.0, True, False)
        assert set(info["reward_terms"].values()) == {0.0}
        assert (
            info["termination_reason"]
            == "the simulation diverged: the velocity of left_elbow ran away"
        )
        env.reset()
        assert not env.step(np.zeros(8))[2]


def test_clipped_entries_are_counted() -> None:
    env = make()
    assert env.reset()[1]["clipped"] == 0
    assert env.step(np.array([1.0, 1.1, -3.0, 0.0, -1.0, 0.5, 7.0, 1.0]))[4]["clipped"] == 3
    assert env.step(np.zeros(8))[4]["clipped"] == 0


def test_the_end_of_the_demonstration_is_named() -> None:
    env = make()
    env.reset()
    while not (step := env.step(np.zeros(8)))[3]:
        pass
    assert step[4]["termination_reason"] == "the demonstration is over"


@pytest.mark.parametrize("options", [{}, {"random_start": True, "observation_noise": 0.1}])
def test_the_last_info_of_an_episode_has_the_tracking_errors_of_the_true_arms(
    options: dict[str, Any],
) -> None:
    env = make(**options)
    sites = env.unwrapped.physics.site_positions
    for episode in range(2):
        env.reset(seed=4) if episode == 0 else env.reset()
        postures, references, truncated = [], [], False
        while not truncated:
            *_, truncated, info = env.step(np.full(8, 0.2))
            postures.append(env.unwrapped.physics.posture())
            references.append(env.unwrapped.last_observation["reference"])
            assert ("p_e_percent" in info, "mpkpe_m" in info) == (truncated, truncated)
        posture, reference = np.array(postures), np.array(references)
        assert info["p_e_percent"] == metrics.posture_error_percent(posture, reference)
        mpkpe = metrics.mpkpe(sites(posture), sites(reference))
        assert info["mpkpe_m"] == pytest.approx(mpkpe, rel=1e-12)


def test_the_length_of_an_episode_is_known_and_no_limit() -> None:
    env = make(repeats=2, motion="ymca")
    assert env.spec is not None
    assert env.spec.max_episode_steps == env.unwrapped._env.task.steps
    assert not isinstance(env, gymnasium.wrappers.TimeLimit)
    again = gymnasium.make(env.spec)
    assert again.spec == env.spec
    timed = gymnasium.wrappers.TimeAwareObservation(env, flatten=False, normalize_time=True)
    timed.reset()
    while not (step := timed.step(np.zeros(8)))[3]:
        pass
    assert step[0]["time"] == 1.0
    assert gymnasium.make(env.spec, max_episode_steps=5).spec.max_episode_steps == 5


def test_arms_beyond_the_termination_distance_end_the_episode() -> None:
    env = make(termination_distance=0.2)
    env.reset()
    while not (step := env.step(np.ones(8)))[2]:
        pass
    assert not step[3]
    assert (
        step[4]["termination_reason"] == "an elbow or wrist is too far from the demonstrated place"
    )


def test_reward_terms_have_names() -> None:
    terms = make().reset()[1]["reward_terms"]
    assert list(terms) == ["left_upper_arm", "left_forearm", "right_upper_arm", "right_forearm"]


def test_no_step_before_and_after_an_episode() -> None:
    env = ImitationEnv(motion=MOTION, repeats=1)
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.step(np.zeros(8))
    env.reset()
    while not env.step(np.zeros(8))[3]:
        pass
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.step(np.zeros(8))


def test_episodes_follow_from_the_seed_alone() -> None:
    def episodes(env: gymnasium.Env[Any, Any], seed: int) -> list[Array]:
        return [env.reset(seed=seed)[0]["target"], env.reset()[0]["target"]]

    env, used = make(seed=5), make(seed=9)
    used.reset(seed=4)
    used.step(np.zeros(8))
    used.reset()
    first, second = episodes(env, 0)
    np.testing.assert_array_equal(episodes(used, 0), [first, second])
    assert not np.array_equal(first, second)
    assert not np.array_equal(episodes(env, 1)[0], first)
    by_option = make(seed=0)
    np.testing.assert_array_equal(by_option.reset()[0]["target"], first)
    np.testing.assert_array_equal(by_option.reset()[0]["target"], second)


def test_seeds_are_whole_numbers_of_any_kind() -> None:
    env = ImitationEnv(arms="kinematic")
    first = env.reset(seed=3)[0]["target"]
    np.testing.assert_array_equal(env.reset(seed=np.int64(3))[0]["target"], first)
    for seed in (-1, True, 0.5):
        with pytest.raises(BadOptionError, match=f"seed is {seed}; expected a whole number"):
            env.reset(seed=seed)


def test_the_generator_is_numpys_and_seeded() -> None:
    env = make(seed=0)
    assert isinstance(env.unwrapped.np_random, np.random.Generator)
    assert env.unwrapped.np_random_seed == 0
    drawn = []
    for _ in range(2):
        env.reset(seed=0)
        drawn.append(env.unwrapped.np_random.random())
    assert drawn[0] == drawn[1]


def test_spaces_are_in_the_order_of_the_documentation() -> None:
    env, flat = make(), make(FLAT)
    labels = len(MOTION.labels)
    sizes = {"posture": 12, "reference": 12, "target": 12, "context": labels}
    sizes |= {"joint_angles": 8, "joint_velocities": 8}
    assert {k: s.shape[0] for k, s in env.observation_space.items()} == sizes
    assert list(env.observation_space) == list(sizes)
    assert flat.observation_space == gymnasium.spaces.flatten_space(env.observation_space)
    assert flat.observation_space.shape == (52 + labels,)
    assert env.observation_space["context"].high.max() == 1.0
    assert env.observation_space["context"].low.min() == 0.0
    np.testing.assert_allclose(env.observation_space["posture"].high, 1.0, atol=1e-8)
    for name in ("joint_angles", "joint_velocities"):
        assert not (env.observation_space[name].bounded_below.any())
        assert not (env.observation_space[name].bounded_above.any())
    for space in (env.action_space, flat.action_space):
        assert space == gymnasium.spaces.Box(-1.0, 1.0, (8,), np.float32)


def test_float64_actions_are_not_rounded() -> None:
    env = make(arms="kinematic")
    env.reset()
    action = np.full(8, 0.1)
    velocity = env.step(action)[0]["joint_velocities"]
    speed = env.unwrapped._env.physics.max_joint_speed
    np.testing.assert_allclose(velocity / speed, action, rtol=1e-12)


@pytest.mark.parametrize(("rate", "expected"), [(20.0, 20), (40.0, 40)])
def test_the_rate_of_pictures_is_that_of_control(rate: float, expected: float) -> None:
    env = make(motion=ymca(rate=rate))
    assert env.metadata["render_fps"] == expected
    assert env.metadata["render_modes"] == ["rgb_array", "human"]
    assert ImitationEnv.metadata["render_fps"] == 20


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"tempi": 2}, "no option 'tempi'; expected motion, seed, render_mode, "),
        ({"pahse": True}, "no option 'pahse'; did you mean phase?"),
        ({"arms": "rubber"}, "arms is 'rubber'; expected one of physics, kinematic"),
        ({"motion": "macarena"}, "no motion 'macarena'"),
        ({"seed": -1}, "seed is -1"),
    ],
)
def test_bad_options_are_one_line(options: dict[str, Any], message: str) -> None:
    with pytest.raises(MpmaError) as caught:
        make(**options)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("mode", ["ansi", 3, ["rgb_array"], np.zeros(2)], ids=repr)
def test_an_unknown_render_mode_is_one_line(mode: Any) -> None:
    with pytest.raises(BadOptionError, match=r"render_mode is .*; expected rgb_array or human"):
        ImitationEnv(render_mode=mode)


@pytest.mark.parametrize("action", [np.zeros(7), np.zeros((1, 8)), 0.5])
def test_an_action_of_another_shape_is_refused_and_changes_nothing(action: Any) -> None:
    env, other = make(), make()
    env.reset(seed=0), other.reset(seed=0)
    with pytest.raises(BadOptionError, match=r"^action has shape \(.*\); expected \(8,\)$"):
        env.step(action)
    assert_same(env.step(np.ones(8)), other.step(np.ones(8)))


@pytest.mark.parametrize("arms", ARMS)
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("again", [lambda env: pickle.loads(pickle.dumps(env)), copy.deepcopy])
def test_a_pickle_goes_on_identically(name: str, arms: str, again: Any) -> None:
    env = make(name, arms=arms, motion="ymca")
    env.reset(seed=3)
    env.reset()
    played = actions(1000)
    for action in played[:50]:
        env.step(action)
    env.action_space.seed(0)
    env.unwrapped.np_random.random()
    other = again(env)
    np.testing.assert_array_equal(env.action_space.sample(), other.action_space.sample())
    assert env.unwrapped.np_random.random() == other.unwrapped.np_random.random()
    assert env.spec == other.spec
    truncated = False
    for action in played[50:]:
        one, two = env.step(action), other.step(action)
        assert_same(one, two)
        if truncated := one[3]:
            break
    assert truncated
    assert_same(env.reset(), other.reset())
    assert_same(env.step(played[0]), other.step(played[0]))


@pytest.mark.parametrize("again", [copy.copy, copy.deepcopy])
def test_a_copy_leaves_the_original_as_it_was(again: Any) -> None:
    envs = [ImitationEnv(repeats=1, random_start="adaptive", arms="kinematic") for _ in range(2)]
    for env in envs:
        env.reset(seed=3)
        env.step(np.ones(8))
    other = again(envs[0])
    for _ in range(3):
        while not other.step(-np.ones(8))[3]:
            pass
        other.reset()
    for _ in range(3):
        truncated = False
        while not truncated:
            one, two = (env.step(np.full(8, 0.1)) for env in envs)
            assert_same(one, two)
            truncated = one[3]
        assert_same(*(env.reset() for env in envs))


def test_pickles_of_an_environment_not_begun_and_of_one_at_its_end() -> None:
    env = ImitationEnv(motion=MOTION, repeats=1, seed=2)
    fresh = pickle.loads(pickle.dumps(env))
    assert_same(env.reset(), fresh.reset())
    while not env.step(np.zeros(8))[3]:
        pass
    over = pickle.loads(pickle.dumps(env))
    with pytest.raises(gymnasium.error.ResetNeeded):
        over.step(np.zeros(8))
    assert_same(env.reset(), over.reset())
    env.unwrapped._env.physics.data.qvel[:] = 1e12
    assert env.step(np.zeros(8))[2]
    diverged = pickle.loads(pickle.dumps(env))
    assert_same(env.reset(), diverged.reset())


@pytest.mark.parametrize("name", NAMES)
def test_asynchronous_environments_are_like_single_ones(name: str) -> None:
    options = {"motion": "ymca", "arms": "kinematic"}
    single = [make(name, **options) for _ in range(2)]
    together = AsyncVectorEnv([lambda: make(name, **options)] * 2)
    with closing(together):
        observations, _ = together.reset(seed=0)
        alone = [env.reset(seed=seed)[0] for seed, env in enumerate(single)]
        for action in actions(3):
            for i, observation in enumerate(alone):
                got = {k: v[i] for k, v in observations.items()} if name != FLAT else None
                assert_same([got or observations[i]], [observation])
            observations, rewards, _, _, infos = together.step(np.stack([action, -action]))
            steps = [single[0].step(action), single[1].step(-action)]
            alone = [step[0] for step in steps]
            np.testing.assert_array_equal(rewards, [step[1] for step in steps])
        term = infos["reward_terms"]["left_forearm"]
        assert term[1] == steps[1][4]["reward_terms"]["left_forearm"]
