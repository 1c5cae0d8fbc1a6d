"""Gymnasium's own wrappers: each is constructed and stepped, or refuses for a known reason."""

import warnings
from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium import wrappers
from gymnasium.spaces import Box
from gymnasium.wrappers import vector

from mpma_mj.envs.make_vec import make_vec
from tests.envs.gym_episodes import DICTIONARY, FLAT, make

Wrap = Callable[[Any], Any]


def identity(values: Any) -> Any:
    return values


SMALL = {"arms": "kinematic", "repeats": 1}
DRAWS = {"render_mode": "rgb_array", "width": 64, "height": 48}
UNBOUNDED = Box(-np.inf, np.inf, (8,))

# Of the flat environment, unless a name is given.
SINGLE: dict[str, Wrap] = {
    "Autoreset": wrappers.Autoreset,
    "ClipAction": wrappers.ClipAction,
    "ClipReward": lambda env: wrappers.ClipReward(env, 0.0, 0.5),
    "DelayObservation": lambda env: wrappers.DelayObservation(env, 2),
    "DiscretizeAction": lambda env: wrappers.DiscretizeAction(env, 2, multidiscrete=True),
    "DtypeObservation": lambda env: wrappers.DtypeObservation(env, np.float32),
    "FlattenObservation": wrappers.FlattenObservation,
    "FrameStackObservation": lambda env: wrappers.FrameStackObservation(env, 3),
    "MaxAndSkipObservation": lambda env: wrappers.MaxAndSkipObservation(env, 2),
    "NormalizeObservation": wrappers.NormalizeObservation,
    "NormalizeReward": wrappers.NormalizeReward,
    "OrderEnforcing": wrappers.OrderEnforcing,
    "PassiveEnvChecker": wrappers.PassiveEnvChecker,
    "RecordEpisodeStatistics": wrappers.RecordEpisodeStatistics,
    "RepeatAction": lambda env: wrappers.RepeatAction(env, 2),
    "RescaleAction": lambda env: wrappers.RescaleAction(env, np.float32(-2), np.float32(2)),
    "ReshapeObservation": lambda env: wrappers.ReshapeObservation(
        env, (2, env.observation_space.shape[0] // 2)
    ),
    "StickyAction": lambda env: wrappers.StickyAction(env, 0.2),
    "TimeAwareObservation": wrappers.TimeAwareObservation,
    "TimeLimit": lambda env: wrappers.TimeLimit(env, 10),
    "TransformAction": lambda env: wrappers.TransformAction(env, identity, UNBOUNDED),
    "TransformObservation": lambda env: wrappers.TransformObservation(env, identity, None),
    "TransformReward": lambda env: wrappers.TransformReward(env, identity),
}
NEED_FLAT = [
    "DtypeObservation",
    "MaxAndSkipObservation",
    "NormalizeObservation",
    "ReshapeObservation",
]
DICTIONARIES = {
    "FilterObservation": lambda env: wrappers.FilterObservation(env, ["posture", "target"]),
    "FlattenObservation": wrappers.FlattenObservation,
    "TimeAwareObservation": wrappers.TimeAwareObservation,
}
# The reasons stand in docs/guides/gymnasium.md.
REFUSED: dict[str, Wrap] = {
    "RescaleObservation": lambda env: wrappers.RescaleObservation(env, -1.0, 1.0),
    "DiscretizeObservation": lambda env: wrappers.DiscretizeObservation(env, 10),
    "AtariPreprocessing": wrappers.AtariPreprocessing,
    "GrayscaleObservation": wrappers.GrayscaleObservation,
    "ResizeObservation": lambda env: wrappers.ResizeObservation(env, (8, 8)),
}
PICTURES: dict[str, Wrap] = {
    "AddRenderObservation": wrappers.AddRenderObservation,
    "AddWhiteNoise": lambda env: wrappers.AddWhiteNoise(env, probability_of_noise_per_pixel=0.1),
    "ObstructView": lambda env: wrappers.ObstructView(
        env, obstructed_pixels_ratio=0.1, obstruction_width=4
    ),
    "RenderCollection": wrappers.RenderCollection,
}
VECTOR: dict[str, Wrap] = {
    "ClipAction": vector.ClipAction,
    "ClipReward": lambda env: vector.ClipReward(env, 0.0, 0.5),
    "DictInfoToList": vector.DictInfoToList,
    "DtypeObservation": lambda env: vector.DtypeObservation(env, np.float32),
    "FlattenObservation": vector.FlattenObservation,
    "NormalizeObservation": vector.NormalizeObservation,
    "NormalizeReward": vector.NormalizeReward,
    "RecordEpisodeStatistics": vector.RecordEpisodeStatistics,
    "RescaleAction": lambda env: vector.RescaleAction(env, np.float32(-2), np.float32(2)),
    "TransformObservation": lambda env: vector.TransformObservation(env, identity),
    "TransformReward": lambda env: vector.TransformReward(env, identity),
}


def skip_if_absent(module: Any, name: str) -> None:
    if not hasattr(module, name):
        pytest.skip(f"Gymnasium {gymnasium.__version__} has no {name}")


def steps(env: gymnasium.Env[Any, Any], count: int = 5) -> Any:
    """Return what the last of some steps returned."""
    env.reset(seed=0)
    env.action_space.seed(0)
    for _ in range(count):
        step = env.step(env.action_space.sample())
    return step


@pytest.mark.parametrize("name", SINGLE)
def test_wrappers_of_flat_observations_step(name: str) -> None:
    skip_if_absent(wrappers, name)
    env = SINGLE[name](make(FLAT, **SMALL))
    observation, reward, *_ = steps(env)
    assert observation in env.observation_space
    assert np.isfinite(observation).all()
    assert np.isfinite(reward)


@pytest.mark.parametrize("name", DICTIONARIES)
def test_wrappers_of_dictionaries_step(name: str) -> None:
    env = DICTIONARIES[name](make(DICTIONARY, **SMALL))
    assert steps(env)[0] in env.observation_space


@pytest.mark.parametrize("name", REFUSED)
def test_some_wrappers_refuse_what_is_unbounded_or_no_picture(name: str) -> None:
    skip_if_absent(wrappers, name)
    with pytest.raises((AssertionError, ValueError, TypeError, gymnasium.error.Error)):
        REFUSED[name](make(FLAT, **SMALL))


@pytest.mark.parametrize("name", NEED_FLAT)
def test_some_wrappers_refuse_dictionaries(name: str) -> None:
    with pytest.raises((AssertionError, ValueError, TypeError)):
        SINGLE[name](make(DICTIONARY, **SMALL))


@pytest.mark.parametrize("name", PICTURES)
@pytest.mark.usefixtures("opengl")
def test_wrappers_of_pictures_draw(name: str) -> None:
    skip_if_absent(wrappers, name)
    env = PICTURES[name](make(FLAT, **SMALL, **DRAWS))
    steps(env, 2)
    assert np.array(env.render()).shape[-3:] == (48, 64, 3)
    env.close()


@pytest.mark.parametrize("name", VECTOR)
def test_wrappers_of_vectors_step(name: str) -> None:
    env = VECTOR[name](make_vec(2, flat=True, **SMALL))  # type: ignore[arg-type]
    observation, reward, *_ = steps(env, 80)
    assert observation.shape == env.observation_space.shape
    assert np.isfinite(reward).all()
    env.close()


def test_statistics_of_episodes_pass_the_tracking_errors_on() -> None:
    env = vector.RecordEpisodeStatistics(make_vec(2, **SMALL))  # type: ignore[arg-type]
    env.reset(seed=0)
    over = np.zeros(2, bool)
    while not over.all():
        *_, over, info = env.step(np.zeros((2, 8)))
    assert (info["p_e_percent"] > 0.0).all()
    assert info["episode"]["l"].tolist() == [env.unwrapped.steps] * 2


@pytest.mark.usefixtures("opengl")
def test_windows_of_pygame_open(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("pygame")
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    env = wrappers.HumanRendering(make(FLAT, **SMALL, **DRAWS))
    steps(env, 2)
    assert env.window.get_size() == (64, 48)
    env.close()


@pytest.mark.usefixtures("opengl")
def test_videos_of_vectors_are_a_grid(tmp_path: Any) -> None:
    pytest.importorskip("moviepy")
    skip_if_absent(vector, "RecordVideo")
    env = vector.RecordVideo(make_vec(3, flat=True, **SMALL, **DRAWS), str(tmp_path))  # type: ignore[arg-type]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        steps(env)
        env.close()
    assert list(tmp_path.glob("*.mp4"))
