"""`mpma imitate`: training, resuming, repertoires."""

import json
import shlex
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mpma_mj.cli import main
from mpma_mj.envs import gl
from mpma_mj.kinematics import posture_from_angles
from mpma_mj.motions import ymca
from mpma_mj.training.run import Run
from mpma_mj.training.trainer import Trainer
from tests.conftest import DISK_FULL, FAILED, Encoder, Refused, dancer, markers_of

WriteTsv = Callable[..., Path]


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")


def test_a_run_prints_its_folder_last_and_shows_its_epochs(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "run"
    assert main(["imitate", "ymca", "--nodes", "30", "--no-video", "--out", str(out)]) == 0
    printed = capsys.readouterr()
    assert printed.out.splitlines()[-1] == str(out)
    assert "converged after" in printed.out
    first = printed.err.splitlines()[0]
    assert all(word in first for word in ("epoch", "p_e", "feedback ratio", "K 1.00", "L 0.01"))
    assert {p.name for p in (out / "figures").iterdir()} == {
        "responsibility.png",
        "module_output.png",
        "trajectory.png",
    }
    assert not (out / "dance.mp4").exists()


@pytest.mark.parametrize(
    ("agent", "by_expert"),
    [
        ("bc --expert-episodes 2", 5),
        ("dagger --expert-episodes 2", 4),
        ("promp --demonstrations 2", 2),
        ("dmp --demonstrations 2", 2),
    ],
)
def test_epochs_of_the_expert_and_of_the_learner_are_named(
    agent: str, by_expert: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "run"
    small = "--arms kinematic --repeats 1 --no-video --out"
    assert main(["imitate", "ymca", "--agent", *agent.split(), *small.split(), str(out)]) == 0
    printed = capsys.readouterr()
    who = [line.split()[2] for line in printed.err.splitlines()]
    epochs = len(who)
    assert who == ["expert"] * by_expert + ["learner"] * (epochs - by_expert)
    assert " K " not in printed.err  # it has no gains
    expert, learner = (printed.err.splitlines()[k].split()[4] for k in (by_expert - 1, -1))
    result = f"learner's p_e {learner} % in one episode, expert's {expert} %"
    assert f"best epoch {epochs}: {result}" in printed.out
    again = tmp_path / "again"
    words = f"imitate ymca --agent {agent} --init {out} {small}"
    assert main([*words.split(), str(again)]) == 0
    assert "expert's" not in capsys.readouterr().out


def test_without_out_a_run_goes_below_runs_by_motion_and_time(
    capsys: pytest.CaptureFixture[str],
) -> None:
    words = "imitate ymca --nodes 10 --repeats 1 --epochs 1 --no-video"
    assert main(words.split()) == 0
    folder = Path(capsys.readouterr().out.splitlines()[-1])
    assert folder.parent == Path("runs")
    assert folder.name.startswith("ymca-20")
    assert (folder / "summary.json").exists()


def test_training_without_opengl_works_and_says_how_to_get_video(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(gl, "_draws", lambda backend: False)
    out = tmp_path / "run"
    assert main(["imitate", "ymca", "--nodes", "20", "--epochs", "1", "--out", str(out)]) == 0
    assert "libosmesa6" in capsys.readouterr().err.splitlines()[-1]
    assert (out / "summary.json").exists()
    assert not (out / "dance.mp4").exists()


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
    common = ["--nodes", "10", "--modules", "2", "--repeats", "1", "--no-video"]
    assert main(["imitate", "ymca", *common, "--epochs", "1", "--out", str(out)]) == 0
    assert main(["imitate", "--resume", str(out), "--epochs", "1", "--no-video"]) == 0
    assert main(["imitate", "ymca", *common, "--epochs", "1", "--resume", str(out)]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == str(out)
    assert len((out / "metrics.csv").read_text().splitlines()) == 1 + 3


@pytest.mark.parametrize("begin", [[], ["--resume"]])
@pytest.mark.parametrize("stopped", ["an epoch", "drawing"])
def test_resume_alone_finishes_what_was_interrupted(
    begin: list[str],
    stopped: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    new = f"imitate ymca --nodes 10 --modules 2 --repeats 1 --no-video --out {tmp_path / 'run'}"
    words = new.split()
    if begin:
        assert main([*words, "--epochs", "1"]) == 0
        words = ["imitate", "--resume", str(tmp_path / "run"), "--no-video"]
    owner, name = (Trainer, "run_epoch") if stopped == "an epoch" else (Run, "write_figures")
    right = getattr(owner, name)

    def interrupted(self: Any, *_: Any, **options: Any) -> Any:
        if owner is Trainer and self.epoch < 1 + len(begin):
            return right(self, **options)
        raise KeyboardInterrupt

    monkeypatch.setattr(owner, name, interrupted)
    assert main([*words, "--epochs", "2"]) == 130
    monkeypatch.setattr(owner, name, right)
    (hint,) = [line for line in capsys.readouterr().err.splitlines() if "to resume" in line]
    assert hint.endswith(" --no-video")
    assert main(shlex.split(hint.partition(": mpma ")[2])) == 0
    lines = (tmp_path / "run" / "metrics.csv").read_text().splitlines()
    assert len(lines) == 1 + len(begin) + 2
    assert ("no epoch was added" in capsys.readouterr().out) == (stopped == "drawing")
    assert (tmp_path / "run" / "figures" / "trajectory.png").exists()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["macarena"], "no motion 'macarena'"),
        (["gone.tsv"], "gone.tsv: no such file"),
        ([], "no motion given"),
        (["ymca", "--modules", "0"], "modules is 0"),
        (["ymca", "--nodes", "-3"], "nodes is -3"),
        (["ymca", "--epochs", "0"], "epochs is 0"),
        (["ymca", "--seed", "-1"], "seed is -1"),
        (["ymca", "--tempo", "0"], "tempo is 0"),
        (["ymca", "--tempo", "nan"], "tempo is nan"),
        (["ymca", "--tempo", "1e-9"], "tempo is 1e-09; expected 0.01 to 100"),
        (["ymca", "--tempo", "5", "--strict"], "leave out --strict"),
        (["ymca", "--segments", "0"], "segments is 0"),
        (["ymca", "--max-gap", "-1"], "max-gap is -1"),
        (["ymca", "--repeats", "0"], "repeats is 0"),
        (["ymca", "--reference-noise", "-0.1"], "--reference-noise is -0.1"),
        (["ymca", "--resume", "nowhere"], "nowhere: is not a run"),
        (
            ["ymca", "--plants", "default", "payload=1", "--switch-every", "3", "1"],
            "--switch-every is 3.0 1.0; expected two times",
        ),
        (
            ["ymca", "--agent", "nobody"],
            "one of mpma, mosaic, hammer, single, adaptive, oracle, bc, dagger,",
        ),
        (["ymca", "--out", "x" * 300], "File name too long; check the path and its permissions"),
    ],
)
def test_bad_input_is_one_line_exit_2_and_no_folder(
    words: list[str], message: str, refused: Refused
) -> None:
    refused(["imitate", *words, "--no-video"], message)
    assert list(Path().iterdir()) == []


def test_a_bad_recording_leaves_no_folder(
    write_tsv: WriteTsv, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = write_tsv(edit=lambda text: text.replace("Elbow_R", "Elbow"))
    out = tmp_path / "run"
    assert main(["imitate", str(path), "--no-video", "--out", str(out)]) == 2
    assert "the right elbow" in capsys.readouterr().err
    assert not out.exists()


def test_a_recording_faster_than_the_arms_is_changed_or_slowed_or_refused(
    write_tsv: WriteTsv, capsys: pytest.CaptureFixture[str]
) -> None:
    angles = np.tile([0.5, 0.1, 0.2, 1.2] * 2, (60, 1))
    angles[:, 3] += 1.1 * np.sin(np.arange(60) / 60 * 2 * np.pi * 4)  # 28 rad/s, filtered less
    path = write_tsv(markers_of(dancer(posture_from_angles(angles))))
    words = ["imitate", str(path), "--no-video", "--epochs", "1", "--nodes", "5"]
    assert main([*words, "--strict", "--out", "strict"]) == 2
    error = capsys.readouterr().err
    assert "left_elbow would have to turn at" in error
    assert "rad/s at 0." in error
    assert "its actuator reaches 15; in the closest motion" in error
    assert main([*words, "--out", "changed"]) == 0
    assert "its actuator reaches 15; in the closest motion" in capsys.readouterr().err
    assert main([*words, "--tempo", "auto", "--strict", "--out", "slowed"]) == 0
    assert "actuator" not in capsys.readouterr().err


def test_a_folder_that_cannot_be_written_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").write_text("")
    words = ["imitate", "ymca", "--no-video", "--out", str(tmp_path / "file" / "run")]
    assert main(words) == 2
    assert f"{tmp_path / 'file'}: is a file, not a folder" in capsys.readouterr().err


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
        (["ymca", "--nodes", "77"], "mpma: --nodes is 77, but the run to resume has 30"),
        (["ymca", "--nodes=200"], "mpma: --nodes is 200, but the run to resume has 30"),
        (["dance.tsv"], "mpma: motions is dance.tsv, but the run to resume has ymca"),
        (["--overwrite"], "leave --overwrite out"),
        (["--out", "elsewhere"], "leave --out out"),
    ],
)
def test_a_resumed_run_keeps_its_settings(
    small_run: Path, words: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["imitate", *words, "--no-video", "--resume", str(small_run)]) == 2
    assert message in capsys.readouterr().err


@pytest.mark.parametrize(
    ("name", "shown", "typed"),
    [
        *(("run", "run", "run"), ("co nv", "co nv", "'co nv'"), ("-dash", "-dash", "./-dash")),
        ("two\nlines", r"two\nlines", r"$'two\x0alines'"),
    ],
)
def test_a_run_that_has_converged_says_so_and_how_to_train_on(
    name: str,
    shown: str,
    typed: str,
    small_run: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    run = Path(shutil.copytree(small_run, name))
    before = (run / "metrics.csv").read_bytes()
    assert main(["imitate", "--resume", f"./{name}", "--no-video"]) == 0
    first, *_ = capsys.readouterr().out.splitlines()
    assert first.startswith(f"{shown}: has converged, so no epoch was added")
    assert first.endswith(f"mpma imitate MOTION --init {typed}")
    assert (run / "metrics.csv").read_bytes() == before


def test_a_run_with_plants_goes_on_though_it_has_converged(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = "--nodes 20 --repeats 1 --plants default payload=1 --epochs 2 --no-video --out run"
    assert main(["imitate", "ymca", *words.split()]) == 0
    assert capsys.readouterr().out.startswith("trained for 2 epochs; in the latest: p_e ")


def test_a_corrupt_checkpoint_is_refused(
    small_run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    copy = tmp_path / "copy"
    shutil.copytree(small_run, copy)
    (copy / "checkpoint" / "latest.npz").write_bytes(b"rubbish")
    assert main(["imitate", "--no-video", "--resume", str(copy)]) == 2
    assert "latest.npz: damaged" in capsys.readouterr().err


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
    assert (hint == f"mpma: to resume: mpma imitate --resume {out} --no-video") == (epochs_done > 0)
    if epochs_done:
        monkeypatch.setattr(Trainer, "run_epoch", whole)
        assert main(["imitate", "--resume", str(out), "--no-video", "--epochs", "1"]) == 0


def test_the_real_dance_is_learned_on_both_kinds_of_arms(mocap: Path, tmp_path: Path) -> None:
    recording = mocap / "qualisys_tsv" / "dance.tsv"
    for arms in ("physics", "kinematic"):
        out = tmp_path / arms
        words = ["imitate", str(recording), "--arms", arms, "--no-video", "--out", str(out)]
        assert main(words) == 0
        summary = json.loads((out / "summary.json").read_text())
        assert summary["converged"]
        assert summary["p_e_percent"] < 0.8


def test_several_movements_are_learned_together(write_tsv: WriteTsv) -> None:
    slow = write_tsv(markers_of(dancer(ymca(rate=60.0, tempo=0.8).posture[:200])))
    words = f"imitate ymca {slow} --nodes 30 --repeats 1 --epochs 3 --no-video --out run"
    assert main(words.split()) == 0
    summary = json.loads(Path("run/summary.json").read_text())
    assert [row["name"] for row in summary["motions"]] == ["ymca", "dance"]
    assert set(summary["active_modules"]) == {"ymca", "dance"}
    steps = [row["steps"] for row in summary["motions"]]
    mean = np.average([row["p_e_percent"] for row in summary["motions"]], weights=steps)
    assert mean == pytest.approx(summary["p_e_percent"])
    assert main(["imitate", "--resume", "run", "--epochs", "1", "--no-video"]) == 0
    assert main(["imitate", "ymca", "--resume", "run", "--epochs", "1", "--no-video"]) == 2


def test_a_folder_is_the_recordings_in_it(
    write_tsv: WriteTsv, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "dances"
    folder.mkdir()
    markers = markers_of(dancer(ymca(rate=60.0).posture[:200]))
    for name in ("b.tsv", "a.tsv"):
        write_tsv(markers).rename(folder / name)
    (folder / "notes.txt").write_text("not a recording")
    words = ["--nodes", "20", "--repeats", "1", "--epochs", "1", "--no-video", "--out", "run"]
    assert main(["imitate", str(folder), *words]) == 0
    summary = json.loads(Path("run/summary.json").read_text())
    assert [row["name"] for row in summary["motions"]] == ["a", "b"]
    empty = tmp_path / "empty"
    empty.mkdir()
    assert main(["imitate", str(empty), "--no-video"]) == 2
    assert "contains no recording" in capsys.readouterr().err


@pytest.mark.parametrize("words", [["--to", "3"], ["--labels", "x.csv"], ["--audio", "x.wav"]])
def test_what_is_for_one_recording_is_refused_for_several(
    words: list[str], write_tsv: WriteTsv, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("x.csv").write_text("0,2,a\n")
    assert main(["imitate", str(write_tsv()), "ymca", *words, "--no-video"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert f"{words[0]} is for one recording, but there are 2; leave it out" in line


@pytest.mark.usefixtures("opengl")
def test_the_run_stays_if_the_video_fails(
    tmp_path: Path, encoder: Encoder, capsys: pytest.CaptureFixture[str]
) -> None:
    encoder(DISK_FULL)
    out = tmp_path / "run"
    words = ["--nodes", "10", "--repeats", "1", "--epochs", "1", "--out", str(out)]
    assert main(["imitate", "ymca", *words]) == 1
    printed = capsys.readouterr()
    assert printed.err.splitlines()[-1].startswith(f"mpma: {out}/dance.mp4: {FAILED}")
    assert "best epoch 1" in printed.out
    assert (out / "summary.json").exists()
    assert not list(out.glob("*.mp4"))


@pytest.mark.parametrize(
    "words", ["imitate RUN", "compare ymca RUN", "motion RUN", "study latency --motion RUN"]
)
def test_a_run_in_place_of_a_motion_is_recognised(
    words: str, small_run: Path, refused: Refused
) -> None:
    message = f"{small_run}: is a run, not a motion; mpma imitate continues it with --resume, or"
    refused(words.replace("RUN", str(small_run)).split(), message)
