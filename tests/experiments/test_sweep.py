"""`mpma sweep` as a user types it."""

import csv
import errno
import functools
import json
import os
import shutil
import signal
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from mpma_mj.cli import main
from mpma_mj.errors import BadOptionError
from mpma_mj.experiments.training import Point
from mpma_mj.utils import atomic_files
from tests.experiments.runs import TINY as TINY_CONFIG
from tests.experiments.runs import TINY_WORDS, mpma, run_files, sweep_of

TINY = [*TINY_WORDS]
NO_NODES = TINY[2:]


def sweep(*words: object, out: Path) -> int:
    return main(["sweep", *map(str, words), "--out", str(out)])


def table(path: Path) -> list[dict[str, str]]:
    with path.open() as file:
        return list(csv.DictReader(file))


def test_a_sweep_writes_and_prints_its_table(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "sweep"
    grid = ["--grid", "nodes=5,6", "context_signal=halves,labels"]
    words = [*grid, "--runs", 2, "--seed", 3, *NO_NODES]
    assert sweep(*words, out=out) == 0
    printed = capsys.readouterr()
    *lines, empty, last = printed.out.splitlines()
    assert last == str(out)
    assert empty == ""
    assert lines == (out / "table.md").read_text().splitlines()
    assert lines[0].startswith(
        "| nodes | context-signal | converged | epochs | p_e, % | feedback ratio | learned share |"
    )
    assert [line.split(" | ")[:3] for line in lines[2:]] == [
        ["| 5", "halves", "0 of 2"],
        ["| 5", "labels", "0 of 2"],
        ["| 6", "halves", "0 of 2"],
        ["| 6", "labels", "0 of 2"],
    ]
    assert printed.err.splitlines()[-1].startswith("   8 of 8 runs   nodes 5, context_signal ")
    rows = table(out / "results.csv")
    assert [(r["nodes"], r["context_signal"], r["seed"]) for r in rows[:3]] == [
        ("5", "halves", "3"),
        ("5", "halves", "4"),
        ("5", "labels", "3"),
    ]
    mean = sum(float(row["p_e_percent"]) for row in rows[:2]) / 2
    assert f"| {mean:.2f} ± " in lines[2]


def test_a_run_of_a_sweep_is_the_run_of_imitate(tmp_path: Path) -> None:
    assert sweep("ymca", "--runs", 2, *TINY, out=tmp_path / "sweep") == 0
    alone = [*TINY, "--seed", "1", "--no-video", "--out", str(tmp_path / "run")]
    assert main(["imitate", "ymca", *alone]) == 0
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    (of_sweep,) = json.loads(run_files(tmp_path / "sweep")[1].read_text())["records"]
    own = {"agent", "seed", "diverged", "seconds"}
    measures = {name: value for name, value in of_sweep.items() if name not in own}
    assert measures == {name: summary[name] for name in measures}
    assert measures["p_e_percent"] > 0


GRID = ["--grid", "nodes=" + ",".join(str(nodes) for nodes in range(20, 28)), "--runs", 1]


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a sweep that was never interrupted."""
    out = tmp_path_factory.mktemp("sweeps") / "whole"
    assert sweep(*GRID, *NO_NODES, out=out) == 0
    return out


def descendants(pid: int) -> list[int]:
    """Return the processes that a process has started, and those that these have started."""
    try:
        children = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
    except OSError:
        return []
    return [found for child in map(int, children) for found in (child, *descendants(child))]


@pytest.mark.parametrize("kill", [signal.SIGKILL, signal.SIGINT, signal.SIGTERM])
def test_a_sweep_that_is_killed_leaves_no_worker_and_goes_on_where_it_was(
    tmp_path: Path, whole: Path, kill: signal.Signals, capsys: pytest.CaptureFixture[str]
) -> None:
    words = [*GRID, *NO_NODES, "--workers", 1]
    out = tmp_path / "killed"
    heeds = functools.partial(signal.signal, signal.SIGINT, signal.SIG_DFL)  # whoever runs tests
    command = mpma("sweep", *words, "--out", out, preexec_fn=heeds)
    while not run_files(out):
        assert command.poll() is None, command.communicate()
        time.sleep(0.005)
    workers = descendants(command.pid)
    os.kill(command.pid, kill)
    errors = command.communicate()[1]
    until = time.monotonic() + 60  # they may finish what they are at
    while any(Path(f"/proc/{pid}").exists() for pid in workers):
        assert time.monotonic() < until
        time.sleep(0.05)
    before = len(run_files(out))
    assert 0 < before < 8
    if kill != signal.SIGKILL:
        assert command.returncode == 128 + kill, errors
        assert errors.splitlines()[-2:] == [
            f"mpma: to resume: the same command with --out {out}",
            "mpma: interrupted",
        ]
    assert "Traceback" not in errors
    assert sweep(*words, out=out) == 0
    assert capsys.readouterr().err.splitlines()[0] == f"resuming: {before} of 8 runs are done"
    for name in ("results.csv", "table.md"):
        assert (out / name).read_text() == (whole / name).read_text()


def test_started_again_a_sweep_trains_nothing_and_prints_the_same(
    whole: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    table = (whole / "table.md").read_text()
    times = [path.stat().st_mtime_ns for path in run_files(whole)]
    assert sweep(*GRID, *NO_NODES, out=whole) == 0
    again = capsys.readouterr()
    assert again.out == f"{table}\n{whole}\n"
    assert again.err == "resuming: 8 of 8 runs are done\n"
    assert [path.stat().st_mtime_ns for path in run_files(whole)] == times


@pytest.mark.parametrize("name", ["table.md", "results.csv"])
def test_a_disk_that_is_full_at_the_end_is_one_line(
    tmp_path: Path,
    whole: Path,
    name: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    write_text: Callable[..., int] = atomic_files.Path.write_text

    def full(path: Path, *args: Any, **options: Any) -> int:
        if path.suffix == Path(name).suffix:
            raise OSError(errno.ENOSPC, "No space left on device")
        return write_text(path, *args, **options)

    monkeypatch.setattr(atomic_files.Path, "write_text", full)
    shutil.copytree(whole, tmp_path, dirs_exist_ok=True)
    assert sweep(*GRID, *NO_NODES, out=tmp_path) == 2
    message = capsys.readouterr().err.splitlines()[-1]
    assert message.startswith(f"mpma: {tmp_path / name}: cannot be written (No space left")


def test_an_unknown_agent_is_named_with_the_grid() -> None:
    with pytest.raises(BadOptionError, match="grid has agent 'nobody'; expected one of mpma"):
        sweep_of("agent=nobody").points()


@pytest.mark.filterwarnings("ignore::mpma_mj.errors.RecordingWarning")
@pytest.mark.parametrize("axis", ["robot=two_arm,cmu_humanoid", "control_timestep=0.05,0.025"])
def test_a_motion_is_read_for_its_robot_and_rate(axis: str) -> None:
    one, other = (job.motion for job in sweep_of(axis, "arms=kinematic").jobs())
    assert (one.angles_of, one.rate) != (other.angles_of, other.rate)


def test_what_varies_is_found_also_where_only_some_agents_have_it() -> None:
    (labels, _), *_ = sweep_of("context_signal=halves,labels").points()
    assert labels == {"context_signal": "halves"}
    points = sweep_of("agent=mpma,random", "nodes=5,6").points()
    assert [tuple(labels.values()) for labels, _ in points] == [
        ("mpma", 5),
        ("mpma", 6),
        ("random", None),
    ]
    assert sweep_of().points() == [Point({}, TINY_CONFIG)]


def test_without_out_a_sweep_goes_below_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["sweep", "--runs", "1", *TINY]) == 0
    folder = Path(capsys.readouterr().out.splitlines()[-1])
    assert folder.parent == Path("runs")
    assert folder.name.startswith("sweep-20")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--runs", "0"], "runs is 0"),
        (["--epochs", "0"], "epochs is 0"),
        (["--workers", "0"], "workers is 0"),
        (["--grid", "nodes=0"], "nodes is 0"),
        (["--grid", "node=5"], "did you mean nodes?"),
        (["--grid", "nodes=5", "ymca"], "put motions before --grid"),
        (["--seed", "-1"], "seed is -1"),
        (["--address", "head:6379"], "add --backend ray, or leave"),
        (["macarena"], "no motion 'macarena'"),
        (["ymca", "gone.tsv"], "gone.tsv"),
    ],
)
def test_bad_input_is_one_line_exit_2_and_no_folder(
    words: list[str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert sweep(*words, out=tmp_path / "new") == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert len(printed.err.splitlines()) == 1
    assert message in printed.err
    assert not (tmp_path / "new").exists()
