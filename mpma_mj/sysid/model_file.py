"""Models with other parameters as MJCF files."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Mapping
from pathlib import Path

import mujoco
import numpy as np

from mpma_mj.errors import one_line
from mpma_mj.kinematics import JOINT_NAMES
from mpma_mj.options import TWO_ARM
from mpma_mj.robots.model_file import read_model_file
from mpma_mj.robots.robot_file import read_robot
from mpma_mj.sysid.parameters import scaled
from mpma_mj.utils.atomic_files import atomic_write

__all__ = ["write_model"]


def write_model(path: str | Path, factors: Mapping[str, float], base: str | Path = TWO_ARM) -> None:
    """Write a model whose parameters are multiplied by factors.

    Numbers are written with six digits. Masses and inertias stand in the file as numbers, even
    where the base takes them from its geoms.

    Args:
        path: The MJCF file, for `mpma_mj.load(..., robot=path)`.
        factors: Factor on each parameter of `UNITS`, by name; 1 where there is none.
        base: MJCF file of the model that is changed; the package's robot if not given.
    """
    base = read_robot(base).model
    spec = read_model_file(base)
    model = scaled(spec.compile(), factors)
    for name in JOINT_NAMES:
        kind = name.partition("_")[2]
        actuator, joint = spec.actuator(name), spec.joint(name)
        kv = float(model.actuator(name).gainprm[0])
        actuator.gainprm[0], actuator.biasprm[2] = kv, -kv
        joint.damping = np.array(joint.damping) * factors.get(f"damping_{kind}", 1.0)
        joint.armature *= factors.get("armature", 1.0)
    if spec.compiler.inertiafromgeom == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE:
        spec.compiler.inertiafromgeom = mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_AUTO
    spec.compiler.settotalmass = -1.0
    for body in spec.bodies:
        _weigh(body, model)
    for folder in ("meshdir", "texturedir"):  # the file may lie elsewhere than the base
        with contextlib.suppress(UnicodeDecodeError):  # written here, and so absolute already
            setattr(spec, folder, os.fsencode((base.parent / getattr(spec, folder)).resolve()))
    spec.compile()  # which `to_file` writes from
    with atomic_write(Path(path)) as temporary:
        try:
            spec.to_file(os.fsencode(temporary))
        except mujoco.FatalError as error:  # such as a full disk
            raise OSError(one_line(error)) from None


def _weigh(body: mujoco.MjsBody, model: mujoco.MjModel) -> None:
    """Give a body, as a number, the mass and the inertia that it has in a model."""
    mass = float(model.body_mass[body.id])
    if mass > 0.0:
        body.explicitinertial = True
        body.mass = mass
        body.ipos, body.iquat = model.body_ipos[body.id], model.body_iquat[body.id]
        body.inertia = model.body_inertia[body.id]
        body.fullinertia = np.full(6, np.nan)
