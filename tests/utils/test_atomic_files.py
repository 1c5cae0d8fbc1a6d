import contextlib
import os
import subprocess
import sys
from pathlib import Path

import pytest

from mpma_mj.commands.folders import check_new_file
from mpma_mj.errors import RunFolderError
from mpma_mj.utils import atomic_files
from mpma_mj.utils.folder_lock import locked

DIE = """
import os, pathlib, signal, sys
from mpma_mj.utils import atomic_files
folder = pathlib.Path(sys.argv[1])
with atomic_files.atomic_write(folder / "a.txt") as file, atomic_files.atomic_folder(
    folder / "b"
) as made:
    file.write_text("half")
    (made / "c").write_text("half")
    os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.fixture
def leftovers(tmp_path: Path) -> Path:
    """Return a folder in which a process died while it wrote a file and a folder."""
    subprocess.run([sys.executable, "-c", DIE, str(tmp_path)], check=False)
    assert len(list(tmp_path.glob(".mpma-*"))) == 2
    return tmp_path


def test_a_write_that_fails_leaves_the_old_file_and_nothing_else(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    atomic_files.write_text(path, "old")
    failure = pytest.raises(RunFolderError, match="No space left on device")
    with failure, atomic_files.atomic_write(path) as temporary:
        temporary.write_text("half")
        raise OSError(28, "No space left on device")
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system does not fork")
def test_a_forked_process_leaves_the_file_to_its_parent(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    with atomic_files.atomic_write(path) as temporary:
        temporary.write_text("new")
        if child := os.fork():
            status = os.waitpid(child, 0)[1]
    if not child:
        os._exit(path.exists())
    assert status == 0
    assert path.read_text() == "new"


def test_a_folder_that_fails_leaves_the_old_one_and_nothing_else(tmp_path: Path) -> None:
    path = tmp_path / "a"
    for content in ("old", "new"):
        with atomic_files.atomic_folder(path) as temporary:
            (temporary / "file").write_text(content)
        assert (path / "file").read_text() == content
    with pytest.raises(ZeroDivisionError), atomic_files.atomic_folder(path):
        raise ZeroDivisionError
    assert (path / "file").read_text() == "new"
    assert list(tmp_path.iterdir()) == [path]


def test_a_folder_that_cannot_take_its_place_leaves_the_old_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "a"
    path.mkdir()
    (path / "old").write_text("")
    rename = Path.rename

    def refuse(source: Path, target: Path) -> Path:
        if target == path and not (source / "old").exists():
            raise OSError(28, "No space left on device")
        return rename(source, target)

    monkeypatch.setattr(Path, "rename", refuse)
    with pytest.raises(RunFolderError, match="No space"), atomic_files.atomic_folder(path) as new:
        (new / "new").write_text("")
    assert [file.name for file in path.iterdir()] == ["old"]
    assert list(tmp_path.iterdir()) == [path]


KILLED = """
import os, pathlib, signal, sys
from mpma_mj.utils.atomic_files import atomic_folder
rename = pathlib.Path.rename
left = [int(sys.argv[2])]
def killed(source, target):
    left[0] -= 1
    if left[0] < 0:
        os.kill(os.getpid(), signal.SIGKILL)
    return rename(source, target)
pathlib.Path.rename = killed
with atomic_folder(pathlib.Path(sys.argv[1])) as new:
    (new / "new").write_text("")
"""


@pytest.mark.parametrize("renames", [0, 1])
def test_of_a_replacement_that_is_killed_the_old_folder_is_left(
    tmp_path: Path, renames: int
) -> None:
    path = tmp_path / "a"
    path.mkdir()
    (path / "old").write_text("")
    subprocess.run([sys.executable, "-c", KILLED, str(path), str(renames)], check=False)
    atomic_files.remove_leftovers(tmp_path)
    assert list(tmp_path.rglob("*")) == [path, path / "old"]


def test_content_reaches_the_disk_before_the_rename(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "a.txt"
    synced: list[tuple[str, bool]] = []

    def fsync(opened: int) -> None:
        synced.append((str(Path(f"/proc/self/fd/{opened}").readlink()), path.exists()))

    monkeypatch.setattr(os, "fsync", fsync)
    atomic_files.write_text(path, "new")
    (file, before), (folder, after) = synced
    assert Path(file).name.endswith("a.txt")
    assert not before
    assert (folder, after) == (str(tmp_path), True)


def test_the_files_of_a_folder_reach_the_disk(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    synced: list[str] = []
    monkeypatch.setattr(
        os, "fsync", lambda opened: synced.append(Path(f"/proc/self/fd/{opened}").readlink().name)
    )
    with atomic_files.atomic_folder(tmp_path / "a") as folder:
        (folder / "in").mkdir()
        (folder / "in" / "file").write_text("new")
    assert synced == ["file", tmp_path.name]


@pytest.mark.parametrize(("number", "written"), [(28, False), (5, False), (22, True)])
def test_a_disk_that_fails_late_keeps_the_old_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: int, written: bool
) -> None:
    path = tmp_path / "a.txt"
    path.write_text("old")

    def fsync(_: int) -> None:
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(os, "fsync", fsync)
    failure = contextlib.nullcontext() if written else pytest.raises(RunFolderError)
    with failure:
        atomic_files.write_text(path, "new")
    assert path.read_text() == ("new" if written else "old")


def test_a_place_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(RunFolderError, match="file: is a file, not a folder; remove it"):
        atomic_files.write_text(tmp_path / "file" / "a.txt", "x")


@pytest.mark.parametrize("name", ["x" * 251 + ".txt", "é" * 120 + ".txt", "\udcff.txt"])
def test_every_name_that_a_file_may_have_can_be_written(tmp_path: Path, name: str) -> None:
    atomic_files.write_text(tmp_path / name, "x")
    assert [path.name for path in tmp_path.iterdir()] == [name]


def test_the_next_command_removes_what_a_killed_one_left(leftovers: Path) -> None:
    with locked(leftovers):
        assert [path.name for path in leftovers.iterdir()] == [".mpma.lock"]


def test_a_lock_removes_what_was_left_one_folder_deeper(leftovers: Path, tmp_path: Path) -> None:
    inner = tmp_path / "run" / "checkpoint"
    inner.parent.mkdir()
    inner.mkdir()
    for path in list(tmp_path.glob(".mpma-*")):
        path.rename(inner / path.name)
    with locked(tmp_path / "run"):
        assert list(inner.iterdir()) == []


def test_a_check_of_a_new_file_removes_what_a_killed_command_left(leftovers: Path) -> None:
    check_new_file("out", leftovers / "a.txt", [".txt"], overwrite=False)
    assert list(leftovers.iterdir()) == []


def test_the_process_of_another_user_is_alive(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def kill(*_: int) -> None:
        raise PermissionError

    with atomic_files.atomic_write(tmp_path / "a") as file:
        file.write_text("")
        monkeypatch.setattr(os, "kill", kill)
        atomic_files.remove_leftovers(tmp_path)
        assert file.exists()


def test_a_number_that_no_process_has_is_of_a_dead_one(tmp_path: Path) -> None:
    with atomic_files.atomic_write(tmp_path / "a") as file:
        file.write_text("")
        dead = file.with_name(file.name.replace(str(os.getpid()), "9" * 30))
        dead.write_text("")
        atomic_files.remove_leftovers(tmp_path)
        assert list(tmp_path.iterdir()) == [file]


def test_what_others_are_writing_stays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with atomic_files.atomic_write(tmp_path / "a") as here:
        here.write_text("")
        monkeypatch.setattr(atomic_files.platform, "node", lambda: "another machine")
        with atomic_files.atomic_write(tmp_path / "b") as elsewhere:
            ended = str(2**22 + 1)  # beyond the largest number of a process
            dead = elsewhere.with_name(elsewhere.name.replace(str(os.getpid()), ended))
            dead.write_text("")
            monkeypatch.undo()
            atomic_files.remove_leftovers(tmp_path)
            assert {path.name for path in tmp_path.iterdir()} == {here.name, dead.name}
            elsewhere.write_text("")
