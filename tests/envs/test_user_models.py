"""Arms of users: as ours where they are alike, sound where they diverge."""

import re
from pathlib import Path

import numpy as np
import pytest

from mpma_mj.cli import main
from mpma_mj.envs.gym_env import ImitationEnv
from mpma_mj.envs.load import load
from mpma_mj.envs.make_vec import make_vec
from mpma_mj.errors import RecordingWarning, RenderingError
from mpma_mj.training.checkpoints import demonstrated
from mpma_mj.training.config import RunConfig
from mpma_mj.training.dataset import read_motions
from mpma_mj.training.run_folder import RunFolder
from mpma_mj.visualization.scene import Scene
from mpma_mj.visualization.video import episode_frames
from tests.envs.user_models import edited


@pytest.fixture
def own(tmp_path: Path) -> Path:
    return tmp_path / "my_arms.xml"


def test_a_copy_of_the_packages_arms_moves_alike(own: Path) -> None:
    envs = load("ymca", robot=edited(own)), load("ymca")
    for env in envs:
        env.reset()
    rng = np.random.default_rng(0)
    for action in rng.uniform(-1, 1, (50, 8)):
        one, other = (env.step(action).observation for env in envs)
        for name, values in one.items():
            np.testing.assert_array_equal(values, other[name])


def test_further_joints_and_another_order_change_nothing(own: Path) -> None:
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
    env, plain = (load("ymca", robot=m, seed=1, repeats=1) for m in (own, "two_arm"))
    many = make_vec(2, "ymca", robot=own, seed=1, repeats=1)
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


def test_contacts_have_the_memory_that_mujoco_reserves(own: Path) -> None:
    edited(own, ('<size memory="1M"/>', ""))
    assert load("ymca", robot=own).physics.model.narena >= 2**24
    edited(own, ('<size memory="1M"/>', '<size memory="64M"/>'))
    assert load("ymca", robot=own).physics.model.narena == 2**26


INERTIAL = re.compile(r"\s*<inertial [^>]*/>")


@pytest.mark.parametrize("from_geoms", ["auto", "true"])
def test_payload_has_its_mass_with_any_definition_of_inertia(own: Path, from_geoms: str) -> None:
    edited(own, ('inertiafromgeom="false"', f'inertiafromgeom="{from_geoms}"'))
    own.write_text(INERTIAL.sub("", own.read_text()))
    bare, loaded = load("ymca", robot=own), load("ymca", robot=own, payload=2.0)
    extra = loaded.physics.model.body_mass.sum() - bare.physics.model.body_mass.sum()
    assert extra == pytest.approx(4.0)
    ball = loaded.physics.model.body("left_hand_payload")
    radius = loaded.physics.model.geom("left_hand_payload").size[0]
    np.testing.assert_allclose(ball.inertia, 0.4 * 2.0 * radius**2)
    np.testing.assert_allclose(ball.pos, bare.physics.model.body("left_hand").ipos)
    loaded.reset()
    assert loaded.step(np.zeros(8)).mid()


def test_payload_collides_as_the_hand_does() -> None:
    model = load("ymca", payload=30.0, collisions=True).physics.model
    hand, ball = model.geom("left_hand"), model.geom("left_hand_payload")
    assert (ball.contype, ball.conaffinity) == (hand.contype, hand.conaffinity)
    assert ball.contype[0] & model.geom("chest").contype[0] == 0  # by affinity, then
    assert ball.conaffinity[0] & model.geom("chest").contype[0]


BALL = (
    '<body name="torso" pos="0 0 1.15">',
    '<body name="ball" pos="2 0 2"><freejoint name="free"/>'
    '<inertial pos="0 0 0" mass="1" diaginertia="0.1 0.1 0.1"/></body>'
    '<body name="torso" pos="0 0 1.15">',
)


def test_gravity_compensation_acts_on_the_arms_only(own: Path) -> None:
    env = load("ymca", robot=edited(own, BALL), gravity_compensation=True)
    env.reset()
    for _ in range(10):
        env.step(np.zeros(8))
    assert env.physics.named.data.xpos["ball", "z"] < 1.5
    carried = env.physics.model.body_gravcomp
    assert carried[env.physics.model.body("left_hand").id] == 1.0
    assert carried[env.physics.model.body("torso").id] == 0.0


def test_divergence_names_the_joint_or_its_number(own: Path) -> None:
    env = load("ymca", robot=edited(own, BALL))
    for address, name in ((7, "left_shoulder_abduction"), (14, "right_elbow"), (2, "free")):
        env.reset()
        env.physics.data.qpos[address] = np.inf
        assert env.step(np.zeros(8)).last()
        assert f"the angle of {name} ran away" in env.task.termination_reason
    nameless = (BALL[0], BALL[1].replace(' name="free"', ""))
    env = load("ymca", robot=edited(own, nameless))
    env.reset()
    env.physics.data.qpos[2] = np.inf
    env.step(np.zeros(8))
    assert "the angle of joint 0 ran away" in env.task.termination_reason


def test_a_model_without_automatic_reset_diverges_as_others(own: Path) -> None:
    edited(own, ('<flag contact="disable"/>', '<flag contact="disable" autoreset="disable"/>'))
    env = load("ymca", robot=own)
    env.reset()
    env.physics.data.qvel[3] = np.nan
    assert env.step(np.zeros(8)).discount == 0.0


def test_contacts_of_a_model_are_off_without_collisions(own: Path) -> None:
    edited(own, ('<flag contact="disable"/>', ""))
    for collisions in (False, True):
        env = load("ymca", robot=own, collisions=collisions)
        with env.physics.reset_context():
            env.physics.data.qpos[:] = np.array([0.0, 0.9, -1.5, 1.6] * 2)
        assert (env.physics.data.ncon > 0) == collisions


def test_divergence_in_the_last_physics_step_is_detected(own: Path) -> None:
    """One physics step a control step, in which an undamped joint turns past MuJoCo's bound."""
    edited(
        own,
        ('timestep="0.005"', 'timestep="0.05"'),
        ('integrator="implicitfast"', 'integrator="Euler"'),
        ('damping="0.3"', 'damping="0"'),
    )
    turned, speed, joint = 9.99e9, 9.9e9, 2  # rotation of a straight arm, which moves nothing else
    env, many = load("ymca", robot=own), make_vec(2, "ymca", robot=own)
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


def test_delayed_actuators_are_the_same_alone_and_in_a_vector(own: Path) -> None:
    edited(
        own,
        (
            '<velocity name="left_elbow" joint="left_elbow" class="elbow"/>',
            '<velocity name="left_elbow" joint="left_elbow" class="elbow" delay="0.02"'
            ' nsample="8"/>',
        ),
    )
    env, many = load("ymca", robot=own), make_vec(2, "ymca", robot=own)
    env.reset(), many.reset()
    for action in np.random.default_rng(0).uniform(-1, 1, (30, 8)):
        expected = env.step(action).observation["joint_angles"]
        np.testing.assert_array_equal(many.step([action] * 2)[0]["joint_angles"][0], expected)
    many.close()


def test_a_camera_on_an_arm_moves_with_it(own: Path) -> None:
    lens = '<camera name="front" pos="0 0 -0.3"/><body name="left_hand" pos="0 0 -0.2689">'
    edited(
        own,
        ('<camera name="front"', '<camera name="fixed"'),
        ('<body name="left_hand" pos="0 0 -0.2689">', lens),
    )
    places = {}
    for arms in ("physics", "kinematic"):
        env = ImitationEnv(robot=own, arms=arms, render_mode="rgb_array", repeats=1)
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


def test_unstable_gains_end_the_episode_and_not_the_next(
    own: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    env = load("ymca", robot=edited(own, *WILD, (' forcerange="-60 60"', "")))
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


def test_divergence_of_one_environment_leaves_the_others_alone(
    own: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    wild = edited(own, *WILD, (' forcerange="-60 60"', ""))
    many, one = make_vec(3, "ymca", robot=wild), load("ymca", robot=wild)
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


@pytest.fixture
def quick(own: Path) -> Path:
    """Return arms that are twice as fast as the package's, and a camera of their own."""
    edited(own, ('<camera name="front"', '<camera name="far" pos="9 0 1"/><camera name="front"'))
    double = re.sub(
        r'ctrlrange="-(\d+) \d+"',
        lambda found: "ctrlrange='-{0} {0}'".format(2 * int(found[1])),
        own.read_text(encoding="utf-8"),
    )
    own.write_text(double, encoding="utf-8")
    return own


def test_a_run_is_checked_and_drawn_with_its_own_arms(quick: Path, tmp_path: Path) -> None:
    out = tmp_path / "run"
    words = f"imitate ymca --robot {quick} --tempo 2 --to 2.5 --repeats 2 --nodes 5 --modules 2"
    assert main([*words.split(), "--epochs", "1", "--no-video", "--out", str(out)]) == 0
    folder = RunFolder(out)
    trace, options = demonstrated(folder)[1], folder.read_config().env
    frames = episode_frames(Scene(trace, folder.read_motion(), options, camera="far"))
    try:
        assert next(frames).std() > 10
    except RenderingError as error:
        pytest.skip(str(error))


def test_a_repertoire_may_be_as_fast_as_its_own_arms(quick: Path) -> None:
    config = RunConfig.of("ymca", "ymca", robot=str(quick), tempo=2.0)
    assert read_motions(config).feasible_angles is None
    with pytest.warns(RecordingWarning, match="the closest motion"):
        changed = read_motions(config.replace(robot="two_arm"))
    assert changed.feasible_angles is not None
