"""The command `mpma capture` as a user types it."""

import json
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from mpma_mj.cli import main
from mpma_mj.kinematics import JOINT_NAMES, SEGMENT_NAMES
from mpma_mj.utils import atomic_files
from tests.conftest import Refused

Arrays = dict[str, np.ndarray]


@pytest.fixture
def run(small_run: Path, tmp_path: Path) -> Path:
    """Return a copy of a finished run of three modules."""
    return shutil.copytree(small_run, tmp_path / "run")


def change_trace(run: Path, change: Callable[[Arrays], Arrays]) -> None:
    trace, _ = atomic_files.read_arrays(run / "trace.npz", "trace")
    atomic_files.write_arrays(run / "trace.npz", "trace", change(trace), {"epoch": 1})


def test_a_run_gets_tables_json_and_a_figure(run: Path) -> None:
    result = subprocess.run(
        [sys.executable, "-m", "mpma_mj.cli", "capture", str(run)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.returncode == 0, result.stderr
    assert result.stderr == "looking for synergies\n"
    lines = result.stdout.splitlines()
    assert lines[-1] == str(run / "figures" / "capture.png")
    assert lines[0] == "| share of, % | module 1 | module 2 | module 3 |"
    assert (run / "figures" / "capture.png").read_bytes().startswith(b"\x89PNG")
    assert sum("|---" in line for line in lines) == 5
    content = json.loads((run / "capture.json").read_text())
    shares = content["shares"]
    assert list(shares["label"]) == ["Y", "M", "C", "A"]
    assert list(shares["joint"]) == list(JOINT_NAMES)
    assert list(shares["segment"]) == list(SEGMENT_NAMES)
    for rows in shares.values():
        for share in rows.values():
            assert sum(share) == pytest.approx(1.0)
    assert set(content["told"]["bits"]) == set(content["told"]["r2"])
    assert np.shape(content["synergies"]["loads"])[1] == 3


def test_a_run_of_one_module_leaves_nothing_to_tell(
    run: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def one(trace: Arrays) -> Arrays:
        modular = ("responsibility", "prior", "module_actions", "predictions")
        first = {name: trace[name][:, :1] for name in modular}
        return trace | first | {"responsibility": np.ones((len(trace["action"]), 1))}

    change_trace(run, one)
    assert main(["capture", str(run)]) == 0
    printed = capsys.readouterr().out
    assert "| context | – | – | 0.00 | 0.00 | – |" in printed
    assert "| label Y | 100 |" in printed


def test_a_later_look_gives_the_same_numbers(run: Path) -> None:
    assert main(["capture", str(run)]) == 0
    first = (run / "capture.json").read_bytes()
    assert main(["capture", str(run)]) == 0
    assert (run / "capture.json").read_bytes() == first


def test_overwriting_a_run_removes_what_was_told_about_it(run: Path) -> None:
    assert main(["capture", str(run)]) == 0
    words = "imitate ymca --nodes 10 --epochs 1 --no-video --overwrite --out"
    assert main([*words.split(), str(run)]) == 0
    assert not (run / "capture.json").exists()


def without_modules(trace: Arrays) -> Arrays:
    agents_own = ("responsibility", "prior", "module_actions", "predictions")
    return {name: signal for name, signal in trace.items() if name not in agents_own}


def silent(trace: Arrays) -> Arrays:
    return trace | {"module_actions": np.zeros_like(trace["module_actions"])}


def shorter(trace: Arrays) -> Arrays:
    return {name: signal[:-5] for name, signal in trace.items()}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (without_modules, "its agent has no modules; choose a run of MPMA"),
        (silent, "its modules put out nothing in the kept epoch; go on with mpma imitate --resume"),
        (shorter, "moments, but ymca repeated 3 times has"),
    ],
)
def test_a_trace_that_does_not_fit_is_one_line_and_exit_2(
    run: Path,
    change: Callable[[Arrays], Arrays],
    message: str,
    refused: Refused,
) -> None:
    change_trace(run, change)
    refused(["capture", str(run)], message)
    assert not (run / "capture.json").exists()


@pytest.mark.parametrize("name", ["trace.npz", "config.json", "checkpoint/motion.npz"])
def test_a_damaged_run_is_one_line_and_exit_2(run: Path, name: str, refused: Refused) -> None:
    (run / name).write_bytes(b"rubbish")
    refused(["capture", str(run)], f"{name}: damaged")
    assert not (run / "capture.json").exists()


def test_a_folder_without_a_run_is_one_line_and_exit_2(tmp_path: Path, refused: Refused) -> None:
    refused(["capture", str(tmp_path)], "no run there")
    refused(["capture", str(tmp_path / "gone")], "no run there")
    assert list(tmp_path.iterdir()) == []
