"""What a step of the environment costs beside its physics, alone and in company."""

from __future__ import annotations

import mujoco
import numpy as np
from dm_control.rl.control import Environment
from mujoco import rollout
from numpy.typing import NDArray

from mpma_mj.bench.child import program
from mpma_mj.bench.report import Report
from mpma_mj.bench.timing import Case, Progress, in_turn, ratio, spread
from mpma_mj.envs.arm_batch import chunk_size
from mpma_mj.envs.gym_env import ImitationEnv
from mpma_mj.envs.load import load
from mpma_mj.envs.vector_env import make_vec
from mpma_mj.utils.system import processors

__all__ = ["bare_rollout", "bare_steps", "env_steps", "measure"]

Array = NDArray[np.float64]

_STATE = mujoco.mjtState.mjSTATE_FULLPHYSICS
_MEMBERS = 64
_STEPS = 225  # of an episode of 227, so that no reset is timed
_BATCHES = 20
_ROUNDS, _STARTS = 21, 5

_FLOOR = "bare mj_step calls, one step's worth"
_STEP = "env.step"
_GYM = "the same through Gymnasium"
_ALONE = f"env.step, {_MEMBERS} environments one after the other"
_TOGETHER = f"make_vec({_MEMBERS}).step, per environment"
_ROLLOUT = f"bare mujoco.rollout of {_MEMBERS}, per environment"
_OURS = "import mpma_mj; load()"
_THEIRS = 'from dm_control import suite; suite.load("reacher", "easy")'
_PROGRAMS = {_OURS: "import mpma_mj; mpma_mj.load()", _THEIRS: _THEIRS}


def measure(progress: Progress) -> Report:
    """Time physics arms on the built-in dance, and the start of a program.

    Args:
        progress: Shows how far a range of rounds is, under a title.
    """
    cases = {_FLOOR: bare_steps(load()), _STEP: env_steps(load()), _GYM: env_steps(ImitationEnv())}
    times = in_turn(cases, progress(range(_ROUNDS), "timing one environment"))
    cases = {
        _ALONE: _one_after_the_other(),
        _TOGETHER: _together(),
        _ROLLOUT: bare_rollout(processors()),
    }
    times |= in_turn(cases, progress(range(_ROUNDS), f"timing {_MEMBERS} environments"))
    starts = {name: program("-c", code) for name, code in _PROGRAMS.items()}
    times |= in_turn(starts, progress(range(_STARTS), "timing the start of a program"))
    return Report(
        seconds={name: spread(values) for name, values in times.items()},
        ratios={
            "env.step over bare mj_step calls": ratio(times[_STEP], times[_FLOOR], 1.35),
            "throughput of make_vec over one after the other": ratio(
                times[_ALONE], times[_TOGETHER], 1.6, at_least=True
            ),
            "make_vec over bare mujoco.rollout": ratio(times[_TOGETHER], times[_ROLLOUT], 1.5),
            "import and first environment over dm_control's": ratio(
                times[_OURS], times[_THEIRS], 1.5
            ),
        },
    )


def _actions(*shape: int) -> Array:
    return np.random.default_rng(0).uniform(-1.0, 1.0, (*shape, 8))


def bare_steps(env: Environment, controls: Array | None = None) -> Case:
    """Return the same simulation as `env_steps`, by bare calls: the floor.

    Args:
        env: What is simulated.
        controls: Controls of T steps, shape (T, U); random joint velocities if not given.

    Returns:
        Its unit of work is a control step.
    """
    env.reset()
    model, data = env.physics.model.ptr, env.physics.data.ptr
    nstep = round(env.control_timestep() / env.physics.timestep())
    begin = env.physics.get_state(_STATE)
    if controls is None:
        controls = _actions(_STEPS) * env.task.max_joint_speed

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

    Returns:
        Its unit of work is a control step.
    """
    if actions is None:
        actions = _actions(_STEPS)

    def run() -> int:
        for action in actions:
            env.step(action)
        return len(actions)

    return Case(run, env.reset)


def _one_after_the_other() -> Case:
    envs = [load(seed=i) for i in range(_MEMBERS)]
    actions = _actions(_BATCHES, _MEMBERS)

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


def bare_rollout(threads: int) -> Case:
    """Return the same simulation as `_together`, by bare calls with all that makes them fast.

    Args:
        threads: How many simulate at a time.

    Returns:
        Its unit of work is a control step of one pair of arms.
    """
    env = load()
    model = env.physics.model.ptr
    nstep = round(env.control_timestep() / env.physics.timestep())
    controls = _actions(_BATCHES, _MEMBERS) * env.task.max_joint_speed
    size = mujoco.mj_stateSize(model, _STATE)
    begin, trajectory = np.zeros((_MEMBERS, size)), np.zeros((_MEMBERS, nstep, size))
    for row in begin:
        env.reset()
        row[:] = env.physics.get_state(_STATE)
    applied = np.zeros((_MEMBERS, nstep, model.nu))
    models, data = [model] * _MEMBERS, [mujoco.MjData(model) for _ in range(threads)]
    pool = rollout.Rollout(nthread=threads)

    def run() -> int:
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
                chunk_size=chunk_size(_MEMBERS, threads),
            )
            state = trajectory[:, -1].copy()
        return _BATCHES * _MEMBERS

    return Case(run)
