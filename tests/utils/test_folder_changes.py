"""Changes of several files of a folder: all or none, whatever happens, and never outside of it."""

import contextlib
import os
import re
import shutil
from pathlib import Path

import pytest

from benchmarks.campaign.snapshots import snapshot
from mpma_mj.errors import RunFolderError
from mpma_mj.utils import data_files
from mpma_mj.utils.atomic_files import not_writable, write_text
from mpma_mj.utils.folder_changes import changes, is_unfinished
from mpma_mj.utils.folder_lock import finish_changes, is_empty, locked
from tests.killed import killed_at

GONE = ("stale.json", "figures/", "figures/a.png", "missing.json", "b/two")
SAVED = ".mpma.saved"
IS_ROOT = hasattr(os, "geteuid") and os.geteuid() == 0


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return a folder with files that are replaced, that go, and that stay."""
    folder = tmp_path / "folder"
    for name in ("a", "b/one", "b/kept", "stale.json", "figures/a.png", "mine.txt"):
        write_text(folder / name, "old")
    return folder


def change(folder: Path) -> None:
    with changes(folder, GONE) as new:
        for name in ("a", "b/one", "b/two", "c/d/three"):
            write_text(new / name, "new")


def test_files_take_their_places_and_others_go_or_stay(folder: Path) -> None:
    change(folder)
    files = {str(p.relative_to(folder)): p.read_text() for p in folder.rglob("*") if p.is_file()}
    new, old = ("a", "b/one", "b/two", "c/d/three"), ("b/kept", "mine.txt")
    assert files == dict.fromkeys(new, "new") | dict.fromkeys(old, "old")
    assert not (folder / "figures").exists()


def test_after_a_kill_at_any_change_of_a_file_all_are_changed_or_none(folder: Path) -> None:
    before, copy = snapshot(folder), folder.parent / "copy"
    states = []
    for number in range(100):
        shutil.copytree(folder, copy)
        with killed_at(number) as done, locked(copy):
            change(copy)
        decided = is_unfinished(copy)
        finish_changes(copy)  # for what is read without the lock
        is_old = (copy / "a").read_text() == "old"
        assert not (decided and is_old)
        with locked(copy):
            pass
        states.append(snapshot(copy))
        assert (states[-1] == before) == is_old
        shutil.rmtree(copy)
        if len(done) < number:
            break
    change(folder)
    after = snapshot(folder)
    number = states.index(after)
    assert 0 < number < len(states) - 5
    assert all(state == before for state in states[:number])
    assert all(state == after for state in states[number:])


def test_a_folder_with_changes_to_be_made_is_not_empty(folder: Path) -> None:
    (folder.parent / "new" / SAVED).mkdir(parents=True)
    assert not is_empty(folder.parent / "new")


def refuse(folder: Path, message: str) -> None:
    """Check that the changes are refused, and none is made."""
    before = snapshot(folder)
    with pytest.raises(RunFolderError, match=message):
        change(folder)
    assert snapshot(folder) == before


@pytest.mark.parametrize(
    ("name", "kind", "message"),
    [
        *(("a", "folder", "a: is a folder"), ("c", "file", "c: is a file, not a folder")),
        *(("stale.json", "folder", "stale.json: is a folder"), ("figures", "file", "is a file")),
        *(("c", "link", "c: leads out of"), ("figures", "pipe", "cannot be written")),
    ],
)
def test_what_is_in_the_way_is_named_before_anything_is_changed(
    folder: Path, name: str, kind: str, message: str
) -> None:
    path = folder / name
    with contextlib.suppress(FileNotFoundError):
        path.rename(folder.parent / "elsewhere")
    if kind == "link":
        (folder.parent / "outside").mkdir()
        path.symlink_to(folder.parent / "outside")
    else:
        {"folder": os.mkdir, "file": Path.touch, "pipe": os.mkfifo}[kind](path)
    refuse(folder, message)


@pytest.mark.skipif(IS_ROOT, reason="everything can be written")
def test_a_folder_that_cannot_be_written_is_named_before_anything_is_changed(folder: Path) -> None:
    (folder / "b").chmod(0o500)
    refuse(folder, "b: cannot be written")


def test_a_full_disk_changes_nothing_and_names_the_file(folder: Path) -> None:
    before = snapshot(folder)
    message = re.escape(f"{folder / 'b' / 'one'}: cannot be written (No space left")
    failure = pytest.raises(RunFolderError, match=f"^{message}")
    with failure, changes(folder, GONE) as new:
        write_text(new / "a", "new")
        raise not_writable(new / "b" / "one", OSError(28, "No space left on device"))
    assert snapshot(folder) == before


@pytest.mark.parametrize(
    "gone",
    [
        *(["../victim"], ["link/victim"], [""], ["."], [1], 1, None, [["a"]], ["x" * 5000]),
        ["/nowhere/victim"],
    ],
)
def test_what_somebody_else_has_decided_reaches_nothing_outside(folder: Path, gone: object) -> None:
    victim = folder.parent / "victim"
    victim.write_text("precious")
    (folder / "link").symlink_to(folder.parent)
    data_files.write_json(folder / SAVED / "gone.json", {"gone": gone})
    before = snapshot(folder.parent)
    for _ in range(2):
        with pytest.raises(RunFolderError):
            finish_changes(folder)
    assert snapshot(folder.parent) == before


def test_no_file_is_moved_through_a_link(folder: Path) -> None:
    victim = folder.parent / "victim"
    victim.write_text("precious")
    (folder / "link").symlink_to(folder.parent)
    write_text(folder / SAVED / "link" / "victim", "bad")
    data_files.write_json(folder / SAVED / "gone.json", {"gone": []})
    with pytest.raises(RunFolderError, match="link: leads out of"):
        finish_changes(folder)
    assert victim.read_text() == "precious"


@pytest.mark.parametrize("text", ["", "{}", "[]", None])
def test_damaged_changes_are_refused_in_one_line(folder: Path, text: str | None) -> None:
    (folder / SAVED).mkdir()
    if text is not None:
        (folder / SAVED / "gone.json").write_text(text)
    with pytest.raises(RunFolderError, match=r"\.mpma\.saved: damaged; remove it"):
        finish_changes(folder)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system does not fork")
def test_a_forked_process_leaves_the_changes_to_its_parent(folder: Path) -> None:
    before = snapshot(folder)
    with changes(folder, GONE) as new:
        write_text(new / "a", "new")
        if child := os.fork():
            status = os.waitpid(child, 0)[1]
    if not child:
        os._exit((folder / "a").read_text() != "old")
    assert status == 0
    assert snapshot(folder) != before
