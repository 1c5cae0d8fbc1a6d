"""Runs that are overwritten: the earlier one is whole until an epoch of the new one is saved."""

import errno
import os
import shutil
from collections.abc import Sequence
from pathlib import Path

import pytest

from benchmarks.campaign.snapshots import snapshot
from mpma_mj.cli import main
from mpma_mj.errors import RunFolderError
from mpma_mj.motions import Motion, ymca
from mpma_mj.training import history
from mpma_mj.training.config import RunConfig
from mpma_mj.training.run import resume, train
from mpma_mj.training.run_folder import RunFolder
from mpma_mj.training.trainer import Trainer
from mpma_mj.utils import data_files
from mpma_mj.utils.atomic_files import not_writable
from mpma_mj.utils.folder_lock import locked
from tests.conftest import Refused
from tests.killed import killed_at

Found = tuple[int, dict[str, str]]

# What follows a command that was killed.
EVALUATE = "evaluate run --arms kinematic --disturbances noise --levels 0.1 --no-baselines --out"
QUICK = (
    "play run --out joints.csv",
    "imitate --resume run --nodes 3 --no-video",
    "imitate ymca --nodes 3 --no-video --out run",
)
ALL = (
    *QUICK,
    f"{EVALUATE} e",
    f"{EVALUATE} run",
    "analyse run",
    "imitate --resume run --epochs 1 --no-video",
    "imitate ymca --arms kinematic --repeats 1 --epochs 1 --init run --no-video --out next",
)
LOCKING = ("analyse", "imitate --resume run --epochs")


def config(nodes: int) -> RunConfig:
    return RunConfig.of(nodes=nodes, modules=2, repeats=1, arms="kinematic")


@pytest.fixture(scope="module")
def motion() -> Motion:
    """Return a motion of a second, so that an epoch takes milliseconds."""
    whole = ymca()
    return Motion(whole.posture[:20], whole.context[:20], whole.labels, whole.rate, "part", "here")


@pytest.fixture(scope="module")
def earlier(tmp_path_factory: pytest.TempPathFactory, motion: Motion) -> Path:
    """Return a folder with a run of two epochs, which has results and a file of its user."""
    folder = RunFolder(tmp_path_factory.mktemp("earlier") / "run")
    train(config(3), 2, motion=motion, folder=folder)
    data_files.write_json(folder.results_of("lesion"), {})
    (folder.evaluations / "one").mkdir(parents=True)
    (folder.path / "mine.txt").write_text("mine")
    return folder.path.parent


@pytest.fixture
def here(earlier: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a copy of the folder, which is the current one."""
    shutil.copytree(earlier, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def overwrite(motion: Motion) -> None:
    with locked(Path("run")):
        train(config(5), 1, motion=motion, folder=RunFolder(Path("run")), overwrite=True)


def follow(place: Path, words: str) -> Found:
    """Run a command in a copy of a folder; return how it ends, and the files that there are."""
    copy = shutil.copytree(place, place.parent / "copy", symlinks=True)
    with pytest.MonkeyPatch.context() as patched:
        patched.chdir(copy)
        code = main(words.split())
    found = snapshot(copy)
    if not words.startswith(LOCKING):  # others may leave what they do not read
        found = {name: digest for name, digest in found.items() if ".mpma" not in name}
    shutil.rmtree(copy)
    return code, found


@pytest.mark.parametrize("followers", [QUICK, pytest.param(ALL, marks=pytest.mark.slow)])
def test_after_a_kill_at_any_change_of_a_file_all_commands_find_the_same_run(
    here: Path, motion: Motion, followers: Sequence[str], tmp_path_factory: pytest.TempPathFactory
) -> None:
    place = tmp_path_factory.mktemp("places")

    def state(number: int | None) -> tuple[Path, int]:
        """Return a folder in which the overwriting was killed, and the number of changes."""
        folder = Path(shutil.copytree(here, place / str(number)))
        with pytest.MonkeyPatch.context() as patched:
            patched.chdir(folder)
            with killed_at(number) as done:
                overwrite(motion)
        return folder, len(done)

    new, changes = state(None)
    no_summary = Path(shutil.copytree(new, place / "no summary"))
    (no_summary / "run" / "summary.json").unlink()
    whole = (here, no_summary, new)
    expected = {words: [follow(one, words) for one in whole] for words in followers}
    seen: dict[tuple[object, ...], int] = {}
    found = []
    for number in range(changes):
        folder, _ = state(number)
        files = snapshot(folder)
        left = any(".mpma-" in name for name in files)
        files = {name: digest for name, digest in files.items() if ".mpma-" not in name}
        if seen.setdefault((left, *files.items()), number) < number:
            continue
        possible = {0, 1, 2}
        for words in followers:
            result = follow(folder, words)
            found_here = {i for i in range(3) if expected[words][i] == result}
            assert found_here, (number, words, result[0])
            possible &= found_here
        assert possible, (number, "not the same run for all")
        found.append(min(possible))
    assert found == sorted(found)
    assert {0, 1} <= set(found)


def test_a_first_epoch_that_is_killed_leaves_no_run(
    motion: Motion, tmp_path: Path, refused: Refused
) -> None:
    folder = RunFolder(tmp_path / "run")
    with killed_at(12), locked(folder.path):
        train(config(3), 1, motion=motion, folder=folder)
    assert list(folder.path.glob(".mpma-*"))
    refused(["play", str(folder.path)], "run: is not a run (no readable config.json)")
    with locked(folder.path):
        train(config(3), 1, motion=motion, folder=folder)
    assert list(folder.path.glob(".mpma*")) == []


@pytest.mark.parametrize(
    "method", ["write_inputs", "write_trace", "write_checkpoint", "write_metrics", "write_latest"]
)
@pytest.mark.parametrize("removed", [None, "config.json", "checkpoint/latest.npz"])
def test_an_epoch_that_cannot_be_saved_leaves_the_earlier_run(
    here: Path, motion: Motion, method: str, removed: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    if removed is not None:
        (here / "run" / removed).unlink()
    before = snapshot(here)
    monkeypatch.setattr(RunFolder, method, full_disk)
    with pytest.raises(RunFolderError, match="No space left"):
        overwrite(motion)
    assert snapshot(here) == before


@pytest.mark.parametrize("method", ["write_trace", "write_checkpoint"])
def test_a_better_epoch_that_cannot_be_saved_leaves_the_results_of_the_best(
    here: Path, method: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(history, "_rank", lambda row: -row["epoch"])
    before = snapshot(here)
    with monkeypatch.context() as patched:
        patched.setattr(RunFolder, method, full_disk)
        patched.setattr(RunFolder, "write_latest", lambda *_: None)  # how long it is to go on
        with pytest.raises(RunFolderError, match="No space left"), locked(Path("run")):
            resume(RunFolder(Path("run")), 1)
    assert snapshot(here) == before
    with locked(Path("run")):
        resume(RunFolder(Path("run")), 1)
    assert not (here / "run" / "evaluations").exists()
    assert not (here / "run" / "lesion.json").exists()


def full_disk(*_: object) -> None:
    raise not_writable(Path("run"), OSError(errno.ENOSPC, os.strerror(errno.ENOSPC)))


def test_a_first_epoch_that_is_interrupted_hints_at_no_run_to_resume(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    before = snapshot(here)
    monkeypatch.setattr(Trainer, "run_epoch", interrupted)
    words = "imitate ymca --nodes 5 --no-video --out"
    assert main([*words.split(), "run", "--overwrite"]) == 130
    assert main([*words.split(), "new"]) == 130
    assert "to resume" not in capsys.readouterr().err
    assert snapshot(here) == before


def test_what_is_in_the_way_is_named_before_an_epoch_is_run(
    here: Path, refused: Refused, monkeypatch: pytest.MonkeyPatch
) -> None:
    shutil.rmtree(here / "run" / "evaluations")
    (here / "run" / "evaluations").touch()
    monkeypatch.setattr(Trainer, "run_epoch", None)
    message = "run/evaluations: is a file, not a folder; remove it, or choose another folder"
    refused(
        ["imitate", "ymca", "--nodes", "5", "--no-video", "--overwrite", "--out", "run"], message
    )


def test_files_of_the_user_stay(here: Path, motion: Motion) -> None:
    overwrite(motion)
    assert (here / "run" / "mine.txt").read_text() == "mine"
    assert not (here / "run" / "evaluations").exists()
    assert not (here / "run" / "lesion.json").exists()
    assert RunFolder(here / "run").read_config() == config(5)
