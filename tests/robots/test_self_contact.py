"""Contacts of a robot with itself, where they are switched on."""

import itertools
from pathlib import Path

import mujoco
import numpy as np
import pytest

from mpma_mj.robots.assembly import assemble
from mpma_mj.robots.geometry import chains
from mpma_mj.robots.poses import POSES, pose_angles
from mpma_mj.robots.robot_file import read_robot
from tests.robots.small_robot import installed, write_small_robot


def excluded(model: mujoco.MjModel) -> set[frozenset[str]]:
    pairs = [(pair >> 16, pair & 0xFFFF) for pair in model.exclude_signature.tolist()]
    return {frozenset(model.body(body).name for body in pair) for pair in pairs}


@pytest.mark.parametrize("name", ["small", "cmu_humanoid", "h1", "openarm", "g1", "gr1", "yumi"])
def test_nothing_touches_in_plain_poses(name: str, tmp_path: Path) -> None:
    robot = read_robot(write_small_robot(tmp_path)) if name == "small" else installed(name)
    model = assemble(robot, ideal=True).compile()
    model.opt.disableflags &= ~int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
    arms, data = chains(model, robot.joints), mujoco.MjData(model)
    places = [int(model.joint(joint).qposadr[0]) for joint in robot.joints]
    for angles in (np.zeros(8), *(pose_angles(arms, pose) for pose in POSES)):
        data.qpos[places] = angles
        mujoco.mj_fwdPosition(model, data)
        assert data.ncon == 0


def test_hands_that_cross_touch() -> None:
    robot = read_robot("cmu_humanoid")
    model = assemble(robot).compile()
    model.opt.disableflags &= ~int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
    arms, data = chains(model, robot.joints), mujoco.MjData(model)
    data.qpos[:] = pose_angles(arms, "arms forward")
    data.qpos[[3, 7]] = 1.5
    mujoco.mj_fwdPosition(model, data)
    touching = {frozenset(pair) for pair in model.geom_bodyid[data.contact.geom].tolist()}
    moving = {body for body in range(model.nbody) if model.body_weldid[body]}
    assert any(pair <= moving for pair in touching)


def test_a_shoulder_passes_the_body_that_it_hangs_on(tmp_path: Path) -> None:
    hollow = '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'
    changes = {'<geom type="sphere" size="0.02"/>': hollow}
    found = excluded(assemble(read_robot(write_small_robot(tmp_path, model=changes))).compile())
    for pair in itertools.combinations(("torso", "l_link1", "l_link2"), 2):
        assert frozenset(pair) in found
    assert frozenset(("torso", "l_forearm")) not in found
