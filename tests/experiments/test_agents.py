"""All agents in one table."""

import csv
import io
from pathlib import Path
from typing import Any

import imageio.v3 as iio
import numpy as np
import pytest

from mpma_mj.agents import AGENTS
from mpma_mj.cli import main
from mpma_mj.errors import BadOptionError
from mpma_mj.experiments import agents as benchmark
from mpma_mj.experiments.agents_figure import write_figure
from mpma_mj.experiments.folder import RunResult
from mpma_mj.experiments.spec import SweepSpec
from mpma_mj.training.config import RunConfig
from tests.conftest import WriteTsv
from tests.experiments.runs import finished

BASES = [
    RunConfig(),
    RunConfig.of(
        "far/away/dance.tsv",
    ),
]
TINY = ("--nodes", "5", "--epochs", "2")

COMPARED = [agent for agent in AGENTS if agent != "oracle"]  # which has plants to be told only


MOSAIC = COMPARED.index("mosaic") - len(COMPARED)  # its row, from the last


def spec_of(runs: int = 2, bases: list[RunConfig] = BASES) -> SweepSpec:
    return benchmark.spec_of(bases, COMPARED, runs, 9, stop=True)


def some_runs(spec: SweepSpec, **summary: Any) -> list[RunResult]:
    """Return runs whose p_e is the number of the agent, and a tenth of the seed."""
    return [
        finished(c, p_e_percent=1 + COMPARED.index(c.agent_name) + c.seed / 10, **summary)
        for c in spec.configs
    ]


def test_every_agent_has_a_line_for_each_movement_and_both_arms() -> None:
    spec = spec_of()
    found = benchmark.lines(spec, some_runs(spec))
    assert [(line.motion, line.point.env.arms, line.point.agent_name) for line in found] == [
        (motion, arms, agent)
        for motion in ("ymca", "dance.tsv")
        for arms in ("physics", "kinematic")
        for agent in COMPARED
    ]
    assert all(line.wanted == len(line.runs) == 2 for line in found)


def test_the_table_shows_means_and_intervals_and_the_file_all_digits() -> None:
    spec = spec_of()
    text = benchmark.as_markdown(spec, some_runs(spec))
    assert text.startswith(
        "| motion | arms | agent | converged | p_e, % | feedback ratio | learned share | epochs |"
    )
    assert (
        "| dance.tsv | kinematic | mosaic | 2 of 2 | 2.05 [2.00, 2.10] | 0.040 | 0.300 | 7.0"
        " | 1589 | 0.90 | 2.0 | 0.5 |"
    ) in text
    rows = list(csv.DictReader(io.StringIO(benchmark.as_csv(spec, some_runs(spec)))))
    assert rows[MOSAIC]["motion"] == "far/away/dance.tsv"
    assert float(rows[MOSAIC]["p_e_percent_mean"]) == pytest.approx(2.05)
    assert (rows[MOSAIC]["p_e_percent_low"], rows[MOSAIC]["p_e_percent_high"]) == ("2.0", "2.1")
    assert (rows[MOSAIC]["converged"], rows[MOSAIC]["runs"]) == ("2", "2")


def test_what_agents_do_not_have_is_a_dash_and_what_went_wrong_is_said() -> None:
    spec = spec_of(3)
    runs = some_runs(spec)[:-1]
    bare = {"epochs": 1, "p_e_percent": 34.0, "environment_steps": 227, "converged": False}
    first = next(i for i, run in enumerate(runs) if run.config.agent_name == "random")
    for number in range(first, first + 3):
        runs[number] = RunResult(runs[number].config, bare, 1, 0.01)
    runs[0] = RunResult(runs[0].config, {"failed": "diverged"}, 1, 0.5)
    text = benchmark.as_markdown(spec, runs)
    assert "| ymca | physics | random | – | 34.00 | – | – | 1.0 | 227 | – | – | 0.01 |" in text
    assert "| ymca | physics | mpma | 2 of 3 |" in text
    assert "1 of 108 runs diverged" in text
    assert "1 of 108 runs are missing" in text


def test_the_seconds_of_a_run_are_the_mean_of_the_shares() -> None:
    spec = spec_of(2, [RunConfig()])
    runs = [RunResult(c, {"epochs": 1}, 1, 1.0 + c.seed) for c in spec.configs]
    assert {line.seconds for line in benchmark.lines(spec, runs)} == {1.5}


def test_the_same_movement_twice_and_no_runs_are_refused() -> None:
    with pytest.raises(BadOptionError, match="twice"):
        spec_of(1, [RunConfig(), RunConfig()])
    with pytest.raises(BadOptionError, match="runs is 0"):
        spec_of(0)


@pytest.mark.parametrize("movements", [1, 2, 4])
def test_the_picture_shows_something_however_many_movements(movements: int, tmp_path: Path) -> None:
    spec = spec_of(
        2,
        [
            RunConfig.of(
                f"dance{i}.tsv",
            )
            for i in range(movements)
        ],
    )
    path = tmp_path / "benchmark.png"
    write_figure(path, benchmark.lines(spec, some_runs(spec)))
    full = iio.imread(path)
    assert full.std() > 10
    write_figure(path, benchmark.lines(spec, []))
    assert np.any(iio.imread(path) != full)


def test_the_command_writes_table_file_and_picture(
    tmp_path: Path, write_tsv: WriteTsv, capsys: pytest.CaptureFixture[str]
) -> None:
    dance, out = write_tsv(), tmp_path / "out"
    words = ["benchmark", "ymca", str(dance), "--runs", "1", *TINY, "--to", "3"]
    assert main([*words, "--out", str(out)]) == 0
    printed = capsys.readouterr()
    assert printed.out.splitlines()[-1] == str(out)
    assert (out / "benchmark.md").read_text() in printed.out
    whole = f"{4 * len(COMPARED)} of {4 * len(COMPARED)} runs   "
    assert f"{whole}dance.tsv, " in printed.err or f"{whole}ymca, " in printed.err
    names = {path.name for path in out.iterdir() if path.is_file()}
    assert names == {
        *("benchmark.md", "benchmark.csv", "benchmark.png", "results.csv", "sweep.json"),
        "time.json",
    }
    with (out / "benchmark.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 4 * len(COMPARED)
    learning = [row for row in rows if row["agent"] in ("mpma", "mosaic", "hammer", "single")]
    assert {row["epochs_mean"] for row in learning} == {"2.0"}
    steps = {row["motion"]: float(row["environment_steps_mean"]) for row in rows}
    assert steps[str(dance)] < 300  # three seconds of the recording; the YMCA is whole
    assert all(float(row["seconds_mean"]) > 0 for row in rows)
    assert main([*words, "--no-stop", "--out", str(out)]) == 2
    assert "with stop True where False is requested" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--runs", "0"], "runs is 0"),
        (["--epochs", "0"], "epochs is 0"),
        (["--nodes", "0"], "nodes is 0"),
        (["gone.tsv"], "gone.tsv"),
        (["ymca", "ymca"], "ymca is given twice"),
        (["gone.tsv", "gone.tsv"], "gone.tsv is given twice"),
        (["--tempo", "0"], "tempo is 0"),
    ],
)
def test_bad_input_is_one_line_exit_2_and_no_folder(
    words: list[str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["benchmark", *words, "--out", str(tmp_path / "new")]) == 2
    told = capsys.readouterr().err
    assert len(told.splitlines()) == 1
    assert message in told
    assert not (tmp_path / "new").exists()
