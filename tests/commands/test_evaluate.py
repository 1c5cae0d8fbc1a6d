"""The command `mpma evaluate` as a user types it."""

import csv
import shutil
from pathlib import Path

import pytest

from mpma_mj.cli import main
from mpma_mj.training.run_folder import RunFolder
from mpma_mj.utils import data_files
from tests.commands.conftest import Reconfigured
from tests.conftest import Refused

QUICK = ["--disturbances", "payload", "--levels", "0", "3"]


def rows(path: Path) -> list[dict[str, str]]:
    with path.open() as file:
        return list(csv.DictReader(file))


def test_a_run_gets_a_table_and_a_figure_beside_baselines(
    run: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    capsys.readouterr()
    assert main(["evaluate", str(run), "--disturbances", "gravity"]) == 0
    printed = capsys.readouterr()
    assert printed.err.splitlines() == [
        f"evaluating {name}" for name in (run, "resolved rate", "feedback only")
    ]
    lines = printed.out.splitlines()
    assert lines[0] == f"| disturbance | level | {run} | resolved rate | feedback only |"
    assert "seeds" not in lines[-3]
    (folder,) = (run / "evaluations").iterdir()
    assert lines[-1] == str(folder)
    names = ["evaluation.csv", "evaluation.md", "evaluation.png"]
    assert sorted(path.name for path in folder.iterdir()) == names
    assert printed.out.startswith((folder / "evaluation.md").read_text())
    found = rows(folder / "evaluation.csv")
    assert {row["seed"] for row in found} == {"0"}
    assert len({row["p_e_percent"] for row in found}) == len(found) == 3 * 2


def test_runs_with_the_same_task_stand_side_by_side(run: Path, tmp_path: Path) -> None:
    other, out = shutil.copytree(run, tmp_path / "other"), tmp_path / "out"
    words = ["evaluate", str(run), str(other), *QUICK, "--no-baselines", "--out", str(out)]
    assert main(words) == 0
    found = rows(out / "evaluation.csv")
    assert [row["agent"] for row in found] == [str(run)] * 2 + [str(other)] * 2
    first, second = ([list(row.values())[1:] for row in part] for part in (found[:2], found[2:]))
    assert first == second


def test_runs_with_other_tasks_are_evaluated_by_themselves(
    run: Path, reconfigured: Reconfigured, refused: Refused
) -> None:
    other = reconfigured(reference_noise=0.02)
    message = f"{other}: differs from {run} in motion or environment; evaluate each separately"
    refused(["evaluate", str(run), str(other)], message)


def test_fine_tuning_has_columns_and_a_figure_which_a_later_evaluation_removes(
    run: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    words = ["evaluate", str(run), "--no-baselines", *QUICK]
    assert main([*words, "--fine-tune", "1", "--out", str(out)]) == 0
    assert (out / "evaluation_fine_tuned.png").exists()
    at_once, tuned = (
        [row[f"fine_tuned.{n}"] for row in rows(out / "evaluation.csv")] for n in "01"
    )
    assert float(tuned[1]) < float(at_once[1])
    assert main([*words, "--out", str(out)]) == 0
    assert not (out / "evaluation_fine_tuned.png").exists()
    assert len(rows(out / "evaluation.csv")) == 2
    assert main(words) == main(words) == 0
    assert len(list((run / "evaluations").iterdir())) == 2


def test_a_new_best_epoch_removes_evaluations(run: Path) -> None:
    (run / "evaluations").mkdir()
    with RunFolder(run).changes():
        pass
    assert (run / "evaluations").exists()
    with RunFolder(run).changes(best=True):
        pass
    assert not (run / "evaluations").exists()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (
            ["--disturbances", "wind"],
            "no disturbance 'wind'; expected one or more of payload, strength",
        ),
        (["--disturbances", "payload", "--levels", "-1"], "payload -1: payload is -1.0; expected"),
        (["--levels", "1"], "but they belong to a single disturbance; name it with --disturbances"),
        (["--motions", "gone.bvh"], "gone.bvh: no such file; check the path"),
        (
            ["--motions", "ymca", *QUICK],
            "not evaluated; leave --motions out, or choose --disturbanc",
        ),
        (["--fine-tune", "-1"], "--fine-tune is -1; expected 0 or more epochs"),
        (["--arms", "kinematic", *QUICK], "payload 3: payload is 3.0; ideal arms have no mass"),
    ],
)
def test_bad_input_is_one_line_and_exit_2(
    words: list[str], message: str, run: Path, refused: Refused
) -> None:
    refused(["evaluate", str(run), *words], message)
    assert not (run / "evaluations").exists()


def test_a_latency_that_the_agent_cannot_have_is_one_line(run: Path, refused: Refused) -> None:
    words = ["evaluate", str(run), "--disturbances", "latency", "--levels", "8"]
    message = "latency 8: max_latency is 5; expected at least 8, the latency of the environment"
    refused(words, message, title=f"evaluating {run}")


def test_an_output_that_cannot_be_written_is_refused_before_the_work(
    run: Path, refused: Refused
) -> None:
    refused(["evaluate", str(run), "--out", str(run / "config.json")], "config.json: ")


def test_no_run_and_damaged_runs_are_one_line_and_exit_2(
    run: Path, tmp_path: Path, refused: Refused
) -> None:
    refused(["evaluate"], "no run given; try: mpma evaluate runs/ymca")
    refused(["evaluate", str(tmp_path / "gone")], "is not a run")
    for name in ("checkpoint/motion.npz", "checkpoint/best.npz", "config.json"):
        (run / name).write_bytes(b"rubbish")  # each is read before the one before
        refused(["evaluate", str(run)], f"{name}: damaged")


def test_a_run_of_another_version_is_one_line_and_exit_2(run: Path, refused: Refused) -> None:
    content = data_files.read_json(run / "config.json")
    data_files.write_json(run / "config.json", content | {"format": 1})
    refused(["evaluate", str(run)], "config.json: format 1, written by mpma-mj")


def test_a_run_that_cannot_learn_on_is_not_fine_tuned(tmp_path: Path, refused: Refused) -> None:
    out = tmp_path / "hammer"
    words = "imitate ymca --agent hammer --nodes 5 --repeats 1 --epochs 4 --no-video --out"
    assert main([*words.split(), str(out)]) == 0
    message = f"{out}: its agent is hammer, which does not learn; leave --fine-tune out"
    refused(["evaluate", str(out), "--fine-tune", "1"], message)
    assert main(["evaluate", str(out), *QUICK]) == 0
