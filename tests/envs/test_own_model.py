"""Arms of a user's own: what they lack is told, and what they have is used."""

import re
from pathlib import Path

import numpy as np
import pytest

from mpma_mj.envs.gym import ImitationEnv
from mpma_mj.envs.load import load
from mpma_mj.envs.model import MODEL_PATH
from mpma_mj.envs.vector import make_vec
from mpma_mj.errors import BadOptionError, MotionReachError

OURS = MODEL_PATH.read_text(encoding="utf-8")


@pytest.fixture
def own(tmp_path: Path) -> Path:
    return tmp_path / "my_arms.xml"


def edited(path: Path, *changes: tuple[str, str]) -> Path:
    """Write the package's arms with some text replaced, each once at least."""
    text = OURS
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    path.write_text(text, encoding="utf-8")
    return path


def refused(path: Path, **options: object) -> str:
    with pytest.raises(BadOptionError) as caught:
        load("ymca", model=path, **options)
    message = str(caught.value)
    assert "\n" not in message
    assert message.startswith(str(path))
    return message


def test_a_copy_of_our_arms_moves_as_ours(own: Path) -> None:
    envs = load("ymca", model=edited(own)), load("ymca")
    for env in envs:
        env.reset()
    rng = np.random.default_rng(0)
    for action in rng.uniform(-1, 1, (50, 8)):
        one, other = (env.step(action).observation for env in envs)
        for name, values in one.items():
            np.testing.assert_array_equal(values, other[name])


def test_all_that_is_missing_is_listed(own: Path) -> None:
    elbow = '<velocity name="left_elbow" joint="left_elbow" class="elbow"/>'
    edited(
        own,
        (elbow, ""),
        ('<site name="right_wrist" pos="0 0 -0.2689"/>', ""),
        ('<joint name="left_elbow" class="elbow" axis="0 -1 0"/>', ""),
    )
    expected = "lacks joint left_elbow, actuator left_elbow, site right_wrist; name them so"
    assert expected in refused(own)


def test_hands_are_needed_only_where_something_acts_on_them(own: Path) -> None:
    edited(own, ('<body name="left_hand"', '<body name="left_fist"'))
    load("ymca", model=own)
    assert "lacks body left_hand" in refused(own, payload=1.0)
    assert "lacks body left_hand" in refused(own, push=(1.0, 10.0))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            '<joint name="left_shoulder_rotation" axis="0 0 1"/>',
            '<joint name="left_shoulder_rotation" axis="0 0 -1"/>',
            "left_forearm points elsewhere than joint angles should make it,"
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
            "left_forearm points elsewhere than joint angles should make it, at zero joint angles",
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
            "actuator left_elbow moves something else than joint left_elbow",
        ),
        (
            'kv="20" ctrlrange="-15 15"',
            'kv="20"',
            "actuator left_elbow has no ctrlrange",
        ),
        ("<joint type=", "<joint typo=", "typo"),
        ("</mujoco>", "", "XML"),
        (
            '<joint name="left_elbow" class="elbow" axis="0 -1 0"/>',
            '<joint name="left_elbow" type="slide" axis="0 -1 0" range="0 1"/>',
            "joint left_elbow is no hinge",
        ),
    ],
)
def test_arms_that_are_built_otherwise_are_refused(
    own: Path, old: str, new: str, message: str
) -> None:
    assert message in refused(edited(own, (old, new)))


def test_strength_needs_forces_that_are_limited(own: Path) -> None:
    edited(own, (' forcerange="-60 60"', ""))
    load("ymca", model=own)
    message = "actuator left_elbow has no forcerange; strength has nothing to scale"
    assert message in refused(own, strength=0.5)


def test_slower_actuators_refuse_a_dance_that_is_too_fast_for_them(own: Path) -> None:
    edited(own, ('ctrlrange="-15 15"', 'ctrlrange="-1 1"'))
    with pytest.raises(MotionReachError, match="left_elbow would have to turn at"):
        load("ymca", model=own)


def test_other_joints_and_another_order_are_no_matter(own: Path) -> None:
    """A pendulum before the arms, and the right arm's actuators first."""
    pendulum = (
        '<body name="pendulum" pos="0 1 2"><joint name="swing" axis="1 0 0"/>'
        '<inertial pos="0 0.3 -0.3" mass="1" diaginertia="0.1 0.1 0.1"/>'
        '<geom name="bob" type="sphere" size="0.05" pos="0 0.3 -0.3"/></body>\n'
        '    <body name="torso" pos="0 0 1.15">'
    )
    edited(own, ('<body name="torso" pos="0 0 1.15">', pendulum))
    text = own.read_text()
    actuators = re.findall(r'    <velocity name="\w+" joint=.*\n', text)
    for line in actuators:
        text = text.replace(line, "")
    text = text.replace("<actuator>\n", "<actuator>\n" + "".join(actuators[4:] + actuators[:4]))
    own.write_text(text)
    env, plain = load("ymca", model=own, seed=1), load("ymca", seed=1)
    many = make_vec(2, "ymca", model=own, seed=1)
    one, expected = env.reset(), plain.reset()
    observations, _ = many.reset()
    rng = np.random.default_rng(0)
    for action in rng.uniform(-1, 1, (60, 8)):
        for name, values in expected.observation.items():
            np.testing.assert_allclose(one.observation[name], values, atol=1e-8)
            np.testing.assert_array_equal(observations[name][0], one.observation[name])
        one, expected = env.step(action), plain.step(action)
        observations, *_ = many.step(np.stack([action, -action]))
    assert abs(env.physics.named.data.qpos["swing"]) > 0.1
    many.close()


def test_pictures_need_the_camera_that_they_are_taken_by(own: Path) -> None:
    edited(own, ('<camera name="front"', '<camera name="mine"'))
    env = ImitationEnv(model=own, render_mode="rgb_array")
    env.reset()
    with pytest.raises(BadOptionError, match="camera is 'front'; the model has mine, side, three"):
        env.render()


WILD = (('integrator="implicitfast"', 'integrator="Euler"'), ('kv="20"', 'kv="90000"'))


def test_wild_gains_end_the_episode_and_the_next_is_sound(
    own: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    env = load("ymca", model=edited(own, *WILD, (' forcerange="-60 60"', "")))
    for _ in range(2):
        timestep = env.reset()
        assert all(np.isfinite(value).all() for value in timestep.observation.values())
        while not timestep.last():
            timestep = env.step(np.ones(8))
        assert timestep.discount == 0.0
        assert timestep.reward == 0.0
        assert "ran away" in env.task.ending
        assert all(np.isfinite(value).all() for value in timestep.observation.values())
    assert [path.name for path in tmp_path.iterdir()] == ["my_arms.xml"]


def test_members_that_diverge_leave_the_others_alone(
    own: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    wild = edited(own, *WILD, (' forcerange="-60 60"', ""))
    many, one = make_vec(3, "ymca", model=wild), load("ymca", model=wild)
    many.reset(), one.reset()
    actions = np.zeros((3, 8))
    actions[0, 3] = 1.0  # only the first does anything
    ended = np.zeros(3, int)
    for _ in range(20):
        observations, rewards, terminated, truncated, infos = many.step(actions)
        timestep = one.step(actions[0])
        assert terminated[0] == (timestep.discount == 0.0)
        assert rewards[0] == (timestep.reward or 0.0)
        for name, values in timestep.observation.items():
            np.testing.assert_array_equal(observations[name][0], values)
        if terminated[0]:
            assert infos["ending"][0] == "the simulation diverged"
        assert not truncated.any()
        assert all(np.isfinite(values).all() for values in observations.values())
        ended += terminated
    assert ended[0] > 1
    assert [path.name for path in tmp_path.iterdir()] == ["my_arms.xml"]
    many.close()
