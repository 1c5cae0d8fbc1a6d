"""Cameras: what is in view, as geometry."""

from pathlib import Path

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray

from mpma_mj.envs.cameras import check_camera, free_camera, orbit_camera
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.envs.physics import PhysicsArms
from mpma_mj.errors import BadOptionError
from tests.envs.user_models import edited

Array = NDArray[np.float64]


def pose_of(camera: mujoco.MjvCamera) -> tuple[Array, Array]:
    """Return place and direction of a free camera, each shape (3,)."""
    turn, tilt = np.radians([camera.azimuth, camera.elevation])
    ahead = np.array([np.cos(turn) * np.cos(tilt), np.sin(turn) * np.cos(tilt), np.sin(tilt)])
    return camera.lookat - camera.distance * ahead, ahead


@pytest.fixture
def without_cameras(tmp_path: Path) -> PhysicsArms:
    names = ('name="front"', 'name="side"', 'name="three_quarter"')
    changes = [(name, f'name="{i}"') for i, name in enumerate(names)]
    far = ('name="torso" pos="0 0 1.15"', 'name="torso" pos="3 1 2"')
    path = edited(tmp_path / "arms.xml", *changes, far)
    return PhysicsArms.make(EnvironmentOptions(robot=str(path)))


@pytest.mark.parametrize("name", ["front", "side", "three_quarter"])
def test_a_free_camera_looks_as_that_of_the_model_does(name: str) -> None:
    arms = PhysicsArms.make()
    place, ahead = pose_of(free_camera(arms, name))
    number = arms.model.name2id(name, "camera")
    np.testing.assert_allclose(place, arms.data.cam_xpos[number], atol=1e-6)
    np.testing.assert_allclose(ahead, -arms.data.cam_xmat[number].reshape(3, 3)[:, 2], atol=1e-6)


@pytest.mark.parametrize("aspect", [0.4, 1.0, 2.5])
@pytest.mark.parametrize("azimuth", [0.0, 77.0, 180.0])
def test_wherever_it_is_a_camera_that_goes_around_sees_the_arms(
    aspect: float, azimuth: float, without_cameras: PhysicsArms
) -> None:
    arms = without_cameras
    camera = orbit_camera(arms, aspect)
    camera.azimuth = azimuth
    place, ahead = pose_of(camera)
    vectors = np.random.default_rng(0).standard_normal((200, 4, 3))
    postures = (vectors / np.linalg.norm(vectors, axis=2, keepdims=True)).reshape(200, 12)
    seen = arms.site_positions(postures).reshape(-1, 3) - place
    right = np.cross(ahead, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    half = np.tan(np.radians(arms.model.vis.global_.fovy) / 2.0)
    depth = seen @ ahead
    assert depth.min() > 0.0
    assert (np.abs(seen @ np.cross(right, ahead)) < half * depth).all()
    assert (np.abs(seen @ right) < aspect * half * depth).all()


def test_a_model_without_the_usual_camera_is_seen_from_the_front(
    without_cameras: PhysicsArms,
) -> None:
    place, ahead = pose_of(free_camera(without_cameras, "front"))
    assert ahead[0] < -0.9
    assert place[0] > 3.0


def test_an_unknown_camera_is_refused_with_the_nearest_name() -> None:
    with pytest.raises(BadOptionError, match="three_quarter; did you mean three_quarter"):
        free_camera(PhysicsArms.make(), "threequarter")
    with pytest.raises(BadOptionError, match="three_quarter, or orbit; did you mean orbit"):
        check_camera(PhysicsArms.make(), "orbits", "orbit")
