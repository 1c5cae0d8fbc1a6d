"""Factory of vectors of environments."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Literal, Never

from gymnasium.vector import AutoresetMode

from mpma_mj.envs.options import options_among
from mpma_mj.envs.plants import PlantsLike
from mpma_mj.envs.vector_env import FlatVectorImitationEnv, VectorImitationEnv
from mpma_mj.errors import BadOptionError
from mpma_mj.motions import Motion
from mpma_mj.options import TWO_ARM, Arms
from mpma_mj.utils.validation import Range

__all__: list[str] = ["make_vec"]


def make_vec(  # noqa: D417 # the fields of `EnvironmentOptions` are documented there
    num_envs: int,
    motion: Motion | str | Path = "ymca",
    *,
    seed: int = 0,
    flat: bool = False,
    autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
    render_mode: str | None = None,
    width: int = 640,
    height: int = 480,
    camera: str = "front",
    threads: int | None = None,
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
) -> VectorImitationEnv:
    """Return a vector of environments that one call steps together.

    All arguments from `arms` on are the fields of `EnvironmentOptions`, which documents them.

    Args:
        num_envs: Number N of environments.
        motion: The motion, or its name, such as "ymca", or the path of a recording.
        seed: Seed of the first environment; environment i is that of `load` with seed + i.
        flat: Whether observations are one array.
        autoreset_mode: When an episode follows one that has ended; see `VectorImitationEnv`.
        render_mode: "rgb_array" for pictures, None for none.
        width: Width of each environment's picture, pixels.
        height: Height of each environment's picture, pixels.
        camera: Name of the model's camera for pictures.
        threads: Greatest number of simulating threads; one for each processor if not given.

    Raises:
        BadOptionError: An option does not exist, is out of bounds, or contradicts another.
        MpmaError: The motion cannot be read, or is faster than the arms.
    """
    chosen = options_among(locals())
    if not isinstance(flat, bool):
        raise BadOptionError(option="flat", value=flat, expected="True or False")
    kind = FlatVectorImitationEnv if flat else VectorImitationEnv
    return kind(
        num_envs,
        motion,
        seed=seed,
        autoreset_mode=autoreset_mode,
        render_mode=render_mode,
        width=width,
        height=height,
        camera=camera,
        threads=threads,
        **vars(chosen),
    )
