"""The command `mpma free-running` as a user types it."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from mpma_mj.cli import main
from mpma_mj.utils import atomic_files
from tests.conftest import Refused

TITLE = "running without demonstration"


@pytest.fixture
def run(small_run: Path, tmp_path: Path) -> Path:
    """Return a copy of a finished run."""
    return shutil.copytree(small_run, tmp_path / "run")


def test_a_run_gets_a_table_json_and_a_figure(run: Path) -> None:
    words = [sys.executable, "-m", "mpma_mj.cli", "free-running", str(run)]
    result = subprocess.run(words, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    assert result.stderr == "running without demonstration\n"
    lines = result.stdout.splitlines()
    assert lines[-1] == str(run / "figures" / "free_running.png")
    assert lines[0].startswith("| run | held, s | near, s | p_e 1 s, % |")
    assert lines[2].startswith(f"| {run}, own prediction | ")
    assert lines[3].startswith(f"| {run}, anticipation | ")
    assert (run / "figures" / "free_running.png").read_bytes().startswith(b"\x89PNG")
    content = json.loads((run / "free_running.json").read_text())
    own, anticipated = content["own prediction"], content["anticipation"]
    for found in (own, anticipated):
        assert list(found["p_e_percent"]) == ["1 s", "2 s", "5 s", "all"]
        assert found["ending"] in ("standstill", "cycle", "wandering")
    # It has learned the motion: released, it is for a moment where the demonstration is.
    assert 0.1 < own["held_s"] <= own["near_s"] < 5.0
    assert content["beat_s"] is None
    assert anticipated["held_s"] == pytest.approx(15 * 3.8)
    assert anticipated["p_e_percent"]["all"] < 1.0
    assert anticipated["ending"] == "cycle"


def test_a_finer_clock_has_as_many_parts_as_beats(run: Path) -> None:
    assert main(["free-running", str(run), "--beat", "0.5"]) == 0
    content = json.loads((run / "free_running.json").read_text())
    assert content["beat_s"] == 0.5
    assert content["anticipation"]["held_s"] == pytest.approx(15 * 3.8)


@pytest.mark.parametrize("beat", ["0.04", "3.9", "nan"])
def test_a_beat_is_a_step_at_least_and_a_repetition_at_most(
    run: Path, beat: str, refused: Refused
) -> None:
    message = f"--beat is {beat}; expected 0.05 to 3.8 s, a control step to a repetition"
    refused(["free-running", str(run), "--beat", beat], message, title=TITLE)
    assert not (run / "free_running.json").exists()


def test_several_runs_have_a_row_each_and_a_later_look_tells_the_same(
    run: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    again = shutil.copytree(run, run.parent / "again")
    capsys.readouterr()
    assert main(["free-running", str(run), str(again)]) == 0
    rows = capsys.readouterr().out.splitlines()[2:6]
    assert [row.replace(f"{run}, ", "") for row in rows[:2]] == [
        row.replace(f"{again}, ", "") for row in rows[2:]
    ]
    assert (run / "free_running.json").read_bytes() == (again / "free_running.json").read_bytes()


def test_overwriting_a_run_removes_what_was_told_about_it(run: Path) -> None:
    atomic_files.write_json(run / "free_running.json", {})
    words = "imitate ymca --nodes 10 --epochs 1 --no-video --overwrite --out"
    assert main([*words.split(), str(run)]) == 0
    assert not (run / "free_running.json").exists()


@pytest.mark.parametrize(
    "name", ["config.json", "trace.npz", "checkpoint/motion.npz", "checkpoint/best.npz"]
)
def test_a_damaged_run_is_one_line_and_exit_2(run: Path, name: str, refused: Refused) -> None:
    (run / name).write_bytes(b"rubbish")
    refused(["free-running", str(run)], f"{name}: damaged", title=TITLE)
    assert not (run / "free_running.json").exists()


def test_a_checkpoint_that_lacks_something_is_one_line_and_exit_2(
    run: Path, refused: Refused
) -> None:
    path = run / "checkpoint" / "best.npz"
    arrays, meta = atomic_files.read_arrays(path, "checkpoint")
    del arrays["forward.weights"]
    atomic_files.write_arrays(path, "checkpoint", arrays, meta)
    refused(
        ["free-running", str(run)], "the checkpoint lacks forward.weights; train again", title=TITLE
    )


def test_a_checkpoint_of_other_sizes_is_one_line_and_exit_2(run: Path, refused: Refused) -> None:
    path = run / "checkpoint" / "best.npz"
    arrays, meta = atomic_files.read_arrays(path, "checkpoint")
    arrays["forward.weights"] = np.zeros((2, 3))
    atomic_files.write_arrays(path, "checkpoint", arrays, meta)
    refused(
        ["free-running", str(run)],
        "the checkpoint does not fit its config; train again",
        title=TITLE,
    )


def test_an_agent_without_forward_models_is_one_line_and_exit_2(
    run: Path, refused: Refused
) -> None:
    config = json.loads((run / "config.json").read_text())
    config["config"]["agent"] = {"name": "feedback_only"}
    atomic_files.write_json(run / "config.json", config)
    path = run / "checkpoint" / "best.npz"
    arrays, meta = atomic_files.read_arrays(path, "checkpoint")
    atomic_files.write_arrays(path, "checkpoint", arrays, meta | {"config": config["config"]})
    message = "--agent is 'FeedbackOnly'; expected an agent with forward models"
    refused(["free-running", str(run)], message, title=TITLE)


def test_a_run_whose_modules_do_nothing_yet_is_named_before_any_other_dances(
    run: Path, tmp_path: Path, refused: Refused
) -> None:
    early = tmp_path / "early"
    words = "imitate ymca --models posture --rule gated --nodes 10 --epochs 1 --no-video --out"
    assert main([*words.split(), str(early)]) == 0
    message = (
        f"{early}: its modules put out nothing in the kept epoch; go on with"
        f" mpma imitate --resume {early}"
    )
    refused(["free-running", str(early)], message)
    refused(["free-running", str(run), str(early)], message)
    assert not (run / "free_running.json").exists()


def test_no_run_is_one_line_and_exit_2(tmp_path: Path, refused: Refused) -> None:
    refused(["free-running", str(tmp_path / "gone")], "no run there")
    refused(["free-running"], "no run given; try: mpma free-running runs/ymca")
    assert list(tmp_path.iterdir()) == []
