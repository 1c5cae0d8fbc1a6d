"""Study `ablation`: MPMA with one component changed at a time."""

from __future__ import annotations

from pathlib import Path

import pytest

from mpma_mj.cli import main
from mpma_mj.errors import BadOptionError
from mpma_mj.experiments.ablation import WHOLE, Ablation
from mpma_mj.experiments.records import Record, matching
from tests.conftest import Refused
from tests.experiments.runs import diverged, finished, labels_of, table_rows


def some_records(study: Ablation) -> list[Record]:
    """Return records whose p_e rises with the seed, and by 0.25 without predictors."""
    return [
        finished(
            labels,
            seed,
            p_e_percent=0.5 + seed + 0.25 * (labels["change"] == "no responsibility predictors"),
            nmi=0.1 + 0.1 * seed if labels["change"] == "no context" else 0.9,
        )
        for labels, seed in labels_of(study)
    ]


def row(table: str, name: str, number: int) -> dict[str, str]:
    """Return the cells of a row of the first or second table, by their titles."""
    rows = table_rows(table)
    heads = [n for n, cells in enumerate(rows) if cells[0] == "change"]
    start = heads[number]
    cells = next(cells for cells in rows[start:] if cells[0] == name)
    return dict(zip(rows[start], cells, strict=True))


@pytest.mark.parametrize("study", [Ablation(), Ablation(models="posture", rule="gated", nodes=5)])
def test_each_differs_from_the_whole_in_one_option(study: Ablation) -> None:
    (labels, whole), *others = study.points()
    assert labels == {"change": WHOLE}
    assert whole.option("rule") == study.rule
    assert len(others) == 11
    before = whole.options()
    for _, other in others:
        after = other.options()
        assert len([name for name in before if after[name] != before[name]]) == 1


def test_differences_are_taken_seed_by_seed_and_marked_if_they_exclude_0() -> None:
    study = Ablation(runs=5)
    table = study.table(some_records(study))
    whole = row(table, WHOLE, 0)
    assert (whole["converged"], whole["p_e, %"]) == ("5 of 5", "2.50 ± 1.58")
    assert row(table, "no responsibility predictors", 0)["p_e, %"] == "2.75 ± 1.58"
    # Seeds differ by more than the change does; compared with themselves they all agree.
    assert row(table, "no responsibility predictors", 1)["p_e, %"] == "**+0.250**"
    assert row(table, "no context", 1)["nmi"].startswith("**-0.600 [-0.7")
    assert row(table, "one module", 1)["p_e, %"] == "+0.000"
    assert row(table, "one module", 0)["active modules"] == "1.50 ± 0.00"  # mean over labels
    assert table.count(f"{WHOLE} |") == 1
    assert "Nothing is in bold" not in table


def test_fewer_than_5_runs_mark_nothing_and_it_is_said() -> None:
    study = Ablation(runs=4)
    table = study.table(some_records(study))
    assert row(table, "no responsibility predictors", 1)["p_e, %"] == "+0.250"
    assert row(table, "no context", 1)["nmi"].startswith("-0.650 [-0.7")
    assert "**" not in table
    assert table.endswith(
        "Nothing is in bold: intervals of fewer than 5 runs are too narrow to distinguish a change"
        " from chance."
    )


def test_a_difference_of_which_fewer_than_5_runs_are_left_is_not_marked() -> None:
    study = Ablation(runs=5)
    records = some_records(study)
    change = {"change": "no responsibility predictors"}
    records[records.index(matching(records, change)[0])] = diverged(change)
    table = study.table(records)
    assert row(table, change["change"], 1)["p_e, %"] == "+0.250"
    assert "**" in "".join(row(table, "no context", 1).values())


def test_what_a_run_does_not_have_is_in_no_difference() -> None:
    study = Ablation(runs=2)
    records = some_records(study)
    for name, other in (("no context", diverged({})), ("constant context", {"nmi": None})):
        matching(records, {"change": name})[0].update(other | {"change": name})
    for measure in ("p_e_percent", "converged", "nmi", "modules_used"):
        matching(records, {"change": "no context"})[0].pop(measure, None)
    table = study.table(records)
    one = row(table, "no context", 0)
    assert (one["converged"], one["p_e, %"]) == ("1 of 2", "1.50 ± –")
    assert row(table, "no context", 1)["p_e, %"] == "+0.000"
    assert row(table, "constant context", 1)["nmi"] == "+0.000"  # of the other seed
    assert "| – |" in study.table([])


def test_no_runs_are_refused() -> None:
    with pytest.raises(BadOptionError, match="runs is 0"):
        Ablation(runs=0).jobs()


def test_the_command_writes_tables_and_rows(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], refused: Refused
) -> None:
    words = ["study", "ablation", "--runs", "1", "--epochs", "1", "--out", str(tmp_path)]
    words += ["--models", "posture", "--rule", "gated", "--nodes"]
    assert main([*words, "5"]) == 0
    printed = capsys.readouterr()
    assert printed.out.splitlines()[-1] == str(tmp_path)
    table = (tmp_path / "table.md").read_text()
    assert table in printed.out
    assert table.startswith("Ablations: ymca, gated rule, 5 nodes, physics arms, runs of each: 1.")
    assert table.count("\n| forward models receive their own command |") == 2
    assert "12 of 12 runs   " in printed.err
    assert len((tmp_path / "results.csv").read_text().splitlines()) == 13
    refused([*words, "6"], "with nodes 5 where 6 is requested")


@pytest.mark.parametrize(
    ("words", "message"), [(["--nodes", "0"], "nodes is 0"), (["--runs", "0"], "runs is 0")]
)
def test_bad_input_is_refused_in_one_line(
    words: list[str], message: str, refused: Refused, tmp_path: Path
) -> None:
    refused(["study", "ablation", *words, "--out", str(tmp_path / "new")], message)
    assert not (tmp_path / "new").exists()
