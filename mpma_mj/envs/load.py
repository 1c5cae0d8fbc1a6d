"""Factory of environments."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Literal, Never

from dm_control.rl import control

from mpma_mj.envs.model_validation import check_geometry
from mpma_mj.envs.options import EnvironmentOptions, check_seed, options_among
from mpma_mj.envs.physics import KinematicArms, PhysicsArms
from mpma_mj.envs.plants import PlantsLike
from mpma_mj.envs.task import TwoArmImitation
from mpma_mj.errors import BadOptionError, RecordingWarning
from mpma_mj.motions import Motion, read_motion
from mpma_mj.motions.feasibility import JointLimits
from mpma_mj.motions.feasible_motion import feasible
from mpma_mj.options import TWO_ARM, Arms
from mpma_mj.utils.validation import Range

__all__: list[str] = ["arm_limits", "check_same_robot", "load", "make_environment", "prepare"]

_KINDS = {"physics": PhysicsArms, "kinematic": KinematicArms}


def load(  # noqa: D417 # the fields of `EnvironmentOptions` are documented there
    motion: Motion | str | Path = "ymca",
    *,
    seed: int = 0,
    arms: Arms = "physics",
    robot: str | Path = TWO_ARM,
    repeats: int = 3,
    reference_noise: float | Range = 0.01,
    control_timestep: float | None = None,
    gravity_compensation: bool = False,
    payload: float | Range = 0.0,
    actuator_strength: float | Range = 1.0,
    actuator_gain: float | Range = 1.0,
    damping: float | Range = 0.0,
    locked_joint: str | None = None,
    collisions: bool = False,
    latency: int | tuple[int, int] = 0,
    latency_every: tuple[float, float] | None = None,
    observation_noise: float | Range = 0.0,
    perturbation: tuple[float, float] = (0.0, 0.0),
    random_start: bool | Literal["adaptive"] = False,
    termination_distance: float | None = None,
    reward_weights: Mapping[str, float] | None = None,
    lookahead: int = 0,
    phase: bool = False,
    error_observation: bool = False,
    plants: PlantsLike | None = None,
    switch_every: tuple[float, float] | None = None,
    epochs_per_plant: int = 3,
    **options: Never,
) -> control.Environment:
    """Return an environment in which two arms imitate a motion.

    The control step is one posture of the motion, 0.05 s at the usual 20 Hz. All arguments but the
    first two are the fields of `EnvironmentOptions`, which documents them.

    Args:
        motion: The motion, or its name, such as "ymca", or the path of a recording.
        seed: Seed of everything random; episode k depends on the seed and k alone.

    Returns:
        A `dm_env.Environment`; see `TwoArmImitation` for observation, action and reward.

    Raises:
        BadOptionError: An option does not exist, is out of bounds, or contradicts another.
        MpmaError: The motion cannot be read.
    """
    return make_environment(motion, options_among(locals()), seed)


def make_environment(
    motion: Motion | str | Path,
    options: EnvironmentOptions,
    seed: int = 0,
    *,
    adjustable: bool = False,
) -> control.Environment:
    """Return the environment of a motion and options; see `load`.

    Args:
        motion: The motion.
        options: Options.
        seed: Seed of everything random.
        adjustable: Whether payload, gain, plant and latency can be set while it runs; see
            `TwoArmImitation.intervene`. No number depends on it.
    """
    seed = check_seed(seed)
    motion, physics, nstep = prepare(motion, options, adjustable=adjustable)
    task = TwoArmImitation(motion, options, physics, seed, adjustable=adjustable)
    return control.Environment(physics, task, n_sub_steps=nstep)


def prepare(
    motion: Motion | str | Path, options: EnvironmentOptions, *, adjustable: bool = False
) -> tuple[Motion, PhysicsArms, int]:
    """Return a motion that arms can follow, the arms, and the physics steps of a control step.

    Where the motion demands more than the arms have, a warning says what is changed. Motion,
    options and errors are those of `load`; whether it is adjustable, as of `make_environment`.
    """
    motion = _read(motion, options.control_timestep)
    physics = _KINDS[options.arms].make(options, adjustable=adjustable)
    if options.robot != TWO_ARM:
        check_geometry(Path(options.robot), physics)
    check_same_robot(motion.angles_of, physics.kinematics.name)
    motion, change = feasible(motion, _limits(physics))
    if change is not None:
        text = f"{motion.name}: {change}"
        warnings.warn(RecordingWarning(text, remedy=change.remedy), stacklevel=4)
    return motion, physics, _physics_steps(motion.rate, physics.timestep())


def check_same_robot(before: str, now: str, *, of_run: bool = False) -> None:
    """Check that a robot is what it was when a motion was fitted to it.

    Args:
        before: Name of its kinematics then.
        now: Name of its kinematics now.
        of_run: Whether another name is a change, too, and not just another robot.

    Raises:
        BadOptionError: It has changed.
    """
    robot = before.partition(" ")[0]
    if before != now and (of_run or robot == now.partition(" ")[0]):
        raise BadOptionError(
            f"{robot} is not what it was: its robot file or its model has changed",
            remedy="restore it, or read the motion and train again",
        )


def arm_limits(arms: Arms | EnvironmentOptions = "physics") -> JointLimits:
    """Return the limits of the joints of an environment's arms.

    Args:
        arms: Options of the environment; "physics" or "kinematic" are the package's arms.

    Raises:
        BadOptionError: A user's model cannot be read, or is incomplete.
    """
    options = arms if isinstance(arms, EnvironmentOptions) else EnvironmentOptions(arms=arms)
    return _limits(_KINDS[options.arms].make(options))


def _limits(physics: PhysicsArms) -> JointLimits:
    return JointLimits(physics.max_joint_speed, *physics.joint_range, physics.kinematics)


def _physics_steps(rate: float, timestep: float) -> int:
    """Return the physics steps of a control step, at a rate in Hz and a timestep in s."""
    steps = 1.0 / rate / timestep
    fewer = max(1, math.floor(steps + 1e-6))
    if abs(steps - round(steps)) > 1e-6 or round(steps) < 1:
        more = fewer + 1
        raise BadOptionError(
            f"rate is {rate:g} Hz; one control step, {1000 / rate:g} ms, must be a whole number of"
            f" physics steps of {1000 * timestep:g} ms, as at {1 / timestep / more:.6g} or"
            f" {1 / timestep / fewer:.6g} Hz",
            remedy=f"use {{control_timestep={more * timestep:g}}} or"
            f" {{control_timestep={fewer * timestep:g}}}, in s",
        )
    return round(steps)


def _read(motion: Motion | str | Path, timestep: float | None) -> Motion:
    """Return a motion at the rate of control; timestep in s."""
    if not isinstance(motion, Motion):
        if not isinstance(motion, str | Path):
            expected = "a name, a path, or what read_motion returned"
            raise BadOptionError(option="motion", value=motion, expected=expected)
        return read_motion(motion) if timestep is None else read_motion(motion, rate=1 / timestep)
    if timestep is not None and abs(motion.rate * timestep - 1.0) > 1e-9:
        raise BadOptionError(
            option="control_timestep",
            value=timestep,
            expected=f"{1 / motion.rate:g} s, the time between two postures of {motion.name}",
            remedy=f"or read the motion with {{rate={1 / timestep:g}}}",
        )
    return motion
