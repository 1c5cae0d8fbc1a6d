"""The arms' MuJoCo model: the package's, or a user's own, with what the options change in it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import mujoco
import numpy as np

from mpma_mj.arm import JOINT_NAMES, SIDES
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.errors import BadOptionError

__all__ = ["HANDS", "MODEL_PATH", "SITES", "make_model"]

MODEL_PATH = Path(__file__).parent.parent / "assets" / "two_arm.xml"
SITES = tuple(f"{side}_{point}" for side in SIDES for point in ("shoulder", "elbow", "wrist"))
HANDS = tuple(f"{side}_hand" for side in SIDES)
"""Bodies that carry the payload and are pushed."""

_IRON = 7870.0  # density, kg/m³


def make_model(options: EnvironmentOptions) -> mujoco.MjModel:
    """Return the model with what the options change in it.

    Args:
        options: Options of the environment.

    Raises:
        BadOptionError: The user's model cannot be read, or lacks what arms need.
    """
    path = MODEL_PATH if options.model is None else Path(options.model)
    if not path.is_file():
        raise BadOptionError(f"model is {path}; expected an MJCF file, and there is none")
    with _errors_in_one_line(path):
        spec = mujoco.MjSpec.from_file(str(path))
    _check_complete(path, spec, hands=options.payload > 0 or options.pushed)
    if options.gravity_compensation:
        for body in spec.bodies[1:]:
            body.gravcomp = 1.0
    if options.payload > 0:
        for hand in HANDS:
            _put_ball(spec.body(hand), options.payload)
    with _errors_in_one_line(path):
        model = spec.compile()
    actuators = [mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_ACTUATOR, n) for n in JOINT_NAMES]
    _check_actuators(path, model, actuators, forces=options.strength != 1.0)
    model.actuator_forcerange[actuators] *= options.strength
    # A solver that begins where it ended makes a step depend on how one came to a state.
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_WARMSTART)
    contact = int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
    if options.collisions:
        model.opt.disableflags &= ~contact
    else:
        model.opt.disableflags |= contact
    return model


@contextmanager
def _errors_in_one_line(path: Path) -> Iterator[None]:
    try:
        yield
    except (ValueError, mujoco.FatalError) as error:
        raise BadOptionError(f"{path}: {' '.join(str(error).split())}") from None


def _check_complete(path: Path, spec: mujoco.MjSpec, *, hands: bool) -> None:
    """Refuse a model that lacks something, with the list of all that is missing."""
    needed = {"joint": JOINT_NAMES, "actuator": JOINT_NAMES, "site": SITES}
    if hands:
        needed["body"] = HANDS
    missing = [
        f"{kind} {name}"
        for kind, names in needed.items()
        for name in names
        if getattr(spec, kind)(name) is None
    ]
    if missing:
        raise BadOptionError(f"{path}: lacks {', '.join(missing)}; name them so, or add them")
    for name in JOINT_NAMES:
        if spec.joint(name).type != mujoco.mjtJoint.mjJNT_HINGE:
            raise BadOptionError(f"{path}: joint {name} is no hinge; arms have hinges only")


def _check_actuators(
    path: Path, model: mujoco.MjModel, actuators: list[int], *, forces: bool
) -> None:
    for name, actuator in zip(JOINT_NAMES, actuators, strict=True):
        joint = model.actuator_trnid[actuator, 0]
        moves_joint = model.actuator_trntype[actuator] == mujoco.mjtTrn.mjTRN_JOINT
        if not moves_joint or model.joint(joint).name != name:
            raise BadOptionError(f"{path}: actuator {name} moves something else than joint {name}")
        if not model.actuator_ctrllimited[actuator] or model.actuator_ctrlrange[actuator, 1] <= 0:
            raise BadOptionError(
                f"{path}: actuator {name} has no ctrlrange; it says which velocity, rad/s, action 1"
                " commands"
            )
        if forces and not model.actuator_forcelimited[actuator]:
            raise BadOptionError(
                f"{path}: actuator {name} has no forcerange; strength has nothing to scale"
            )


def _put_ball(hand: mujoco.MjsBody, mass: float) -> None:
    """Put an iron ball into the middle of a hand; gravity compensation does not know of it."""
    radius = (3.0 * mass / (4.0 * math.pi * _IRON)) ** (1.0 / 3.0)
    name = f"{hand.name}_payload"
    ball = hand.add_body(name=name, pos=hand.ipos)
    ball.mass, ball.ipos, ball.inertia = mass, np.zeros(3), np.full(3, 0.4 * mass * radius**2)
    ball.explicitinertial = True
    ball.add_geom(
        name=name, type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[radius, 0, 0], rgba=[0.2, 0.2, 0.22, 1]
    )
