"""Pictures of the arms."""

import pickle
import subprocess
import sys
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from numpy.typing import NDArray

from mpma_mj.envs import gl
from mpma_mj.envs.gym_env import ImitationEnv
from mpma_mj.envs.make_vec import make_vec
from mpma_mj.envs.physics import KinematicArms, PhysicsArms
from mpma_mj.envs.rendering import ArmRenderer
from mpma_mj.errors import BadOptionError
from mpma_mj.motions import ymca
from tests.envs.gym_episodes import actions, assert_same, make
from tests.envs.test_gl import environment, python

POSTURES = ymca().posture

pytestmark = pytest.mark.usefixtures("opengl")


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


MOTION = ymca()


Array = NDArray[np.float64]


def test_pictures_pickled_and_closed() -> None:
    env = make(render_mode="rgb_array")
    env.reset(seed=0)
    env.step(np.ones(8))
    picture = env.render()
    assert picture.shape == (480, 640, 3)
    assert picture.dtype == np.uint8
    other = pickle.loads(pickle.dumps(env))
    env.close()
    env.close()
    np.testing.assert_array_equal(other.render(), picture)
    assert_same(env.step(np.ones(8)), other.step(np.ones(8)))
    assert (env.render() != picture).any()
    env.close(), other.close()


def test_size_and_camera_are_options_of_the_environment() -> None:
    view = {"width": 160, "height": 90, "camera": "side"}
    with closing(make(render_mode="rgb_array", **view)) as env:
        env.reset(seed=0)
        side = env.render()
        again = pickle.loads(pickle.dumps(env))
        np.testing.assert_array_equal(again.render(), side)
        again.close()
    with closing(make(render_mode="rgb_array", **view | {"camera": "front"})) as env:
        env.reset(seed=0)
        assert env.render().shape == side.shape == (90, 160, 3)
        assert (env.render() != side).any()


@pytest.mark.parametrize(
    ("view", "message"),
    [
        ({"camera": "back"}, "camera is 'back'; expected one of the model's cameras: front, side"),
        ({"width": 0}, "width is 0; expected a whole number of pixels from 1 to 8192"),
        ({"height": 99999}, "height is 99999; expected a whole number of pixels"),
        ({"height": -1}, "height is -1; expected a whole number of pixels"),
        ({"width": "640"}, "width is '640'; expected a whole number of pixels"),
        ({"camera": None}, "camera is None; expected one of the model's cameras: front, side"),
        ({"camera": np.zeros(2)}, r"camera is array\(.*\); expected one of the model's cameras"),
    ],
)
@pytest.mark.parametrize("mode", ["rgb_array", None])
def test_an_impossible_view_is_refused_when_the_environment_is_made(
    mode: str | None, view: dict[str, Any], message: str
) -> None:
    for maker in (make, partial(make_vec, 2)):
        with pytest.raises(BadOptionError, match=message):
            maker(render_mode=mode, **view)


DRAWN = """
import gymnasium, os, sys, threading
from mpma_mj.errors import RenderingError
def make():
    env = gymnasium.make("mpma_mj:TwoArmImitation-v0", arms="kinematic", render_mode="rgb_array")
    env.reset()
    return env
def draw(env):
    try: print(env.render().shape, flush=True)
    except RenderingError as error: print(error, flush=True)
env = make()
env.render()
"""


def test_a_forked_process_that_draws_is_refused() -> None:
    forks = """
if not (child := os.fork()):
    draw(env), draw(make()), env.close()
    sys.exit()
os.waitpid(child, 0), draw(env)
"""
    lines = python(DRAWN + forks).stdout.splitlines()
    assert len(lines) == 3
    for line in lines[:2]:
        assert line.startswith(
            "no picture: this process was forked from one that has drawn; use sp"
        )
    assert lines[2] == "(480, 640, 3)"


def test_another_thread_that_draws_needs_its_own_environment() -> None:
    threads = """
for one in (lambda: draw(env), lambda: draw(make())):
    thread = threading.Thread(target=one)
    thread.start(), thread.join()
draw(env)
"""
    first, *others = python(DRAWN + threads).stdout.splitlines()
    assert first.startswith("no picture: another thread has drawn this environment; draw in one")
    assert others == ["(480, 640, 3)"] * 2


def test_videos_can_be_recorded(tmp_path: Path) -> None:
    pytest.importorskip("moviepy")
    env = make(render_mode="rgb_array")
    with closing(gymnasium.wrappers.RecordVideo(env, str(tmp_path / "videos"))) as recorded:
        recorded.reset()
        for action in actions(5):
            recorded.step(action)
    (video,) = (tmp_path / "videos").glob("*.mp4")
    assert video.stat().st_size > 1000


def test_nothing_is_printed_without_closing() -> None:
    code = (
        "import gymnasium\n"
        "env = gymnasium.make('mpma_mj:TwoArmImitation-v0', render_mode='rgb_array')\n"
        "env.reset(); env.render()"
    )
    result = python(code)
    assert (result.returncode, result.stderr) == (0, "")


def test_rendering_without_a_mode_warns() -> None:
    env = ImitationEnv(motion=MOTION)
    env.reset()
    with pytest.warns(UserWarning, match="without a render_mode"):
        assert env.render() is None
