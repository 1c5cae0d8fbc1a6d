"""Construction of the environments and agents of runs from configs."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any, TypeAlias, overload

from dm_control.rl import control
from threadpoolctl import threadpool_limits

from mpma_mj.agents import Agent, AgentConfig, AgentSpec, NetworkConfig, agent_class
from mpma_mj.agents.base import Seeds
from mpma_mj.agents.config import CONFIG_TYPES
from mpma_mj.agents.wrappers import AlteredContext, altered_context_size
from mpma_mj.envs.load import make_environment
from mpma_mj.envs.options import check_seed, seeds_of_batch
from mpma_mj.envs.task import TwoArmImitation
from mpma_mj.envs.vector_env import FlatVectorImitationEnv, VectorImitationEnv
from mpma_mj.errors import BadOptionError, CheckpointError, placeholder
from mpma_mj.motions import Motion
from mpma_mj.training.config import RunConfig
from mpma_mj.training.config_json import OutsideConfig

__all__ = ["agent_of", "make_agent", "make_environments", "one_thread"]

Environments: TypeAlias = control.Environment | VectorImitationEnv

_THREADS = 1  # of physics: batches of runs use several processors through processes


def make_agent(
    env: Environments,
    config: AgentConfig | None = None,
    *,
    kind: str | None = None,
    seed: Seeds = 0,
) -> Agent:
    """Return an untrained agent that fits an environment.

    Args:
        env: Environment that `mpma_mj.load` returned, or those that `mpma_mj.make_vec` returned.
        config: Config of the agent, its defaults if not given; from a config of another kind, the
            fields that both have are taken.
        kind: A name of `mpma_mj.agents.AGENTS`, or the path of a class, such as
            my_agents.py:MyAgent; the kind of the config if not given.
        seed: Seed of weights and noise. For many environments: the seed of the first run, which
            the seeds of the others follow, or one for each.

    Returns:
        The agent; for many environments a batch of as many runs.

    Raises:
        BadOptionError: There is no such kind, the config is not of an agent, a seed is negative or
            not an integer, there are not as many seeds as environments, or the environment is not
            one of this package, or flat.
    """
    if not isinstance(config, AgentConfig | None):
        raise BadOptionError(option="config", value=config, expected="a config of an agent")
    if config is None:
        given = RunConfig()
    else:
        named = "" if type(config) in CONFIG_TYPES.values() else kind or ""
        given = RunConfig(agent=config, agent_name=named)
    return agent_of(given.replace(agent=kind) if kind else given, env, seed)


def agent_of(config: RunConfig, env: Environments, seed: Seeds) -> Agent:
    """Return the agent of a run, or of a batch of runs; it receives its config's context signal.

    Args:
        config: Config; its seed is ignored.
        env: Environment, or environments.
        seed: Seed of weights and noise, or one for each environment.

    Raises:
        BadOptionError: As of `make_agent`.
        CheckpointError: The config is of a run folder, and names a class from outside that the
            user has not named.
    """
    if isinstance(config.agent, OutsideConfig):
        named = " and ".join(placeholder(*named) for named in config.agent.outside.items())
        raise CheckpointError(
            f"the run was trained with {' and '.join(config.agent.outside.values())}, code that is"
            " not in this package",
            remedy=f"if you trust it, name it with {named}",
        )
    kind, own = agent_class(config.agent_name), config.agent
    if isinstance(env, VectorImitationEnv):
        seed = [check_seed(single) for single in seeds_of_batch(seed, env.num_envs)]
    else:
        seed = check_seed(seed)
    if type(own) is not kind.config_type:
        expected = f"a {kind.config_type.__name__}, the config of {kind.__name__}"
        raise BadOptionError(option="config", value=own, expected=expected)
    spec = _spec(env)
    signal = own.context_signal if isinstance(own, NetworkConfig) else "labels"
    size = altered_context_size(signal, spec.context_size)
    agent = kind(own, dataclasses.replace(spec, context_size=size), seed=seed)
    if signal == "labels":
        return agent
    episodes = env if isinstance(env, VectorImitationEnv) else env.task
    return AlteredContext(agent, signal, episodes.context, episodes.period, seed)


@overload
def make_environments(
    config: RunConfig, seed: int, motion: Motion, changes: Mapping[str, Any] = ...
) -> control.Environment: ...
@overload
def make_environments(
    config: RunConfig, seed: Sequence[int], motion: Motion, changes: Mapping[str, Any] = ...
) -> VectorImitationEnv: ...
def make_environments(
    config: RunConfig,
    seed: int | Sequence[int],
    motion: Motion,
    changes: Mapping[str, Any] = MappingProxyType({}),
) -> Environments:
    """Return the environment of a run, or those of a batch of runs.

    Args:
        config: Config; its seed is ignored.
        seed: Seed of one run, or those of a batch.
        motion: The motion.
        changes: Options of the environment that differ from those of the config.

    Raises:
        MpmaError: An option is out of bounds, or the arms cannot follow the motion.
    """
    options = dataclasses.replace(config.env, **changes)
    if isinstance(seed, int):
        return make_environment(motion, options, seed)
    envs = VectorImitationEnv(len(seed), motion=motion, threads=_THREADS, **vars(options))
    envs.reset(seed=seed)
    return envs


def one_thread() -> threadpool_limits:
    """Limit BLAS to one thread.

    The matrices are small, and with two threads training takes twice as long. With one thread,
    results do not depend on the number of cores either.
    """
    return threadpool_limits(1, user_api="blas")


def _spec(env: Environments) -> AgentSpec:
    if isinstance(env, FlatVectorImitationEnv):
        raise BadOptionError("env is flat, but agents need observations by name; leave flat out")
    if isinstance(env, VectorImitationEnv):
        context_size, options = len(env.motion.labels), env.options
        max_joint_speed, control_timestep = env.max_joint_speed, env.control_timestep
        kinematics = env.arms.kinematics
    elif not isinstance(getattr(env, "task", None), TwoArmImitation):
        raise BadOptionError(
            f"env is {env}; expected what mpma_mj.load or mpma_mj.make_vec returned, not flat"
        )
    else:
        context_size, options = len(env.task.motion.labels), env.task.options
        max_joint_speed, control_timestep = env.task.max_joint_speed, env.control_timestep()
        kinematics = env.task.kinematics
    return AgentSpec(
        context_size=context_size,
        max_joint_speed=max_joint_speed,
        control_timestep=control_timestep,
        latency=options.latency if isinstance(options.latency, int) else None,
        longest_latency=options.longest_latency,
        lookahead=options.lookahead,
        kinematics=kinematics,
    )
