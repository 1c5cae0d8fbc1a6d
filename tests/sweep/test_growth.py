"""`mpma grow`: runs that grow beside fixed numbers of modules."""

import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from mpma_mj.cli import main
from mpma_mj.errors import BadOptionError
from mpma_mj.sweep.folder import RunResult
from mpma_mj.sweep.growth import as_markdown, by_number, growing_runs, spec_of
from mpma_mj.training.config import RunConfig

SMALL = (
    "grow --nodes 5 --arms kinematic --repeats 1 --most 2 --runs 2 --epochs 20 --workers 2 --out"
)


def finished(most: int, settled: dict[int, int], p_e: dict[int, float], own: float) -> Any:
    """Return what is asked for, and runs with such results; `settled` is by seed."""
    spec = spec_of(most, len(settled), RunConfig(), 50)
    runs = []
    for config in spec.configs:
        grows = config.agent_name == "growing"
        found = {"p_e_percent": own if grows else p_e[config.option("modules")], "converged": True}
        number = {"modules_enabled": settled[config.seed], "growing": 0.0} if grows else {}
        runs.append(RunResult(config, found | number, 1, 0.5))
    return spec, runs


def test_growth_is_asked_for_beside_every_fixed_number() -> None:
    configs = spec_of(3, 2, RunConfig.of(nodes=7), 50).configs
    kinds = [(c.agent_name, c.option("modules"), c.seed) for c in configs]
    fixed = [("mpma", n, seed) for n in (1, 2, 3) for seed in (0, 1)]
    assert kinds == [("growing", 3, 0), ("growing", 3, 1), *fixed]
    assert {c.option("nodes") for c in configs} == {7}


def test_the_table_says_where_growth_settled_and_how_it_compares() -> None:
    spec, runs = finished(3, {0: 2, 1: 3}, {1: 2.0, 2: 1.0, 3: 1.5}, own=1.1)
    table = as_markdown(spec, runs)
    assert "| growing: 2.5 ± 0.7 | 2 of 2 |" in table
    assert "| 2 | 2 of 2 | – ± – | 1.00 ± 0.00 |" in table
    assert (
        "Growth settled at 2 3 modules, seed by seed; its mean p_e is 10 % above that of the best"
        " fixed number, 2." in table
    )


def test_runs_that_still_grow_have_settled_nowhere() -> None:
    spec, runs = finished(2, {0: 2}, {1: 2.0, 2: 1.0}, own=1.1)
    runs[0].summary["growing"] = 1.0
    assert growing_runs(runs) == []
    assert list(by_number(runs)) == [1, 2]
    assert "No run has grown to the end." in as_markdown(spec, runs)


def test_runs_that_diverged_are_passed_over() -> None:
    spec, runs = finished(1, {0: 1}, {1: 2.0}, own=1.1)
    runs = [RunResult(run.config, {"failed": "epoch 1"}, 1, 0.5) for run in runs]
    assert "2 of 2 runs diverged" in as_markdown(spec, runs)


@pytest.mark.parametrize(
    ("most", "runs", "base", "message"),
    [
        (0, 1, {}, "most is 0; expected at least 1"),
        (2, 0, {}, "runs is 0; expected at least 1"),
        (2, 1, {"modules": 6}, "modules is 6; leave it out: growth is tried beside 1 to"),
        (2, 1, {"agent": "mosaic"}, "agent is 'mosaic'; leave it out: growth is tried beside 1 to"),
    ],
)
def test_what_cannot_be_asked_for_is_one_line(
    most: int, runs: int, base: dict[str, Any], message: str
) -> None:
    with pytest.raises(BadOptionError, match=message):
        spec_of(most, runs, RunConfig.of(**base), 50)


def test_the_command_writes_table_rows_and_picture_and_goes_on_where_it_was(tmp_path: Path) -> None:
    words = [sys.executable, "-m", "mpma_mj.cli", *SMALL.split(), str(tmp_path / "g")]
    result = subprocess.run(words, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    lines = result.stdout.splitlines()
    assert lines[-1] == str(tmp_path / "g")
    assert lines[0].startswith("| modules | converged | epochs |")
    assert [line.split(" |")[0] for line in lines[2:4]] == ["| 1", "| 2"]
    assert lines[4].startswith("| growing: ")
    assert (tmp_path / "g" / "growth.md").read_text().splitlines() == lines[: len(lines) - 2]
    assert (tmp_path / "g" / "growth.png").read_bytes().startswith(b"\x89PNG")
    assert len((tmp_path / "g" / "results.csv").read_text().splitlines()) == 1 + 6
    again = subprocess.run(words, capture_output=True, text=True, check=False)
    assert again.stdout == result.stdout
    assert again.stderr == ""


def test_bad_input_is_one_line_and_exit_2(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["grow", "--most", "0", "--out", str(tmp_path / "g")]) == 2
    assert capsys.readouterr().err == "mpma: --most is 0; expected at least 1\n"
    assert main(["grow", str(tmp_path / "none.bvh"), "--out", str(tmp_path / "g")]) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1
    assert not (tmp_path / "g").exists()
