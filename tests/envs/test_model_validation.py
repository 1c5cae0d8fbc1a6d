"""Validation of models of users."""

from pathlib import Path

import numpy as np
import pytest

from mpma_mj.envs.gym_env import ImitationEnv
from mpma_mj.envs.load import load
from mpma_mj.errors import BadOptionError, RecordingWarning
from tests.envs.user_models import edited


@pytest.fixture
def own(tmp_path: Path) -> Path:
    return tmp_path / "my_arms.xml"


def refused(path: Path, **options: object) -> str:
    with pytest.raises(BadOptionError) as caught:
        load("ymca", robot=path, **options)
    message = str(caught.value)
    assert "\n" not in message
    assert message.startswith(str(path))
    return message


def test_a_folder_is_no_model(tmp_path: Path) -> None:
    with pytest.raises(
        BadOptionError, match="is a folder; give the path of a file in it; expected an MJCF"
    ):
        load("ymca", robot=tmp_path)


def test_all_missing_elements_are_listed(own: Path) -> None:
    elbow = '<velocity name="left_elbow" joint="left_elbow" class="elbow"/>'
    edited(
        own,
        (elbow, ""),
        ('<site name="right_wrist" pos="0 0 -0.2689"/>', ""),
        ('<joint name="left_elbow" class="elbow" axis="0 -1 0"/>', ""),
    )
    expected = "lacks joint left_elbow, actuator left_elbow, site right_wrist; mpma robot "
    assert expected in refused(own)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('torso" pos="0 0 1.15"', 'torso" pos="nan 0 0"', "body_pos of torso is nan"),
        ('gravity="0 0 -9.81"', 'gravity="0 0 -inf"', "gravity of element 2 is -inf"),
        ('mass="30"', 'mass="nan"', "body_mass of torso is nan"),
        ('diaginertia="1 1 1"', 'diaginertia="inf inf inf"', "body_inertia of torso is inf"),
        ('kv="20"', 'kv="inf"', "actuator_biasprm of left_shoulder_abduction is -inf"),
        ('damping="0.3"', 'damping="nan"', "dof_damping of left_shoulder_abduction is nan"),
    ],
)
def test_numbers_are_finite(own: Path, old: str, new: str, message: str) -> None:
    edited(own, (old, new))
    assert f"{message}; give a finite number" in refused(own)


def test_ranges_may_be_infinite(own: Path) -> None:
    load("ymca", robot=edited(own, ('forcerange="-70 70"', 'forcerange="-inf inf"')))


def test_hands_are_needed_for_payload_and_perturbations_only(own: Path) -> None:
    edited(own, ('<body name="left_hand"', '<body name="left_fist"'))
    load("ymca", robot=own)
    assert "lacks body left_hand" in refused(own, payload=1.0)
    assert "lacks body left_hand" in refused(own, perturbation=(1.0, 10.0))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            '<joint name="left_shoulder_rotation" axis="0 0 1"/>',
            '<joint name="left_shoulder_rotation" axis="0 0 -1"/>',
            "left_forearm does not point where the joint angles should put it,"
            " where left_shoulder_rotation turns",
        ),
        (
            '<joint name="right_shoulder_flexion" axis="0 -1 0"/>',
            '<joint name="right_shoulder_flexion" axis="0 1 0"/>',
            "where right_shoulder_flexion turns",
        ),
        (
            '<site name="left_wrist" pos="0 0 -0.2689"/>',
            '<site name="left_wrist" pos="0 0.1 -0.2689"/>',
            "left_forearm does not point where the joint angles should put it, at zero joint",
        ),
        (
            '<joint name="left_shoulder_abduction" axis="1 0 0"/>\n'
            '        <joint name="left_shoulder_flexion" axis="0 -1 0"/>',
            '<joint name="left_shoulder_flexion" axis="0 -1 0"/>\n'
            '        <joint name="left_shoulder_abduction" axis="1 0 0"/>',
            "where all joints turn (order of axes?)",
        ),
        (
            'name="left_elbow" joint="left_elbow"',
            'name="left_elbow" joint="right_elbow"',
            "actuator left_elbow does not move joint left_elbow",
        ),
        (
            'kv="20" ctrlrange="-15 15"',
            'kv="20"',
            "actuator left_elbow has no ctrlrange",
        ),
        (
            'kv="20" ctrlrange="-15 15"',
            'kv="20" ctrllimited="false" ctrlrange="-15 15"',
            "actuator left_elbow has no ctrlrange from -v to v",
        ),
        (
            'kv="20" ctrlrange="-15 15"',
            'kv="20" ctrlrange="-1 15"',
            "actuator left_elbow has no ctrlrange from -v to v",
        ),
        (
            '<velocity name="left_elbow" joint="left_elbow" class="elbow"/>',
            '<motor name="left_elbow" joint="left_elbow" ctrlrange="-1 1"/>',
            "actuator left_elbow is not a <velocity> with kv above 0 and gear 1",
        ),
        (
            '<velocity name="left_elbow" joint="left_elbow" class="elbow"/>',
            '<position name="left_elbow" joint="left_elbow" kp="20" ctrlrange="-1 1"/>',
            "actuator left_elbow is not a <velocity",
        ),
        (
            '<velocity name="left_elbow" joint="left_elbow" class="elbow"/>',
            '<velocity name="left_elbow" joint="left_elbow" class="elbow" gear="10"/>',
            "actuator left_elbow is not a <velocity",
        ),
        (
            '<velocity name="left_elbow" joint="left_elbow" class="elbow"/>',
            '<velocity name="left_elbow" site="left_elbow" class="elbow"/>',
            "actuator left_elbow does not move joint left_elbow",
        ),
        (
            '<site name="left_elbow"/>',
            '<site name="left_elbow" pos="0 0 0.2817"/>',
            "left_upper_arm has no length; move the site at its end",
        ),
        (
            '<material name="floor"',
            '<mesh name="lost" file="lost.stl"/><material name="floor"',
            "lost.stl",
        ),
        (
            '<velocity name="left_elbow" joint="left_elbow" class="elbow"/>',
            '<general name="left_elbow" joint="left_elbow" gainprm="50" biasprm="0 0 -50"'
            ' ctrlrange="-15 15"/>',
            "is not a <velocity>",
        ),
        (
            '<velocity name="left_elbow" joint="left_elbow" class="elbow"/>',
            '<general name="left_elbow" joint="left_elbow" gainprm="50" biasprm="0 0 -50"'
            ' biastype="affine" dyntype="filter" dynprm="0.5" ctrlrange="-15 15"/>',
            "is not a <velocity>",
        ),
        (
            '<option timestep="0.005"',
            '<option actuatorgroupdisable="0" timestep="0.005"',
            "actuator left_shoulder_abduction is in a disabled group",
        ),
        ('timestep="0.005"', 'timestep="0"', "timestep is 0 s; expected 1e-05"),
        ('timestep="0.005"', 'timestep="-0.005"', "timestep is -0.005 s; expected"),
        ('kv="20" ctrlrange="-15 15"', 'kv="-20" ctrlrange="-15 15"', "with kv above 0"),
        ("<joint type=", "<joint typo=", "typo"),
        ("</mujoco>", "", "XML"),
        (
            '<joint name="left_elbow" class="elbow" axis="0 -1 0"/>',
            '<joint name="left_elbow" type="slide" axis="0 -1 0" range="0 1"/>',
            "joint left_elbow is not a hinge",
        ),
    ],
)
def test_arms_of_another_structure_are_refused(own: Path, old: str, new: str, message: str) -> None:
    assert message in refused(edited(own, (old, new)))


def test_actuator_strength_needs_force_limits(own: Path) -> None:
    edited(own, (' forcerange="-60 60"', ""))
    load("ymca", robot=own)
    message = "actuator left_elbow has no forcerange; add one, or leave actuator_strength out"
    assert message in refused(own, actuator_strength=0.5)


def test_a_motion_is_fitted_to_slower_actuators(own: Path) -> None:
    edited(own, ('ctrlrange="-15 15"', 'ctrlrange="-1 1"'))
    with pytest.warns(RecordingWarning, match="left_elbow would have to turn at"):
        angles = load("ymca", robot=own).task.motion.feasible_angles
    assert np.abs(np.diff(angles[:, 3::4], axis=0)).max() * 20.0 <= 0.901


def test_pictures_need_their_camera(own: Path) -> None:
    edited(own, ('<camera name="front"', '<camera name="mine"'))
    with pytest.raises(
        BadOptionError, match="camera is 'front'; expected one of the model's cameras: mine, side"
    ):
        ImitationEnv(robot=own, render_mode="rgb_array")
    ImitationEnv(robot=own, render_mode="rgb_array", camera="mine")
    ImitationEnv(robot=own)


def test_a_motion_is_fitted_to_the_joint_ranges(own: Path) -> None:
    axis = '<joint name="left_shoulder_abduction" axis="1 0 0"'
    edited(own, (f"{axis}/>", f'{axis} range="-0.1 0.1"/>'))
    message = r"left_shoulder_abduction would have to be at .* rad at .* s, but .* -0.1 to 0.1"
    with pytest.warns(RecordingWarning, match=message):
        angles = load("ymca", robot=own).task.motion.feasible_angles
    assert np.abs(angles[:, 0]).max() <= 0.1


def test_a_name_clash_with_the_payload_is_reported(own: Path) -> None:
    edited(own, ('<geom name="left_hand"', '<geom name="left_hand_payload"'))
    assert "left_hand_payload" in refused(own, payload=1.0)
