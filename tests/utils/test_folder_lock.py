"""Locks of folders: between two commands, and after one that was killed."""

import contextlib
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from mpma_mj.cli import main
from mpma_mj.commands import folders
from mpma_mj.commands.folders import output_folder
from mpma_mj.errors import RunFolderError
from mpma_mj.sysid import write_log
from mpma_mj.utils.folder_lock import is_empty, locked
from tests.conftest import Refused
from tests.sysid.conftest import dance_of

LOCK = ".mpma.lock"
BUSY = "another command is writing into it; wait until it has ended, or choose another folder"
QUICK = ["imitate", "ymca", "--nodes", "10", "--epochs", "1", "--no-video"]

HOLD = """
import sys, pathlib
from mpma_mj.utils.folder_lock import locked
with locked(pathlib.Path(sys.argv[1])):
    print("locked", flush=True)
    sys.stdin.read()
"""


@contextlib.contextmanager
def held(folder: Path) -> Iterator[subprocess.Popen[str]]:
    """Lock a folder in another process."""
    command = [sys.executable, "-c", HOLD, str(folder)]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "locked\n"
        yield process


@pytest.fixture
def run(small_run: Path, tmp_path: Path) -> Path:
    """Return a copy of a run."""
    return Path(shutil.copytree(small_run, tmp_path / "run"))


@pytest.fixture(scope="session")
def robot_log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the file of a short log."""
    path = tmp_path_factory.mktemp("robot") / "log.csv"
    write_log(path, dance_of("two_arm", 1.0, latency=0))
    return path


def test_of_two_commands_the_second_is_refused_until_the_first_is_killed(
    tmp_path: Path, refused: Refused
) -> None:
    out = tmp_path / "run"
    long = ["imitate", "ymca", "--nodes", "1000", "--no-video", "--overwrite", "--out", str(out)]
    first = subprocess.Popen([sys.executable, "-m", "mpma_mj.cli", *long], stderr=subprocess.PIPE)
    try:
        while not (out / LOCK).exists():
            assert first.poll() is None, first.communicate()
            time.sleep(0.01)
        refused([*QUICK, "--seed", "1", "--overwrite", "--out", str(out)], f"{out}: {BUSY}")
        assert first.poll() is None, "the first was too fast"
    finally:
        first.send_signal(signal.SIGKILL)
        first.communicate()
    assert (out / LOCK).exists()
    assert main([*QUICK, "--seed", "1", "--overwrite", "--out", str(out)]) == 0
    assert not (out / LOCK).exists()
    assert '"seed": 1' in (out / "config.json").read_text()


COMMANDS = [
    "imitate ymca --no-video --out FOLDER",
    "imitate ymca --no-video --overwrite --out FOLDER",
    "imitate --no-video --resume FOLDER",
    "analyse FOLDER modules",
    "analyse FOLDER free-running",
    "analyse FOLDER lesion",
    "evaluate FOLDER",
    "evaluate RUN --out RESULTS",
    "sweep --out FOLDER",
    "study table1 --out FOLDER",
    "study robustness --out FOLDER",
    "compare ymca --no-video --out RESULTS",
    "identify LOG --out RESULTS",
    "record ymca --out RESULTS",
]


@pytest.fixture(scope="module")
def held_results(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Yield a folder of results that another process holds."""
    results = tmp_path_factory.mktemp("held") / "results"
    with held(results):
        yield results


@pytest.fixture(scope="module")
def held_run(small_run: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Yield a copy of a run that another process holds."""
    run = shutil.copytree(small_run, tmp_path_factory.mktemp("held") / "run")
    with held(run):
        yield run


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_that_writes_a_folder_is_refused_while_another_does(
    command: str,
    held_run: Path,
    held_results: Path,
    small_run: Path,
    robot_log: Path,
    refused: Refused,
) -> None:
    folder = held_results if "RESULTS" in command else held_run
    before = {path: path.stat().st_mtime_ns for path in folder.rglob("*")}
    places = {"FOLDER": folder, "RESULTS": folder, "RUN": small_run, "LOG": robot_log}
    refused([str(places.get(word, word)) for word in command.split()], f"mpma: {folder}: {BUSY}")
    assert {path: path.stat().st_mtime_ns for path in folder.rglob("*")} == before


def test_a_run_is_read_while_a_command_writes_it(
    run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["evaluate", str(run), "--no-baselines", "--disturbances", "gravity"]
    with held(run):
        assert main([*words, "--out", str(tmp_path / "evaluation")]) == 0


def test_a_lock_ends_with_its_process(tmp_path: Path) -> None:
    with held(tmp_path / "a") as process:
        with pytest.raises(RunFolderError, match=BUSY), locked(tmp_path / "a"):
            pass
        process.kill()
        process.wait()
        assert (tmp_path / "a" / LOCK).exists()
        with locked(tmp_path / "a"):
            pass
    assert list((tmp_path / "a").iterdir()) == []


def test_a_lock_leaves_nothing_and_no_folder_in_which_nothing_was_written(tmp_path: Path) -> None:
    with locked(tmp_path / "a" / "b"):
        assert is_empty(tmp_path / "a" / "b")
        (tmp_path / "a" / "mine").write_text("")
    assert [path.name for path in tmp_path.rglob("*")] == ["a", "mine"]
    (tmp_path / "empty").mkdir()
    with locked(tmp_path / "empty"):
        pass
    assert (tmp_path / "empty").exists(), "it was there before"
    with pytest.raises(ZeroDivisionError), locked(tmp_path / "failed"):
        raise ZeroDivisionError
    assert not (tmp_path / "failed").exists()


def test_what_a_killed_command_leaves_makes_no_folder_full(tmp_path: Path) -> None:
    for name in ("run", "sweep"):
        (tmp_path / name).mkdir()
        (tmp_path / name / LOCK).write_text("")
    assert main([*QUICK, "--out", str(tmp_path / "run")]) == 0
    tiny = ["--nodes", "5", "--modules", "2", "--repeats", "1", "--epochs", "1", "--runs", "1"]
    assert main(["sweep", *tiny, "--out", str(tmp_path / "sweep")]) == 0
    assert list(tmp_path.rglob(LOCK)) == []


def test_of_one_second_every_new_folder_has_a_name_of_its_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(folders.time, "strftime", lambda form: "NOW")
    with contextlib.ExitStack() as stack:
        made = [stack.enter_context(output_folder(None, "a", tmp_path)) for _ in range(3)]
        assert [path.name for path in made] == ["a-NOW", "a-NOW-2", "a-NOW-3"]
    assert list(tmp_path.iterdir()) == []


def test_a_run_that_is_given_twice_is_locked_once(
    run: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (run.parent / "link").symlink_to(run)
    assert main(["analyse", "free-running", str(run), str(run.parent / "link")]) == 0
    assert main(["analyse", "lesion", str(run), str(run)]) == 2
    assert "is given twice; leave one out" in capsys.readouterr().err


def test_a_place_that_cannot_be_a_folder_is_told(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    for folder in (tmp_path / "file", tmp_path / "file" / "run"):
        expected = "file: is a file, not a folder; remove"
        with pytest.raises(RunFolderError, match=expected), locked(folder):
            pass


def test_a_file_system_without_locks_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fcntl = pytest.importorskip("fcntl")

    def none(*_: object) -> None:
        raise OSError(38, os.strerror(38))

    monkeypatch.setattr(fcntl, "flock", none)
    with (
        pytest.raises(RunFolderError, match=r"a: cannot be written \(Function not implemented\)"),
        locked(tmp_path / "a"),
    ):
        pass
