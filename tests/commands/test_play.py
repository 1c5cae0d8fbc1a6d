"""`mpma play`: in a stand-in for the window, without a display, and in a real window."""

import dataclasses
import errno
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
import pytest

from mpma_mj.cli import main
from mpma_mj.envs import viewer
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.envs.physics import PhysicsArms
from mpma_mj.kinematics import posture_from_angles
from mpma_mj.motions import Motion, ymca
from mpma_mj.motions.motion import save_motion
from mpma_mj.training.run_folder import RunFolder
from mpma_mj.visualization.episode import EpisodeArms
from mpma_mj.visualization.playback import KEYS, LEFT, RIGHT, SPACE, play
from mpma_mj.visualization.scene import Scene
from tests.conftest import Refused
from tests.envs.test_gl import environment
from tests.envs.window import Window

NONE = 0  # no key


class Audience:
    """Sees what a stand-in for the window shows, presses a key each time, and then closes it."""

    def __init__(self, keys: list[int]) -> None:
        self.keys = keys
        self.times: list[float] = []
        self.steps: list[str] = []
        self.labels: list[str] = []
        self.angles: list[Any] = []

    def open(self, *arguments: Any, **options: Any) -> Window:
        self.window = Window(*arguments, **options)
        self.window.sync = self.see
        return self.window

    def see(self) -> None:
        above, below = (text[2:] for text in self.window.texts)
        assert above[0] == "time\nstep\nlabel"
        assert below == ("\n".join(KEYS), "\n".join(KEYS.values()))
        assert self.window.user_scn.ngeom == 8  # of one ghost
        time, step, label = above[1].split("\n")
        self.times.append(float(time.removesuffix(" s")))
        self.steps.append(step)
        self.labels.append(label)
        self.angles.append(self.window.data.qpos.copy())
        self.window.press(self.keys[len(self.steps) - 1])
        self.window.open = len(self.steps) < len(self.keys)


@pytest.fixture
def seat(monkeypatch: pytest.MonkeyPatch) -> Callable[[list[int]], Audience]:
    """Return a function that lets an audience that presses these keys see what is shown next."""

    def sit_down(keys: list[int]) -> Audience:
        audience = Audience(keys)
        monkeypatch.setattr(viewer, "_missing_display", lambda: None)
        monkeypatch.setattr("mujoco.viewer.launch_passive", audience.open)
        return audience

    return sit_down


Seat = Callable[[list[int]], Audience]


def test_a_run_is_shown_as_it_was_danced(
    seat: Seat, small_run: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    audience = seat([NONE] * 4 + [LEFT] * 5)
    assert main(["play", str(small_run)]) == 0
    trace = RunFolder(small_run).read_trace()
    last = len(trace.joint_angles) - 1
    np.testing.assert_array_equal(audience.angles[:5], trace.joint_angles[:5])
    np.testing.assert_array_equal(audience.angles[-1], trace.joint_angles[0])
    np.testing.assert_allclose(audience.times[:5], np.arange(5) / 20)
    assert audience.steps[4:6] == [f"4 / {last}", f"3 / {last}, paused"]
    assert audience.labels[0] == "Y"
    (line,) = capsys.readouterr().out.splitlines()
    assert all(key in line and does in line for key, does in KEYS.items())


def test_a_run_is_shown_without_the_noise_of_observation(small_run: Path) -> None:
    folder = RunFolder(small_run)
    trace = folder.read_trace()
    noise = np.random.default_rng(0).normal(0.0, 0.05, trace.joint_angles.shape)
    noisy = dataclasses.replace(trace, joint_angles=trace.joint_angles + noise)
    arms, shown = EpisodeArms(noisy), []
    for step in range(len(trace.posture)):
        arms.pose(step)
        shown.append(arms.physics.data.qpos.copy())
    np.testing.assert_allclose(posture_from_angles(np.array(shown)), trace.posture, atol=1e-9)


def test_the_arms_of_a_run_are_shown(seat: Seat, small_run: Path) -> None:
    folder, audience = RunFolder(small_run), seat([NONE])
    options = EnvironmentOptions(payload=2.0)
    trace, motion = folder.read_trace(), folder.read_motion()
    play(Scene(trace, motion, options), instead="", on_open=lambda: None)
    assert audience.window.model.body("left_hand_payload").mass > 0


def test_a_recording_is_followed_ideally_over_and_over(seat: Seat) -> None:
    audience = seat([NONE] * 8)
    assert main(["play", "ymca", "--from", "1", "--to", "1.3"]) == 0
    expected = ymca()
    np.testing.assert_allclose(
        audience.angles[:6], expected.joint_angles[20:26], rtol=0, atol=1e-12
    )
    np.testing.assert_allclose(audience.times, [1, 1.05, 1.1, 1.15, 1.2, 1.25, 1, 1.05])
    assert audience.steps[5:7] == ["5 / 5", "0 / 5"]


def test_a_part_of_a_run_is_shown_with_its_times(seat: Seat, small_run: Path) -> None:
    audience = seat([NONE] * 5)
    assert main(["play", str(small_run), "--from", "1.02", "--to", "1.2"]) == 0
    trace = RunFolder(small_run).read_trace()
    np.testing.assert_array_equal(audience.angles[:4], trace.joint_angles[21:25])
    np.testing.assert_allclose(audience.times, [1.05, 1.1, 1.15, 1.2, 1.05])


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--from", "99"], "--from is 99.0; expected less, as the episode lasts 11.35 s"),
        (["--from", "2", "--to", "2"], "--to is 2.0; expected more than 2 s"),
        (["--from", "2.01", "--to", "2.02"], "no step from 2.01 to 2.02 s; give a longer time"),
        (["--from", "-1"], "--from is -1.0; expected"),
        (["--to", "nan"], "--to is nan; expected"),
        (["--camera", "orbit"], "--camera orbit is for a video file; give --out dance.mp4, or"),
        (["--camera", "frnt"], "front, side, three_quarter; did you mean front?"),
        (["--fps", "30"], "--fps is for a video file; give --out dance.mp4"),
    ],
)
def test_what_cannot_be_shown_in_the_window_is_one_line(
    words: list[str], message: str, seat: Seat, small_run: Path, refused: Refused
) -> None:
    seat([NONE])
    refused(["play", str(small_run), *words], message)


def test_the_window_may_look_from_another_camera_and_without_captions(
    seat: Seat, monkeypatch: pytest.MonkeyPatch
) -> None:
    audience = seat([NONE])
    monkeypatch.setattr(audience, "see", lambda: setattr(audience.window, "open", False))
    assert main(["play", "ymca", "--camera", "side", "--no-captions"]) == 0
    assert audience.window.texts == []
    assert audience.window.cam.azimuth == pytest.approx(-90.0, abs=0.1)


def test_keys_pause_step_and_go_on(seat: Seat) -> None:
    audience = seat([NONE, SPACE, NONE, RIGHT, RIGHT, LEFT, SPACE, RIGHT, NONE, SPACE, NONE])
    assert main(["play", "ymca", "--to", "0.3"]) == 0
    shown = [step.replace(" / 5", "").replace(", paused", "p") for step in audience.steps]
    assert shown == ["0", "1", "1p", "1p", "2p", "3p", "2p", "3", "4p", "4p", "5"]


def test_a_label_of_other_letters_and_no_label_are_shown(seat: Seat, tmp_path: Path) -> None:
    motion, context = ymca(), np.zeros((len(ymca()), 1))
    context[0] = 1.0
    labelled = Motion(motion.posture, context, ("Fuß",), motion.rate, "dance", "test")
    save_motion(tmp_path / "dance.npz", labelled)
    audience = seat([NONE] * 2)
    assert main(["play", str(tmp_path / "dance.npz")]) == 0
    assert audience.labels == ["Fu?", ""]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["macarena"], "no run or motion 'macarena'; expected the folder of a run, ymca, wave"),
        (["runs/gone"], "no run or motion 'runs/gone'; expected the folder of a run"),
        (["folder"], "(no readable config.json); expected a folder that mpma imitate wrote"),
        (["text.csv"], "text.csv: "),
        (["ymca", "--tempo", "0"], "tempo is 0"),
    ],
)
def test_what_is_neither_run_nor_recording_is_one_line(
    words: list[str],
    message: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("folder").mkdir()
    Path("text.csv").write_text("not a recording\n")
    assert main(["play", *words]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert len(printed.err.splitlines()) == 1
    assert message in printed.err


@pytest.mark.parametrize("words", [["--tempo", "1"], ["--max-gap", "0.5"], ["--no-strict"]])
def test_how_to_read_is_refused_for_a_run_even_as_the_default(
    words: list[str], small_run: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["play", str(small_run), *words]) == 2
    option = words[0].replace("no-", "")
    message = f"{small_run} is a run; leave {option} out: it is for a recording"
    assert message in capsys.readouterr().err


def test_a_robot_is_refused_for_a_run_and_an_unknown_one_for_a_motion(
    small_run: Path, refused: Refused
) -> None:
    words = ["--robot", "two_arm"]
    message = f"{small_run} is a run; leave --robot out: it has its own"
    refused(["play", str(small_run), *words], message)
    for command in ("play", "motion"):
        refused([command, "ymca", "--robot", "cmu_humanoit"], "--robot is 'cmu_humanoit'")
        refused([command, "ymca", "--robot", "gone.toml"], "gone.toml: no such file")


def test_a_run_without_a_trace_is_one_line(
    small_run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.copy(small_run / "config.json", tmp_path)
    assert main(["play", str(tmp_path)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.endswith("trace.npz: missing; restore it, or train again with --overwrite")


def test_the_window_looks_from_the_front(seat: Seat) -> None:
    audience = seat([NONE])
    assert main(["play", "ymca"]) == 0
    model, camera = PhysicsArms.make().model, audience.window.cam
    azimuth, elevation = np.radians([camera.azimuth, camera.elevation])
    level = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    ahead = np.cos(elevation) * level + np.sin(elevation) * np.array([0.0, 0.0, 1.0])
    place = camera.lookat - camera.distance * ahead
    np.testing.assert_allclose(place, model.cam_pos[model.name2id("front", "camera")], atol=0.01)


def test_ctrl_c_closes_the_window(seat: Seat, capsys: pytest.CaptureFixture[str]) -> None:
    def interrupted() -> NoReturn:
        raise KeyboardInterrupt

    audience = seat([NONE])
    audience.see = interrupted
    assert main(["play", "ymca"]) == 130
    assert capsys.readouterr().err == "mpma: interrupted\n"
    assert not audience.window.open


def test_without_mjpython_the_error_names_it(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def refuse(*_: object, **__: object) -> NoReturn:
        raise RuntimeError("as on macOS")

    monkeypatch.setattr(viewer, "_missing_display", lambda: None)
    monkeypatch.setattr("mujoco.viewer.launch_passive", refuse)
    assert main(["play", "ymca"]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert "mjpython -m mpma_mj" in line
    assert line.endswith("write a file: mpma play ymca --out dance.mp4")


def play_outside(*words: object, **variables: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "mpma_mj", "play", *map(str, words)],
        env=environment(**variables),
        capture_output=True,
        text=True,
        check=False,
    )


NOT_HERE = "there is no display here"


@pytest.mark.parametrize("display", [{}, {"DISPLAY": ":98765"}])
def test_without_a_display_it_says_what_to_do_instead(display: dict[str, str]) -> None:
    result = play_outside("ymca", **display)
    expected = f"mpma: no window: {NOT_HERE}; write a file: mpma play ymca --out dance.mp4\n"
    assert (result.returncode, result.stdout, result.stderr) == (1, "", expected)


def test_what_to_do_instead_can_be_typed(
    small_run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, refused: Refused
) -> None:
    monkeypatch.setattr(viewer, "_missing_display", lambda: NOT_HERE)
    spaced = tmp_path / "a dance.npz"
    save_motion(spaced, ymca())
    for source, typed in {small_run: f"{small_run}", spaced: f"'{spaced}'"}.items():
        instead = f"no window: {NOT_HERE}; write a file: mpma play {typed} --out dance.mp4"
        refused(["play", str(source)], instead, code=1)


@pytest.fixture(scope="module")
def display() -> Iterator[str]:
    """Return the name of a display that nobody sees; skip where there is no Xvfb."""
    if shutil.which("Xvfb") is None:
        pytest.skip("no window was opened: Xvfb is not installed")
    read, write = os.pipe()
    command = ["Xvfb", "-displayfd", str(write), "-screen", "0", "320x240x24"]
    with subprocess.Popen(command, pass_fds=[write], stderr=subprocess.DEVNULL) as server:
        os.close(write)
        with os.fdopen(read) as told:
            number = told.readline().strip()
        try:
            if not number:
                pytest.skip("no window was opened: Xvfb does not start")
            yield f":{number}"
        finally:
            server.terminate()


IN_A_REAL_WINDOW = """
import signal, sys
from mpma_mj.cli import main
from mpma_mj.envs.viewer import ArmViewer
signal.signal(signal.SIGINT, signal.default_int_handler)
show, shown = ArmViewer.show, []
def show_and_end(viewer, *arguments, **options):
    show(viewer, *arguments, **options)
    shown.append(True)
    if len(shown) == 5:
        {end}
ArmViewer.show = show_and_end
sys.exit(main(["play", "ymca"]))
"""


@pytest.mark.parametrize(
    ("end", "code", "error"),
    [
        ("viewer._window.close()", 0, ""),
        ("signal.raise_signal(signal.SIGINT)", 130, "mpma: interrupted\n"),
    ],
)
def test_a_real_window_opens_and_ends(display: str, end: str, code: int, error: str) -> None:
    result = subprocess.run(
        [sys.executable, "-c", IN_A_REAL_WINDOW.format(end=end)],
        env=environment(DISPLAY=display),
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    if "OpenGL does not draw" in result.stderr:
        pytest.skip(f"no window was opened: {result.stderr.strip()}")
    assert (result.returncode, result.stderr) == (code, error)
    assert result.stdout.startswith("space: pause")


@pytest.mark.parametrize("name", ["a.csv", "a.bvh", "a.trc", "a.npz"])
def test_a_full_disk_keeps_the_old_file(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, refused: Refused
) -> None:
    def full(_: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    out = tmp_path / name
    out.write_text("old")
    monkeypatch.setattr(os, "fsync", full)
    message = f"{out}: cannot be written (No space left on device)"
    refused(["play", "ymca", "--out", str(out), "--overwrite"], message)
    assert out.read_text() == "old"
    assert list(tmp_path.iterdir()) == [out]
