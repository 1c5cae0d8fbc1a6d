"""Runs that are overwritten: kept until an epoch of the new run is saved, whatever happens."""

import contextlib
import errno
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import mpma_mj
from mpma_mj.cli import main
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.errors import RunFolderError
from mpma_mj.training import earlier_run
from mpma_mj.training.run_folder import RunFolder
from tests.conftest import Refused

Contents = dict[str, bytes]

NEW = ["imitate", "ymca", "--nodes", "5", "--modules", "2", "--epochs", "1", "--no-video", "--out"]


@pytest.fixture(scope="module")
def trained(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a run of one epoch."""
    agent = mpma_mj.agents.MPMAConfig(nodes=10, modules=2)
    env = EnvironmentOptions(arms="kinematic", repeats=1)
    folder = tmp_path_factory.mktemp("runs") / "run"
    return mpma_mj.imitate("ymca", agent=agent, env=env, epochs=1).save(folder)


@pytest.fixture
def run(trained: Path, tmp_path: Path) -> Path:
    """Return a copy of the run, with a file of its user."""
    run = shutil.copytree(trained, tmp_path / "run")
    (run / "mine.txt").write_text("mine")
    return run


def contents(run: Path) -> Contents:
    return {str(p.relative_to(run)): p.read_bytes() for p in run.rglob("*") if p.is_file()}


def begin_another(run: Path) -> None:
    """Write what a new run writes before its first epoch."""
    shutil.copy(run / ".mpma-set-aside" / "config.json", run / "config.json")
    for name in ("checkpoint", "sound"):
        (run / name).mkdir()
        (run / name / "new").write_text("new")


def test_a_first_epoch_that_cannot_be_saved_leaves_the_earlier_run(
    run: Path, monkeypatch: pytest.MonkeyPatch, refused: Refused
) -> None:
    def full(*_: object) -> None:
        raise RunFolderError("cannot be written (No space left on device)")

    before = contents(run)
    monkeypatch.setattr(RunFolder, "write_checkpoint", full)
    refused([*NEW, str(run), "--overwrite"], "No space left on device")
    assert contents(run) == before


def test_an_epoch_that_is_saved_replaces_the_earlier_run(run: Path) -> None:
    assert main([*NEW, str(run), "--overwrite"]) == 0
    assert '"nodes": 5' in (run / "config.json").read_text()
    assert (run / "mine.txt").read_text() == "mine"
    assert list(run.glob(".mpma-*")) == []


def test_the_next_command_puts_back_what_a_killed_one_has_set_aside(
    run: Path, refused: Refused
) -> None:
    before = contents(run)
    earlier_run.set_aside(run)
    begin_another(run)
    refused([*NEW, str(run)], "already contains a run")
    assert contents(run) == before
    earlier_run.set_aside(run)
    begin_another(run)
    assert main(["imitate", "--resume", str(run), "--epochs", "1", "--no-video"]) == 0
    assert '"nodes": 10' in (run / "config.json").read_text()


def fail_after(patch: pytest.MonkeyPatch, number: int) -> None:
    """Let every change of a file fail but the first ones."""
    left = [number]

    def failing(change: Callable[..., Any]) -> Callable[..., Any]:
        def failing_change(*words: Any, **options: Any) -> Any:
            left[0] -= 1
            if left[0] < 0:
                raise OSError(errno.EIO, "failed")
            return change(*words, **options)

        return failing_change

    for name in ("rename", "unlink", "rmdir", "mkdir"):
        patch.setattr(Path, name, failing(getattr(Path, name)))


@pytest.mark.parametrize("step", [earlier_run.set_aside, earlier_run.put_back])
@pytest.mark.parametrize("number", range(10))
def test_whatever_is_interrupted_can_be_repeated(
    run: Path, step: Callable[[Path], None], number: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = contents(run)
    if step == earlier_run.put_back:
        earlier_run.set_aside(run)
        begin_another(run)
    with monkeypatch.context() as patch:
        fail_after(patch, number)
        with contextlib.suppress(OSError):
            step(run)
    earlier_run.put_back(run)
    assert contents(run) == before
