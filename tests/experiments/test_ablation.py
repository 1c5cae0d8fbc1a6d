"""MPMA with one thing changed at a time."""

import csv
import io
from pathlib import Path

import pytest

from mpma_mj.cli import main
from mpma_mj.errors import BadOptionError
from mpma_mj.experiments import ablation
from mpma_mj.experiments.ablation import changes_of
from mpma_mj.experiments.folder import RunResult
from mpma_mj.experiments.spec import SweepSpec, by_point
from mpma_mj.training.config import RunConfig
from tests.experiments.runs import TINY, finished


def some_runs(spec: SweepSpec) -> list[RunResult]:
    """Return runs whose p_e rises with the seed, and by 0.25 without predictors."""
    return [
        finished(
            config,
            p_e_percent=0.5
            + config.seed
            + (0 if config.option("responsibility_predictors") else 0.25),
            nmi=0.9 if config.option("context_signal") == "labels" else 0.1 + 0.1 * config.seed,
        )
        for config in spec.configs
    ]


def row(table: str, name: str, number: int) -> dict[str, str]:
    """Return the cells of a row of the first or second table, by their titles."""
    lines = [line.strip("| ").split(" | ") for line in table.splitlines() if " | " in line]
    titles = [line for line in lines if line[0] == "change"][number]
    return dict(zip(titles, [line for line in lines if line[0] == name][number], strict=True))


@pytest.mark.parametrize(
    "whole", [TINY, TINY.replace(models="posture", rule="gated")], ids=["joint", "posture"]
)
def test_each_differs_from_the_whole_in_one_setting(whole: RunConfig) -> None:
    spec = ablation.spec_of(whole, 2)
    first, *others = by_point(spec.configs)
    assert first == whole
    changes = changes_of(whole.option("models"))
    assert len(others) + 1 == len(changes)
    for other in others:
        before, after = whole.options(), other.options()
        assert len([name for name in before if after[name] != before[name]]) == 1
    assert ablation.title(spec, spec.configs[1]) == "the whole"
    assert ablation.title(spec, spec.configs[-1]) == list(changes)[-1]


def test_differences_are_taken_seed_by_seed_and_marked_if_they_exclude_0() -> None:
    spec = ablation.spec_of(RunConfig(), 5)
    table = ablation.as_markdown(spec, some_runs(spec))
    whole = row(table, "the whole", 0)
    assert (whole["converged"], whole["p_e, %"]) == ("5 of 5", "2.50 ± 1.58")
    assert row(table, "no responsibility predictors", 0)["p_e, %"] == "2.75 ± 1.58"
    # Seeds differ by more than the change does; compared with themselves they all agree.
    assert row(table, "no responsibility predictors", 1)["p_e, %"] == "**+0.250**"
    assert row(table, "no context", 1)["nmi"].startswith("**-0.600 [-0.7")
    assert row(table, "one module", 1)["p_e, %"] == "+0.000"
    assert table.count("the whole |") == 1
    assert "Nothing is in bold" not in table


def test_fewer_than_5_runs_mark_nothing_and_it_is_said() -> None:
    spec = ablation.spec_of(RunConfig(), 4)
    table = ablation.as_markdown(spec, some_runs(spec))
    assert row(table, "no responsibility predictors", 1)["p_e, %"] == "+0.250"
    assert row(table, "no context", 1)["nmi"].startswith("-0.650 [-0.7")
    assert "**" not in table
    assert "\n\nNothing is in bold: intervals of fewer than 5 runs are too narrow" in table


def test_a_difference_of_which_fewer_than_5_runs_are_left_is_not_marked() -> None:
    spec = ablation.spec_of(RunConfig(), 5)
    runs = some_runs(spec)
    assert ablation.title(spec, runs[5].config) == "no responsibility predictors"
    runs[5] = RunResult(runs[5].config, {"failed": "diverged"}, 1, 0.5)
    table = ablation.as_markdown(spec, runs)
    assert row(table, "no responsibility predictors", 1)["p_e, %"] == "+0.250"
    assert "**" in "".join(row(table, "no context", 1).values())


def test_active_modules_are_the_mean_over_labels() -> None:
    spec = ablation.spec_of(RunConfig(), 2)
    table = ablation.as_markdown(spec, some_runs(spec))
    assert row(table, "one module", 0)["active modules"] == "1.50 ± 0.00"


def test_what_a_run_does_not_have_is_in_no_difference() -> None:
    spec = ablation.spec_of(RunConfig(), 2)
    runs = some_runs(spec)
    lost = {
        "no context": RunResult(runs[6].config, {"failed": "diverged"}, 1, 0.5),
        "constant context": finished(runs[8].config, nmi=None),
    }
    runs[6], runs[8] = lost.values()
    assert [ablation.title(spec, run.config) for run in lost.values()] == list(lost)
    table = ablation.as_markdown(spec, runs)
    one = row(table, "no context", 0)
    assert (one["converged"], one["p_e, %"]) == ("1 of 2", "1.50 ± –")
    assert row(table, "no context", 1)["p_e, %"] == "+0.000"
    assert row(table, "constant context", 1)["nmi"] == "-0.700"  # of the other seed
    assert "1 of 24 runs diverged" in table


def test_the_file_has_means_and_differences_with_all_digits() -> None:
    spec = ablation.spec_of(RunConfig(), 3)
    rows = list(csv.DictReader(io.StringIO(ablation.as_csv(spec, some_runs(spec)))))
    assert [r["change"] for r in rows] == list(changes_of("joint"))
    assert rows[1]["p_e_percent_mean"] == "1.75"
    assert rows[1]["p_e_percent_difference_low"] == "0.25"
    assert rows[0]["nmi_difference_mean"] == "0.0"


def test_no_runs_are_refused() -> None:
    with pytest.raises(BadOptionError, match="runs is 0"):
        ablation.spec_of(RunConfig(), 0)


def test_the_command_writes_tables_and_file(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ablation, "_EPOCHS", 1)
    words = ["ablate", "--runs", "1", "--nodes", "5", "--out", str(tmp_path)]
    assert main([*words, "--models", "posture", "--rule", "gated"]) == 0
    printed = capsys.readouterr()
    assert printed.out.splitlines()[-1] == str(tmp_path)
    table = (tmp_path / "ablate.md").read_text()
    assert table in printed.out
    assert table.startswith("Ablations: ymca, gated rule, 5 nodes, physics arms, runs of each: 1.")
    assert all(table.count(f"\n| {name} |") == 2 for name in list(changes_of("posture"))[1:])
    assert "12 of 12 runs   " in printed.err
    names = {path.name for path in tmp_path.iterdir() if path.is_file()}
    assert names == {"ablate.md", "ablate.csv", "results.csv", "sweep.json", "time.json"}
    assert main([*words, "--models", "posture", "--rule", "gated", "--nodes", "6"]) == 2
    assert "with nodes 5 where 6 is requested" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--nodes", "0"], "nodes is 0"),
        (["--runs", "0"], "runs is 0"),
        (["--workers", "0"], "workers is 0"),
    ],
)
def test_bad_input_is_one_line_exit_2_and_no_folder(
    words: list[str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["ablate", *words, "--out", str(tmp_path / "new")]) == 2
    told = capsys.readouterr().err
    assert len(told.splitlines()) == 1
    assert message in told
    assert not (tmp_path / "new").exists()
