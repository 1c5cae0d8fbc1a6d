"""Arms of a user's own: what they lack is told, and what they have is used."""

import re
from pathlib import Path

import numpy as np
import pytest

from mpma_mj.envs.gym_env import ImitationEnv
from mpma_mj.envs.load import load
from mpma_mj.envs.model import MODEL_PATH
from mpma_mj.envs.vector_env import make_vec
from mpma_mj.errors import BadOptionError, MotionReachError, RenderingError

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


def test_a_folder_is_no_model(tmp_path: Path) -> None:
    with pytest.raises(BadOptionError, match="expected an MJCF file, and this is a folder"):
        load("ymca", model=tmp_path)


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
    assert "lacks body left_hand" in refused(own, perturbation=(1.0, 10.0))


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
            "actuator left_elbow is no <velocity> with kv above 0 and gear 1",
        ),
        (
            '<velocity name="left_elbow" joint="left_elbow" class="elbow"/>',
            '<position name="left_elbow" joint="left_elbow" kp="20" ctrlrange="-1 1"/>',
            "actuator left_elbow is no <velocity",
        ),
        (
            '<velocity name="left_elbow" joint="left_elbow" class="elbow"/>',
            '<velocity name="left_elbow" joint="left_elbow" class="elbow" gear="10"/>',
            "actuator left_elbow is no <velocity",
        ),
        (
            '<velocity name="left_elbow" joint="left_elbow" class="elbow"/>',
            '<velocity name="left_elbow" site="left_elbow" class="elbow"/>',
            "actuator left_elbow moves something else than joint left_elbow",
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
            "is no <velocity>",
        ),
        (
            '<velocity name="left_elbow" joint="left_elbow" class="elbow"/>',
            '<general name="left_elbow" joint="left_elbow" gainprm="50" biasprm="0 0 -50"'
            ' biastype="affine" dyntype="filter" dynprm="0.5" ctrlrange="-15 15"/>',
            "is no <velocity>",
        ),
        (
            '<option timestep="0.005"',
            '<option actuatorgroupdisable="0" timestep="0.005"',
            "actuator left_shoulder_abduction is in a group that is disabled",
        ),
        ('timestep="0.005"', 'timestep="0"', "timestep is 0 s; expected above 0"),
        ('timestep="0.005"', 'timestep="-0.005"', "timestep is -0.005 s; expected above 0"),
        ('kv="20" ctrlrange="-15 15"', 'kv="-20" ctrlrange="-15 15"', "with kv above 0"),
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
    message = "actuator left_elbow has no forcerange; add one, or leave actuator_strength out"
    assert message in refused(own, actuator_strength=0.5)


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
    env, plain = (load("ymca", model=m, seed=1, repeats=1) for m in (own, None))
    many = make_vec(2, "ymca", model=own, seed=1, repeats=1)
    one, expected = env.reset(), plain.reset()
    observations, _ = many.reset()
    rng = np.random.default_rng(0)
    for action in rng.uniform(-1, 1, (100, 8)):  # into a second episode
        for name, values in expected.observation.items():
            np.testing.assert_allclose(one.observation[name], values, atol=1e-8)
            np.testing.assert_array_equal(observations[name][0], one.observation[name])
        one, expected = env.step(action), plain.step(action)
        observations, *_ = many.step(np.stack([action, -action]))
        swung = env.physics.data.qpos[0]
        assert swung == pytest.approx(many._batch._state[0, 1], abs=0.0)
    assert abs(swung) > 0.1
    many.close()


def test_pictures_need_the_camera_that_they_are_taken_by(own: Path) -> None:
    edited(own, ('<camera name="front"', '<camera name="mine"'))
    env = ImitationEnv(model=own, render_mode="rgb_array")
    env.reset()
    with pytest.raises(
        BadOptionError, match="camera is 'front'; expected one of the model's cameras: mine, side"
    ):
        env.render()


def test_contacts_have_the_memory_that_mujoco_would_give_them(own: Path) -> None:
    edited(own, ('<size memory="1M"/>', ""))
    assert load("ymca", model=own).physics.model.narena >= 2**24
    edited(own, ('<size memory="1M"/>', '<size memory="64M"/>'))
    assert load("ymca", model=own).physics.model.narena == 2**26


def test_ranges_that_the_dance_leaves_are_told(own: Path) -> None:
    axis = '<joint name="left_shoulder_abduction" axis="1 0 0"'
    edited(own, (f"{axis}/>", f'{axis} range="-0.1 0.1"/>'))
    message = r"left_shoulder_abduction would have to be at .* rad at frame .* -0.1 to 0.1"
    with pytest.raises(MotionReachError, match=message):
        load("ymca", model=own)


INERTIAL = re.compile(r"\s*<inertial [^>]*/>")


@pytest.mark.parametrize("from_geoms", ["auto", "true"])
def test_payload_weighs_the_same_whatever_says_how_heavy_the_hands_are(
    own: Path, from_geoms: str
) -> None:
    edited(own, ('inertiafromgeom="false"', f'inertiafromgeom="{from_geoms}"'))
    own.write_text(INERTIAL.sub("", own.read_text()))
    bare, loaded = load("ymca", model=own), load("ymca", model=own, payload=2.0)
    extra = loaded.physics.model.body_mass.sum() - bare.physics.model.body_mass.sum()
    assert extra == pytest.approx(4.0)
    ball = loaded.physics.model.body("left_hand_payload")
    radius = loaded.physics.model.geom("left_hand_payload").size[0]
    np.testing.assert_allclose(ball.inertia, 0.4 * 2.0 * radius**2)
    np.testing.assert_allclose(ball.pos, bare.physics.model.body("left_hand").ipos)
    loaded.reset()
    assert loaded.step(np.zeros(8)).mid()


def test_payload_touches_what_the_hand_touches() -> None:
    model = load("ymca", payload=30.0, collisions=True).physics.model
    hand, ball = model.geom("left_hand"), model.geom("left_hand_payload")
    assert (ball.contype, ball.conaffinity) == (hand.contype, hand.conaffinity)
    assert ball.contype[0] & model.geom("chest").contype[0] == 0  # by affinity, then
    assert ball.conaffinity[0] & model.geom("chest").contype[0]


def test_a_name_that_the_payload_needs_is_told(own: Path) -> None:
    edited(own, ('<geom name="left_hand"', '<geom name="left_hand_payload"'))
    assert "left_hand_payload" in refused(own, payload=1.0)


BALL = (
    '<body name="torso" pos="0 0 1.15">',
    '<body name="ball" pos="2 0 2"><freejoint name="free"/>'
    '<inertial pos="0 0 0" mass="1" diaginertia="0.1 0.1 0.1"/></body>'
    '<body name="torso" pos="0 0 1.15">',
)


def test_gravity_compensation_carries_the_arms_only(own: Path) -> None:
    env = load("ymca", model=edited(own, BALL), gravity_compensation=True)
    env.reset()
    for _ in range(10):
        env.step(np.zeros(8))
    assert env.physics.named.data.xpos["ball", "z"] < 1.5
    carried = env.physics.model.body_gravcomp
    assert carried[env.physics.model.body("left_hand").id] == 1.0
    assert carried[env.physics.model.body("torso").id] == 0.0


def test_what_ran_away_is_told_by_its_joint_or_its_number(own: Path) -> None:
    env = load("ymca", model=edited(own, BALL))
    for address, name in ((7, "left_shoulder_abduction"), (14, "right_elbow"), (2, "free")):
        env.reset()
        env.physics.data.qpos[address] = np.inf
        assert env.step(np.zeros(8)).last()
        assert f"the angle of {name} ran away" in env.task.termination_reason
    nameless = (BALL[0], BALL[1].replace(' name="free"', ""))
    env = load("ymca", model=edited(own, nameless))
    env.reset()
    env.physics.data.qpos[2] = np.inf
    env.step(np.zeros(8))
    assert "the angle of joint 0 ran away" in env.task.termination_reason


def test_a_model_that_does_not_start_over_diverges_as_others(own: Path) -> None:
    edited(own, ('<flag contact="disable"/>', '<flag contact="disable" autoreset="disable"/>'))
    env = load("ymca", model=own)
    env.reset()
    env.physics.data.qvel[3] = np.nan
    assert env.step(np.zeros(8)).discount == 0.0


def test_contacts_of_a_model_are_off_unless_asked_for(own: Path) -> None:
    edited(own, ('<flag contact="disable"/>', ""))
    for collisions in (False, True):
        env = load("ymca", model=own, collisions=collisions)
        with env.physics.reset_context():
            env.physics.data.qpos[:] = np.array([0.0, 0.9, -1.5, 1.6] * 2)
        assert (env.physics.data.ncon > 0) == collisions


def test_numbers_that_run_away_in_the_last_physics_step_are_not_handed_out(own: Path) -> None:
    """One physics step a control step, in which an undamped joint turns past MuJoCo's bound."""
    edited(
        own,
        ('timestep="0.005"', 'timestep="0.05"'),
        ('integrator="implicitfast"', 'integrator="Euler"'),
        ('damping="0.3"', 'damping="0"'),
    )
    turned, speed, joint = 9.99e9, 9.9e9, 2  # rotation of a straight arm, which moves nothing else
    env, many = load("ymca", model=own), make_vec(2, "ymca", model=own)
    env.reset(), many.reset()
    angles, velocities = np.zeros(8), np.zeros(8)
    angles[joint], velocities[joint] = turned, speed
    env.physics.set_joint_state(angles, velocities)
    many._batch.set_joint_state(0, angles, velocities)
    timestep = env.step(np.zeros(8))
    observations, _, terminated, *_ = many.step(np.zeros((2, 8)))
    assert timestep.discount == 0.0
    assert "left_shoulder_rotation ran away" in env.task.termination_reason
    assert terminated.tolist() == [True, False]
    for name, values in timestep.observation.items():
        np.testing.assert_array_equal(observations[name][0], values)
    many.close()


def test_delayed_actuators_are_the_same_alone_and_in_company(own: Path) -> None:
    edited(
        own,
        (
            '<velocity name="left_elbow" joint="left_elbow" class="elbow"/>',
            '<velocity name="left_elbow" joint="left_elbow" class="elbow" delay="0.02"'
            ' nsample="8"/>',
        ),
    )
    env, many = load("ymca", model=own), make_vec(2, "ymca", model=own)
    env.reset(), many.reset()
    for action in np.random.default_rng(0).uniform(-1, 1, (30, 8)):
        expected = env.step(action).observation["joint_angles"]
        np.testing.assert_array_equal(many.step([action] * 2)[0]["joint_angles"][0], expected)
    many.close()


def test_a_camera_on_an_arm_goes_along(own: Path) -> None:
    lens = '<camera name="front" pos="0 0 -0.3"/><body name="left_hand" pos="0 0 -0.2689">'
    edited(
        own,
        ('<camera name="front"', '<camera name="fixed"'),
        ('<body name="left_hand" pos="0 0 -0.2689">', lens),
    )
    places = {}
    for arms in ("physics", "kinematic"):
        env = ImitationEnv(model=own, arms=arms, render_mode="rgb_array", repeats=1)
        env.reset()
        for _ in range(10):
            env.step(np.full(8, 0.3))
        try:
            env.render()
        except RenderingError as error:
            pytest.skip(str(error))
        camera, forearm = (
            env.physics.named.data.cam_xpos["front"],
            env.physics.named.data.xpos["left_forearm"],
        )
        places[arms] = float(np.linalg.norm(camera - forearm))
        env.close()
    assert places["kinematic"] == pytest.approx(0.3, abs=1e-6)
    assert places["physics"] == pytest.approx(0.3, abs=1e-6)


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
        assert "ran away" in env.task.termination_reason
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
            assert infos["termination_reason"][0] == "the simulation diverged"
        assert not truncated.any()
        assert all(np.isfinite(values).all() for values in observations.values())
        ended += terminated
    assert ended[0] > 1
    assert [path.name for path in tmp_path.iterdir()] == ["my_arms.xml"]
    many.close()
