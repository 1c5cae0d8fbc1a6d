import subprocess
import sys
from contextlib import closing

import numpy as np
import pytest

from mpma_mj.envs import gl
from mpma_mj.envs.physics import KinematicArms, PhysicsArms
from mpma_mj.envs.rendering import ArmRenderer
from mpma_mj.errors import RenderingError
from mpma_mj.motions import ymca
from tests.envs.test_gl import environment

POSTURES = ymca().posture


@pytest.fixture(scope="module", autouse=True)
def _needs_opengl() -> None:
    try:
        gl.require_backend()
    except RenderingError as error:
        pytest.skip(str(error))


def test_pictures_show_the_arms_move() -> None:
    physics = PhysicsArms.make()
    with closing(ArmRenderer(physics)) as renderer:
        before = renderer.picture()
        with physics.reset_context():
            physics.data.qpos[:] = 1.0
        after = renderer.picture()
    assert before.shape == (480, 640, 3)
    assert before.dtype == np.uint8
    assert (before != after).any(axis=2).mean() > 0.01


def test_the_ghost_is_seen_where_the_arms_are_not() -> None:
    physics = PhysicsArms.make()
    with closing(ArmRenderer(physics)) as renderer:
        without = renderer.picture()
        hidden = renderer.picture(ghost=physics.posture())
        apart = renderer.picture(ghost=POSTURES[0])
        again = renderer.picture()
    assert (apart != without).any(axis=2).mean() > 0.003
    assert (hidden != without).any(axis=2).mean() < (apart != without).any(axis=2).mean()
    np.testing.assert_array_equal(again, without)


@pytest.mark.parametrize("camera", ["front", "side", "three_quarter"])
@pytest.mark.parametrize("kind", [PhysicsArms, KinematicArms])
def test_every_camera_sees_both_arms(kind: type[PhysicsArms], camera: str) -> None:
    physics = kind.make()
    with physics.reset_context():
        physics.data.qpos[:] = [1.2, 0.4, 0, 0.2] * 2
    with closing(ArmRenderer(physics, camera=camera)) as renderer:
        red, green, blue = np.moveaxis(renderer.picture().astype(int), -1, 0)
    assert ((blue - green > 50) & (blue - red > 30)).sum() > 100  # left arm
    assert ((red - green > 70) & (red - blue > 40)).sum() > 100  # right arm


def test_closing_twice_and_drawing_again_are_fine() -> None:
    renderer = ArmRenderer(PhysicsArms.make())
    renderer.close()
    renderer.picture()
    renderer.close()
    renderer.close()


@pytest.mark.parametrize("backend", ["egl", "osmesa"])
def test_both_software_backends_draw(backend: str) -> None:
    if not gl._loads(backend):
        pytest.skip(f"no library for {backend}")
    assert gl._draws(backend)


def test_without_opengl_drawing_says_what_to_install() -> None:
    code = (
        "from mpma_mj.envs.physics import PhysicsArms\n"
        "from mpma_mj.envs.rendering import ArmRenderer\n"
        "from mpma_mj.errors import RenderingError\n"
        "try: ArmRenderer(PhysicsArms.make()).picture()\n"
        "except RenderingError as error: print(error)"
    )
    result = subprocess.run(
        [sys.executable, "-c", code],
        env=environment(MUJOCO_GL="disable"),
        capture_output=True,
        text=True,
        check=False,
    )
    assert "libosmesa6" in result.stdout, result.stderr
