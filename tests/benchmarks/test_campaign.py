"""That the campaign kills where it says, and sees what was lost, left over or invented."""

from __future__ import annotations

import signal
from pathlib import Path

import numpy as np
import pytest

from benchmarks.campaign.children import Ended, in_fork
from benchmarks.campaign.continuation import _following
from benchmarks.campaign.faults import Fault, Part, report
from benchmarks.campaign.file_operations import die_at, list_operations
from benchmarks.campaign.folder_damage import damage
from benchmarks.campaign.kills import verdict
from benchmarks.campaign.snapshots import differences, snapshot
from benchmarks.campaign.workers import spread
from mpma_mj.utils.atomic_files import write_text


def write() -> int:
    write_text(Path("work/a/new.txt"), "content")
    return 0


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "work").mkdir()
    return tmp_path


def operations(folder: Path) -> list[str]:
    def listed() -> int:
        list_operations(Path("work"), folder / "listed")
        return write()

    assert in_fork(listed, folder).code == 0
    return (folder / "listed").read_text().split()


def killed(folder: Path, number: int, *, torn: bool = False) -> Ended:
    def dying() -> int:
        die_at(Path("work"), number, torn=torn)
        return write()

    return in_fork(dying, folder)


def test_changes_of_files_are_numbered_in_their_order(folder: Path) -> None:
    assert operations(folder)[:4] == ["os.mkdir", "open", "os.fsync", "os.rename"]


@pytest.mark.parametrize(
    ("number", "found"), [(0, []), (1, [""]), (2, ["content"]), (3, ["content"])]
)
def test_a_process_dies_before_a_change(folder: Path, number: int, found: list[str]) -> None:
    assert killed(folder, number).code == -signal.SIGKILL
    files = [path for path in (folder / "work").rglob("*") if path.is_file()]
    assert [path.read_text() for path in files] == [one for one in found if one]
    assert not (folder / "work" / "a" / "new.txt").exists()


def test_a_torn_file_has_a_beginning(folder: Path) -> None:
    killed(folder, 1, torn=True)
    (file,) = (path for path in (folder / "work").rglob("*") if path.is_file())
    assert file.read_text().startswith('{"torn"')


def test_a_process_that_hangs_is_ended(tmp_path: Path) -> None:
    assert in_fork(lambda: signal.pause() or 0, tmp_path, seconds=0.2).code is None


def test_an_exception_is_no_refusal(tmp_path: Path) -> None:
    def failing() -> int:
        raise ValueError("of the campaign's test")

    ended = in_fork(failing, tmp_path)
    assert not ended.is_refusal
    assert "Traceback" in ended.err


def test_what_is_lost_left_over_or_other_is_seen(tmp_path: Path) -> None:
    for name in ("lost", "other"):
        (tmp_path / name).write_text("1")
    before = snapshot(tmp_path)
    (tmp_path / "lost").rename(tmp_path / ".mpma-left")
    (tmp_path / "other").write_text("2")
    found = "missing: lost; left over: .mpma-left; different: other"
    assert differences(before, snapshot(tmp_path)) == found
    assert verdict([Ended(0, "", "")], before, tmp_path) == found


def test_seconds_are_no_result(tmp_path: Path) -> None:
    (tmp_path / "one.json").write_text('{"p_e": 1, "seconds": 2}')
    before = snapshot(tmp_path)
    (tmp_path / "one.json").write_text('{"p_e": 1, "seconds": 3}')
    assert snapshot(tmp_path) == before


def test_a_refusal_that_names_no_way_is_a_fault(tmp_path: Path) -> None:
    ended = Ended(2, "", "mpma: run: is not empty\n")
    assert verdict([ended], {}, tmp_path).startswith("no way to go on")
    words = ["imitate", "ymca", "--out", "run"]
    message = "mpma: run: exists; --overwrite replaces it"
    assert _following(words, words, message) == [*words, "--overwrite"]
    message = f"{message}, --resume continues it"
    assert _following(words, words, message) == ["imitate", "--resume", "run", "--no-video"]


@pytest.mark.parametrize("crafted", [True, False])
def test_damage_changes_one_file_and_repeats(tmp_path: Path, crafted: bool) -> None:
    found = []
    for place in ("one", "two"):
        run = tmp_path / place
        run.mkdir()
        (run / "a.json").write_text('{"a": 1, "b": [2, 3]}')
        np.savez(run / "b.npz", meta=np.array("{}"), array=np.arange(3.0))
        before = snapshot(run)
        rng = np.random.default_rng(5)
        kind = damage(run, ("a.json", "b.npz"), run, rng, crafted=crafted)
        assert crafted or not kind.startswith("crafted")
        assert snapshot(run) != before
        found.append((kind, snapshot(run)))
    assert found[0] == found[1]


def test_faults_of_all_workers_are_gathered() -> None:
    def do(number: int) -> list[Fault]:
        return [Fault("odd", str(number))] if number % 2 else []

    done, faults = spread(range(10), do, workers=2, seconds=60.0)
    assert done == 10
    assert sorted(fault.repeat for fault in faults) == ["1", "3", "5", "7", "9"]


def test_faults_and_figures_are_reported() -> None:
    text = report([Part("kills", 5, 10, [Fault("lost", "seed 3")]), Part("leaks", 2, None, [])])
    assert "- kills: lost — seed 3" in text
    assert "| kills | 5 of 10 | 1 |" in text
