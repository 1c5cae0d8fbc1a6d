import os
import subprocess
import sys

import pytest

from mpma_mj.envs import gl


def environment(**changes: str) -> dict[str, str]:
    """Return this process's environment as a headless user's who chose nothing."""
    chosen = ("MUJOCO_GL", "PYOPENGL_PLATFORM", "DISPLAY", "WAYLAND_DISPLAY")
    return {k: v for k, v in os.environ.items() if k not in chosen} | changes


def python(code: str, **changes: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", code],
        env=environment(**changes),
        capture_output=True,
        text=True,
        check=False,
    )


def test_importing_the_package_imports_neither_mujoco_nor_what_needs_it() -> None:
    code = "import mpma_mj, sys; print({'mujoco', 'dm_control', 'scipy'} & set(sys.modules))"
    result = python(code)
    assert result.stdout.strip() == "set()"


@pytest.mark.parametrize("choice", ["disable", "osmesa", "egl"])
def test_a_users_choice_that_can_work_is_respected(choice: str) -> None:
    if not gl._can_be_imported(choice):
        pytest.skip(f"no library for {choice}")
    result = python("import mpma_mj, os; print(os.environ['MUJOCO_GL'])", MUJOCO_GL=choice)
    assert result.stdout.strip() == choice


@pytest.mark.parametrize("choice", ["nonsense", "disable", "glx", "EGL"])
def test_everything_but_drawing_works_without_opengl(choice: str) -> None:
    code = "import mpma_mj; print(mpma_mj.load('ymca').reset().first())"
    result = python(code, MUJOCO_GL=choice)
    assert "True" in result.stdout, result.stderr


@pytest.mark.parametrize(
    ("platform", "display", "headless"),
    [("linux", "", True), ("linux", ":0", False), ("darwin", "", False), ("win32", "", False)],
)
def test_only_linux_without_a_display_is_headless(
    monkeypatch: pytest.MonkeyPatch, platform: str, display: str, headless: bool
) -> None:
    monkeypatch.setattr(sys, "platform", platform)
    monkeypatch.setenv("DISPLAY", display)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    assert gl._headless() is headless


def test_without_any_library_the_choice_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(gl, "_users_choice", None)
    monkeypatch.setattr(gl, "_LIBRARIES", {"egl": "libnot-there.so", "osmesa": "libnor-this.so"})
    monkeypatch.setattr(gl, "_headless", lambda: True)
    monkeypatch.delenv("MUJOCO_GL", raising=False)
    gl.choose_backend()
    assert os.environ["MUJOCO_GL"] == "disable"


def test_a_backend_that_does_not_draw_is_passed_over(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(gl, "_users_choice", None)
    monkeypatch.setattr(gl, "_headless", lambda: True)
    monkeypatch.setattr(gl, "_draws", lambda backend: backend == "osmesa")
    monkeypatch.setenv("MUJOCO_GL", "egl")
    assert gl.require_backend() == "osmesa"
    assert os.environ["MUJOCO_GL"] == "osmesa"


def test_with_none_that_draws_the_error_names_packages(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(gl, "_draws", lambda backend: False)
    with pytest.raises(gl.RenderingError, match=r"libegl1.*libosmesa6") as caught:
        gl.require_backend()
    assert "\n" not in str(caught.value)


def test_a_trial_without_opengl_does_not_draw() -> None:
    assert not gl._draws("disable")


LLVM = "print('LLVM', any('LLVM' in line for line in open('/proc/self/maps')))"


MAKE = """
import gymnasium, mpma_mj
envs = [
    mpma_mj.load("ymca"),
    mpma_mj.make_vec(2, "ymca"),
    gymnasium.make("mpma_mj:TwoArmImitation-v0", motion="ymca"),
]
for env in envs:
    env.reset()
"""


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads /proc")
@pytest.mark.parametrize("backend", ["egl", "osmesa"])
def test_environments_that_draw_nothing_load_no_llvm(backend: str) -> None:
    if not gl._loads(backend):
        pytest.skip(f"no library for {backend}")
    result = python(MAKE + LLVM, MUJOCO_GL=backend)
    assert result.stdout.strip() == "LLVM False", result.stderr


def test_a_machine_without_a_choice_loads_no_llvm() -> None:
    result = python(f"import mpma_mj; mpma_mj.load('ymca'); {LLVM}")
    assert result.stdout.strip() == "LLVM False", result.stderr


@pytest.mark.parametrize("backend", ["egl", "osmesa"])
def test_dm_control_and_mujoco_draw_pictures(backend: str) -> None:
    if not gl._draws(backend):
        pytest.skip(f"{backend} does not draw")
    code = (
        "import mpma_mj, mujoco\n"
        "from dm_control import suite\n"
        "from dm_control.suite.wrappers import pixels\n"
        "env = pixels.Wrapper(mpma_mj.load('ymca'), render_kwargs={'camera_id': 'front'})\n"
        "print(env.reset().observation['pixels'].std() > 1)\n"
        "print(env.physics.render(32, 32, depth=True).std() > 1)\n"
        "print(suite.load('cartpole', 'swingup').physics.render(32, 32).std() > 1)\n"
        "with mujoco.Renderer(env.physics.model.ptr, 32, 32) as renderer:\n"
        "    renderer.update_scene(env.physics.data.ptr)\n"
        "    print(renderer.render().std() > 1)\n"
    )
    result = python(code, MUJOCO_GL=backend)
    assert result.stdout.split() == ["True"] * 4, result.stderr
