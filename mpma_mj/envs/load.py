"""The factory of environments."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

import numpy as np
from dm_control.rl import control
from numpy.typing import NDArray

from mpma_mj.envs.model_validation import check_geometry
from mpma_mj.envs.options import EnvironmentOptions, options_from
from mpma_mj.envs.physics import KinematicArms, PhysicsArms
from mpma_mj.envs.task import TwoArmImitation
from mpma_mj.errors import BadOptionError
from mpma_mj.motions import Motion, read_motion
from mpma_mj.motions.reach import check_ranges, check_reach
from mpma_mj.options import Arms

__all__ = ["arm_limits", "load", "make_environment", "prepare"]

P = ParamSpec("P")
R = TypeVar("R")

_KINDS = {"physics": PhysicsArms, "kinematic": KinematicArms}


def _takes(options: Callable[P, object]) -> Callable[[Callable[..., R]], Callable[P, R]]:
    """Tell type checkers and `help` that a function takes what makes the options."""

    def decorate(function: Callable[..., R]) -> Callable[P, R]:
        returned = inspect.signature(function).return_annotation
        signature = inspect.signature(options).replace(return_annotation=returned)
        function.__signature__ = signature  # type: ignore[attr-defined]
        return function

    return decorate


@_takes(EnvironmentOptions)
def load(*motion: Any, **options: Any) -> control.Environment:
    """Return an environment in which two arms imitate a movement.

    The control step is one posture of the movement, 0.05 s at the usual 20 Hz.

    Args:
        *motion: The movement, or what `read_motion` takes: "ymca", or a recording's path.
        **options: The fields of `EnvironmentOptions`, such as arms="kinematic".

    Returns:
        A `dm_env.Environment`; see `TwoArmImitation` for observation, action and reward.

    Raises:
        BadOptionError: An option is outside what it may be, or there is none of that name.
        MpmaError: The movement cannot be read, or is faster than the arms.
    """
    return make_environment(options_from(*motion, **options))


def make_environment(options: EnvironmentOptions) -> control.Environment:
    """Return the environment of options; see `load`."""
    motion, physics, nstep = prepare(options)
    return control.Environment(
        physics, TwoArmImitation(motion, options, physics), n_sub_steps=nstep
    )


def prepare(options: EnvironmentOptions) -> tuple[Motion, PhysicsArms, int]:
    """Return the movement, arms that can follow it, and the physics steps of a control step.

    Args:
        options: Options of the environment.

    Raises:
        MpmaError: As of `load`.
    """
    motion = _motion(options)
    physics = _KINDS[options.arms].make(options)
    if options.model is not None:
        check_geometry(Path(options.model), physics)
    check_reach(motion, physics.max_joint_speed, physics.max_elbow)
    if options.model is not None:
        check_ranges(motion, *physics.joint_range)
    return motion, physics, _physics_steps(motion.rate, physics.timestep())


def _physics_steps(rate: float, timestep: float) -> int:
    """Return the physics steps of a control step, at a rate in Hz and a timestep in s."""
    steps = 1.0 / rate / timestep
    fewer = max(1, math.floor(steps + 1e-6))
    if abs(steps - round(steps)) > 1e-6 or round(steps) < 1:
        raise BadOptionError(
            f"rate is {rate:g} Hz; one control step, {1000 / rate:g} ms, has to be a whole number"
            f" of physics steps of {1000 * timestep:g} ms, as at {1 / timestep / (fewer + 1):.6g}"
            f" or {1 / timestep / fewer:.6g} Hz (control_timestep {(fewer + 1) * timestep:g} or"
            f" {fewer * timestep:g} s)"
        )
    return round(steps)


def arm_limits(arms: Arms) -> tuple[NDArray[np.float64], float]:
    """Return what arms can do.

    Returns:
        Fastest that each joint can turn, shape (8,), rad/s, and how far an elbow bends, rad.
    """
    physics = _KINDS[arms].make()
    return physics.max_joint_speed, physics.max_elbow


def _motion(options: EnvironmentOptions) -> Motion:
    """Return the movement at the rate of control."""
    motion, timestep = options.motion, options.control_timestep
    if not isinstance(motion, Motion):
        return read_motion(motion) if timestep is None else read_motion(motion, rate=1 / timestep)
    if timestep is not None and abs(motion.rate * timestep - 1.0) > 1e-9:
        raise BadOptionError(
            f"control_timestep is {timestep:g} s, but {motion.name} has a posture every"
            f" {1 / motion.rate:g} s; read it with rate={1 / timestep:g}"
        )
    return motion
