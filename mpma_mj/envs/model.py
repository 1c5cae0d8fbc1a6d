"""MuJoCo models of the arms: the package's or a user's, changed by the options; one a plant."""

from __future__ import annotations

import copy
import math
import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from mpma_mj.envs.model_validation import HANDS, check_actuators, check_complete
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.errors import BadOptionError
from mpma_mj.kinematics import JOINT_NAMES

__all__: list[str] = ["MODEL_PATH", "CompiledPlants", "make_model", "make_models"]

MODEL_PATH = Path(__file__).parent.parent / "assets" / "two_arm.xml"

_FIXED = 1e9  # inertia of a locked joint, kg m² (choice)
_IRON = 7870.0  # density, kg/m³
_SMALLEST = 1e-3  # radius of a ball without mass, m
_MEMORY = 2**24  # bytes; MuJoCo ends the process where contacts need more


def make_models(options: EnvironmentOptions) -> tuple[mujoco.MjModel, ...]:
    """Return the model of each plant, all of the same sizes; one where there are no plants.

    Args:
        options: Options of the environment.

    Raises:
        BadOptionError: As of `make_model`.
    """
    plants = options.of_plants()
    balls = any(plant.payload > 0 for plant in plants)
    return tuple(make_model(plant, balls=balls) for plant in plants)


def make_model(options: EnvironmentOptions, *, balls: bool = False) -> mujoco.MjModel:
    """Return the model with the changes of the options.

    Args:
        options: Options of the environment, without plants.
        balls: Whether the hands hold balls even without payload, which then have no mass.

    Raises:
        BadOptionError: The user's model cannot be read, or is incomplete.
    """
    balls = balls or options.payload > 0
    path = MODEL_PATH if options.model is None else Path(options.model)
    if not path.is_file():
        found = "this is a folder" if path.is_dir() else "there is no such file"
        raise BadOptionError(option="model", value=str(path), expected=f"an MJCF file, but {found}")
    with _errors_in_one_line(path):
        spec = mujoco.MjSpec.from_file(os.fsencode(path))  # the name may not be UTF-8
        check_complete(path, spec, hands=balls or options.perturbed)
        if options.model is not None:
            spec.memory = max(spec.compile().narena, _MEMORY)
        if options.gravity_compensation:
            _compensate_gravity(spec)
        if options.locked_joint is not None:
            # Fixed for every integrator, in contacts too.
            spec.joint(options.locked_joint).armature = _FIXED
        if balls:
            _add_payload(spec, options.payload)
        model = spec.compile()
    if balls and not options.payload:
        for hand in HANDS:  # only now, or the compiler would leave the balls out of its trees
            ball = model.geom(f"{hand}_payload")
            ball.contype[:], ball.conaffinity[:] = 0, 0
    if not 0.0 < model.opt.timestep < math.inf:
        raise BadOptionError(f"{path}: timestep is {model.opt.timestep:g} s; expected above 0")
    check_actuators(path, model, forces=options.actuator_strength != 1.0)
    for name in JOINT_NAMES:
        actuator = model.actuator(name)
        actuator.forcerange[:] *= options.actuator_strength
        actuator.gainprm[0] *= options.actuator_gain  # aims at gain x command
        model.joint(name).damping[:] += options.damping
    flag = mujoco.mjtDisableBit
    # Without warm start a step depends on the state alone, not on the steps before it. With
    # automatic reset a simulation that diverged is detected by its time.
    model.opt.disableflags |= int(flag.mjDSBL_WARMSTART)
    model.opt.disableflags &= ~int(flag.mjDSBL_AUTORESET)
    if options.collisions:
        model.opt.disableflags &= ~int(flag.mjDSBL_CONTACT)
    else:
        model.opt.disableflags |= int(flag.mjDSBL_CONTACT)
    return model


@contextmanager
def _errors_in_one_line(path: Path) -> Iterator[None]:
    try:
        yield
    except BadOptionError:
        raise
    except (ValueError, mujoco.FatalError) as error:
        problem = " ".join(str(error).split())
        if "could not find decoder" in problem:  # for the ending of the file's name
            problem = "is no MJCF file; expected an XML model of the arms"
        raise BadOptionError(f"{path}: {problem}") from None


def _compensate_gravity(spec: mujoco.MjSpec) -> None:
    """Compensate gravity for all bodies that the arms' joints move."""
    below = [spec.joint(name).parent for name in JOINT_NAMES]
    while below:
        body = below.pop()
        body.gravcomp = 1.0
        below += body.bodies


def _add_payload(spec: mujoco.MjSpec, mass: float) -> None:
    """Add an iron ball to the middle of each hand, without gravity compensation; mass in kg."""
    bare = spec.compile()
    radius = (3.0 * mass / (4.0 * math.pi * _IRON)) ** (1.0 / 3.0)
    for name in HANDS:
        hand, ball = bare.body(name), spec.body(name).add_body(name=f"{name}_payload")
        ball.pos, ball.ipos = hand.ipos, np.zeros(3)
        ball.mass, ball.inertia = mass, np.full(3, 0.4 * mass * radius**2)
        ball.explicitinertial = True
        geom = ball.add_geom(name=f"{name}_payload", type=mujoco.mjtGeom.mjGEOM_SPHERE)
        geom.size = [max(radius, _SMALLEST), 0.0, 0.0]
        geom.rgba = [0.2, 0.2, 0.22, 1.0 if mass > 0 else 0.0]
        geom.mass = mass  # for models that compute inertia from geoms
        if hand.geomnum[0]:  # collides with the same geoms as the hand
            of_hand = bare.geom(int(hand.geomadr[0]))
            geom.contype, geom.conaffinity = of_hand.contype[0], of_hand.conaffinity[0]


class CompiledPlants:
    """One compiled model for each plant, and a live model that becomes any of them.

    The models have the same sizes and differ in numbers only, which are copied into the live model.
    MuJoCo's own `mj_setConst` would compute them instead, but it resets the pose.

    Attributes:
        models: Model of each plant.
        live: Model to simulate, at first of the first plant.
    """

    def __init__(self, models: Sequence[mujoco.MjModel]) -> None:
        """Find the numbers in which the models of all plants differ."""
        self.models = tuple(models)
        self._plant = 0
        self.live = models[0] if len(models) == 1 else copy.copy(models[0])
        self._differing = _differing(self.live, self.models) + _differing(
            self.live.stat, [model.stat for model in models]
        )

    def use(self, plant: int) -> None:
        """Give the live model the numbers of a plant, by its index; simulations stay."""
        if plant == self._plant:
            return
        self._plant = plant
        for owner, name, values in self._differing:
            if isinstance(values[plant], np.ndarray):
                getattr(owner, name)[...] = values[plant]
            else:
                setattr(owner, name, values[plant])


def _differing(live: Any, each: Sequence[Any]) -> list[tuple[Any, str, list[Any]]]:
    """Return the numbers that are not equal in all: of the live one, by name, with all values."""
    found = []
    for name in dir(live):
        if name.startswith("_") or not isinstance(getattr(live, name), np.ndarray | float):
            continue
        values = [getattr(one, name) for one in each]
        if not all(np.array_equal(values[0], value, equal_nan=True) for value in values):
            found.append((live, name, values))
    return found
