"""What a step of the environment costs in addition to its physics, alone and in a vector."""

from __future__ import annotations

from collections.abc import Callable

import mujoco
import numpy as np
from dm_control.rl.control import Environment
from mujoco import rollout
from numpy.typing import NDArray

from benchmarks.speed.timing import Case, Report, Sizes, in_turn, ratio
from mpma_mj.envs.arm_batch import chunk_size
from mpma_mj.envs.gym_env import ImitationEnv
from mpma_mj.envs.load import load
from mpma_mj.envs.make_vec import make_vec
from mpma_mj.utils.system import processors

__all__ = ["STEPS", "bare_steps", "env_steps", "measure"]

Array = NDArray[np.float64]

STEPS = 225
"""Steps that are timed, of an episode of 227, so that no reset is."""

_STATE = mujoco.mjtState.mjSTATE_FULLPHYSICS
_MEMBERS, _BATCHES = 64, 20  # environments of a vector, and its steps

_FLOOR, _STEP = "bare mj_step calls, one step's worth", "env.step"
_ALONE = f"env.step, {_MEMBERS} environments one after the other"
_TOGETHER = f"make_vec({_MEMBERS}).step, per environment"
_ROLLOUT = f"bare mujoco.rollout of {_MEMBERS}, per environment"


def measure(sizes: Sizes) -> Report:
    """Time physics arms on the built-in dance."""
    cases = {_FLOOR: bare_steps(load()), _STEP: env_steps(load())}
    cases["the same through Gymnasium"] = env_steps(ImitationEnv())
    times = in_turn("timing one environment", cases, sizes.rounds)
    cases = {_ALONE: _one_after_the_other(), _TOGETHER: _together()}
    cases[_ROLLOUT] = Case(_bare_rollout(processors(), _MEMBERS, _BATCHES))
    times |= in_turn(f"timing {_MEMBERS} environments", cases, sizes.rounds)
    gained = ratio(times[_ALONE], times[_TOGETHER], 1.6, at_least=True)
    targets = {
        "env.step over bare mj_step calls": ratio(times[_STEP], times[_FLOOR], 1.35),
        "throughput of make_vec over one after the other": gained,
        "make_vec over bare mujoco.rollout": ratio(times[_TOGETHER], times[_ROLLOUT], 1.5),
    }
    return Report(times, targets)


def bare_steps(env: Environment, controls: Array | None = None) -> Case:
    """Return the same simulation as `env_steps`, by bare calls: the floor.

    Args:
        env: What is simulated.
        controls: Controls of T steps, shape (T, U); random joint velocities if not given.
    """
    env.reset()
    model, data = env.physics.model.ptr, env.physics.data.ptr
    nstep = round(env.control_timestep() / env.physics.timestep())
    begin = env.physics.get_state(_STATE)
    if controls is None:
        controls = _actions(STEPS) * env.task.max_joint_speed

    def run() -> int:
        for control in controls:
            data.ctrl[:] = control
            for _ in range(nstep):
                mujoco.mj_step(model, data)
        return len(controls)

    return Case(run, lambda: mujoco.mj_setState(model, data, begin, _STATE))


def env_steps(env: Environment | ImitationEnv, actions: Array | None = None) -> Case:
    """Return the start of an episode.

    Args:
        env: What is stepped.
        actions: Actions of T steps, shape (T, U); random ones of all arms if not given.
    """
    if actions is None:
        actions = _actions(STEPS)

    def run() -> int:
        for action in actions:
            env.step(action)
        return len(actions)

    return Case(run, env.reset)


def _actions(*shape: int) -> Array:
    return np.random.default_rng(0).uniform(-1.0, 1.0, (*shape, 8))


def _one_after_the_other() -> Case:
    envs, actions = [load(seed=i) for i in range(_MEMBERS)], _actions(_BATCHES, _MEMBERS)

    def run() -> int:
        for batch in actions:
            for env, action in zip(envs, batch, strict=True):
                env.step(action)
        return _BATCHES * _MEMBERS

    return Case(run, lambda: [env.reset() for env in envs])


def _together() -> Case:
    envs, actions = make_vec(_MEMBERS), _actions(_BATCHES, _MEMBERS)

    def run() -> int:
        for batch in actions:
            envs.step(batch)
        return _BATCHES * _MEMBERS

    return Case(run, envs.reset)


def _bare_rollout(threads: int, members: int, steps: int) -> Callable[[], int]:
    """Return a simulation of arms under random commands, with all that makes it fast.

    Args:
        threads: How many simulate at a time.
        members: Number of pairs of arms.
        steps: Control steps of each.

    Returns:
        Function that simulates from the start and returns the control steps of all pairs.
    """
    env = load()
    model = env.physics.model.ptr
    nstep = round(env.control_timestep() / env.physics.timestep())
    actions = np.random.default_rng(0).uniform(-1.0, 1.0, (steps, members, model.nu))
    controls = actions * env.task.max_joint_speed
    size = mujoco.mj_stateSize(model, _STATE)
    begin, trajectory = np.zeros((members, size)), np.zeros((members, nstep, size))
    for row in begin:
        env.reset()
        row[:] = env.physics.get_state(_STATE)
    applied = np.zeros((members, nstep, model.nu))
    models, data = [model] * members, [mujoco.MjData(model) for _ in range(threads)]
    pool = rollout.Rollout(nthread=threads)

    def simulate() -> int:
        state = begin
        for control in controls:
            applied[:] = control[:, None]
            pool.rollout(
                models,
                data,
                state,
                applied,
                skip_checks=True,
                nstep=nstep,
                state=trajectory,
                chunk_size=chunk_size(members, threads),
            )
            state = trajectory[:, -1].copy()
        return steps * members

    return simulate
