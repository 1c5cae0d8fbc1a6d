"""The paper's Table 1: its own numbers, ours, and what is said about them."""

import csv
import io
import math
from pathlib import Path

import imageio.v3 as iio
import numpy as np
import pytest

from mpma_mj.bench.timing import Case
from mpma_mj.cli import main
from mpma_mj.errors import BadOptionError
from mpma_mj.experiments import floor, table1
from mpma_mj.experiments.folder import RunResult
from mpma_mj.experiments.measures import Spread, spread, values
from mpma_mj.experiments.spec import SweepSpec
from mpma_mj.experiments.table1_figure import write_figure
from mpma_mj.training.config import RunConfig
from tests.experiments.runs import finished

BASE = RunConfig.of(modules=2)


def some_runs(spec: SweepSpec) -> list[RunResult]:
    """Return runs whose epochs and modules used depend on the seed."""
    return [
        finished(config, epochs=6 + 2 * (config.seed % 2), modules_used=1 + config.seed % 2)
        for config in spec.configs
    ]


def test_mean_and_deviation_are_of_the_sample_and_skip_what_is_not_there() -> None:
    (config,) = table1.spec_of([5], 1, BASE).configs
    runs = [finished(config, nmi=value) for value in (0.2, 0.4, None)]
    runs.append(RunResult(config, {"failed": "diverged"}, 1, 0.5))
    assert values(runs, "nmi") == [0.2, 0.4]
    assert values(runs, "active_modules.M") == [2.0] * 3
    assert spread(runs, "nmi").mean == pytest.approx(0.3)
    assert spread(runs, "nmi").deviation == pytest.approx(math.sqrt(0.02))
    assert spread(runs[:1], "nmi").text(2) == "0.20 ± –"
    assert spread(runs, "of nothing").text(1, "/") == "–/–"


def test_the_papers_numbers_are_the_papers() -> None:
    assert list(table1.PAPER) == [50, 100, 200, 400]
    line = table1.PAPER[200]
    assert line.measures["epochs"] == Spread(14, 3.89)
    assert line.measures["p_e_percent"] == Spread(2.76, 0.17)
    assert line.measures["feedback_ratio"] == Spread(0.20, 0.02)
    active = [line.measures[f"active_modules.{letter}"].mean for letter in "YMCA"]
    assert active == [1.05, 1.8, 2.25, 1]


def test_every_size_has_the_papers_line_and_ours() -> None:
    spec = table1.spec_of([50, 60], 4, BASE)
    found = table1.lines(spec, some_runs(spec))
    assert [(line.nodes, line.source) for line in found] == [
        (50, "paper"),
        (50, "ours"),
        (60, "ours"),
    ]
    ours = found[1]
    assert ours.measures["epochs"] == Spread(7.0, pytest.approx(math.sqrt(4 / 3)))
    assert ours.all_used == 0.5
    assert ours.converged == (4, 4)


def test_the_table_shows_both_and_the_file_has_all_digits() -> None:
    spec = table1.spec_of([50], 2, BASE)
    runs = some_runs(spec)
    text = table1.as_markdown(spec, runs)
    assert "weighted rule, physics arms" in text
    assert "| 50 | paper | 18.00/3.78 | 2.76/0.23 | 0.230/0.020 | 1.00 | 1.60 | 2.70 |" in text
    assert "| 50 | ours | 7.00/1.41 | 0.50/0.00 | 0.040/0.000 | 1.00 | 2.00 | 2.00 |" in text
    assert "| 50 % | 2 of 2 |" in text
    rows = list(csv.DictReader(io.StringIO(table1.as_csv(spec, runs))))
    assert [row["source"] for row in rows] == ["paper", "ours"]
    assert rows[0]["p_e_percent_sd"] == "0.23"
    assert rows[0]["nmi_mean"] == rows[0]["converged"] == ""
    assert float(rows[1]["epochs_sd"]) == pytest.approx(math.sqrt(2))
    assert (rows[1]["converged"], rows[1]["runs"]) == ("2", "2")


def test_runs_that_did_not_end_well_are_told() -> None:
    spec = table1.spec_of([50], 4, BASE)
    first, second, *_ = spec.configs
    runs = [RunResult(first, {"failed": "diverged"}, 1, 0.5), finished(second, 2, converged=False)]
    text = table1.as_markdown(spec, runs)
    assert "| 0 of 4 |" in text
    assert "1 of 4 runs diverged" in text
    assert "2 of 4 runs are missing" in text
    assert "1 of 4 runs were tried again" in text


@pytest.mark.parametrize(
    ("sizes", "runs", "message"),
    [([], 1, "no runs"), ([5], 0, "runs is 0"), ([5, 5], 1, "twice")],
)
def test_no_sizes_no_runs_and_equal_sizes_are_refused(
    sizes: list[int], runs: int, message: str
) -> None:
    with pytest.raises(BadOptionError, match=message):
        table1.spec_of(sizes, runs, BASE)


@pytest.mark.parametrize("sizes", [[50, 100, 200, 400], [7]])
def test_the_picture_shows_something_whatever_the_sizes(tmp_path: Path, sizes: list[int]) -> None:
    spec = table1.spec_of(sizes, 3, BASE)
    path = tmp_path / "table1.png"
    write_figure(path, spec, some_runs(spec))
    full = iio.imread(path)
    assert full.std() > 10
    write_figure(path, spec, [])
    assert np.any(iio.imread(path) != full)


def test_bare_physics_is_of_as_many_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    spec = table1.spec_of([50], 2, BASE)
    runs = [finished(config, epochs=5, environment_steps=500) for config in spec.configs]
    runs.append(RunResult(spec.configs[0], {"failed": "diverged"}, 1, 0.5))
    monkeypatch.setattr(floor, "bare_rollout", lambda threads: Case(lambda: 1))
    monkeypatch.setattr(floor, "in_turn", lambda cases, rounds: {"bare": np.array([1e-3, 2e-3])})
    said = floor.beside_bare_physics(3.0, runs, 2, range(2))
    assert "3 s, 300 ms an epoch" in said
    assert "the same 10 epochs, `mujoco.rollout` on 2 thread(s), takes 1.5 s, 150 ms" in said
    assert said.endswith("2.00 times as much.")


def test_the_command_writes_table_file_and_picture(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(table1, "_EPOCHS", 2)
    monkeypatch.setattr(floor, "ROUNDS", 1)
    words = ["table1", "--nodes", "5", "6", "--runs", "2", "--out", str(tmp_path)]
    assert main(words) == 0
    printed = capsys.readouterr().out
    assert printed.splitlines()[-1] == str(tmp_path)
    assert (tmp_path / "table1.md").read_text() in printed
    assert "times as much." in printed
    names = {path.name for path in tmp_path.iterdir() if path.is_file()}
    assert names == {
        *("table1.md", "table1.csv", "table1.png", "results.csv", "sweep.json", "time.json"),
    }
    assert main([*words, "--models", "posture", "--rule", "gated"]) == 2
    assert "with models joint where posture is requested" in capsys.readouterr().err


def test_ideal_arms_have_no_physics_to_compare_with(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(table1, "_EPOCHS", 1)
    words = ["table1", "--nodes", "5", "--runs", "1", "--arms", "kinematic"]
    assert main([*words, "--out", str(tmp_path)]) == 0
    printed = capsys.readouterr().out
    assert "kinematic arms" in printed
    assert "bare physics" not in printed


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--nodes", "0"], "nodes is 0"),
        (["--nodes", "50", "50"], "twice"),
        (["--runs", "0"], "runs is 0"),
        (["--workers", "0"], "workers is 0"),
    ],
)
def test_bad_input_is_one_line_exit_2_and_no_folder(
    words: list[str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["table1", *words, "--out", str(tmp_path / "new")]) == 2
    told = capsys.readouterr().err
    assert len(told.splitlines()) == 1
    assert message in told
    assert not (tmp_path / "new").exists()
