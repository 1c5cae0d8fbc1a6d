"""The study `robustness`."""

import csv
import json
from pathlib import Path

import pytest

from mpma_mj.cli import main
from mpma_mj.errors import BadOptionError, DivergedError
from mpma_mj.evaluation.disturbances import disturbance_levels
from mpma_mj.evaluation.robustness import evaluate_levels
from mpma_mj.experiments import robustness
from mpma_mj.experiments.robustness import Robustness
from mpma_mj.experiments.study import run_study
from mpma_mj.motions import ymca
from mpma_mj.training.config import RunConfig
from mpma_mj.training.trainer import train_agents

AGENTS = {
    "mpma": {"agent": "mpma", "nodes": 10, "modules": 2, "repeats": 1},
    "feedback only": {"agent": "feedback_only", "repeats": 1},
}
SMALL = Robustness(
    runs=2, epochs=2, fine_tune=1, disturbances=("gravity", "payload"), agents=AGENTS
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("studies") / "robustness"
    run_study(SMALL, folder, workers=1)
    return folder


def test_the_table_has_a_row_for_each_level_and_a_column_for_each_agent(folder: Path) -> None:
    text = (folder / "table.md").read_text()
    assert text.startswith("| disturbance | level | mpma | feedback only |")
    assert text.count("| gravity | ") == 2 * 2  # at once, and after fine-tuning
    assert text.count("| payload in each hand, kg | ") == 2 * 5
    assert "means over 2 seeds" in text
    assert "cannot learn on: feedback only." in text
    for name in ("figure.png", "figure_fine_tuned.png"):
        assert (folder / name).read_bytes().startswith(b"\x89PNG")


def test_results_are_those_of_agents_trained_and_evaluated_in_this_process(folder: Path) -> None:
    configs = [RunConfig.of(seed=seed, **AGENTS["mpma"]) for seed in (0, 1)]
    trained = train_agents(configs, ymca(), 2, {})
    levels = disturbance_levels(configs[0], ymca(), disturbances=["payload"])
    expected = [str(one.p_e_percent) for one in evaluate_levels("mpma", trained, levels)]
    with (folder / "results.csv").open() as file:
        found = [
            row["p_e_percent"]
            for row in csv.DictReader(file)
            if (row["agent"], row["disturbance"]) == ("mpma", "payload")
        ]
    assert sorted(found) == sorted(expected)


def test_jobs_of_fine_tuned_agents_are_cut_by_disturbance() -> None:
    names = {job.name for job in SMALL.jobs()}
    assert names == {"gravity, mpma", "payload, mpma", "feedback only"}


def test_agents_whose_runs_are_missing_have_dashes(tmp_path: Path) -> None:
    records = [one for job in SMALL.jobs() if job.agent == "feedback only" for one in job.do()]
    assert all(line.split(" | ")[2] == "–" for line in SMALL.table(records).splitlines()[2:9])
    SMALL.draw(tmp_path / "figure.png", records)
    SMALL.draw(tmp_path / "none.png", [])
    assert not (tmp_path / "none.png").exists()


def test_a_finished_study_is_not_run_again(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = (folder / "results.csv").read_bytes()
    monkeypatch.setattr(robustness, "train_agents", None)  # which would fail
    run_study(SMALL, folder, workers=1)
    assert (folder / "results.csv").read_bytes() == before


def test_divergence_in_training_names_agent_and_seed(monkeypatch: pytest.MonkeyPatch) -> None:
    def diverge(*given: object) -> None:
        raise DivergedError("seed 0, epoch 1: the simulation diverged")

    monkeypatch.setattr(robustness, "train_agents", diverge)
    with pytest.raises(DivergedError, match="mpma: seed 0, epoch 1: the simulation diverged"):
        SMALL.jobs()[0].do()


def test_numbers_of_epochs_are_checked() -> None:
    with pytest.raises(BadOptionError, match="epochs is 0; expected a whole number from 1"):
        Robustness(epochs=0)
    with pytest.raises(BadOptionError, match="fine_tune is -1; expected a whole number from 0"):
        Robustness(fine_tune=-1)


def test_the_command_passes_its_options_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(robustness, "AGENTS", {"feedback only": {"agent": "feedback_only"}})
    out = tmp_path / "out"
    words = "study robustness --runs 1 --epochs 2 --disturbances mirrored --arms kinematic"
    assert main([*words.split(), "--workers", "1", "--out", str(out)]) == 0
    settings = json.loads((out / "study.json").read_text())["settings"]
    assert (settings["epochs"], settings["disturbances"]) == (2, ["mirrored"])
    assert (settings["arms"], settings["fine_tune"]) == ("kinematic", 0)
    assert "| mirrored motion | yes | " in (out / "table.md").read_text()
