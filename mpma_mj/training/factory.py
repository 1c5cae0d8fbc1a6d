"""What a run is made of: environment and agent, as its settings say."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import fields
from typing import Any, Literal, TypeAlias, overload

from dm_control.rl import control
from threadpoolctl import threadpool_limits

from mpma_mj.agents import AGENTS, MPMA, Agent, AgentSpec, MPMAConfig
from mpma_mj.agents.altered_context import AlteredContext, altered_context_size
from mpma_mj.agents.base import Seeds
from mpma_mj.agents.registry import IRRELEVANT_OPTIONS
from mpma_mj.envs.load import load
from mpma_mj.envs.options import check_seed, seeds_of_batch
from mpma_mj.envs.task import TwoArmImitation
from mpma_mj.envs.vector_env import FlatVectorImitationEnv, VectorImitationEnv
from mpma_mj.errors import BadOptionError
from mpma_mj.motions import Motion
from mpma_mj.options import AgentName
from mpma_mj.training.config import RunConfig

__all__ = [
    "agent_of",
    "architecture",
    "config_of",
    "environment_of",
    "environment_options",
    "environments_of",
    "make_agent",
    "one_thread",
]

Environments: TypeAlias = control.Environment | VectorImitationEnv

_THREADS = 1  # of physics: runs side by side share processors by processes


@overload
def make_agent(
    env: Environments,
    config: MPMAConfig = ...,
    *,
    kind: Literal["mpma", "single"] = ...,
    seed: Seeds = ...,
) -> MPMA: ...


@overload
def make_agent(
    env: Environments, config: MPMAConfig = ..., *, kind: str, seed: Seeds = ...
) -> Agent: ...


def make_agent(
    env: Environments,
    config: MPMAConfig = MPMAConfig(),  # noqa: B008, frozen
    *,
    kind: str = "mpma",
    seed: Seeds = 0,
) -> Agent:
    """Return an untrained agent that fits an environment.

    Args:
        env: Environment that `load` returned, or those that `make_vec` did.
        config: Settings, of which an agent takes what it has: MOSAIC and HAMMER those of the
            networks, HAMMER not the number of modules, agents without networks none.
        kind: One of `mpma_mj.agents.AGENTS`: "mpma" or a rival.
        seed: Seed of weights and noise; for many environments the first member's, which the
            others' follow, or one for each.

    Returns:
        The agent; for many environments as many side by side, see `BatchedAgent`: they learn by
        `learn_batch()` in place of `learn()`.

    Raises:
        BadOptionError: There is no such kind, a seed is no whole number from 0 up, there are not
            as many seeds as environments, or the environment is another, or flat.
    """
    if not isinstance(config, MPMAConfig):
        raise BadOptionError(f"config is {config!r}; expected an MPMAConfig")
    _check_name("kind", kind)
    return AGENTS[kind](config, _spec(env), _seeds(env, seed))


def _check_name(option: str, name: object) -> None:
    if not isinstance(name, str) or name not in AGENTS:
        raise BadOptionError(f"{option} is '{name}'; expected one of {', '.join(AGENTS)}")


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


def architecture(config: RunConfig) -> MPMAConfig:
    """Return the settings of the agent of a run."""
    return MPMAConfig(**{f.name: getattr(config, f.name) for f in fields(MPMAConfig)})


def agent_of(config: RunConfig, env: Environments, seed: Seeds) -> Agent:
    """Return the agent of a run, or those of runs side by side.

    Args:
        config: Settings, of which the seed does not count.
        env: Environment, or environments.
        seed: Seed of weights and noise, or one for each environment.

    Raises:
        BadOptionError: A setting is outside what it may be, or the agent does not have it.
    """
    _check_name("agent", config.agent)
    _refuse_what_is_not_taken(config)
    spec, seeds = _spec(env), _seeds(env, seed)
    heard = dataclasses.replace(
        spec, context_size=altered_context_size(config.context_signal, spec.context_size)
    )
    agent = AGENTS[config.agent](architecture(config), heard, seeds)
    if config.context_signal == "labels":
        return agent
    info = env if isinstance(env, VectorImitationEnv) else env.task
    return AlteredContext(agent, config.context_signal, info.context, info.period, seeds)


def _refuse_what_is_not_taken(config: RunConfig) -> None:
    for setting in fields(config):
        value = getattr(config, setting.name)
        if setting.name in IRRELEVANT_OPTIONS.get(config.agent, ()) and value != setting.default:
            raise BadOptionError(
                f"{setting.name} is {value}, which {config.agent} does not have; leave it out"
            )


def config_of(config: RunConfig, agent: AgentName) -> RunConfig:
    """Return the settings of a run for another agent; what it does not have is left out."""
    default = {setting.name: setting.default for setting in fields(config)}
    left_out: dict[str, Any] = {name: default[name] for name in IRRELEVANT_OPTIONS.get(agent, ())}
    return dataclasses.replace(config, agent=agent, **left_out)


def environment_options(config: RunConfig) -> dict[str, Any]:
    """Return the options of the environment of a run, by name, but for the movement."""
    return {name: getattr(config, name) for name in ("arms", "repeats", "reference_noise", "seed")}


def environment_of(
    config: RunConfig, motion: Motion, env_options: Mapping[str, Any]
) -> control.Environment:
    """Return the environment of one run.

    Args:
        config: Config of the run.
        motion: The motion.
        env_options: Options of the environment that differ from those of the config.

    Raises:
        MpmaError: An option is out of bounds, or the arms cannot follow the motion.
    """
    return load(motion, **environment_options(config) | dict(env_options))


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
