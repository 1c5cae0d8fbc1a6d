"""Contacts of a robot with itself that mean nothing: of bodies that overlap in plain poses."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import mujoco
import numpy as np
from numpy.typing import NDArray

from mpma_mj.robots.chain import Chain
from mpma_mj.robots.poses import POSES, pose_angles

__all__ = ["exclude_touching"]

Array = NDArray[np.float64]


def exclude_touching(
    spec: mujoco.MjSpec, model: mujoco.MjModel, joints: Sequence[str], arms: Sequence[Chain]
) -> None:
    """Exclude contacts of bodies that touch at zero joint angles or in `POSES`, and of shoulders.

    The three links of a shoulder touch neither one another nor the body that they hang on: they
    overlap there in most models, as MuJoCo makes meshes convex.

    Args:
        spec: The robot, assembled; all its bodies have names.
        model: The same, compiled.
        joints: Names of the eight joints.
        arms: The left and the right arm.
    """
    pairs: set[tuple[int, int]] = set()
    for shoulder in (joints[:3], joints[4:7]):
        links = {int(model.joint(name).bodyid[0]) for name in shoulder}
        torso = int(model.body_parentid[min(links)])
        while torso and not model.body_geomnum[torso]:
            torso = int(model.body_parentid[torso])
        pairs |= set(itertools.combinations(sorted(links | {torso}), 2))
    data = mujoco.MjData(model)
    flags = int(model.opt.disableflags)
    model.opt.disableflags &= ~int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
    places = [int(model.joint(name).qposadr[0]) for name in joints]
    for angles in (np.zeros(8), *(pose_angles(arms, pose) for pose in POSES)):
        data.qpos[places] = angles
        mujoco.mj_fwdPosition(model, data)
        bodies = model.geom_bodyid[data.contact.geom[: data.ncon]]
        pairs |= {(min(pair), max(pair)) for pair in bodies.tolist()}
    model.opt.disableflags = flags
    excluded = {tuple(sorted((e.bodyname1, e.bodyname2))) for e in spec.excludes}
    for pair in sorted(pairs):
        first, second = (model.body(body).name for body in pair)
        if tuple(sorted((first, second))) not in excluded:
            spec.add_exclude(bodyname1=first, bodyname2=second)
