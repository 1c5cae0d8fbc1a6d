"""The factory of environments."""

from __future__ import annotations

from pathlib import Path
from typing import get_args

import numpy as np
from dm_control.rl import control
from numpy.typing import NDArray

from mpma_mj.envs.physics import KinematicArms, PhysicsArms
from mpma_mj.envs.task import TwoArmImitation
from mpma_mj.errors import BadOptionError
from mpma_mj.motions import Motion, read_motion
from mpma_mj.options import Arms

__all__ = ["arm_limits", "load"]

_KINDS = {"physics": PhysicsArms, "kinematic": KinematicArms}


def arm_limits(arms: Arms) -> tuple[NDArray[np.float64], float]:
    """Return what arms can do.

    Returns:
        Fastest that each joint can turn, shape (8,), rad/s, and how far an elbow bends, rad.
    """
    physics = _KINDS[arms].make()
    return physics.max_joint_speed, float(physics.joint_range[1][3])


def load(
    motion: Motion | str | Path = "ymca",
    *,
    arms: Arms = "physics",
    repeats: int = 3,
    noise: float = 0.01,
    seed: int = 0,
) -> control.Environment:
    """Return an environment in which two arms imitate a movement.

    The control step is one posture of the movement, 0.05 s at the usual 20 Hz.

    Args:
        motion: The movement, or what `read_motion` takes: "ymca", or a recording's path.
        arms: "physics" for simulated arms, "kinematic" for arms that move ideally.
        repeats: How often the movement is danced in an episode.
        noise: Standard deviation of the noise on the demonstrated unit vectors.
        seed: Seed of the noise.

    Returns:
        A `dm_env.Environment`; see `TwoArmImitation` for observation, action and reward.

    Raises:
        BadOptionError: An option is outside what it may be.
        MpmaError: The movement cannot be read, or is faster than the arms.
    """
    if arms not in _KINDS:
        raise BadOptionError(f"arms is '{arms}'; expected {' or '.join(get_args(Arms))}")
    if not 1 <= repeats <= 1000:
        raise BadOptionError(f"repeats is {repeats}; expected 1 to 1000")
    if not 0.0 <= noise <= 1.0:
        raise BadOptionError(f"noise is {noise:g}; expected 0 to 1, such as 0.01")
    if seed < 0:
        raise BadOptionError(f"seed is {seed}; expected a whole number from 0 up")
    if not isinstance(motion, Motion):
        motion = read_motion(motion)
    physics = _KINDS[arms].make()
    task = TwoArmImitation(
        motion,
        max_joint_speed=physics.max_joint_speed,
        max_elbow=float(physics.joint_range[1][3]),
        repeats=repeats,
        noise=noise,
        seed=seed,
    )
    try:
        steps = control.compute_n_steps(1.0 / motion.rate, physics.timestep())
    except ValueError:
        raise BadOptionError(
            f"rate is {motion.rate:g} Hz; one control step, {1000 / motion.rate:g} ms, has to be"
            f" a whole number of physics steps of {1000 * physics.timestep():g} ms, as at 20, 25,"
            " 40 or 50 Hz"
        ) from None
    return control.Environment(physics, task, n_sub_steps=steps)
