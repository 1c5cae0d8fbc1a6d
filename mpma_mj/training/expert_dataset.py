"""Datasets of an agent's episodes in Minari's format, for offline learners."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import gymnasium
import numpy as np
from gymnasium.envs.registration import EnvSpec
from numpy.typing import NDArray

from mpma_mj.agents import Agent, NetworkConfig
from mpma_mj.agents.wrappers import AgentWrapper, Frozen, altered_context_size
from mpma_mj.envs.gym_env import ImitationEnv
from mpma_mj.envs.options import check_seed
from mpma_mj.envs.step_rules import check_action
from mpma_mj.envs.wrappers import GymEvaluate
from mpma_mj.errors import BadOptionError
from mpma_mj.utils.atomic_files import atomic_folder
from mpma_mj.utils.folder_lock import is_empty, locked
from mpma_mj.utils.validation import is_integer

if TYPE_CHECKING:
    from minari.data_collector.episode_buffer import EpisodeBuffer

__all__ = ["check_dataset", "record_dataset", "write_dataset"]

_INSTALL = (
    "datasets need Minari, which is not installed; pip install 'mpma-mj[minari]', or in a checkout"
    " pip install -e '.[minari]'"
)
_DATASET_ID = re.compile(r"([-\w]+/)*[-\w]+-v\d+")  # Minari's

Policy = Callable[[Any], Any]
"""Function from an observation of the environment to an action, shape (8,)."""

_OF_AGENT = ("spec", "config", "seed", "observes_plant", "act", "observe", "reset")


def record_dataset(
    env: gymnasium.Env[Any, Any],
    agent: Agent | Policy,
    episodes: int,
    path: str | Path,
    *,
    seed: int = 0,
    overwrite: bool = False,
) -> Path:
    """Record episodes of an agent as a Minari dataset.

    `minari.MinariDataset(path / "data")` opens it, and `recover_environment()` of that makes the
    environment again. The agent learns nothing. Episode k is the one that follows
    `env.reset(seed=seed + k)`; its actions are rounded to the action space's single precision
    before they are executed, so that they lead to the recorded observations again.

    Args:
        env: Environment that `gymnasium.make` returned for a motion's name or path, flat or not.
        agent: Agent of one run; or a policy of another library, as a function from an observation
            of `env` to an action, shape (8,), which is clipped to the action space.
        episodes: Number of episodes.
        path: Folder of the dataset.
        seed: Seed of the first episode.
        overwrite: Whether a dataset in the folder may be replaced.

    Returns:
        The folder.

    Raises:
        BadOptionError: Minari is not installed, the folder exists, the agent is neither an agent
            nor a function or does not fit the environment, or that cannot be made again from names
            and numbers.
        RunFolderError: The folder cannot be written, or another command writes into it.
    """
    path = Path(path)
    with locked(path):
        check_dataset(path, episodes, overwrite=overwrite)
        return write_dataset(env, agent, episodes, path, seed=seed)


def write_dataset(
    env: gymnasium.Env[Any, Any], agent: Agent | Policy, episodes: int, path: Path, *, seed: int
) -> Path:
    """Record episodes into a folder that is locked and checked; see `record_dataset`."""
    inner = env.unwrapped if isinstance(env, gymnasium.Env) else None
    if not isinstance(inner, ImitationEnv) or env.spec is None:
        expected = "what gymnasium.make returned for an environment of mpma_mj"
        raise BadOptionError(option="env", value=env, expected=expected)
    _check_recoverable(env.spec)
    name = _algorithm(agent)
    if isinstance(agent, Agent | type) or not callable(agent):
        agent = Frozen(_checked_agent(agent, inner))
    first = check_seed(seed)
    evaluated = GymEvaluate(env)
    buffers = [_episode(evaluated, inner, agent, first + k, k) for k in range(episodes)]
    p_e = [metrics["p_e_percent"] for metrics in evaluated.episode_metrics]
    metadata = {
        "dataset_id": path.name if _DATASET_ID.fullmatch(path.name) else f"{_stem(path)}-v0",
        "algorithm_name": name,
        "description": f"{name} that imitates {_motion(env.spec)}; number of episodes: {episodes}",
        "expert_p_e_percent": float(np.mean(p_e)),
    }
    _write(path, env, buffers, metadata, p_e)
    return path


def check_dataset(path: Path, episodes: int, *, overwrite: bool) -> None:
    """Check that a dataset can be written to a folder, before an agent is trained for it.

    Raises:
        BadOptionError: Minari is not installed, there are no episodes, or the folder exists and
            holds something else, or a dataset that may not be replaced.
    """
    try:
        import h5py  # noqa: F401, Minari imports it later
        import minari  # noqa: F401
    except ImportError:
        raise BadOptionError(_INSTALL) from None
    if not is_integer(episodes) or episodes < 1:
        expected = "a whole number of at least 1"
        raise BadOptionError(option="episodes", value=episodes, expected=expected)
    if not os.path.lexists(path) or (path.is_dir() and is_empty(path)):
        return
    if not (path / "data" / "metadata.json").is_file():
        raise BadOptionError(
            f"{path}: already exists, and is no dataset", remedy="choose another folder"
        )
    if not overwrite:
        raise BadOptionError(f"{path}: already exists", remedy="{overwrite} replaces it")


def _check_recoverable(spec: EnvSpec) -> None:
    """Refuse an environment that was made from an object, such as a `Motion`."""
    for option, value in spec.kwargs.items():
        try:
            json.dumps(value)
        except TypeError:
            expected = "names and numbers, as a dataset keeps no objects; a motion's name or path"
            raise BadOptionError(option=option, value=value, expected=expected) from None


def _checked_agent(agent: Any, env: ImitationEnv) -> Agent:
    """Return an agent of one run that was made for the environment's observations and arms."""
    if not all(hasattr(agent, name) for name in _OF_AGENT):
        raise BadOptionError(
            option="agent",
            value=agent,
            expected="an agent of mpma_mj, or a function from observation to action",
            remedy="of Stable-Baselines3 give lambda observation: model.predict(observation)[0]",
        )
    if np.ndim(agent.seed):
        raise BadOptionError("agent is a batch of runs; expected an agent of one run")
    env.reset()
    labels = len(env.last_observation["context"])
    signal = agent.config.context_signal if isinstance(agent.config, NetworkConfig) else "labels"
    expected = altered_context_size(signal, labels)
    if agent.spec.context_size != expected:
        raise BadOptionError(
            f"agent has a context of size {agent.spec.context_size}, but the environment's motion"
            f" leads to one of {expected}",
            remedy="choose the motion that it was trained on",
        )
    same_speed = np.allclose(agent.spec.max_joint_speed, env.max_joint_speed)
    if not same_speed or not np.isclose(agent.spec.control_timestep, env.control_timestep):
        raise BadOptionError(
            "agent is for other arms or another control timestep than those of the environment",
            remedy="make the environment with the options with which it was trained",
        )
    checked: Agent = agent
    return checked


def _episode(
    env: GymEvaluate, inner: ImitationEnv, agent: Agent | Policy, seed: int, number: int
) -> EpisodeBuffer:
    """Return an episode of the agent, with the arrays of Minari's buffer."""
    from minari.data_collector.episode_buffer import EpisodeBuffer

    if isinstance(agent, Agent):
        agent.reset(number)
    observation, info = env.reset(seed=seed)
    space = env.action_space
    assert isinstance(space, gymnasium.spaces.Box)
    observations, actions, rewards, terminations, truncations = [observation], [], [], [], []
    over = False
    while not over:
        if not isinstance(agent, Agent):
            action = check_action(agent(observation))
        else:
            if agent.observes_plant:
                plant = info.get("plant")
                agent.observe_plant(None if plant is None else np.asarray(plant, np.intp))
            action = agent.act(inner.last_observation)
        action = np.clip(action, space.low, space.high).astype(np.float32)
        observation, reward, terminated, truncated, info = env.step(action)
        over = terminated or truncated
        observations.append(observation)
        actions.append(action)
        rewards.append(float(reward))
        terminations.append(terminated)
        truncations.append(truncated)
    p_e = np.full(len(observations), np.nan)  # known at the end, as in `info`
    p_e[-1] = env.episode_metrics[-1]["p_e_percent"]
    return EpisodeBuffer(
        seed=seed,
        observations=_stacked(observations),
        actions=np.array(actions),
        rewards=rewards,
        terminations=terminations,
        truncations=truncations,
        infos={"p_e_percent": p_e},
    )


def _stacked(observations: list[Any]) -> NDArray[np.float64] | dict[str, NDArray[np.float64]]:
    if isinstance(observations[0], dict):
        return {name: np.array([one[name] for one in observations]) for name in observations[0]}
    return np.array(observations)


def _write(
    path: Path,
    env: gymnasium.Env[Any, Any],
    episodes: list[EpisodeBuffer],
    metadata: dict[str, Any],
    p_e: list[float],
) -> None:
    """Write a dataset; its folder is complete or as it was."""
    import minari
    from minari.dataset.minari_storage import MinariStorage

    # Minari cannot write to a relative path.
    with atomic_folder(path.absolute() / "data") as folder:
        storage = MinariStorage.new(
            folder,
            observation_space=env.observation_space,
            action_space=env.action_space,
            env_spec=env.spec,
        )
        storage.update_metadata(metadata | {"minari_version": minari.__version__})
        storage.update_episodes(episodes)
        storage.update_episode_metadata([{"p_e_percent": one} for one in p_e])


def _stem(path: Path) -> str:
    """Return a name that Minari accepts."""
    return re.sub(r"[^-\w]", "_", path.stem) or "dataset"


def _algorithm(agent: Agent | Policy) -> str:
    """Return the name of a function, or of the class of an agent inside all wrappers."""
    while isinstance(agent, AgentWrapper):
        agent = agent.agent
    return str(getattr(agent, "__name__", type(agent).__name__))


def _motion(spec: EnvSpec) -> str:
    return Path(str(spec.kwargs.get("motion", "ymca"))).name
