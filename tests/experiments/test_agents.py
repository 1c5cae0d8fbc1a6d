"""Study `agents`: all agents in one table."""

from __future__ import annotations

import csv
import re
from pathlib import Path
from typing import Any

import imageio.v3 as iio
import numpy as np
import pytest

from mpma_mj.agents import AGENTS
from mpma_mj.cli import main
from mpma_mj.experiments.agents import CompareAgents
from mpma_mj.experiments.records import Record, matching
from tests.conftest import Refused, WriteTsv
from tests.experiments.runs import diverged, finished, labels_of, table_rows

COMPARED = tuple(agent for agent in AGENTS if agent != "oracle")  # which needs plants
STUDY = CompareAgents(motions=("far/away/dance.tsv",), agents=COMPARED, runs=2)


def some_records(study: CompareAgents, **summary: Any) -> list[Record]:
    """Return records whose p_e is the number of the agent, and a tenth of the seed."""
    return [
        finished(labels, seed, p_e_percent=1 + COMPARED.index(labels["agent"]) + seed / 10)
        | summary
        for labels, seed in labels_of(study)
    ]


def test_every_agent_has_a_row_for_each_motion_and_both_arms() -> None:
    _, *rows = table_rows(STUDY.table(some_records(STUDY)))
    assert [tuple(row[:4]) for row in rows if row[3] != "–"] == [
        (motion, arms, agent, "2 of 2")
        for motion in ("ymca", "dance.tsv")
        for arms in ("physics", "kinematic")
        for agent in COMPARED
        if agent not in ("resolved_rate", "feedback_only", "open_loop", "random")
    ]
    assert len(rows) == 4 * len(COMPARED)


def test_the_table_shows_means_and_intervals() -> None:
    text = STUDY.table(some_records(STUDY))
    assert text.startswith(
        "| motion | arms | agent | converged | p_e, % | feedback ratio | learned share | epochs |"
    )
    p_e = 1 + COMPARED.index("mosaic")
    assert (
        f"| dance.tsv | kinematic | mosaic | 2 of 2 | {p_e}.05 [{p_e}.00, {p_e}.10] | 0.040 | 0.300"
        " | 7.0 | 1589 | 0.90 | 2.0 | 0.5 |"
    ) in text


def test_what_agents_do_not_have_is_a_dash() -> None:
    ymca = {"motion": "ymca", "arms": "physics"}
    bare = {"epochs": 1, "p_e_percent": 34.0, "environment_steps": 227, "converged": False}
    records = [
        {**ymca, "agent": "random", "seed": seed, "diverged": False, "seconds": 0.01} | bare
        for seed in (0, 1)
    ]
    records += [diverged(ymca | {"agent": "mpma"}), finished(ymca | {"agent": "mpma"}, 1)]
    text = STUDY.table(records)
    assert "| ymca | physics | random | – | 34.00 | – | – | 1.0 | 227 | – | – | 0.01 |" in text
    assert "| ymca | physics | mpma | 1 of 2 | 0.50 |" in text
    assert "| ymca | kinematic | mpma | 0 of 2 | – |" in text


def test_the_seconds_of_a_run_are_the_mean_of_the_shares() -> None:
    study = CompareAgents(agents=("mpma",), runs=2)
    records = [finished(ls, seed, seconds=1.0 + seed) for ls, seed in labels_of(study)]
    assert [row[-1] for row in table_rows(study.table(records))[1:]] == ["1.5", "1.5"]


def test_recordings_of_the_same_name_are_different_motions() -> None:
    study = CompareAgents(motions=("a/dance.tsv", "b/dance.tsv"), agents=("mpma",), runs=1)
    records = [
        finished(labels, seed, p_e_percent=1 + (labels["motion"] == "b/dance.tsv"))
        for labels, seed in labels_of(study)
    ]
    rows = [row for row in table_rows(study.table(records)) if row[:2] == ["dance.tsv", "physics"]]
    assert [row[4] for row in rows] == ["1.00", "2.00"]


@pytest.mark.parametrize("motions", [0, 1, 3])
def test_the_figure_shows_something_however_many_motions(motions: int, tmp_path: Path) -> None:
    names = tuple(f"dance{i}.tsv" for i in range(motions))
    study, path = CompareAgents(motions=names, agents=COMPARED, runs=2), tmp_path / "figure.png"
    study.draw(path, some_records(study))
    full = iio.imread(path)
    assert full.std() > 10
    study.draw(path, [])
    assert np.any(iio.imread(path) != full)


def test_the_command_writes_table_rows_and_figure(
    tmp_path: Path, write_tsv: WriteTsv, capsys: pytest.CaptureFixture[str], refused: Refused
) -> None:
    recording, out = write_tsv(), tmp_path / "out"
    words = ["study", "agents", "ymca", str(recording), "--runs", "1", "--nodes", "5", "--to", "3"]
    words += ["--agents", "mpma", "hammer", "random", "--out", str(out)]
    assert main([*words, "--epochs", "2"]) == 0
    printed = capsys.readouterr()
    assert printed.out.splitlines()[-1] == str(out)
    assert (out / "table.md").read_text() in printed.out
    assert re.search(r"  12 of 12 runs   motion (ymca|dance.tsv), arms \w+, \w+", printed.err)
    assert (out / "figure.png").stat().st_size > 5_000
    rows: list[Record] = [*csv.DictReader((out / "results.csv").read_text().splitlines())]
    assert len(rows) == 2 * 2 * 3
    assert {row["epochs"] for row in rows if row["agent"] != "random"} == {"2"}
    assert all(
        int(r["environment_steps"]) < 300 for r in matching(rows, {"motion": recording.name})
    )
    refused([*words, "--epochs", "2", "--no-stop"], "with stop True where False is requested")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--runs", "0"], "runs is 0"),
        (["--epochs", "0"], "epochs is 0"),
        (
            ["--agents", "mpma", "bc", "--epochs", "5"],
            "--epochs is 5; expected at least 24, as bc has",
        ),
        (["--nodes", "0"], "nodes is 0"),
        (["--tempo", "0"], "tempo is 0"),
        (["--agents", "nobody"], "--agents has 'nobody'"),
        (["ymca", "ymca"], "ymca is given twice"),
        (["gone.tsv"], "gone.tsv"),
    ],
)
def test_bad_input_is_refused_in_one_line(
    words: list[str], message: str, refused: Refused, tmp_path: Path
) -> None:
    refused(["study", "agents", *words, "--out", str(tmp_path / "new")], message)
    assert not (tmp_path / "new").exists()
