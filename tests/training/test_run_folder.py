"""Damaged run folders: refused in one line that names the file, and replaced on demand."""

import dataclasses
import json
import os
import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mpma_mj
from benchmarks.campaign.snapshots import snapshot
from mpma_mj.cli import main
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.errors import CheckpointError, MotionFileError, RunFolderError
from mpma_mj.motions.options import ReadingOptions
from mpma_mj.training.config import RunConfig
from mpma_mj.training.run import resume
from mpma_mj.training.run_folder import RunFolder
from mpma_mj.utils import data_files
from tests.conftest import Refused

ARCHIVES = ("trace.npz", "checkpoint/best.npz", "checkpoint/latest.npz", "checkpoint/motion.npz")
ENV = EnvironmentOptions(arms="kinematic", repeats=1)


@pytest.fixture(scope="module")
def trained(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a run of two epochs."""
    path = tmp_path_factory.mktemp("runs") / "run"
    agent = mpma_mj.agents.MPMAConfig(nodes=10, modules=2)
    return mpma_mj.imitate("ymca", agent=agent, env=ENV, epochs=2).save(path)


@pytest.fixture
def run(trained: Path, tmp_path: Path) -> Path:
    """Return a copy of the run."""
    return shutil.copytree(trained, tmp_path / "run")


def change(path: Path, edit: Callable[[dict[str, Any], dict[str, Any]], object]) -> None:
    """Change arrays or header of an archive, as this program would have written them."""
    kind = "checkpoint" if path.stem in ("best", "latest") else path.stem
    arrays, meta = data_files.read_arrays(path, kind)
    edit(arrays, meta)
    data_files.write_arrays(path, kind, arrays, meta)


@pytest.mark.parametrize("file", ["config.json", *ARCHIVES])
@pytest.mark.parametrize(
    "replace",
    [
        os.mkfifo,
        os.mkdir,
        lambda path: path.symlink_to("/dev/zero"),
        lambda path: path.symlink_to("/nowhere/a"),
        lambda path: path.symlink_to(path.name),
        lambda path: path.write_bytes(b""),
        lambda path: path.write_bytes(b"PK\x03\x04" + bytes(50)),
        lambda path: (path.touch(), os.truncate(path, 5_000_000_000)),
    ],
)
def test_what_is_no_file_of_a_run_is_one_line(
    run: Path, file: str, replace: Callable[[Path], object], refused: Refused
) -> None:
    (run / file).unlink()
    replace(run / file)
    refused(["imitate", "--resume", str(run), "--no-video"], str(run))


@pytest.mark.parametrize(
    ("name", "damage", "message"),
    [
        ("posture", lambda x: x[:, :11], "has posture float64("),
        ("posture", lambda x: x * 1e300, "has a value in posture"),
        ("reference", lambda x: x[0], "has reference float64(12,)"),
        ("context", lambda x: x[1:], "has context float64("),
        ("joint_angles", lambda x: x.astype(str), "has joint_angles <U"),
        ("joint_velocities", lambda x: x + 0j, "has joint_velocities complex128"),
        ("action", lambda x: np.zeros(()), "has action float64()"),
        ("action", lambda x: x[1:], "has reward"),
        ("reward", lambda x: x * np.nan, "has a value in reward"),
        ("prior", lambda x: x[:, :1], "has prior"),
        ("module_actions", lambda x: x[..., 0], "has module_actions"),
        ("feedback", lambda x: np.zeros((0, 8)), "has feedback float64(0, 8)"),
    ],
)
def test_a_trace_of_other_signals_is_refused(
    run: Path, name: str, damage: Callable[[Any], Any], message: str, refused: Refused
) -> None:
    change(run / "trace.npz", lambda arrays, _: arrays.update({name: damage(arrays[name])}))
    refused(["play", str(run), "--out", str(run / "a.csv")], f"trace.npz: {message}")


def test_a_trace_has_a_moment_more_than_steps(run: Path, refused: Refused) -> None:
    steps = len(RunFolder(run).read_trace())

    def shorten(arrays: dict[str, Any], _: object) -> None:
        arrays |= {name: array[1:] for name, array in arrays.items() if len(array) == steps}

    change(run / "trace.npz", shorten)
    message = f"trace.npz: has {steps - 1} steps for {steps + 1} moments"
    refused(["play", str(run), "--out", str(run / "a.csv")], message)


@pytest.mark.parametrize(
    "rows",
    [
        *(None, [], {}, "x", [None], [[]], [{}], [{"epoch": 2, "p_e_percent": 1.0}]),
        [{"epoch": 1, "p_e_percent": 1.0}] * 2,
        *([{"epoch": n, "p_e_percent": 1.0}] for n in (-1, 1.0, True, "1", 10**400)),
        [{"epoch": 1, "p_e_percent": 1.0, "nmi": "high"}],
    ],
)
def test_metrics_that_are_none_are_refused(run: Path, rows: Any, refused: Refused) -> None:
    change(run / "checkpoint" / "latest.npz", lambda _, meta: meta.update(rows=rows))
    refused(["imitate", "--resume", str(run), "--no-video"], "latest.npz: ")


@pytest.mark.parametrize(
    ("name", "kind", "expected"),
    [
        *((name, Path.mkdir, "folder, not a file") for name in ("metrics.csv", "modules.json")),
        *((name, Path.touch, "file, not a folder") for name in ("figures", "evaluations")),
    ],
)
def test_what_is_in_the_way_in_a_run_folder_is_named(
    run: Path, name: str, kind: Callable[[Path], None], expected: str
) -> None:
    shutil.rmtree(run / name, ignore_errors=True)
    (run / name).unlink(missing_ok=True)
    kind(run / name)
    message = f"{run / name}: is a {expected}; remove it, or choose another folder"
    with pytest.raises(RunFolderError, match=f"^{re.escape(message)}$"):
        resume(RunFolder(run), 1).write_figures(RunFolder(run))


def test_a_file_in_place_of_a_parent_folder_is_named(tmp_path: Path, refused: Refused) -> None:
    (tmp_path / "file").touch()
    message = f"{tmp_path / 'file'}: is a file, not a folder; remove it, or choose another folder"
    for words in ("imitate ymca --out", "motion ymca --picture"):
        refused([*words.split(), str(tmp_path / "file" / "x" / "y.png")], message)


@pytest.mark.parametrize("epochs", [None, "3", 3.0, True])
def test_epochs_that_are_no_number_are_refused(run: Path, epochs: Any, refused: Refused) -> None:
    change(run / "checkpoint" / "latest.npz", lambda _, meta: meta.update(epochs=epochs))
    message = "latest.npz: lacks its largest number of epochs"
    refused(["imitate", "--resume", str(run), "--no-video"], message)


@pytest.mark.parametrize(
    ("row", "message"),
    [
        (None, "lacks the metrics of its epoch as numbers"),
        *(({"epoch": n, "p_e_percent": 1.0}, "has an epoch that is not") for n in (0, -1, 1.0)),
        *(({"epoch": 1, "p_e_percent": x}, "has no p_e_percent") for x in (-1.0, float("nan"))),
        ({"epoch": 1}, "has no p_e_percent"),
        ({"epoch": 1, "p_e_percent": 10**400}, "lacks the metrics of its epoch as numbers"),
    ],
)
def test_metrics_of_no_best_epoch_are_refused(
    run: Path, row: object, message: str, refused: Refused
) -> None:
    change(run / "checkpoint" / "best.npz", lambda _, meta: meta.update(row=row))
    refused(["imitate", "--resume", str(run), "--no-video"], f"best.npz: {message}")


@pytest.mark.parametrize(
    ("name", "value"),
    [("progress", -0.1), ("progress", 1.1), ("progress", np.nan), ("untrained_error", -1.0)],
)
def test_a_state_that_no_agent_has_is_refused(
    run: Path, name: str, value: float, refused: Refused
) -> None:
    change(run / "checkpoint" / "latest.npz", lambda arrays, _: arrays[name].fill(value))
    refused(["imitate", "--resume", str(run), "--no-video"], "latest.npz: does not fit its config")


@pytest.mark.parametrize(
    ("name", "value"),
    [
        *(("rate", np.array(rate)) for rate in (0.0, -20.0, np.nan, np.inf, 1e12, 1e-12, 1j)),
        *(("posture", np.zeros(shape)) for shape in ((), (0,), (3, 12), (10, 11))),
        ("posture", np.full((77, 12), "a")),
        ("labels", np.zeros(3)),
        *(("tempo", np.array(tempo)) for tempo in (0.0, np.nan, np.inf)),
        ("start", np.array(np.nan)),
    ],
)
def test_a_motion_that_is_none_is_refused(run: Path, name: str, value: Any) -> None:
    change(run / "checkpoint" / "motion.npz", lambda arrays, _: arrays.update({name: value}))
    with pytest.raises(CheckpointError, match=r"motion\.npz: damaged; train again with overwrite"):
        RunFolder(run).read_motion()


@pytest.mark.parametrize("part", ["config", "agent", "env", "reading", "seed", "motions", "init"])
@pytest.mark.parametrize("value", [[], None, "x", 1.5, True, {}, -(10**400), {"x": {}}])
def test_a_config_of_other_parts_is_refused(
    run: Path, part: str, value: Any, refused: Refused
) -> None:
    content = data_files.read_json(run / "config.json")
    if part == "config":
        content["config"] = value
    else:
        content["config"][part] = value
    data_files.write_json(run / "config.json", content)
    refused(["imitate", "--resume", str(run), "--no-video"], "config.json: damaged, or not of a")


@pytest.mark.parametrize("option", ["name", "rule"])
def test_a_config_of_an_agent_that_there_is_not_is_damaged(
    run: Path, option: str, refused: Refused
) -> None:
    content = data_files.read_json(run / "config.json")
    content["config"]["agent"][option] = "nobody"
    data_files.write_json(run / "config.json", content)
    refused(["imitate", "--resume", str(run), "--no-video"], "config.json: damaged, or not of a")


def overwrite(path: Path) -> int:
    words = ("--arms", "kinematic", "--nodes", "10", "--repeats", "1", "--epochs", "1")
    return main(["imitate", "ymca", *words, "--no-video", "--overwrite", "--out", str(path)])


@pytest.mark.parametrize(
    "text", ["{", "[]", '{"format": 1, "config": {}, "versions": {}}', None], ids=str
)
def test_a_damaged_run_and_one_of_another_version_are_replaced(run: Path, text: str | None) -> None:
    (run / "notes.txt").write_text("precious")
    (run / "config.json").unlink()
    if text is not None:
        (run / "config.json").write_text(text)
    assert overwrite(run) == 0
    assert RunFolder(run).read_latest(RunFolder(run).read_config())[1][-1]["epoch"] == 1
    assert (run / "notes.txt").read_text() == "precious"


def test_a_run_of_an_earlier_version_is_replaced_by_its_config(tmp_path: Path) -> None:
    earlier = '{"format": 1, "config": {}, "versions": {"mpma-mj": "0.1.0"}}'
    (tmp_path / "config.json").write_text(earlier)
    assert overwrite(tmp_path) == 0


def test_a_foreign_folder_is_never_replaced(tmp_path: Path, refused: Refused) -> None:
    (tmp_path / "config.json").write_text('{"format": 1, "config": {}}')
    (tmp_path / "checkpoint").mkdir()
    np.savez(tmp_path / "checkpoint" / "latest.npz", weights=np.ones(3))
    np.savez(tmp_path / "trace.npz", meta=np.array('{"kind": "theirs"}'))
    before = {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*")}
    words = ["imitate", "ymca", "--no-video", "--overwrite", "--out", str(tmp_path)]
    refused(words, "is not empty and not a run; choose another folder with --out")
    assert {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*")} == before


@pytest.mark.parametrize("file", ARCHIVES)
def test_files_of_another_run_are_refused(
    run: Path, tmp_path: Path, file: str, refused: Refused
) -> None:
    agent = mpma_mj.agents.MPMAConfig(nodes=10, modules=2)
    other = mpma_mj.imitate("ymca", agent=agent, env=ENV, epochs=2, seed=1).save(tmp_path / "other")
    shutil.copy(other / file, run / file)
    message = f"{file}: belongs to a run with another config"
    refused(["imitate", "--resume", str(run), "--no-video"], message)


def test_a_full_disk_keeps_the_run_that_is_overwritten(
    run: Path, monkeypatch: pytest.MonkeyPatch, refused: Refused
) -> None:
    def full(self: Path, *_: object, **__: object) -> int:
        raise OSError(28, "No space left on device")

    before = {path: path.read_bytes() for path in run.rglob("*") if path.is_file()}
    monkeypatch.setattr(Path, "write_text", full)
    words = "imitate ymca --nodes 5 --epochs 1 --no-video --overwrite --out"
    refused([*words.split(), str(run)], "cannot be written (No space left on device)")
    assert {path: path.read_bytes() for path in run.rglob("*") if path.is_file()} == before


@pytest.mark.parametrize("removed", [(), ("checkpoint/latest.npz",), ("config.json", "trace.npz")])
def test_what_is_left_of_a_run_is_replaced_on_demand_only(
    run: Path, removed: tuple[str, ...], refused: Refused
) -> None:
    for name in removed:
        (run / name).unlink()
    before = snapshot(run)
    words = ["imitate", "ymca", "--nodes", "5", "--epochs", "1", "--no-video", "--out"]
    refused([*words, str(run)], "already contains a run; --overwrite replaces it, --resume contin")
    assert snapshot(run) == before


def test_a_trace_of_another_epoch_than_the_best_is_refused(run: Path, refused: Refused) -> None:
    best = int(json.loads((run / "summary.json").read_text())["best_epoch"])
    change(run / "trace.npz", lambda _, meta: meta.update(epoch=best + 1))
    message = f"trace.npz: is of epoch {best + 1}, but checkpoint/best.npz of epoch {best}"
    for command in ("play RUN --out j.csv", "imitate --no-video --resume RUN", "evaluate RUN"):
        refused(command.replace("RUN", str(run)).split(), message)


def replace_inputs(folder: RunFolder, config: RunConfig) -> None:
    with folder.changes(new=True) as saved:
        saved.write_inputs(config, folder.read_motion())


def test_a_run_keeps_a_copy_of_its_music(run: Path, tmp_path: Path) -> None:
    folder, music = RunFolder(run), tmp_path / "a.wav"
    assert folder.sound is None
    reading = ReadingOptions(audio=str(music), context="bars")
    config = dataclasses.replace(folder.read_config(), reading=reading)
    with pytest.raises(MotionFileError, match=r"a\.wav: no such file"):
        RunFolder(tmp_path / "new").check_new(config, overwrite=True)
    music.write_bytes(b"music")
    replace_inputs(folder, config)
    assert folder.sound == run / "sound" / "a.wav"
    assert folder.sound.read_bytes() == b"music"
    reading = ReadingOptions(audio=str(folder.sound), context="bars")  # of the run it replaces
    replace_inputs(folder, dataclasses.replace(config, reading=reading))
    assert folder.sound.read_bytes() == b"music"
    replace_inputs(folder, dataclasses.replace(config, reading=ReadingOptions()))
    assert folder.sound is None


@pytest.mark.parametrize("name", ["summary.json", "metrics.csv", "trace.npz"])
def test_what_is_in_the_way_of_a_run_is_refused_before_it_goes_on(run: Path, name: str) -> None:
    content = (run / name).read_bytes()
    (run / name).unlink()
    (run / name).mkdir()
    before = RunFolder(run).checkpoint("latest").read_bytes()
    with pytest.raises(RunFolderError, match=rf"{name}: is a folder, not a file; remove it"):
        resume(RunFolder(run), 1)
    assert RunFolder(run).checkpoint("latest").read_bytes() == before
    (run / name).rmdir()
    (run / name).write_bytes(content)
    assert resume(RunFolder(run), 1).history.rows
