"""The MJCF model, and the options that change it."""

import dm_env
import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray

from mpma_mj.envs.load import load
from mpma_mj.envs.physics import PhysicsArms
from mpma_mj.kinematics import JOINT_NAMES, SIDES, posture_from_angles
from mpma_mj.motions import Motion, ymca
from mpma_mj.robots.robot_file import read_robot

BODY_MASS = 73.0


# de Leva (1996), table 4, men: length m, mass share, centre of mass, radii of gyration (x, y, z)
DE_LEVA = {
    "upper_arm": (0.2817, 0.0271, 0.5772, (0.285, 0.269, 0.158)),
    "forearm": (0.2689, 0.0162, 0.4574, (0.276, 0.265, 0.121)),
    "hand": (0.0862, 0.0061, 0.7900, (0.628, 0.513, 0.401)),
}


@pytest.fixture(scope="module")
def model() -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_path(str(read_robot("two_arm").model))


def test_every_element_has_a_name(model: mujoco.MjModel) -> None:
    kinds = ("body", "jnt", "geom", "site", "cam", "light", "actuator", "mat", "tex")
    for kind in kinds:
        addresses = getattr(model, f"name_{kind}adr")
        names = [model.names[a : model.names.index(b"\0", a)] for a in addresses]
        assert len(names) > 0
        assert all(names), f"a {kind} has no name"


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("segment", DE_LEVA)
def test_masses_and_inertias_are_de_levas(model: mujoco.MjModel, side: str, segment: str) -> None:
    length, share, centre, radii = DE_LEVA[segment]
    body = model.body(f"{side}_{segment}")
    mass = share * BODY_MASS
    assert body.mass[0] == pytest.approx(mass, rel=1e-3)
    np.testing.assert_allclose(body.ipos, [0, 0, -centre * length], atol=1e-4)
    np.testing.assert_allclose(body.inertia, mass * (np.array(radii) * length) ** 2, rtol=2e-3)


@pytest.mark.parametrize("side", SIDES)
def test_segments_have_their_lengths(side: str) -> None:
    lengths = dict(zip(("upper_arm", "forearm"), PhysicsArms.make().segment_lengths, strict=False))
    for segment, length in lengths.items():
        assert length == pytest.approx(DE_LEVA[segment][0])


def test_joints_and_actuators_are_the_eight_in_order(model: mujoco.MjModel) -> None:
    assert tuple(model.joint(i).name for i in range(model.njnt)) == JOINT_NAMES
    assert tuple(model.actuator(i).name for i in range(model.nu)) == JOINT_NAMES
    assert (model.actuator_trnid[:, 0] == np.arange(8)).all()
    assert model.nq == model.nv == 8


def test_actuators_are_limited_and_alike_on_both_sides(model: mujoco.MjModel) -> None:
    for limits in (model.actuator_ctrlrange, model.actuator_forcerange):
        np.testing.assert_array_equal(limits[:4], limits[4:])
        np.testing.assert_array_equal(limits[:, 0], -limits[:, 1])
        assert (limits[:, 1] > 0).all()


def test_simulation_is_as_the_actuators_need_it(model: mujoco.MjModel) -> None:
    assert model.opt.integrator == mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    assert model.opt.timestep == 0.005
    np.testing.assert_array_equal(model.opt.gravity, [0, 0, -9.81])


@pytest.mark.parametrize("camera", ["front", "side", "three_quarter"])
def test_cameras_look_at_the_torso(model: mujoco.MjModel, camera: str) -> None:
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    towards = np.array([0, 0, 1.15]) - data.camera(camera).xpos
    forward = -data.camera(camera).xmat.reshape(3, 3)[:, 2]
    assert forward @ towards / np.linalg.norm(towards) > 0.95


def at_rest(env: dm_env.Environment, steps: int) -> list[dm_env.TimeStep]:
    return [env.reset()] + [env.step(np.zeros(8)) for _ in range(steps)]


def test_compensated_arms_stand_still_and_others_sink() -> None:
    motion = ymca()
    raised = Motion(
        posture_from_angles(np.tile([1.5, 0, 0, 0.5] * 2, (20, 1))),
        np.ones((20, 1)),
        ("up",),
        motion.rate,
        "raised",
        "arms held sideways",
    )
    sunk = {}
    for compensated in (True, False):
        angles = [
            t.observation["joint_angles"]
            for t in at_rest(load(raised, gravity_compensation=compensated), 15)
        ]
        sunk[compensated] = np.abs(angles[-1] - angles[0]).max()
    assert sunk[True] < 1e-3
    assert sunk[False] > 0.05


def test_gravity_compensation_ignores_the_payload() -> None:
    env = load("ymca", gravity_compensation=True, payload=2.0)
    env.reset()
    force = env.physics.data.qfrc_gravcomp + env.physics.data.qfrc_passive
    bare = load("ymca", gravity_compensation=True)
    bare.reset()
    np.testing.assert_allclose(
        force, bare.physics.data.qfrc_gravcomp + bare.physics.data.qfrc_passive, atol=1e-9
    )
    assert env.physics.model.body_gravcomp[env.physics.model.body("left_hand_payload").id] == 0


@pytest.mark.parametrize("kilograms", [0.5, 3.0])
def test_payload_is_the_mass_in_each_hand(kilograms: float) -> None:
    bare, loaded = load("ymca"), load("ymca", payload=kilograms)
    mass = loaded.physics.model.body_mass.sum() - bare.physics.model.body_mass.sum()
    assert mass == pytest.approx(2 * kilograms)
    for env in (bare, loaded):
        with env.physics.reset_context():
            env.physics.data.qpos[:] = np.array([np.pi / 2, 0, 0, 0] * 2)
    lever = 0.2817 + 0.2689 + 0.0681  # shoulder to the middle of the hand, m
    torque = loaded.physics.data.qfrc_bias[0] - bare.physics.data.qfrc_bias[0]
    assert torque == pytest.approx(9.81 * kilograms * lever, rel=1e-3)


def test_actuator_strength_scales_the_force_limits() -> None:
    ranges = [
        load("ymca", actuator_strength=s).physics.model.actuator_forcerange for s in (1.0, 0.25)
    ]
    np.testing.assert_allclose(ranges[1], 0.25 * ranges[0])


def test_arms_that_collide_do_not_pass_through_the_body() -> None:
    angles = {}
    for collide in (True, False):
        env = load("ymca", collisions=collide)
        env.reset()
        with env.physics.reset_context():
            env.physics.data.qpos[:] = np.array([0.0, 0.9, 0.0, 1.2] * 2)
        for _ in range(20):  # forearms turn inwards, towards the chest
            env.physics.set_control(np.array([0.0, 0.0, -3.0, 0.0] * 2))
            env.physics.step(10)
        angles[collide] = env.physics.joint_angles()
        assert env.physics.divergence == ""
    assert angles[False][2] < angles[True][2] - 0.3


def test_arms_that_hang_touch_nothing() -> None:
    env = load("ymca", collisions=True)
    with env.physics.reset_context():
        pass
    assert env.physics.data.ncon == 0


def test_what_is_only_looked_at_touches_nothing_and_hands_touch_undrawn() -> None:
    physics = PhysicsArms.make()
    model = physics.model.ptr
    touching = (model.geom_contype | model.geom_conaffinity) != 0
    undrawn = {model.geom(i).name for i in np.flatnonzero(touching & (model.geom_group > 2))}
    only_seen = {model.geom(i).name for i in np.flatnonzero(~touching)}
    parts = ("palm", "thumb", "index", "middle", "little", "eye")
    assert undrawn == {"left_hand", "right_hand", "visor"}
    assert only_seen == {"shadow", "face"} | {f"{side}_{part}" for side in SIDES for part in parts}


# Linear RGB as seen without long, middle or short cones: Machado, Oliveira & Fernandes (2009), A
# physiologically-based model for simulation of color vision deficiency, IEEE TVCG 15(6), 1291-1298,
# table of severity 1.
_VISION = {
    "normal": np.eye(3),
    "protanopia": [
        [0.152286, 1.052583, -0.204868],
        [0.114503, 0.786281, 0.099216],
        [-0.003882, -0.048116, 1.051998],
    ],
    "deuteranopia": [
        [0.367322, 0.860646, -0.227968],
        [0.280085, 0.672501, 0.047413],
        [-0.011820, 0.042940, 0.968881],
    ],
    "tritanopia": [
        [1.255528, -0.076749, -0.178779],
        [-0.078411, 0.930809, 0.147602],
        [0.004733, 0.691367, 0.303900],
    ],
}


@pytest.mark.parametrize("vision", _VISION)
def test_the_arms_colours_differ_for_every_kind_of_colour_vision(
    model: mujoco.MjModel, vision: str
) -> None:
    left, right = (_lab(model.mat(f"{side}_arm").rgba[:3], _VISION[vision]) for side in SIDES)
    assert np.linalg.norm(left - right) > 40  # CIE 1976: 2.3 is just seen


def _lab(rgb: NDArray[np.float64], vision: object) -> NDArray[np.float64]:
    """Return CIE L*a*b* (D65) of an sRGB colour, shape (3,), as somebody sees it."""
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    seen = np.clip(np.asarray(vision) @ linear, 0.0, 1.0)
    to_xyz = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
    x, y, z = np.cbrt(np.maximum(to_xyz @ seen / [0.9505, 1.0, 1.089], 0.008856))
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])
