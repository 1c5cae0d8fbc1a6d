"""MuJoCo models of a robot's arms, changed by the options; one a plant."""

from __future__ import annotations

import copy
import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from mpma_mj.arm_kinematics import TWO_ARMS, ArmKinematics
from mpma_mj.envs.model_validation import check_actuators, check_complete, check_finite
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.envs.randomisation import PlantValues, plants_of
from mpma_mj.errors import BadOptionError, one_line
from mpma_mj.options import TWO_ARM
from mpma_mj.robots.assembly import HANDS, assemble
from mpma_mj.robots.chain_arms import ChainArms
from mpma_mj.robots.geometry import chains
from mpma_mj.robots.robot_file import read_robot

__all__: list[str] = [
    "CompiledPlants",
    "ModelCompiler",
    "geom_colours",
    "make_model",
]

_FIXED = 1e9  # inertia of a locked joint, kg m² (choice)
_IRON = 7870.0  # density, kg/m³
_SMALLEST = 1e-3  # radius of a ball without mass, m
_PLAIN = np.array([0.5, 0.5, 0.5, 1.0], np.float32)  # MuJoCo's default, for which a material stands
_MEMORY = 2**24  # bytes; MuJoCo ends the process where contacts need more


def make_model(options: EnvironmentOptions) -> mujoco.MjModel:
    """Return the model with the changes of the options, that of the first plant.

    Args:
        options: Options of the environment.

    Raises:
        BadOptionError: The user's model cannot be read, or is incomplete.
    """
    return ModelCompiler(options).compile(plants_of(options)[0])


def geom_colours(model: Any) -> NDArray[np.float64]:
    """Return the colour of each geom, shape (G, 4), rgba: its material's, unless it has its own.

    Args:
        model: Model of MuJoCo, or of dm_control.
    """
    colours = model.geom_rgba.copy()
    plain = (colours == _PLAIN).all(axis=1) & (model.geom_matid >= 0)
    colours[plain] = model.mat_rgba[model.geom_matid[plain]]
    return colours


class ModelCompiler:
    """Compiler of the models of plants, all of the same sizes, from a file that is read once.

    Attributes:
        kinematics: Kinematics of the robot's arms.
    """

    kinematics: ArmKinematics

    def __init__(self, options: EnvironmentOptions, *, adjustable: bool = False) -> None:
        """Read the file, and change what all plants have.

        Args:
            options: Options of the environment.
            adjustable: Whether hands, where the model has them, can hold balls in any case.

        Raises:
            BadOptionError: As of `make_model`.
        """
        # Where one hand holds balls all do, some of them without mass, which change no bit.
        self._balls = any(plant["payload"] > 0 for plant in plants_of(options))
        self._collisions = options.collisions
        self._robot = robot = read_robot(options.robot)
        self._path, self.kinematics = robot.path, TWO_ARMS
        with _errors_in_one_line(self._path):
            spec = assemble(robot, ideal=options.arms == "kinematic")
            if robot.complete:
                check_complete(self._path, spec, hands=self._balls or options.perturbed)
            if adjustable:
                self._balls = all(spec.body(name) is not None for name in HANDS)
            if options.robot != TWO_ARM:
                given = spec.compile()
                check_finite(self._path, given)
                spec.memory = max(given.narena, _MEMORY)
                if not robot.complete:
                    arms = chains(given, robot.joints)
                    self.kinematics = ChainArms(robot.name, *arms, robot.numbers)
            if options.gravity_compensation:
                _compensate_gravity(spec, robot.joints)
            if options.locked_joint is not None:
                _check_joint(options.locked_joint, robot.joints)
                # Fixed for every integrator, in contacts too.
                spec.joint(options.locked_joint).armature = _FIXED
            if self._balls:
                _add_balls(spec)
        self._spec = spec

    @property
    def has_balls(self) -> bool:
        """Whether hands hold balls, which may be without mass."""
        return self._balls

    def compile(self, plant: PlantValues) -> mujoco.MjModel:
        """Return the model of a plant; errors as of `make_model`."""
        path, payload = self._path, plant["payload"]
        with _errors_in_one_line(path):
            if self._balls:
                _set_payload(self._spec, payload)
            model = self._spec.compile()
        if self._balls and not payload:
            for hand in HANDS:  # only now, or the compiler would leave the balls out of its trees
                ball = model.geom(f"{hand}_payload")
                ball.contype[:], ball.conaffinity[:] = 0, 0
        if self._robot.complete:
            check_actuators(path, model, forces=plant["actuator_strength"] != 1.0)
        for name in self._robot.joints:
            actuator = model.actuator(name)
            actuator.forcerange[:] *= plant["actuator_strength"]
            actuator.gainprm[0] *= plant["actuator_gain"]  # aims at gain x command
            model.joint(name).damping[:] += plant["damping"]
        flag = mujoco.mjtDisableBit
        # Without warm start a step depends on the state alone, not on the steps before it. With
        # automatic reset a simulation that diverged is detected by its time.
        model.opt.disableflags |= int(flag.mjDSBL_WARMSTART)
        model.opt.disableflags &= ~int(flag.mjDSBL_AUTORESET)
        if self._collisions:
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
        raise BadOptionError(f"{path}: {one_line(error)}") from None


def _check_joint(joint: str, joints: Sequence[str]) -> None:
    """Check that a robot has the joint that is to be locked; raises a BadOptionError."""
    if joint not in joints:
        expected = f"one of {', '.join(joints)}"
        raise BadOptionError(option="locked_joint", value=joint, expected=expected)


def _compensate_gravity(spec: mujoco.MjSpec, joints: Sequence[str]) -> None:
    """Compensate gravity for all bodies that the arms' joints move."""
    below = [spec.joint(name).parent for name in joints]
    while below:
        body = below.pop()
        body.gravcomp = 1.0
        below += body.bodies


def _add_balls(spec: mujoco.MjSpec) -> None:
    """Add a ball to the middle of each hand, without gravity compensation, yet without mass."""
    bare = spec.compile()
    for name in HANDS:
        hand, ball = bare.body(name), spec.body(name).add_body(name=f"{name}_payload")
        ball.pos, ball.ipos = hand.ipos, np.zeros(3)
        ball.explicitinertial = True
        geom = ball.add_geom(name=f"{name}_payload", type=mujoco.mjtGeom.mjGEOM_SPHERE)
        if hand.geomnum[0]:  # collides with the same geoms as the hand
            of_hand = bare.geom(int(hand.geomadr[0]))
            geom.contype, geom.conaffinity = of_hand.contype[0], of_hand.conaffinity[0]


def _set_payload(spec: mujoco.MjSpec, mass: float) -> None:
    """Make the balls in the hands of iron and of a mass, kg."""
    radius = (3.0 * mass / (4.0 * math.pi * _IRON)) ** (1.0 / 3.0)
    for name in HANDS:
        ball, geom = spec.body(f"{name}_payload"), spec.geom(f"{name}_payload")
        ball.mass, ball.inertia = mass, np.full(3, 0.4 * mass * radius**2)
        geom.size = [max(radius, _SMALLEST), 0.0, 0.0]
        geom.rgba = [0.2, 0.2, 0.22, 1.0 if mass > 0 else 0.0]
        geom.mass = mass  # for models that compute inertia from geoms


class CompiledPlants:
    """One compiled model for each plant, and a live model that becomes any of them, or others.

    The models have the same sizes and differ in parameters only, which are copied into the live
    model. MuJoCo's own `mj_setConst` would compute them instead, but it resets the pose.

    Attributes:
        plants: The plants, as `plants_of` returns them.
        models: Model of each plant.
        live: Model to simulate, at first of the first plant.
        compiler: Compiler of models of further plants.
    """

    def __init__(self, options: EnvironmentOptions, *, adjustable: bool = False) -> None:
        """Compile the plants of an environment; errors as of `make_model`.

        Args:
            options: Options of the environment.
            adjustable: Whether payload and gain can have any value; see `ModelCompiler`.
        """
        self.compiler = ModelCompiler(options, adjustable=adjustable)
        self.plants = plants_of(options)
        self.models = tuple(self.compiler.compile(plant) for plant in self.plants)
        self._plant, self._values = 0, self.plants[0]
        others = self.models[1:]
        if adjustable:
            first = self.plants[0]
            gain = 2.0 * first["actuator_gain"]
            ends = ({"payload": 0.0}, {"payload": 1.0}, {"actuator_gain": gain})
            others += tuple(self.compiler.compile(first | end) for end in ends)
        self.live = copy.copy(self.models[0]) if others else self.models[0]
        self._differing = _differing((self.models[0], *others))
        self._of_stat = _differing([model.stat for model in (self.models[0], *others)])

    def use(self, plant: int) -> None:
        """Give the live model the parameters of a plant, by its index; simulations stay."""
        if plant != self._plant:
            self._plant, self._values = plant, self.plants[plant]
            self.become(self.models[plant])

    def become_plant(self, values: PlantValues) -> None:
        """Give the live model the parameters of any plant, by its values; see `use`."""
        if values != self._values:
            self._plant, self._values = -1, values
            self.become(self.compiler.compile(values))

    @property
    def values(self) -> PlantValues:
        """Values of the plant that the live model is; not to be changed."""
        return self._values

    def become(self, model: mujoco.MjModel) -> None:
        """Give the live model the parameters of another one; simulations stay."""
        _copy_parameters(model, self.live, self._differing)
        _copy_parameters(model.stat, self.live.stat, self._of_stat)


def _differing(each: Sequence[Any]) -> list[str]:
    """Return the names of the parameters that are not equal in all."""
    found = []
    for name in dir(each[0]):
        if name.startswith("_") or not isinstance(getattr(each[0], name), np.ndarray | float):
            continue
        values = [getattr(one, name) for one in each]
        if not all(np.array_equal(values[0], value, equal_nan=True) for value in values):
            found.append(name)
    return found


def _copy_parameters(source: Any, target: Any, names: Sequence[str]) -> None:
    for name in names:
        value = getattr(source, name)
        if isinstance(value, np.ndarray):
            getattr(target, name)[...] = value
        else:
            setattr(target, name, value)
