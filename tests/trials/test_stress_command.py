"""The command `mpma stress` as a user types it."""

import csv
import json
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from mpma_mj.cli import main
from mpma_mj.experiments.backend import Processes, Work
from mpma_mj.training.run_folder import RunFolder
from mpma_mj.utils import atomic_files
from tests.conftest import Refused

QUICK = ["--disturbances", "payload", "--levels", "0", "3"]


@pytest.fixture
def run(tiny_run: Path, tmp_path: Path) -> Path:
    """Return a copy of a finished run."""
    return shutil.copytree(tiny_run, tmp_path / "run")


def rows(path: Path) -> list[dict[str, str]]:
    with path.open() as file:
        return list(csv.DictReader(file))


def test_a_run_and_all_agents_get_a_table_and_a_figure(run: Path) -> None:
    words = f"stress {run} --runs 1 --epochs 8 --disturbances gravity".split()
    result = subprocess.run(
        [sys.executable, "-m", "mpma_mj.cli", *words], capture_output=True, text=True, check=False
    )
    assert result.returncode == 0, result.stderr
    assert "  14 of 14 trials   " in result.stderr.splitlines()[-1]
    lines = result.stdout.splitlines()
    assert lines[0] == (
        "| disturbance | level | mpma | single | mosaic | hammer | resolved rate | feedback only |"
        " this run |"
    )
    (folder,) = (run / "stress").iterdir()
    assert lines[-1] == str(folder)
    names = ["stress.csv", "stress.md", "stress.png"]
    assert sorted(path.name for path in folder.iterdir()) == names
    assert result.stdout.startswith((folder / "stress.md").read_text())
    found = rows(folder / "stress.csv")
    assert {row["seed"] for row in found} == {"4"}
    p_e = {(row["agent"], row["level"]): row["p_e_percent"] for row in found}
    assert len(p_e) == len(found) == 7 * 2
    # The run's own agent is that of its seed among the others; no two others are alike.
    assert len(set(p_e.values())) == 6 * 2
    for level in ("on", "off"):
        assert p_e["mpma", level] == p_e["this run", level]


def test_the_runs_own_agent_is_that_of_its_seed_and_workers_change_nothing(
    run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    tables = []
    for workers in ("1", "3"):
        out = tmp_path / workers
        words = ["--agents", "mpma", "--runs", "2", "--epochs", "8", "--adapt"]
        words += ["--adapt-epochs", "1", "--workers", workers, "--out", str(out), *QUICK]
        assert main(["stress", str(run), *words]) == 0
        assert capsys.readouterr().out.splitlines()[-1] == str(out)
        tables.append({p.name: p.read_bytes() for p in out.iterdir() if p.suffix != ".png"})
    assert tables[0] == tables[1]
    assert {"stress.csv", "stress.md", "adapt.csv"} == tables[0].keys()
    for name in ("stress.csv", "adapt.csv"):
        twins = [
            [list(row.values())[1:] for row in rows(out / name) if row["agent"] == agent]
            for agent in ("mpma", "this run")
        ]
        assert twins[1] == [row for row in twins[0] if row[2] == "4"]
        assert len(twins[0]) == 2 * len(twins[1]) > 0
    learned = rows(out / "adapt.csv")
    assert {row["epochs_learned"] for row in learned} == {"0", "1"}
    assert (out / "adapt.png").exists()


def test_levels_of_a_run_with_plants_are_those_of_its_arms(
    tmp_path: Path,
) -> None:
    words = (
        f"imitate ymca --repeats 1 --epochs 1 --no-video --plants payload=1 --out {tmp_path}/run"
    )
    assert main(words.split()) == 0
    assert main(["stress", str(tmp_path / "run"), "--runs", "0", *QUICK]) == 0
    (folder,) = (tmp_path / "run" / "stress").iterdir()
    light, heavy = (float(row["p_e_percent"]) for row in rows(folder / "stress.csv"))
    assert light < heavy


def test_each_look_has_a_folder_and_replaces_what_is_in_one_that_is_named(
    run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["stress", str(run), "--runs", "0", *QUICK]
    out = tmp_path / "out"
    adapt = ["--adapt", "--adapt-epochs", "1"]
    assert main([*words, *adapt, "--out", str(out)]) == 0
    assert (out / "adapt.csv").exists()
    assert main([*words, "--out", str(out)]) == 0
    assert not (out / "adapt.csv").exists()
    assert len(rows(out / "stress.csv")) == 2
    assert main(words) == main(words) == 0
    assert len(list((run / "stress").iterdir())) == 2
    assert "seeds" not in capsys.readouterr().out.splitlines()[-3]


def test_a_run_of_another_epoch_has_not_been_stressed(run: Path) -> None:
    (run / "stress").mkdir()
    RunFolder(run).forget_epoch()
    assert not (run / "stress").exists()
    (run / "stress").mkdir()
    words = "imitate ymca --nodes 10 --epochs 1 --no-video --overwrite --out"
    assert main([*words.split(), str(run)]) == 0
    assert not (run / "stress").exists()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (
            ["--disturbances", "wind"],
            "no disturbance 'wind'; expected some of payload, strength",
        ),
        (["--disturbances", "payload", "--levels", "0", "-1"], "payload is -1.0; expected 0"),
        (["--levels", "1"], "levels are those of one disturbance; name it with --disturbances"),
        (["--unseen", "gone.bvh"], "gone.bvh: no such file; give the path of a recording"),
        (["--unseen", "ymca", *QUICK], "dances are given that are not to be tried; drop --unseen"),
        (["--runs", "-1"], "runs is -1; expected at least 0"),
        (["--runs", "0", "--agents", "mpma"], "runs is 0, so no agents are trained"),
        (["--epochs", "0"], "epochs is 0; expected at least 1"),
        (["--adapt", "--adapt-epochs", "0"], "adapt-epochs is 0; expected at least 1"),
        (["--adapt-epochs", "3"], "adapt-epochs is given without --adapt"),
        (
            ["--disturbances", "strength", "--levels", "0"],
            "strength 0.0: actuator_strength is 0.0;",
        ),
        (["--disturbances", "latency", "--levels", "1.5"], "latency 1.5: latency is 1.5; expected"),
        (["--disturbances", "noise", "--levels", "101"], "noise 101.0: observation_noise is 1.01"),
        (
            ["--disturbances", "pushes", "--levels", "-5"],
            "pushes -5.0: perturbation is (1.0, -5.0)",
        ),
        (["--disturbances", "tempo", "--levels", "0"], "tempo"),
        (
            ["--disturbances", "locked", "--levels", "knee"],
            "locked has no level 'knee'; expected",
        ),
        (
            ["--disturbances", "gravity", "--levels", "half"],
            "gravity has no level 'half'",
        ),
        (["--disturbances", "payload", "--levels", "nan"], "payload has no level 'nan'; expected"),
        (["--workers", "0"], "workers is 0; expected at least 1"),
        (["--adapt", "--agents", "hammer"], "hammer learns nothing more; leave it out"),
        (["--adapt", "--agents", "mpma", "feedback_only"], "feedback_only learns nothing more"),
    ],
)
def test_bad_input_is_one_line_and_exit_2(
    words: list[str], message: str, run: Path, refused: Refused
) -> None:
    refused(["stress", str(run), *words], message)
    assert not (run / "stress").exists()


def test_an_output_that_cannot_be_is_told_before_the_work(run: Path, refused: Refused) -> None:
    refused(["stress", str(run), "--out", str(run / "config.json")], "config.json: ")


def test_no_run_and_damaged_runs_are_one_line_and_exit_2(
    run: Path, tmp_path: Path, refused: Refused
) -> None:
    refused(["stress", str(tmp_path / "gone")], "no run there")
    for name in ("checkpoint/motion.npz", "checkpoint/best.npz", "config.json"):
        (run / name).write_bytes(b"rubbish")  # each is read before the one before
        refused(["stress", str(run)], f"{name}: damaged")


def test_a_run_of_another_version_is_one_line_and_exit_2(run: Path, refused: Refused) -> None:
    content = json.loads((run / "config.json").read_text())
    atomic_files.write_json(run / "config.json", content | {"format": 1})
    refused(["stress", str(run)], "config.json: format 1, written by mpma-mj")


def test_a_run_that_learns_nothing_more_does_not_adapt(tmp_path: Path, refused: Refused) -> None:
    out = tmp_path / "hammer"
    words = "imitate ymca --agent hammer --nodes 5 --repeats 1 --epochs 4 --no-video --out"
    assert main([*words.split(), str(out)]) == 0
    refused(["stress", str(out), "--adapt"], "its agent is hammer, which learns nothing more")
    assert main(["stress", str(out), "--runs", "0", *QUICK]) == 0


def test_a_worker_that_dies_time_and_again_is_one_line_and_exit_1(
    run: Path, refused: Refused, monkeypatch: pytest.MonkeyPatch
) -> None:
    def lose(self: Processes) -> tuple[Work, Any]:
        worker, work = self._busy.pop(next(iter(self._busy)))
        worker.end()
        return work, None

    monkeypatch.setattr(Processes, "next_done", lose)
    refused(["stress", str(run), "--runs", "0"], "a worker that tried this run died", code=1)
