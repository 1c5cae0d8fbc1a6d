"""The command line as a user types it."""

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from mpma_mj import __version__
from mpma_mj.cli import main
from mpma_mj.commands import COMMANDS
from mpma_mj.commands.imitate import Imitate
from mpma_mj.envs import gl
from mpma_mj.errors import RenderingError
from mpma_mj.kinematics import posture_from_angles
from mpma_mj.training.trainer import Trainer
from tests.conftest import dancer, markers_of

WriteTsv = Callable[..., Path]


def mpma(*words: object, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run the command in a process of its own."""
    return subprocess.run(
        [sys.executable, "-m", "mpma_mj.cli", *map(str, words)],
        capture_output=True,
        text=True,
        env=os.environ | environment,
        check=False,
    )


def test_a_run_prints_its_folder_last_and_shows_its_epochs(tmp_path: Path) -> None:
    out = tmp_path / "run"
    result = mpma("imitate", "ymca", "--nodes", 30, "--no-video", "--out", out)
    assert result.returncode == 0, result.stderr
    assert result.stdout.splitlines()[-1] == str(out)
    assert "converged after" in result.stdout
    first = result.stderr.splitlines()[0]
    assert all(word in first for word in ("epoch", "p_e", "feedback ratio", "K 1.00", "L 0.01"))
    assert {p.name for p in (out / "figures").iterdir()} == {
        "responsibility.png",
        "module_output.png",
        "trajectory.png",
    }
    assert not (out / "dance.mp4").exists()


def test_without_out_a_run_goes_below_runs_by_motion_and_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    words = ["imitate", "ymca", "--nodes", "10", "--epochs", "1", "--no-video"]
    assert main(words) == 0
    folder = Path(capsys.readouterr().out.splitlines()[-1])
    assert folder.parent == Path("runs")
    assert folder.name.startswith("ymca-20")
    assert (folder / "summary.json").exists()


def test_training_without_opengl_works_and_says_how_to_get_video(tmp_path: Path) -> None:
    out = tmp_path / "run"
    words = ("imitate", "ymca", "--nodes", 20, "--epochs", 1, "--out", out)
    result = mpma(*words, MUJOCO_GL="disable")
    assert result.returncode == 0
    assert "Traceback" not in result.stderr
    assert "libosmesa6" in result.stderr.splitlines()[-1]
    assert (out / "summary.json").exists()
    assert not (out / "dance.mp4").exists()


def test_render_without_opengl_fails_in_one_line(small_run: Path) -> None:
    result = mpma("render", small_run, MUJOCO_GL="disable")
    assert result.returncode == 1
    assert len(result.stderr.splitlines()) == 1
    assert "libosmesa6" in result.stderr


def test_render_makes_the_video_of_a_run(
    small_run: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    try:
        gl.require_backend()
    except RenderingError as error:
        pytest.skip(str(error))
    assert main(["render", str(small_run), "--camera", "three_quarter"]) == 0
    video = Path(capsys.readouterr().out.splitlines()[-1])
    assert video == small_run / "dance.mp4"
    assert video.stat().st_size > 10_000


def test_a_recording_becomes_a_dance(write_tsv: WriteTsv, tmp_path: Path) -> None:
    out = tmp_path / "run"
    words = ["imitate", str(write_tsv()), "--nodes", "30", "--segments", "3", "--no-video"]
    assert main([*words, "--out", str(out)]) == 0
    summary = json.loads((out / "summary.json").read_text())
    assert list(summary["active_modules"]) == ["1", "2", "3"]
    assert summary["p_e_percent"] < 3


def test_resume_goes_on_in_the_runs_folder(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "run"
    common = ["--nodes", "20", "--modules", "2", "--no-video"]
    assert main(["imitate", "ymca", *common, "--epochs", "1", "--out", str(out)]) == 0
    assert main(["imitate", "--resume", str(out), "--epochs", "1", "--no-video"]) == 0
    assert main(["imitate", "ymca", *common, "--epochs", "1", "--resume", str(out)]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == str(out)
    assert len((out / "metrics.csv").read_text().splitlines()) == 1 + 3


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["macarena"], "no motion 'macarena'"),
        (["gone.tsv"], "gone.tsv: no such file"),
        ([], "no motion given"),
        (["/dev/zero"], "/dev/zero: is not a file"),
        (["ymca", "--modules", "0"], "modules is 0"),
        (["ymca", "--nodes", "-3"], "nodes is -3"),
        (["ymca", "--epochs", "0"], "epochs is 0"),
        (["ymca", "--seed", "-1"], "seed is -1"),
        (["ymca", "--tempo", "0"], "tempo is 0"),
        (["ymca", "--tempo", "nan"], "tempo is nan"),
        (["ymca", "--tempo", "1e-9"], "tempo is 1e-09; expected 0.01 to 100"),
        (["ymca", "--tempo", "5"], "slow the movement with --tempo"),
        (["ymca", "--segments", "0"], "segments is 0"),
        (["ymca", "--max-gap", "-1"], "max-gap is -1"),
        (["ymca", "--repeats", "0"], "repeats is 0"),
        (["ymca", "--reference-noise", "-0.1"], "--reference-noise is -0.1"),
        (["ymca", "--resume", "nowhere"], "nowhere: no run there"),
        (["ymca", "--out", "x" * 300], "File name too long; check path and rights"),
    ],
)
def test_bad_input_is_one_line_exit_2_and_no_folder(
    words: list[str],
    message: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["imitate", *words, "--no-video"]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert len(printed.err.splitlines()) == 1
    assert message in printed.err
    assert list(tmp_path.iterdir()) == []


def test_a_bad_recording_leaves_no_folder(
    write_tsv: WriteTsv, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = write_tsv(edit=lambda text: text.replace("Elbow_R", "Elbow"))
    out = tmp_path / "run"
    assert main(["imitate", str(path), "--no-video", "--out", str(out)]) == 2
    assert "the right elbow" in capsys.readouterr().err
    assert not out.exists()


def test_a_recording_faster_than_the_arms_says_joint_frame_speed_and_tempo(
    write_tsv: WriteTsv, capsys: pytest.CaptureFixture[str]
) -> None:
    angles = np.tile([0.5, 0.1, 0.2, 1.2] * 2, (60, 1))
    angles[:, 3] += 1.1 * np.sin(np.arange(60) / 60 * 2 * np.pi * 4)  # 28 rad/s, filtered less
    path = write_tsv(markers_of(dancer(posture_from_angles(angles))))
    assert main(["imitate", str(path), "--no-video"]) == 2
    error = capsys.readouterr().err
    assert "left_elbow would have to turn at" in error
    assert "at frame" in error
    assert "its actuator reaches 15; slow the movement with --tempo 0." in error


def test_a_folder_that_cannot_be_written_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").write_text("")
    words = ["imitate", "ymca", "--no-video", "--out", str(tmp_path / "file" / "run")]
    assert main(words) == 2
    assert "cannot be written" in capsys.readouterr().err


def test_a_run_that_exists_is_not_replaced(
    small_run: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = (small_run / "metrics.csv").read_bytes()
    assert main(["imitate", "ymca", "--no-video", "--out", str(small_run)]) == 2
    assert "--overwrite replaces it, --resume continues it" in capsys.readouterr().err
    assert (small_run / "metrics.csv").read_bytes() == before


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["ymca", "--nodes", "77"], "nodes is 77, but the run to resume has 30"),
        (["ymca", "--nodes=200"], "nodes is 200, but the run to resume has 30"),
        (["dance.tsv"], "motions is dance.tsv, but the run to resume has ymca"),
        (["--overwrite"], "leave --overwrite out"),
        (["--out", "elsewhere"], "leave --out out"),
    ],
)
def test_a_resumed_run_keeps_its_settings(
    small_run: Path, words: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["imitate", *words, "--no-video", "--resume", str(small_run)]) == 2
    assert message in capsys.readouterr().err


def test_a_corrupt_checkpoint_is_refused(
    small_run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    copy = tmp_path / "copy"
    subprocess.run(["cp", "-r", str(small_run), str(copy)], check=True)
    (copy / "checkpoint" / "latest.npz").write_bytes(b"rubbish")
    assert main(["imitate", "--no-video", "--resume", str(copy)]) == 2
    assert "latest.npz: damaged" in capsys.readouterr().err


@pytest.mark.parametrize(
    "words", [["imitate", "ymca", "--arms", "rubber"], ["imitate", "--bogus"], ["dance"], []]
)
def test_words_that_are_no_command_exit_2_without_a_traceback(words: list[str]) -> None:
    result = mpma(*words)
    assert result.returncode == 2
    assert "Traceback" not in result.stderr


@pytest.mark.parametrize(
    ("error", "code", "message"),
    [(MemoryError, 1, "mpma: not enough memory"), (KeyboardInterrupt, 130, "mpma: interrupted")],
)
def test_what_stops_a_run_from_outside_is_one_line(
    error: type[BaseException],
    code: int,
    message: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    def stopped(self: Imitate) -> Path:
        raise error

    monkeypatch.setattr(Imitate, "run", stopped)
    assert main(["imitate", "ymca"]) == code
    printed = capsys.readouterr().err
    assert printed.startswith(message)
    assert len(printed.splitlines()) == 1


@pytest.mark.parametrize("epochs_done", [0, 2])
def test_an_interrupted_run_says_how_to_go_on_if_there_is_something_to_go_on_with(
    epochs_done: int,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    whole = Trainer.run_epoch

    def run_epoch(trainer: Trainer, **options: bool) -> object:
        if trainer.epoch == epochs_done:
            raise KeyboardInterrupt
        return whole(trainer, **options)

    monkeypatch.setattr(Trainer, "run_epoch", run_epoch)
    out = tmp_path / "run"
    words = ["imitate", "ymca", "--nodes", "10", "--no-video", "--out", str(out)]
    assert main(words) == 130
    *_, hint, last = ["", *capsys.readouterr().err.splitlines()]
    assert last == "mpma: interrupted"
    assert (hint == f"mpma: to resume: mpma imitate --resume {out}") == (epochs_done > 0)
    if epochs_done:
        monkeypatch.setattr(Trainer, "run_epoch", whole)
        assert main(["imitate", "--resume", str(out), "--no-video", "--epochs", "1"]) == 0


@pytest.mark.parametrize("words", [["analyse", "RUN"], ["imitate", "--help"], ["--version"]])
def test_output_that_nobody_reads_any_more_ends_the_command_quietly(
    words: list[str], small_run: Path, tmp_path: Path
) -> None:
    run = shutil.copytree(small_run, tmp_path / "run")
    words = [str(run) if word == "RUN" else word for word in words]
    reader, writer = os.pipe()
    os.close(reader)
    try:
        result = subprocess.run(
            [sys.executable, "-m", "mpma_mj.cli", *words],
            stdout=writer,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )
    finally:
        os.close(writer)
    assert result.returncode == 141
    assert result.stderr in ("", "looking for synergies\n")


def test_version(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--version"]) == 0
    assert capsys.readouterr().out.strip() == f"mpma {__version__}"


def test_help_imports_neither_mujoco_nor_scipy() -> None:
    code = (
        "import sys; from mpma_mj import cli\n"
        "try: cli.main(['imitate', '--help'])\n"
        "except SystemExit: pass\n"
        "assert not {'mujoco', 'scipy', 'matplotlib'} & set(sys.modules)"
    )
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, check=False)
    assert result.returncode == 0, result.stderr


def test_the_real_dance_is_learned_on_both_kinds_of_arms(mocap: Path, tmp_path: Path) -> None:
    recording = mocap / "qualisys_tsv" / "dance.tsv"
    for arms in ("physics", "kinematic"):
        out = tmp_path / arms
        words = ["imitate", str(recording), "--arms", arms, "--no-video", "--out", str(out)]
        assert main(words) == 0
        summary = json.loads((out / "summary.json").read_text())
        assert summary["converged"]
        assert summary["p_e_percent"] < 0.8


@pytest.mark.parametrize(
    "words", [["imitate", ""], ["evaluate", "run", "--out", ""], ["imitate", "--out="]]
)
def test_an_empty_argument_is_one_line_and_exit_2(
    words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(words) == 2
    assert capsys.readouterr().err.endswith(
        "is an empty argument; give it a value, or leave it out\n"
    )


@pytest.mark.parametrize("command", COMMANDS)
def test_help_shows_no_empty_default_and_no_none(
    command: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit):
        main([command, "--help"])
    printed = capsys.readouterr().out
    assert "--help" in printed
    assert "(default: )" not in printed
    assert "None" not in printed


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (["imitate", "ymca", "--random-start"], "training imitates whole episodes"),
        (["sweep", "--termination-distance=0.3"], "training imitates whole episodes"),
        (["compare", "--no-random-start"], "training imitates whole episodes"),
    ],
)
def test_an_option_that_a_command_would_refuse_is_not_listed(
    words: list[str], reason: str, capsys: pytest.CaptureFixture[str]
) -> None:
    option = next(word for word in words if word.startswith("--")).partition("=")[0]
    assert main(words) == 2
    option = option.replace("--no-", "--")
    message = f"mpma: mpma {words[0]} has no option {option}; leave it out: {reason}"
    assert capsys.readouterr().err.startswith(message)
    with pytest.raises(SystemExit):
        main([words[0], "--help"])
    assert f"{option} " not in capsys.readouterr().out
