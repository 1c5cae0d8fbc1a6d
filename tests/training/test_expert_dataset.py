"""Datasets in Minari's format."""

import importlib.util
import json
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

from mpma_mj import load, make_agent, make_vec, record_dataset
from mpma_mj.errors import BadOptionError
from mpma_mj.motions import read_motion
from tests.envs.test_gl import python

FLAT, DICT = "mpma_mj:TwoArmImitationFlat-v0", "mpma_mj:TwoArmImitation-v0"
IDEAL: dict[str, Any] = {"arms": "kinematic", "repeats": 1}


def made(name: str = FLAT, **options: Any) -> gymnasium.Env[Any, Any]:
    return gymnasium.make(name, **{"motion": "ymca"} | IDEAL | options)


def follower(**options: Any) -> Any:
    return make_agent(load("ymca", **IDEAL | options), kind="resolved_rate")


@pytest.fixture
def minari() -> Any:
    pytest.importorskip("h5py")
    return pytest.importorskip("minari")


@pytest.mark.parametrize("name", [FLAT, DICT])
def test_recorded_actions_lead_to_the_recorded_observations_again(
    name: str, tmp_path: Path, minari: Any
) -> None:
    options = {"observation_noise": 0.01, "latency": (0, 2), "lookahead": 2}
    env = made(name, **options)
    record_dataset(env, follower(), 2, tmp_path / "d.minari", seed=5)
    dataset = minari.MinariDataset(tmp_path / "d.minari" / "data")
    assert (dataset.total_episodes, dataset.total_steps) == (2, 2 * len(dataset[0]))
    assert dataset.observation_space == env.observation_space
    again = dataset.recover_environment()
    assert again.spec.kwargs["latency"] == [0, 2]
    for k, episode in enumerate(dataset):
        observation, _ = again.reset(seed=5 + k)
        moments = [observation]
        for step, action in enumerate(episode.actions):
            observation, reward, terminated, truncated, _ = again.step(action)
            moments.append(observation)
            assert reward == episode.rewards[step]
            assert (terminated, truncated) == (False, bool(episode.truncations[step]))
        assert truncated
        if name == FLAT:
            np.testing.assert_array_equal(moments, episode.observations)
        else:
            for part, rows in episode.observations.items():
                np.testing.assert_array_equal([one[part] for one in moments], rows)


def test_episodes_have_seed_and_p_e_and_the_dataset_its_expert(tmp_path: Path, minari: Any) -> None:
    folder = record_dataset(made(), follower(), 3, tmp_path / "expert-v2")
    dataset = minari.MinariDataset(folder / "data")
    own = list(dataset.storage.get_episode_metadata(range(3)))
    assert [int(one["seed"]) for one in own] == [0, 1, 2]
    for one, episode in zip(own, dataset, strict=True):
        p_e = episode.infos["p_e_percent"]
        assert len(p_e) == len(episode.observations)
        assert np.isnan(p_e[:-1]).all()
        assert p_e[-1] == one["p_e_percent"]
        assert 0.1 < p_e[-1] < 0.3  # that of the agent on these arms
    metadata = json.loads((folder / "data" / "metadata.json").read_text())
    assert metadata["dataset_id"] == "expert-v2"
    assert metadata["algorithm_name"] == "ResolvedRate"
    mean = np.mean([one["p_e_percent"] for one in own])
    assert metadata["expert_p_e_percent"] == pytest.approx(mean)
    assert "author" not in metadata


def test_minari_loads_a_dataset_that_is_named_as_it_expects(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, minari: Any
) -> None:
    record_dataset(made(), follower(), 1, tmp_path / "ymca-v0")
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path))
    assert list(minari.list_local_datasets()) == ["ymca-v0"]
    assert len(minari.load_dataset("ymca-v0")) == 1


def test_the_path_of_a_recording_stays_a_path(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, minari: Any
) -> None:
    from mpma_mj import export_motion

    monkeypatch.chdir(tmp_path)
    export_motion("dance.npz", read_motion("ymca"))
    agent = make_agent(load("dance.npz", **IDEAL), kind="resolved_rate")
    record_dataset(made(motion="dance.npz"), agent, 1, "d.minari")
    dataset = minari.MinariDataset("d.minari/data")
    assert dataset.recover_environment().spec.kwargs["motion"] == "dance.npz"


def test_a_dataset_is_replaced_only_if_asked_and_nothing_else_ever(
    tmp_path: Path, minari: Any
) -> None:
    out = tmp_path / "d.minari"
    record_dataset(made(), follower(), 1, out)
    with pytest.raises(BadOptionError, match=r"already exists; overwrite replaces it"):
        record_dataset(made(), follower(), 2, out)
    record_dataset(made(), follower(), 2, out, overwrite=True)
    assert len(minari.MinariDataset(out / "data")) == 2
    other = tmp_path / "other"
    (other / "data").mkdir(parents=True)
    with pytest.raises(BadOptionError, match=r"already exists, and is no dataset"):
        record_dataset(made(), follower(), 1, other, overwrite=True)
    assert {path.name for path in tmp_path.iterdir()} == {"d.minari", "other"}


def test_what_fails_leaves_the_dataset_as_it_was(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, minari: Any
) -> None:
    out = tmp_path / "d.minari"
    record_dataset(made(), follower(), 1, out)
    from minari.dataset._storages.hdf5_storage import HDF5Storage

    def fail(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(HDF5Storage, "update_episode_metadata", fail)
    with pytest.raises(Exception, match=r"cannot be written \(No space left on device\)"):
        record_dataset(made(), follower(), 2, out, overwrite=True)
    assert len(minari.MinariDataset(out / "data")) == 1
    assert [path.name for path in tmp_path.iterdir()] == ["d.minari"]


@pytest.mark.parametrize("episodes", [0, -1, 1.5, None])
def test_numbers_of_episodes_that_cannot_be_are_refused(
    episodes: Any, tmp_path: Path, minari: Any
) -> None:
    with pytest.raises(BadOptionError, match=f"episodes is {episodes}; expected a whole number"):
        record_dataset(made(), follower(), episodes, tmp_path / "d")


def test_an_agent_that_does_not_fit_is_refused(tmp_path: Path, minari: Any) -> None:
    out = tmp_path / "d"
    fewer = make_agent(load("synthetic-2", **IDEAL), kind="resolved_rate")
    with pytest.raises(BadOptionError, match=r"agent has a context of size 1, but .* one of 4"):
        record_dataset(made(), fewer, 1, out)
    slower = follower(control_timestep=0.1)
    with pytest.raises(BadOptionError, match=r"agent is for other arms or another control times"):
        record_dataset(made(), slower, 1, out)
    faster = follower()
    faster.spec = replace(faster.spec, max_joint_speed=2.0 * faster.spec.max_joint_speed)
    with pytest.raises(BadOptionError, match=r"agent is for other arms or another control times"):
        record_dataset(made(), faster, 1, out)
    many = make_agent(make_vec(2, "ymca", **IDEAL), kind="resolved_rate")
    with pytest.raises(BadOptionError, match=r"agent is a batch of runs"):
        record_dataset(made(), many, 1, out)
    assert not out.exists()


def test_a_function_from_observation_to_action_is_recorded(tmp_path: Path, minari: Any) -> None:
    def far(observation: np.ndarray) -> np.ndarray:
        return 100.0 * (observation[24:32] - observation[:8])

    record_dataset(made(), far, 1, tmp_path / "d", seed=3)
    (episode,) = minari.MinariDataset(tmp_path / "d" / "data")
    for observation, action in zip(episode.observations[:-1], episode.actions, strict=True):
        np.testing.assert_array_equal(action, np.clip(far(observation), -1, 1).astype(np.float32))
    metadata = json.loads((tmp_path / "d" / "data" / "metadata.json").read_text())
    assert metadata["algorithm_name"] == "far"
    assert np.abs(episode.actions).max() == 1.0


def test_a_policy_of_stable_baselines3_is_recorded(tmp_path: Path, minari: Any) -> None:
    if importlib.util.find_spec("stable_baselines3") is None:
        pytest.skip("stable_baselines3 is not installed")
    # In a process of its own: PyTorch crashes where Mesa was loaded first; see `envs.gl`.
    result = python(f"""
import gymnasium
from stable_baselines3 import PPO
from mpma_mj import record_dataset

env = gymnasium.make({FLAT!r}, motion="ymca", arms="kinematic", repeats=1)
model = PPO("MlpPolicy", env, device="cpu")
record_dataset(env, lambda seen: model.predict(seen)[0], 1, {str(tmp_path / "d")!r})
for wrong in (model, model.predict):
    try:
        record_dataset(env, wrong, 1, {str(tmp_path / "e")!r})
    except ValueError as error:
        print(error)
""")
    assert result.returncode == 0, result.stderr
    of_model, of_predict = result.stdout.splitlines()
    assert "PPO" in of_model
    assert "; expected an agent of mpma_mj, or a function" in of_model
    assert of_predict == "action is not an array; expected shape (8,)"
    assert len(minari.MinariDataset(tmp_path / "d" / "data")) == 1
    assert not (tmp_path / "e").exists()


def test_an_agent_that_can_be_called_has_to_fit_too(tmp_path: Path, minari: Any) -> None:
    slower = follower(control_timestep=0.1)
    called = type("Called", (type(slower),), {"__call__": lambda *_: np.zeros(8)})
    with pytest.raises(BadOptionError, match=r"agent is for other arms or another control times"):
        record_dataset(made(), called(slower.config, slower.spec), 1, tmp_path / "d")


class Foreign:
    def act(self, observation: Any) -> Any:
        return observation


@pytest.mark.parametrize("agent", [Foreign(), Foreign, None, "mpma", np.zeros(8)])
def test_what_is_neither_agent_nor_function_is_refused_in_one_line(
    agent: Any, tmp_path: Path, minari: Any
) -> None:
    with pytest.raises(BadOptionError) as error:
        record_dataset(made(), agent, 1, tmp_path / "d")
    assert str(error.value) == (
        f"agent is {agent!r}; expected an agent of mpma_mj, or a function from observation to"
        " action; of Stable-Baselines3 give lambda observation: model.predict(observation)[0]"
    )


@pytest.mark.parametrize(
    ("action", "message"),
    [
        (None, r"action is of type object; expected float64, shape \(8,\)"),
        (np.zeros(7), r"action has shape \(7,\); expected \(8,\)"),
        (np.full(8, np.nan), r"action\[0\] is nan; expected numbers in"),
    ],
)
def test_a_function_that_returns_no_action_is_refused(
    action: Any, message: str, tmp_path: Path, minari: Any
) -> None:
    with pytest.raises(BadOptionError, match=message):
        record_dataset(made(), lambda observation: action, 1, tmp_path / "d")
    assert not (tmp_path / "d").exists()


def test_environments_that_cannot_be_made_again_are_refused(tmp_path: Path, minari: Any) -> None:
    with pytest.raises(BadOptionError, match=r"motion is .*; expected names and numbers"):
        record_dataset(made(motion=read_motion("ymca")), follower(), 1, tmp_path / "d")
    cart: Any = gymnasium.make("CartPole-v1")
    for env in (cart, load("ymca", **IDEAL), make_vec(2, "ymca", **IDEAL), None):
        with pytest.raises(BadOptionError, match=r"env is .*; expected what gymnasium.make retu"):
            record_dataset(env, follower(), 1, tmp_path / "d")
    with pytest.raises(BadOptionError, match=r"env is .*; expected what gymnasium.make returned"):
        record_dataset(made().unwrapped.__class__(**IDEAL), follower(), 1, tmp_path / "d")


def test_without_minari_one_line_says_how_to_install_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "minari", None)
    with pytest.raises(BadOptionError) as error:
        record_dataset(made(), follower(), 1, tmp_path / "d")
    assert str(error.value) == (
        "datasets need Minari, which is not installed; pip install 'mpma-mj[minari]', or in a"
        " checkout pip install -e '.[minari]'"
    )
