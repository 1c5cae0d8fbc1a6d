"""A small robot that looks along -y of its model, with all that an assembly has to mend."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from pathlib import Path

import mujoco
import numpy as np
import pytest

from mpma_mj.errors import BadOptionError
from mpma_mj.robots.assembly import assemble
from mpma_mj.robots.robot import Robot
from mpma_mj.robots.robot_file import read_robot

_FILE = """\
name = "small"
title = "Small robot"
licence = "Apache-2.0, nobody"

[model]
file = "small.xml"
left = ["l_pitch", "l_roll", "l_yaw", "l_elbow"]
right = ["r_pitch", "r_roll", "r_yaw", "r_elbow"]
wrist = ["l_wrist", "r_wrist"]
up = [0, 0, 2]
[model.rest]
waist = 0.0
[model.range]
r_roll = [-1.5, 3.0]

[speed]
values = [9, 8.0, 7.0, 6.0]
source = "data sheet"
[force]
values = [40.0, 30.0, 20.0, 10.0]
source = "data sheet"
[armature]
values = [0.04, 0.03, 0.02, 0.0]
source = "data sheet"
[damping]
values = [0.4, 0.3, 0.2, 0.0]
source = "data sheet"
[kv]
values = [14.0, 13.0, 12.0, 11.0]
source = "choice"
"""

_ARM = """
<body name="{s}_clavicle" pos="{x} 0 0.3">
  <joint name="{s}_clavicle" axis="0 1 0" range="-1 1"/>
  <geom type="sphere" size="0.02"/>
  <frame euler="0.2 0 0">
    <body name="{s}_link1" pos="{x} 0 0.01" euler="-0.2 {tilt} 0">
      <joint name="{s}_pitch" axis="1 0 0" ref="0.2" range="-4 4"/>
      <geom type="sphere" size="0.04"/>
      <body name="{s}_link2" pos="{x2} 0 0">
        <joint name="{s}_roll" axis="0 1 0" range="-4 4"/>
        <joint name="{s}_yaw" axis="0 0 1" pos="0.01 0 0" range="-4 4"/>
        <geom type="capsule" size="0.03" fromto="0 0 0 0 0 -0.3"/>
        <body name="{s}_forearm" pos="0 0 -0.3">
          <joint name="{s}_elbow" axis="1 0 0" range="-0.5 2.5" ref="-0.3"/>
          <geom type="capsule" size="0.03" fromto="0 0 0 0 0 -0.2"/>
          <site name="{side}_wrist"/>
          <body name="{side}_hand" pos="0 0 -0.25" gravcomp="1">
            <joint name="{s}_wrist" axis="0 1 0" range="-1 1"/>
            <geom type="box" size="0.02 0.02 0.05" pos="0 0 -0.05"/>
          </body>
        </body>
      </body>
    </body>
  </frame>
</body>
"""

_MODEL = """\
<mujoco model="small">
  <compiler angle="radian"/>
  <option timestep="0.001" gravity="0 0 -1"/>
  <default>
    <joint damping="5" armature="1" frictionloss="0.3" stiffness="7" actuatorfrcrange="-3 3"/>
    <geom rgba="0.2 0.3 0.8 1" friction="0.1 0.1 0.1"/>
    <general gear="4" ctrlrange="-1 1" forcerange="-2 2"/>
    <site group="1" size="0.2"/>
  </default>
  <asset>
    <texture type="skybox" builtin="flat" rgb1="0 0 0" width="8" height="48"/>
    <material name="floor" rgba="1 0 0 1"/>
  </asset>
  <worldbody>
    <geom name="ground" type="plane" size="5 5 0.1"/>
    <geom name="pedestal" type="box" size="0.1 0.1 0.02" pos="0 0 -0.5" material="floor"/>
    <light name="key" mode="targetbody" target="torso" pos="0 0 4"/>
    <camera name="front" pos="0 -3 1"/>
    <body name="pelvis" pos="0.3 0.2 1">
      <freejoint name="root"/>
      <geom type="box" size="0.1 0.1 0.1"/>
      <body name="torso" pos="0 0 0.15" euler="0 0 0.1">
        <joint name="waist" axis="0 0 1" pos="0.02 0 0" range="-2 2"/>
        <geom type="box" size="0.1 0.1 0.2" pos="0 0 0.2"/>
        {left}{right}
      </body>
    </body>
  </worldbody>
  <contact><exclude body1="left_hand" body2="torso"/></contact>
  <equality><joint joint1="l_wrist" joint2="r_wrist"/></equality>
  <sensor><jointpos joint="waist"/></sensor>
  <actuator><motor name="l_pitch" joint="l_pitch"/><motor joint="waist"/></actuator>
  <keyframe><key name="home" qpos="0 0 1 1 0 0 0 {zeros}"/></keyframe>
</mujoco>
"""


def _arm(side: str, sign: float) -> str:
    x, x2, tilt = 0.12 * sign, 0.05 * sign, 0.1 * sign
    return _ARM.format(s=side[0], side=side, x=x, x2=x2, tilt=tilt)


MODEL = _MODEL.format(left=_arm("left", 1.0), right=_arm("right", -1.0), zeros="0 " * 13)


def write_small_robot(
    folder: Path, file: dict[str, str] | None = None, model: dict[str, str] | None = None
) -> Path:
    """Write the robot's file and model with some texts replaced; return the path of the file."""
    for name, text, changes in (("small.xml", MODEL, model), ("small.toml", _FILE, file)):
        for old, new in (changes or {}).items():
            assert old in text, old
            text = text.replace(old, new)
        folder.joinpath(name).write_text(text, "utf-8")
    return folder / "small.toml"


def installed(name: str) -> Robot:
    """Return a robot of the catalogue; skip the test where its model is not on this machine."""
    try:
        return read_robot(name)
    except BadOptionError as error:
        if "finds no model: " not in str(error):
            raise
        pytest.skip(f"{name}: {error}")


def compiled(robot: Robot) -> mujoco.MjModel:
    return assemble(robot, ideal=True).compile()


@functools.cache
def compiled_once(name: str) -> mujoco.MjModel:
    return compiled(installed(name))


def placed(
    model: mujoco.MjModel, robot: Robot, angles: Sequence[float] | np.ndarray
) -> mujoco.MjData:
    """Return the simulation at some angles of the eight joints."""
    data = mujoco.MjData(model)
    for name, angle in zip(robot.joints, angles, strict=True):
        data.qpos[model.joint(name).qposadr] = angle
    mujoco.mj_fwdPosition(model, data)
    return data
