"""`mpma play --out`: runs and motions as files."""

import dataclasses
import resource
import shutil
import subprocess
import sys
import wave
from pathlib import Path

import imageio.v2 as imageio
import imageio_ffmpeg
import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image, ImageSequence

from mpma_mj.arm_kinematics import TWO_ARMS
from mpma_mj.cli import main
from mpma_mj.envs import gl
from mpma_mj.envs.load import load
from mpma_mj.motions import loader, read_motion, ymca
from mpma_mj.motions.export import ANGLE_COLUMNS, COMMAND_COLUMNS
from mpma_mj.trace import OBSERVED, Trace
from mpma_mj.training.run_folder import RunFolder
from tests.conftest import DISK_FULL, FAILED, Encoder, Refused


@pytest.fixture
def short_run(small_run: Path, tmp_path: Path) -> Path:
    """Return a copy of a run, of whose epoch the first second is left."""
    copy = RunFolder(shutil.copytree(small_run, tmp_path / "run"))
    arrays = copy.read_trace().to_arrays()
    trace = Trace.from_arrays(
        {name: signal[: 21 if name in OBSERVED else 20] for name, signal in arrays.items()}
    )
    config = copy.read_config()
    copy.write_trace(trace, config, int(copy.read_best(config)[1]["epoch"]))
    return copy.path


def frames_of(path: Path) -> NDArray[np.uint8]:
    """Return the frames of a video or of an animated picture."""
    if path.suffix in (".mp4", ".webm"):
        with imageio.get_reader(path) as reader:
            return np.stack([np.asarray(frame) for frame in reader])
    with Image.open(path) as image:
        return np.stack([np.asarray(f.convert("RGB")) for f in ImageSequence.Iterator(image)])


@pytest.mark.usefixtures("opengl")
@pytest.mark.parametrize(
    ("ending", "codecs"), [(".mp4", ("h264", "aac")), (".webm", ("vp9", "opus"))]
)
def test_the_video_of_a_run_has_its_sound(
    ending: str, codecs: tuple[str, str], short_run: Path
) -> None:
    (short_run / "sound").mkdir()
    with wave.open(str(short_run / "sound" / "a.wav"), "wb") as file:
        file.setparams((1, 2, 8000, 0, "NONE", ""))
        file.writeframes(np.full(8000, 1000, "<i2").tobytes())
    out = short_run / f"dance{ending}"
    words = ["play", str(short_run), "--from", "0.2", "--fps", "30", "--out", str(out)]
    assert main([*words, "--overwrite"]) == 0
    words = [imageio_ffmpeg.get_ffmpeg_exe(), "-i", str(out)]
    about = subprocess.run(words, capture_output=True, text=True, check=False).stderr
    assert f"Video: {codecs[0]}" in about
    assert f"Audio: {codecs[1]}" in about
    assert "Duration: 00:00:00.8" in about


@pytest.mark.usefixtures("opengl")
def test_a_format_without_sound_warns_where_one_was_given(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        loader, "label_motion", lambda posture, *_: (np.ones((len(posture), 1)), "1")
    )
    out = tmp_path / "a.gif"
    words = ["--to", "0.3", "--audio", "a.wav", "--size", "160x240"]
    assert main(["play", "ymca", *words, "--out", str(out)]) == 0
    printed = capsys.readouterr()
    assert f"warning: {out} has no sound; write .mp4 or .webm for the sound" in printed.err
    assert out.exists()


@pytest.mark.usefixtures("opengl")
def test_pictures_between_steps_are_between_those_of_the_steps(short_run: Path) -> None:
    words = ["play", str(short_run), "--no-captions", "--size", "321x241"]
    usual, often = short_run / "a.webp", short_run / "b.webp"
    assert main([*words, "--to", "0.5", "--out", str(usual)]) == 0
    assert main([*words, "--to", "0.5", "--out", str(often), "--fps", "40"]) == 0
    pictures, twice = frames_of(usual).astype(float), frames_of(often).astype(float)
    assert (pictures.shape, twice.shape) == ((10, 241, 321, 3), (20, 241, 321, 3))
    assert np.abs(twice[::2] - pictures).mean() < 0.5
    moved = np.abs(pictures[6] - pictures[5]).mean()
    assert 0.2 * moved < np.abs(twice[11] - pictures[5]).mean() < moved


@pytest.mark.usefixtures("opengl")
def test_a_camera_goes_around_the_arms_once(short_run: Path, tmp_path: Path) -> None:
    out = tmp_path / "a.webp"
    words = ["--camera", "orbit", "--no-captions", "--size", "240x240"]
    assert main(["play", str(short_run), *words, "--out", str(out)]) == 0
    frames = frames_of(out).astype(float)
    assert len(frames) == 20
    red = [frames[i][..., 0] - frames[i][..., 2] > 60 for i in (0, 10, 19)]
    front, back, end = (float(np.nonzero(one)[1].mean()) for one in red)
    assert max(front, end) < 115 < 125 < back  # from the front, the right arm is on the left


@pytest.mark.usefixtures("opengl")
@pytest.mark.parametrize("ending", [".mp4", ".webm", ".gif", ".webp"])
def test_a_run_becomes_a_file_of_the_size_that_is_given(
    ending: str, short_run: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = short_run / f"new/dance{ending}"
    words = ["--out", str(out), "--size", "320x240", "--camera", "three_quarter"]
    assert main(["play", str(short_run), *words]) == 0
    assert capsys.readouterr().out.splitlines() == [str(out)]
    frames = frames_of(out)
    assert frames.shape == (20, 240, 320, 3)
    moved = np.abs(frames[0].astype(float) - frames[10])
    assert moved[:144].max() > 50
    assert moved[144:].max() > 50  # the mark of the current step


@pytest.mark.usefixtures("opengl")
def test_a_motion_becomes_a_file_read_as_its_options_say(tmp_path: Path) -> None:
    first, later = tmp_path / "first.gif", tmp_path / "later.gif"
    words = ["play", "ymca", "--size", "320x240"]
    assert main([*words, "--to", "0.5", "--out", str(first)]) == 0
    assert main([*words, "--from", "1", "--to", "1.5", "--out", str(later)]) == 0
    first_frames, later_frames = frames_of(first), frames_of(later)
    assert len(first_frames) == len(later_frames)
    assert (first_frames[0] != later_frames[0]).any()


def test_a_robot_gets_what_the_arms_of_a_run_did_and_what_was_commanded(short_run: Path) -> None:
    assert main(["play", str(short_run), "--out", str(short_run / "x.csv")]) == 0
    head, *rows = (short_run / "x.csv").read_text().splitlines()
    assert head.split(",") == ["time", *ANGLE_COLUMNS, *COMMAND_COLUMNS]
    table = np.array([row.split(",") for row in rows], float)
    trace = RunFolder(short_run).read_trace()
    np.testing.assert_allclose(table[:, 0], np.arange(20) / 20.0)
    np.testing.assert_allclose(table[:, 1:9], trace.true_joint_angles(TWO_ARMS)[:-1], atol=1e-8)
    speed = load("ymca", control_timestep=0.05).task.max_joint_speed
    np.testing.assert_allclose(table[:, 9:], trace.action * speed, atol=1e-8)


def test_a_robot_gets_no_turns_that_can_be_left_out_unless_a_joint_has_a_range(
    short_run: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    trace = RunFolder(short_run).read_trace()
    turned = trace.joint_angles + 6 * np.pi
    wound = dataclasses.replace(trace, joint_angles=turned)
    monkeypatch.setattr(RunFolder, "read_trace", lambda _: wound)
    assert main(["play", str(short_run), "--out", str(short_run / "x.csv")]) == 0
    table = np.genfromtxt(short_run / "x.csv", delimiter=",", skip_header=1)[:, 1:9]
    expected = trace.joint_angles[:-1].copy()
    expected[:, 3::4] += 6 * np.pi  # the elbows have a range
    np.testing.assert_allclose(table, expected, atol=1e-8)


@pytest.mark.parametrize("ending", [".bvh", ".trc", ".npz"])
def test_animators_get_what_the_arms_of_a_run_did(ending: str, short_run: Path) -> None:
    out = short_run / f"x{ending}"
    assert main(["play", str(short_run), "--out", str(out)]) == 0
    options = {} if ending == ".npz" else {"cutoff": 9.0}
    done, demonstrated = read_motion(out, **options), ymca().posture[:20]
    trace = RunFolder(short_run).read_trace()
    assert done.posture.shape == (20, 12)
    assert np.abs(done.posture - trace.posture[:20]).max() < 0.01
    assert np.abs(done.posture - demonstrated).max() > 1e-4


def test_a_motion_that_is_played_to_a_file_is_the_motion(tmp_path: Path) -> None:
    words = ["--from", "1", "--out"]
    assert main(["play", "ymca", *words, str(tmp_path / "a.bvh")]) == 0
    assert (
        main(
            [
                "motion",
                "ymca",
                *words,
                str(tmp_path / "b.bvh"),
                "--picture",
                str(tmp_path / "a.png"),
            ]
        )
        == 0
    )
    assert (tmp_path / "a.bvh").read_text() == (tmp_path / "b.bvh").read_text()


@pytest.mark.usefixtures("opengl")
def test_pictures_may_be_larger_than_the_models_buffer(tmp_path: Path) -> None:
    out = tmp_path / "wide.webp"
    words = ["--to", "0.2", "--out", str(out), "--size", "2000x240"]
    assert main(["play", "ymca", *words]) == 0
    assert frames_of(out).shape[1:] == (240, 2000, 3)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (
            ["--out", "dance.avi"],
            "--out is 'dance.avi'; expected a file name that ends in .mp4 or .webm or .gif or .webp"
            " or .html or .bvh or .csv or .npz or .trc",
        ),
        (["--out", "a.csv", "--size", "640x480"], "--size is for a video file; give --out"),
        (["--out", "old.mp4"], "old.mp4: already exists; --overwrite replaces it"),
        (["--size", "640x480"], "--size is for a video file; give --out dance.mp4"),
        (["--out", "a.csv", "--camera", "side"], "--camera is for a video file; give --out"),
        (["--out", "a.npz", "--no-captions"], "--captions is for a video file; give --out"),
        (["--fps", "30"], "--fps is for a video file; give --out dance.mp4"),
        (["--out", "a.html", "--size", "640x480"], "--size is for a video file; give --out"),
        (["--out", "a.html", "--camera", "orbit"], "--camera orbit is for a video file; give"),
        (["--out", "dance.mpg4"], "did you mean .mp4?"),
        *(
            (["--out", "a.mp4", "--fps", fps], f"--fps is {float(fps)}; expected 0.1 to 1000, Hz")
            for fps in ("0", "-5", "nan", "1e9", "inf")
        ),
        (["--out", "a.gif", "--fps", "60"], "--fps is 60.0; expected at most 50 Hz for a .gif"),
        (["--out", "a.mp4", "--from", "3", "--to", "1"], "--to is 1.0; expected more than 3 s"),
        (["--out", "a.mp4", "--from", "99"], "--from is 99.0; expected less, as ymca lasts"),
        (["--size", "640x481", "--out", "a.webm"], "--size is '640x481'; expected two even"),
        (["--size", "641x9999", "--out", "a.gif"], "--size is '641x9999'; expected two whole"),
        (
            ["--size", "12x12", "--out", "a.mp4"],
            "--size is '12x12'; expected two even numbers",
        ),
        (["--size", "641x480", "--out", "a.mp4"], "--size is '641x480'; expected"),
        (["--size", "9999x480", "--out", "a.mp4"], "--size is '9999x480'; expected"),
        (["--size", "big", "--out", "a.mp4"], "--size is 'big'; expected two even"),
    ],
)
def test_a_file_that_cannot_be_written_so_is_refused_at_once(
    words: list[str],
    message: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    refused: Refused,
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("old.mp4").write_text("old")
    refused(["play", "ymca", *words], message)
    assert names(tmp_path) == {"old.mp4"}


@pytest.mark.usefixtures("opengl")
def test_an_unknown_camera_is_one_line(tmp_path: Path, refused: Refused) -> None:
    words = ["play", "ymca", "--camera", "top", "--out", str(tmp_path / "a.mp4")]
    refused(words, "--camera is 'top'; expected one of the model's cameras: front, side")


def test_a_file_without_opengl_fails_in_one_line(
    small_run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, refused: Refused
) -> None:
    monkeypatch.setattr(gl, "_draws", lambda backend: False)
    refused(["play", str(small_run), "--out", str(tmp_path / "a.mp4")], "libosmesa6", code=1)


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


@pytest.fixture
def old_video(short_run: Path) -> Path:
    """Return the path of a video in the folder of a short run."""
    path = short_run / "dance.mp4"
    path.write_text("old")
    return path


@pytest.mark.usefixtures("opengl")
def test_the_old_video_stays_if_the_disk_is_full(
    old_video: Path, encoder: Encoder, refused: Refused
) -> None:
    run, there = old_video.parent, names(old_video.parent)
    encoder(DISK_FULL)
    words = ["play", str(run), "--out", str(old_video), "--overwrite"]
    refused(words, f"{old_video}: {FAILED}", code=1, title="drawing 20 frames")
    assert old_video.read_text() == "old"
    assert names(run) == there


@pytest.mark.usefixtures("opengl")
def test_the_old_video_stays_if_its_encoder_is_stopped(old_video: Path) -> None:
    """By the limit of a file's size, as by a quota; Python itself gets an error there instead."""
    run, there = old_video.parent, names(old_video.parent)
    words = ["play", str(run), "--out", str(old_video), "--overwrite"]
    result = subprocess.run(
        [sys.executable, "-m", "mpma_mj.cli", *words],
        capture_output=True,
        text=True,
        check=False,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (10_000, 10_000)),
    )
    assert result.returncode == 1
    title, line = result.stderr.splitlines()
    assert title == "drawing 20 frames"
    assert line.startswith(
        f"mpma: {old_video}: the video was not written: ffmpeg was stopped: File size"
    )
    assert old_video.read_text() == "old"
    assert names(run) == there


@pytest.mark.usefixtures("opengl")
def test_without_an_encoder_it_says_so(
    short_run: Path, monkeypatch: pytest.MonkeyPatch, refused: Refused
) -> None:
    monkeypatch.setenv("IMAGEIO_FFMPEG_EXE", "/nowhere")
    said = "/nowhere cannot be started (No such file or directory); set IMAGEIO_FFMPEG_EXE"
    words = ["play", str(short_run), "--out", str(short_run / "new.mp4")]
    refused(words, said, code=1, title="drawing 20 frames")
