"""What a run is made of: environment and agent, as its settings say."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import fields
from typing import Any, TypeAlias

from dm_control.rl import control
from threadpoolctl import threadpool_limits

from mpma_mj.agents import (
    AGENTS,
    Agent,
    AgentConfig,
    AgentSpec,
    MPMAConfig,
    NetworkConfig,
    agent_class,
)
from mpma_mj.agents.base import Seeds
from mpma_mj.agents.wrappers import AlteredContext, altered_context_size
from mpma_mj.envs.options import check_seed, seeds_of_batch
from mpma_mj.envs.task import TwoArmImitation
from mpma_mj.envs.vector_env import FlatVectorImitationEnv, VectorImitationEnv
from mpma_mj.errors import BadOptionError
from mpma_mj.motions import Motion
from mpma_mj.options import AgentName
from mpma_mj.training.config import RunConfig

__all__ = [
    "agent_config",
    "agent_of",
    "architecture",
    "config_of",
    "environment_options",
    "environments_of",
    "make_agent",
    "one_thread",
]

Environments: TypeAlias = control.Environment | VectorImitationEnv

_THREADS = 1  # of physics: runs side by side share processors by processes


def make_agent(
    env: Environments,
    config: AgentConfig = MPMAConfig(),  # noqa: B008, frozen
    *,
    kind: str = "mpma",
    seed: Seeds = 0,
) -> Agent:
    """Return an untrained agent that fits an environment.

    Args:
        env: Environment that `load` returned, or those that `make_vec` did.
        config: Config, of which an agent takes the fields that it has.
        kind: A name of `mpma_mj.agents.AGENTS`, or the path of a class.
        seed: Seed of weights and noise; for many environments the first member's, which the
            others' follow, or one for each.

    Returns:
        The agent; for many environments a batch of as many runs.

    Raises:
        BadOptionError: There is no such kind, a seed is no whole number from 0 up, there are not
            as many seeds as environments, or the environment is another, or flat.
    """
    if not isinstance(config, AgentConfig):
        raise BadOptionError(option="config", value=config, expected="a config of an agent")
    agent_type = agent_class(kind)
    own = config if type(config) is agent_type.config_type else agent_config(agent_type, config)
    return _wrapped(agent_type, own, env, _seeds(env, seed))


def agent_config(agent_type: type[Agent], flat: object) -> AgentConfig:
    """Return an agent's own config, with the fields that it shares with another."""
    names = [f.name for f in fields(agent_type.config_type) if hasattr(flat, f.name)]
    return agent_type.config_type(**{name: getattr(flat, name) for name in names})


def _wrapped(agent_type: type[Agent], config: AgentConfig, env: Environments, seed: Seeds) -> Agent:
    """Return an agent that receives the context of its config."""
    spec = _spec(env)
    signal = config.context_signal if isinstance(config, NetworkConfig) else "labels"
    size = altered_context_size(signal, spec.context_size)
    agent = agent_type(config, dataclasses.replace(spec, context_size=size), seed=seed)
    if signal == "labels":
        return agent
    info = env if isinstance(env, VectorImitationEnv) else env.task
    return AlteredContext(agent, signal, info.context, info.period, seed)


def _spec(env: Environments) -> AgentSpec:
    if isinstance(env, FlatVectorImitationEnv):
        raise BadOptionError("env is flat, but agents need observations by name; leave flat out")
    if isinstance(env, VectorImitationEnv):
        context_size = len(env.motion.labels)
        return AgentSpec(context_size, env.max_joint_speed, env.control_timestep)
    if not isinstance(getattr(env, "task", None), TwoArmImitation):
        raise BadOptionError(
            f"env is {env}; expected what mpma_mj.load or mpma_mj.make_vec returned"
        )
    return AgentSpec(
        context_size=env.observation_spec()["context"].shape[0],
        max_joint_speed=env.task.max_joint_speed,
        control_timestep=env.control_timestep(),
    )


def _seeds(env: Environments, seed: Seeds) -> Seeds:
    """Return a seed, or one for each of many environments."""
    if not isinstance(env, VectorImitationEnv):
        return check_seed(seed)
    return [check_seed(own) for own in seeds_of_batch(seed, env.num_envs)]


def architecture(config: RunConfig) -> AgentConfig:
    """Return the config of the agent of a run."""
    return agent_config(agent_class(config.agent), config)


def agent_of(config: RunConfig, env: Environments, seed: Seeds) -> Agent:
    """Return the agent of a run, or those of runs side by side.

    Args:
        config: Settings, of which the seed does not count.
        env: Environment, or environments.
        seed: Seed of weights and noise, or one for each environment.

    Raises:
        BadOptionError: A setting is outside what it may be, or the agent does not have it.
    """
    agent_type = agent_class(config.agent)
    for name, default in _irrelevant(config.agent).items():
        if getattr(config, name) != default:
            raise BadOptionError(
                f"{name} is {getattr(config, name)}, which {config.agent} does not have; leave"
                " it out"
            )
    return _wrapped(agent_type, agent_config(agent_type, config), env, _seeds(env, seed))


def _irrelevant(agent: str) -> dict[str, Any]:
    """Return the defaults of settings that other agents have; all may stand in a grid of sizes."""
    names = {f.name for one in AGENTS.values() for f in fields(one.config_type)}
    names -= {f.name for f in fields(agent_class(agent).config_type)} | {"modules", "nodes"}
    return {f.name: f.default for f in fields(RunConfig) if f.name in names}


def config_of(config: RunConfig, agent: AgentName) -> RunConfig:
    """Return the settings of a run for another agent; what it does not have is left out."""
    return dataclasses.replace(config, agent=agent, **_irrelevant(agent))


def environment_options(config: RunConfig) -> dict[str, Any]:
    """Return the options of the environment of a run, by name, but for the movement."""
    return {name: getattr(config, name) for name in ("arms", "repeats", "reference_noise", "seed")}


def environments_of(
    config: RunConfig, seeds: Sequence[int], motion: Motion, env_options: Mapping[str, Any]
) -> VectorImitationEnv:
    """Return the environments of runs side by side.

    Args:
        config: Settings of the runs, of which the seed does not count.
        seeds: Seed of each.
        motion: The movement.
        env_options: Options of the environment that are other than the settings say.

    Raises:
        MpmaError: An option is outside what it may be, or the movement is faster than the arms.
    """
    options = environment_options(config) | dict(env_options)
    envs = VectorImitationEnv(len(seeds), motion=motion, threads=_THREADS, **options)
    envs.reset(seed=seeds)
    return envs


def one_thread() -> threadpool_limits:
    """Keep BLAS to one thread.

    The matrices are small: with two threads training takes twice as long. And results do not
    depend on the number of cores.
    """
    return threadpool_limits(1, user_api="blas")
