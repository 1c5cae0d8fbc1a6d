"""Study `table1`: the paper's numbers, ours, the figure and the command."""

from __future__ import annotations

from pathlib import Path

import imageio.v3 as iio
import numpy as np
import pytest

from mpma_mj.cli import main
from mpma_mj.errors import BadOptionError
from mpma_mj.evaluation.statistics import MeanStd
from mpma_mj.experiments.records import Record
from mpma_mj.experiments.table1 import PAPER, Table1
from tests.conftest import Refused
from tests.experiments.runs import diverged, finished, labels_of, table_rows


def some_records(study: Table1) -> list[Record]:
    """Return records whose epochs and modules used depend on the seed."""
    return [
        finished(labels, seed, epochs=6 + 2 * (seed % 2), modules_used=3 + seed % 2)
        for labels, seed in labels_of(study)
    ]


def test_the_papers_numbers_are_the_papers() -> None:
    assert list(PAPER) == [50, 100, 200, 400]
    measures = PAPER[200]
    assert measures["epochs"] == MeanStd(14, 3.89)
    assert measures["p_e_percent"] == MeanStd(2.76, 0.17)
    assert measures["feedback_ratio"] == MeanStd(0.20, 0.02)
    assert [measures[f"active_modules.{letter}"].mean for letter in "YMCA"] == [1.05, 1.8, 2.25, 1]


def test_every_size_has_the_papers_row_and_ours() -> None:
    study = Table1(nodes=(50, 60), runs=4)
    table = study.table(some_records(study))
    assert table.startswith("Table 1: ymca, weighted rule, physics arms\n\n| nodes |  | epochs µ/σ")
    _, paper, ours, other = table_rows(table)
    assert [(row[0], row[1]) for row in (paper, ours, other)] == [
        ("50", "paper"),
        ("50", "ours"),
        ("60", "ours"),
    ]
    assert paper[2:9] == ["18.00/3.78", "2.76/0.23", "0.230/0.020", "1.00", "1.60", "2.70", "1.05"]
    assert paper[9:] == ["–"] * 5
    assert ours[2:8] == ["7.00/1.15", "0.50/0.00", "0.040/0.000", "1.00", "2.00", "2.00"]
    assert ours[9:] == ["0.90", "0.990", "3.50", "50 %", "4 of 4"]


def test_runs_that_did_not_end_well_are_in_no_mean() -> None:
    study = Table1(nodes=(60,), runs=4)
    _, row = table_rows(
        study.table([diverged({"nodes": 60}), finished({"nodes": 60}, 1, converged=False)])
    )
    assert row[2] == "7.00/–"
    assert row[-2:] == ["0 %", "0 of 4"]
    assert table_rows(study.table([]))[1][2:] == ["–/–"] * 3 + ["–"] * 7 + ["–", "0 of 4"]


@pytest.mark.parametrize(
    ("nodes", "message"), [((), "no runs"), ((5, 5), "twice"), ((0,), "nodes is 0")]
)
def test_no_sizes_and_equal_sizes_are_refused(nodes: tuple[int, ...], message: str) -> None:
    with pytest.raises(BadOptionError, match=message):
        Table1(nodes=nodes).jobs()


@pytest.mark.parametrize("nodes", [(50, 100, 200, 400), (7,)])
def test_the_figure_shows_something_whatever_the_sizes(
    tmp_path: Path, nodes: tuple[int, ...]
) -> None:
    study, path = Table1(nodes=nodes, runs=3), tmp_path / "figure.png"
    study.draw(path, some_records(study))
    full = iio.imread(path)
    assert full.std() > 10
    study.draw(path, [])
    assert np.any(iio.imread(path) != full)


def test_the_command_writes_table_rows_and_figure_and_refuses_another_study(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], refused: Refused
) -> None:
    words = ["study", "table1", "--nodes", "5", "6", "--runs", "1", "--epochs", "1"]
    assert main([*words, "--arms", "kinematic", "--out", str(tmp_path)]) == 0
    printed = capsys.readouterr()
    assert printed.out.splitlines()[-1] == str(tmp_path)
    table = (tmp_path / "table.md").read_text()
    assert table in printed.out
    assert table.startswith("Table 1: ymca, weighted rule, kinematic arms")
    assert printed.err.splitlines()[-1].startswith("   2 of 2 runs   nodes ")
    names = {path.name for path in tmp_path.iterdir() if path.is_file()}
    assert names == {"study.json", "results.csv", "table.md", "figure.png"}
    rest = ["--arms", "kinematic", "--out", str(tmp_path)]
    paper = ["--models", "posture", "--rule", "gated"]
    refused([*words, *rest, *paper], "with models joint where posture is requested")
    refused(["study", "agents", "--out", str(tmp_path)], "table1 where agents is requested")
