"""The command `mpma analyse` as a user types it."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from mpma_mj.cli import main
from mpma_mj.commands.analyse import with_analysis
from mpma_mj.errors import BadOptionError
from mpma_mj.kinematics import JOINT_NAMES, SEGMENT_NAMES
from mpma_mj.training.run_folder import RunFolder
from mpma_mj.utils import atomic_files, data_files
from tests.commands.conftest import Reconfigured, write_config
from tests.conftest import Refused

Arrays = dict[str, np.ndarray]
ANALYSES = ("modules", "lesion", "free-running")
TITLES = dict.fromkeys(ANALYSES, "") | {"free-running": "running without demonstration"}


def change_trace(run: Path, change: Callable[[Arrays], Arrays]) -> None:
    trace, meta = data_files.read_arrays(run / "trace.npz", "trace")
    data_files.write_arrays(run / "trace.npz", "trace", change(trace), meta)


def change_checkpoint(run: Path, change: Callable[[Arrays], object]) -> None:
    path = run / "checkpoint" / "best.npz"
    arrays, meta = data_files.read_arrays(path, "checkpoint")
    change(arrays)
    data_files.write_arrays(path, "checkpoint", arrays, meta)


def result(run: Path, analysis: str) -> Path:
    return run / f"{analysis.replace('-', '_')}.json"


def picture(run: Path, analysis: str) -> Path:
    return run / "figures" / f"{analysis.replace('-', '_')}.png"


@pytest.mark.parametrize(
    ("words", "ordered"),
    [
        ("RUN lesion --fine-tune 1", "lesion RUN --fine-tune 1"),
        ("lesion RUN", "lesion RUN"),
        ("RUN OTHER --beat 0.5 free-running", "free-running RUN OTHER --beat 0.5"),
        ("RUN", "modules RUN"),
        ("--help", "--help"),
    ],
)
def test_the_analysis_stands_before_or_after_the_runs_and_is_modules_without_one(
    words: str, ordered: str
) -> None:
    assert with_analysis(words.split()) == ordered.split()


def test_a_mistyped_analysis_is_a_question_unless_it_is_a_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(BadOptionError, match=r"no analysis 'lesions'; .*; did you mean lesion\?"):
        with_analysis(["runs/ymca", "lesions"])
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lesions").mkdir()
    assert with_analysis(["lesions"]) == ["modules", "lesions"]


def test_modules_get_tables_json_and_a_figure(
    run: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    again = shutil.copytree(run, run.parent / "again")
    capsys.readouterr()
    assert main(["analyse", str(run), str(again), "modules"]) == 0
    printed = capsys.readouterr()
    assert printed.err == "looking for synergies\n" * 2
    lines = printed.out.splitlines()
    assert lines[-1] == str(picture(again, "modules"))
    assert lines[0] == str(run)
    assert lines[2] == "| share of, % | module 1 | module 2 | module 3 |"
    assert picture(run, "modules").read_bytes().startswith(b"\x89PNG")
    assert sum("|---" in line for line in lines) == 2 * 5
    assert (run / "modules.json").read_bytes() == (again / "modules.json").read_bytes()
    content = json.loads((run / "modules.json").read_text())
    shares = content["shares"]
    assert list(shares["label"]) == ["Y", "M", "C", "A"]
    assert list(shares["joint"]) == list(JOINT_NAMES)
    assert list(shares["segment"]) == list(SEGMENT_NAMES)
    for rows in shares.values():
        for share in rows.values():
            assert sum(share) == pytest.approx(1.0)
    assert set(content["information"]["bits"]) == set(content["information"]["r2"])
    assert np.shape(content["synergies"]["loads"])[1] == 3


def test_one_module_has_no_information(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    def one(trace: Arrays) -> Arrays:
        modular = ("responsibility", "prior", "module_actions", "predictions")
        first = {name: trace[name][:, :1] for name in modular}
        return trace | first | {"responsibility": np.ones((len(trace["action"]), 1))}

    change_trace(run, one)
    assert main(["analyse", str(run)]) == 0
    printed = capsys.readouterr().out
    assert "| context | – | – | 0.00 | 0.00 | – |" in printed
    assert "| label Y | 100 |" in printed


def test_lesions_get_tables_json_and_a_figure(
    run: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    capsys.readouterr()
    assert main(["analyse", str(run), "lesion", "--fine-tune", "1"]) == 0
    printed = capsys.readouterr()
    assert printed.err == "run: dropping modules\n"
    lines = printed.out.splitlines()
    assert lines[-1] == str(picture(run, "lesion"))
    assert lines[0] == "| p_e, %, at once → after fine-tuning | Y | M | C | A | all |"
    assert any(line.startswith("| one module, in its own labels | ") for line in lines)
    assert picture(run, "lesion").read_bytes().startswith(b"\x89PNG")
    content = json.loads((run / "lesion.json").read_text())
    assert content["fine_tune_epochs"] == 1
    assert set(content["dominant_module"]) == set("YMCA")
    dropped = [lesion["dropped"] for lesion in content["lesions"]]
    assert dropped == [[], [1], [2], [3], [1, 2], [1, 3], [2, 3], [1, 2, 3]]
    intact, silent = content["lesions"][0]["at_once"], content["lesions"][-1]["at_once"]
    assert silent["p_e_percent"] > 3 * intact["p_e_percent"]
    assert len(intact["labels"]["Y"]["responsibility"]) == 3


def test_lesions_of_several_runs_are_summarised_and_each_is_the_same_as_alone(
    run: Path, reconfigured: Reconfigured, capsys: pytest.CaptureFixture[str]
) -> None:
    other = reconfigured(seed=5)
    again = shutil.copytree(run, run.parent / "again")
    assert main(["analyse", str(again), "lesion", "--fine-tune", "0"]) == 0
    capsys.readouterr()
    assert main(["analyse", str(run), str(other), "lesion", "--fine-tune", "0"]) == 0
    assert (run / "lesion.json").read_bytes() == (again / "lesion.json").read_bytes()
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "| p_e, %, without | intact | at once | all silent |"
    assert lines[-1] == str(picture(other, "lesion"))


def test_lesions_of_runs_that_differ_in_more_than_their_seed_are_not_summarised(
    run: Path, reconfigured: Reconfigured, refused: Refused
) -> None:
    refused(["analyse", "lesion", str(run), str(run)], "is given twice; leave one out")
    other = reconfigured(reference_noise=0.02)
    message = f"{other}: differs from {run} in more than its seed; analyse each separately"
    refused(["analyse", "lesion", str(run), str(other)], message)


def test_one_module_has_no_lesions(tmp_path: Path, refused: Refused) -> None:
    alone = tmp_path / "alone"
    words = "imitate ymca --epochs 1 --agent single --nodes 5 --repeats 1 --no-video --out"
    assert main([*words.split(), str(alone)]) == 0
    message = "has only one module, so that no other could take over; choose a run with --modules"
    refused(["analyse", str(alone), "lesion"], f"{alone}: {message}")
    assert not (alone / "lesion.json").exists()


def test_free_running_gets_a_table_json_and_a_figure(
    run: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    again = shutil.copytree(run, run.parent / "again")
    capsys.readouterr()
    assert main(["analyse", str(run), str(again), "free-running"]) == 0
    printed = capsys.readouterr()
    assert printed.err == "running without demonstration\n"
    lines = printed.out.splitlines()
    assert lines[-1] == str(picture(again, "free-running"))
    assert lines[0].startswith("| run | held, s | near, s | p_e 1 s, % |")
    assert lines[2].startswith(f"| {run}, own prediction | ")
    assert lines[3].startswith(f"| {run}, anticipation | ")
    assert [line.replace(str(run), str(again)) for line in lines[2:4]] == lines[4:6]
    assert picture(run, "free-running").read_bytes().startswith(b"\x89PNG")
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
    assert (run / "free_running.json").read_bytes() == (again / "free_running.json").read_bytes()


def test_a_finer_context_has_as_many_parts_as_beats(run: Path) -> None:
    assert main(["analyse", str(run), "free-running", "--beat", "0.5"]) == 0
    content = json.loads((run / "free_running.json").read_text())
    assert content["beat_s"] == 0.5
    assert content["anticipation"]["held_s"] == pytest.approx(15 * 3.8)


@pytest.mark.parametrize("beat", ["0.04", "3.9", "nan"])
def test_a_beat_is_a_step_at_least_and_a_repetition_at_most(
    run: Path, beat: str, refused: Refused
) -> None:
    message = f"--beat is {beat}; expected 0.05 to 3.8 s, a control step to a repetition"
    words = ["analyse", str(run), "free-running", "--beat", beat]
    refused(words, message)  # before the title of the progress
    assert not (run / "free_running.json").exists()


def test_an_agent_without_forward_models_does_not_run_freely(run: Path, refused: Refused) -> None:
    config = data_files.read_json(run / "config.json")["config"]
    write_config(run, config | {"agent": {"name": "feedback_only"}})
    message = "--agent is 'FeedbackOnly'; expected an agent with forward models"
    refused(["analyse", str(run), "free-running"], message, title=TITLES["free-running"])


def test_overwriting_a_run_removes_its_analyses(run: Path) -> None:
    folder = RunFolder(run)
    for analysis in ANALYSES:
        data_files.write_json(result(run, analysis), {})
        atomic_files.write_text(picture(run, analysis), "")
    with folder.changes(new=True):
        pass
    for analysis in ANALYSES:
        assert not result(run, analysis).exists()
        assert not picture(run, analysis).exists()


def without_modules(trace: Arrays) -> Arrays:
    modular = ("responsibility", "prior", "module_actions", "predictions")
    return {name: signal for name, signal in trace.items() if name not in modular}


def silent(trace: Arrays) -> Arrays:
    return trace | {"module_actions": np.zeros_like(trace["module_actions"])}


def shorter(trace: Arrays) -> Arrays:
    return {name: signal[:-5] for name, signal in trace.items()}


@pytest.mark.parametrize("analysis", ANALYSES)
@pytest.mark.parametrize(
    ("change", "message"),
    [
        (without_modules, "its agent has no modules; choose a run of MPMA"),
        (
            silent,
            "its modules have no output in the best epoch; continue with mpma imitate --resume",
        ),
        (shorter, "moments, but ymca repeated 3 times has"),
    ],
)
def test_a_trace_that_does_not_fit_is_one_line_and_exit_2(
    run: Path,
    analysis: str,
    change: Callable[[Arrays], Arrays],
    message: str,
    refused: Refused,
) -> None:
    change_trace(run, change)
    refused(["analyse", str(run), analysis], message)
    assert not result(run, analysis).exists()


@pytest.mark.parametrize("analysis", ANALYSES)
@pytest.mark.parametrize(
    "name", ["config.json", "trace.npz", "checkpoint/motion.npz", "checkpoint/best.npz"]
)
def test_a_damaged_run_is_one_line_and_exit_2(
    run: Path, analysis: str, name: str, refused: Refused
) -> None:
    if (analysis, name) == ("modules", "checkpoint/best.npz"):
        pytest.skip("modules are those of the trace")
    (run / name).write_bytes(b"rubbish")
    refused(["analyse", str(run), analysis], f"{name}: damaged", title=TITLES[analysis])
    assert not result(run, analysis).exists()


@pytest.mark.parametrize("analysis", ["lesion", "free-running"])
def test_a_checkpoint_that_does_not_fit_is_one_line_and_exit_2(
    run: Path, analysis: str, refused: Refused
) -> None:
    words, title = ["analyse", str(run), analysis], TITLES[analysis]
    change_checkpoint(run, lambda arrays: arrays.update({"forward.weights": np.zeros((2, 3))}))
    refused(words, "best.npz: does not fit its config; train again with --overwrite", title=title)
    change_checkpoint(run, lambda arrays: arrays.pop("forward.weights"))
    refused(words, "best.npz: lacks forward.weights; train again", title=title)


def test_all_runs_are_checked_before_the_first_is_analysed(
    run: Path, small_run: Path, tmp_path: Path, refused: Refused
) -> None:
    early = shutil.copytree(small_run, tmp_path / "early")
    change_trace(early, silent)
    for analysis in ANALYSES[2:]:
        message = (
            f"{early}: its modules have no output in the best epoch; continue with mpma imitate"
        )
        refused(["analyse", str(run), str(early), analysis], message)
        assert not result(run, analysis).exists()


def test_a_run_of_another_version_is_one_line_and_exit_2(run: Path, refused: Refused) -> None:
    content = data_files.read_json(run / "config.json")
    data_files.write_json(run / "config.json", content | {"format": 1})
    for analysis in ANALYSES:
        message = "config.json: format 1, written by mpma-mj"
        refused(["analyse", str(run), analysis], message)


def test_no_run_and_a_wrong_analysis_are_one_line_and_exit_2(
    tmp_path: Path, run: Path, refused: Refused
) -> None:
    refused(["analyse"], "no run given; try: mpma analyse runs/ymca [modules|lesion|free-running]")
    refused(
        ["analyse", str(run), "lesions"], "no analysis 'lesions'; expected one of modules, lesi"
    )
    for analysis in ANALYSES:
        refused(["analyse", analysis], "no run given; try: mpma analyse runs/ymca")
        refused(["analyse", str(tmp_path / "gone"), analysis], "is not a run")
    refused(["analyse", str(run), "lesion", "--fine-tune", "-1"], "--fine-tune is -1; expected 0")
    assert [path.name for path in tmp_path.iterdir()] == ["run"]
    assert not (run / "lesion.json").exists()
