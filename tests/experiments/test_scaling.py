"""Study `scaling`: amounts and sizes, tables, sentences, the figure and the command."""

from __future__ import annotations

import csv
import math
from pathlib import Path

import imageio.v3 as iio
import numpy as np
import pytest

from mpma_mj.cli import main
from mpma_mj.errors import BadOptionError
from mpma_mj.experiments.records import Record
from mpma_mj.experiments.scaling import Amount, Scaling, Size
from mpma_mj.experiments.scaling_report import fixed, least_enough, named, saturation
from tests.conftest import Refused
from tests.experiments.runs import diverged, finished, labels_of, run_files, table_rows

NAMES = ("ymca", "synthetic-1", "synthetic-2")


def study_of(
    modules: tuple[int, ...] = (2, 4, 8), nodes: tuple[int, ...] = (50, 100), runs: int = 2
) -> Scaling:
    return Scaling(motions=NAMES, lengths=(4.0, 2.0), modules=modules, nodes=nodes, runs=runs)


def some_records(study: Scaling) -> list[Record]:
    """Return records that are the better the larger the agent, up to 4 modules and 100 nodes."""
    return [
        finished(
            labels,
            seed,
            p_e_percent=1.0 / min(labels["modules"], 4) + 10.0 / min(labels["nodes"], 100),
            modules_used=min(labels["modules"], labels["amount"] * (labels["unit"] == "motions")),
            entropy={"usage": 0.9, "sharing": 0.2},
        )
        for labels, seed in labels_of(study)
    ]


def test_motions_double_up_to_all_and_the_longest_is_cut() -> None:
    assert study_of().amounts == (
        Amount("motions", 1, ("ymca",)),
        Amount("motions", 2, ("ymca", "synthetic-1")),
        Amount("motions", 3, NAMES),
        Amount("seconds", 2.0, ("synthetic-1",), 2.0),
        Amount("seconds", 4.0, ("synthetic-1",), 4.0),
    )


def test_without_motions_there_are_synthetic_ones_and_lengths_double() -> None:
    found = Scaling().amounts
    assert [amount.number for amount in found] == [1, 2, 4, 8, 5, 10, 20, 40]
    assert found[3].motions[-1] == "synthetic-8"
    assert {amount.motions for amount in found if amount.unit == "seconds"} == {("synthetic",)}


def test_sizes_are_a_cross_whose_lines_meet() -> None:
    study = study_of((8, 2, 4), (400, 50, 200, 100))
    assert study.crossing == Size(4, 100)
    assert study.lines["modules"] == (Size(2, 100), Size(4, 100), Size(8, 100))
    assert study.lines["nodes"] == (Size(4, 50), Size(4, 100), Size(4, 200), Size(4, 400))
    assert len(study.sizes) == 6
    assert len(study.points()) == 5 * 6


def test_there_is_a_label_a_motion_and_four_in_one_that_is_cut() -> None:
    jobs = study_of((2,), (50,), 1).jobs()
    assert [len(job.motion.labels) for job in jobs] == [1, 2, 3, 4, 4]


@pytest.mark.parametrize(
    ("found", "least"),
    [
        ({2: 1.0, 4: 0.5, 8: 0.47}, 4),
        ({2: 0.5, 4: 0.46, 8: 0.6}, 2),
        ({2: 1.0, 4: 0.9, 8: 0.1}, 8),
        ({2: math.nan, 4: 0.5}, 4),
        ({2: math.nan}, None),
    ],
)
def test_enough_is_the_least_within_ten_percent_of_the_lowest(
    found: dict[int, float], least: int | None
) -> None:
    assert least_enough(found) == least


def test_the_sentences_say_what_the_numbers_say() -> None:
    study = study_of()
    assert saturation(study, some_records(study)) == [
        "More motions, 50 nodes: enough modules are 4 for 1, 2, 3 motions.",
        "More motions, 4 modules: enough nodes are 100 for 1, 2, 3 motions.",
        "More motions: most modules used 1.0, 2.0, 3.0 for 1, 2, 3 motions; 8 is the most"
        " there are.",
        "More motions: p_e with 4 modules and 50 nodes is 0.45, 0.45, 0.45 % for 1, 2, 3 motions.",
        "More seconds, 50 nodes: enough modules are 4 for 2, 4 s.",
        "More seconds, 4 modules: enough nodes are 100 for 2, 4 s.",
        "More seconds: most modules used 0.0, 0.0 for 2, 4 s; 8 is the most there are.",
        "More seconds: p_e with 4 modules and 50 nodes is 0.45, 0.45 % for 2, 4 s.",
    ]


def test_one_is_not_many() -> None:
    one, two, *_ = study_of().amounts
    assert (named([one]), named([one, two])) == ("1 motion", "1, 2 motions")
    assert fixed("nodes", Size(1, 50)) == "1 module"
    assert fixed("modules", Size(1, 50)) == "50 nodes"


def test_a_single_size_says_nothing_about_enough() -> None:
    study = study_of((2,), (50,))
    sentences = saturation(study, some_records(study))
    assert not any("enough" in sentence for sentence in sentences)


def test_runs_that_are_missing_or_diverged_leave_dashes() -> None:
    study = study_of()
    first, *others = some_records(study)[::2]
    lost = diverged({name: first[name] for name in ("unit", "amount", "modules", "nodes")})
    rows = table_rows(study.table([lost, *others[:3]]))
    assert rows[0] == ["modules", "nodes", "1 motion", "2 motions", "3 motions", "2 s", "4 s"]
    assert rows[1] == ["2", "50", "–", "–", "–", "–", "–"]
    assert rows[2] == ["4", "50", "0.45", "–", "–", "–", "–"]
    assert rows[-4:][1] == ["4", "50", "1", "0", "0", "0", "0"]  # runs that converged


def test_the_figure_shows_something_whatever_there_is(tmp_path: Path) -> None:
    study, path = study_of(), tmp_path / "figure.png"
    study.draw(path, some_records(study))
    full = iio.imread(path)
    assert full.std() > 10
    study.draw(path, [])
    empty = iio.imread(path)
    assert empty.shape != full.shape or np.any(empty != full)


def test_the_command_writes_tables_rows_and_figure_and_goes_on(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["study", "scaling", "ymca", "synthetic-1", "--lengths", "1", "2", "--epochs", "1"]
    words += ["--modules", "2", "3", "--nodes", "5", "--runs", "1", "--out", str(tmp_path)]
    assert main(words) == 0
    first = capsys.readouterr().out
    assert first.splitlines()[-1] == str(tmp_path)
    assert (tmp_path / "table.md").read_text() in first
    rows = [*csv.DictReader((tmp_path / "results.csv").read_text().splitlines())]
    assert [(row["unit"], row["amount"], row["modules"]) for row in rows[::2]] == [
        ("motions", "1", "2"),
        ("motions", "2", "2"),
        ("seconds", "1.0", "2"),
        ("seconds", "2.0", "2"),
    ]
    assert all(0.0 < float(row["p_e_percent"]) < 20.0 for row in rows)
    assert all(0.0 <= float(row["entropy.sharing"]) <= 1.0 for row in rows)
    assert (tmp_path / "figure.png").stat().st_size > 10_000
    kept = run_files(tmp_path)[1:]
    times = [path.stat().st_mtime_ns for path in kept]
    run_files(tmp_path)[0].unlink()
    assert main(words) == 0
    again = capsys.readouterr()
    assert again.out == first
    assert again.err.splitlines()[0] == "resuming: 7 of 8 runs are done"
    assert [path.stat().st_mtime_ns for path in kept] == times


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--runs", "0"], "runs is 0"),
        (["--nodes", "0"], "nodes is 0"),
        (["--modules", "0"], "modules is 0"),
        (["--modules", "2", "2"], "modules has a value twice"),
        (["--lengths", "0"], "--lengths has 0; expected seconds above 0"),
        (["--lengths", "2", "2"], "lengths has a value twice"),
        (["--lengths", "81"], "and synthetic, the longest motion, lasts 80.00 s"),
        (["ymca"], "ymca, the longest motion, lasts 3.80 s, less than 5 s"),
        (["gone.tsv"], "gone.tsv: no such file"),
        (["ymca", "ymca", "--lengths", "2"], "ymca is given twice"),
    ],
)
def test_bad_input_is_refused_in_one_line_and_leaves_nothing(
    words: list[str], message: str, refused: Refused, tmp_path: Path
) -> None:
    refused(["study", "scaling", *words, "--out", str(tmp_path / "new")], message)
    assert not (tmp_path / "new").exists()


def test_no_size_is_refused() -> None:
    with pytest.raises(BadOptionError, match="modules has no value; expected at least 1 size"):
        Scaling(modules=()).jobs()
