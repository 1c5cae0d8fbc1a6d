"""Pictures of the arms."""

import pickle
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
from tests.envs.test_gl import python

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


FACES = {
    "gymnasium": (
        'gymnasium.make("mpma_mj:TwoArmImitation-v0", render_mode="rgb_array", **OPTIONS)',
        "env.render().shape",
    ),
    "vector": (
        'mpma_mj.make_vec(2, render_mode="rgb_array", **OPTIONS)',
        "env.render()[1].shape",
    ),
    "dm_control": ("mpma_mj.load(**OPTIONS)", "env.physics.render(480, 640).shape"),
}

DRAWN = """
import gc, gymnasium, mpma_mj, os, signal, sys, threading
from mpma_mj.errors import RenderingError
OPTIONS = {{"arms": "kinematic", "repeats": 1}}
def make():
    env = {make}
    env.reset()
    return env
def draw(env):
    try: print({draw}, flush=True)
    except RenderingError as error: print(error, flush=True)
"""


@pytest.fixture(params=FACES.values(), ids=FACES)
def drawn(request: pytest.FixtureRequest) -> str:
    """Start of a script that draws with each interface: `make` an environment, `draw` it."""
    make, draw = request.param
    return DRAWN.format(make=make, draw=draw)


def run(code: str) -> list[str]:
    """Run a script that prints no traceback; return its lines."""
    result = python(code)
    assert (result.returncode, result.stderr) == (0, "")
    return result.stdout.splitlines()


def test_a_forked_process_that_draws_is_refused(drawn: str) -> None:
    forks = """
env = make()
draw(env)
if not (child := os.fork()):
    signal.alarm(60)  # it would hang
    draw(env), draw(make()), env.close()
    sys.exit()
os.waitpid(child, 0), draw(env)
"""
    first, *lines = run(drawn + forks)
    assert len(lines) == 3
    for line in lines[:2]:
        assert line.startswith(
            "no picture: this process was forked from one that has drawn; use sp"
        )
    assert first == lines[2] == "(480, 640, 3)"


@pytest.mark.parametrize("before", ["", "env.close()"])
def test_a_forked_process_may_drop_what_its_parent_drew_with(drawn: str, before: str) -> None:
    forks = """
if not (child := os.fork()):
    signal.alarm(60)  # it would hang
    del env
    gc.collect()
    sys.exit()
print(os.waitpid(child, 0)[1])
"""
    code = f"{drawn}\nenv = make()\ndraw(env)\n{before}\n{forks}"
    assert run(code) == ["(480, 640, 3)", "0"]


def test_another_thread_that_draws_needs_its_own_environment(drawn: str) -> None:
    threads = """
def in_thread(function):
    thread = threading.Thread(target=function)
    thread.start(), thread.join()
env, other = make(), make()
draw(env)
in_thread(lambda: draw(env)), in_thread(lambda: draw(other))
draw(env), draw(other)
env.close(), other.close()
"""
    picture, refused = "(480, 640, 3)", "no picture: another thread has drawn this environment"
    lines = [line.partition(";")[0] for line in run(drawn + threads)]
    assert lines == [picture, refused, picture, picture, refused]


def test_without_opengl_every_interface_says_what_to_install(drawn: str) -> None:
    code = f"import os\nos.environ['MUJOCO_GL'] = 'disable'\n{drawn}\ndraw(make())"
    (line,) = run(code)
    assert line.startswith("OpenGL cannot draw on this machine; install libegl1")


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
