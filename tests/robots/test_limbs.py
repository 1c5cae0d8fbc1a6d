"""Limbs: paths of hinges that part, their names and mirror images."""

import mujoco
import pytest

from mpma_mj.robots.limbs import (
    are_alike,
    are_called_otherwise,
    are_mirrored,
    limb_pairs,
    lone_limb,
    turning_about_shoulder,
)
from tests.robots.figures import ARM, compile_figure


def test_a_waist_belongs_to_neither_limb() -> None:
    model = compile_figure(waist=3, legs=False)
    named = [
        tuple(tuple(model.joint(hinge).name for hinge in limb) for limb in pair)
        for pair in limb_pairs(model)
    ]
    joints = [*ARM, "wrist0"]
    for length in range(1, 6):
        limbs = (
            tuple(f"{side}_{joint}" for joint in joints[:length]) for side in ("left", "right")
        )
        assert tuple(limbs) in named
    assert not any(name.startswith("waist") for pair in named for limb in pair for name in limb)
    assert all(len(one) == len(other) and not set(one) & set(other) for one, other in named)


@pytest.mark.parametrize(
    ("name", "otherwise"),
    [
        ("left_hip_roll", True),
        ("LFinger2", True),
        ("l_ankle", True),
        ("joint4", False),
        ("", False),
        ("wheeled_robot/left_shoulder_pitch", False),
        ("index_arm_3", False),
    ],
)
def test_names_tell_legs_and_fingers_unless_they_tell_arms(name: str, otherwise: bool) -> None:
    body = f"<body><joint name='{name}'/><geom size='1'/></body>"
    model = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{body}</worldbody></mujoco>")
    assert are_called_otherwise(model, (0,)) == otherwise


def test_mirror_images_are_told_from_copies() -> None:
    model = compile_figure()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    arm, other = (tuple(model.joint(f"{s}_{j}").id for j in ARM) for s in ("left", "right"))
    assert are_mirrored(data, (arm, other))
    assert not are_mirrored(data, (arm, arm))
    data.qpos[model.joint("left_pitch").qposadr] = 1.0
    mujoco.mj_kinematics(model, data)
    assert not are_mirrored(data, (arm, other))
    assert are_alike(data, (arm, other))
    assert not are_alike(data, (arm, arm[::-1]))
    assert [turning_about_shoulder(data, arm[:n]) for n in (1, 2, 3, 4)] == [1, 2, 3, 3]


def test_the_longest_path_is_the_lone_limb() -> None:
    model = compile_figure(arms=("right",), waist=2)
    joints = ["waist0", "waist1", *(f"right_{joint}" for joint in [*ARM, "wrist0"])]
    assert [model.joint(hinge).name for hinge in lone_limb(model)] == joints
