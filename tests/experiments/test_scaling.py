"""How MPMA scales: what is spec, what is said about it, and `mpma scale` as a user types it."""

import csv
import math
from pathlib import Path

import imageio.v3 as iio
import numpy as np
import pytest

from mpma_mj.cli import main
from mpma_mj.errors import BadOptionError
from mpma_mj.experiments import scaling as scale
from mpma_mj.experiments.folder import RunResult
from mpma_mj.experiments.scaling import Material, Scale, Size, materials
from mpma_mj.experiments.scaling_figure import write_figure
from mpma_mj.experiments.scaling_table import (
    Results,
    amounts,
    as_markdown,
    as_rows,
    fixed,
    least_enough,
    saturation,
)
from mpma_mj.training.config import RunConfig
from mpma_mj.training.dataset import read_motions
from tests.conftest import Refused
from tests.experiments.runs import finished, run_files

NAMES = ["ymca", "invented-1", "invented-2"]


def question(modules: tuple[int, ...] = (2, 4, 8), nodes: tuple[int, ...] = (50, 100)) -> Scale:
    return Scale(materials(NAMES, [2.0, 4.0]), modules, nodes, RunConfig())


def run_of(config: RunConfig) -> RunResult:
    """Return a run that is the better the larger it is, up to 4 modules and 100 nodes."""
    worse = 1.0 / min(config.option("modules"), 4) + 10.0 / min(config.option("nodes"), 100)
    used = min(config.option("modules"), len(config.motions))
    entropy = {"usage": 0.9, "sharing": 0.2}
    return finished(config, p_e_percent=worse, modules_used=used, entropy=entropy)


def test_movements_double_up_to_all_and_the_longest_is_cut() -> None:
    found = materials(NAMES, [4.0, 2.0])
    assert found == (
        Material("movements", 1, ("ymca",)),
        Material("movements", 2, ("ymca", "invented-1")),
        Material("movements", 3, tuple(NAMES)),
        Material("seconds", 2.0, ("invented-1",), 2.0),
        Material("seconds", 4.0, ("invented-1",), 4.0),
    )


def test_without_motions_dances_are_invented_and_lengths_double() -> None:
    found = materials([], [])
    assert [m.amount for m in found] == [1, 2, 4, 8, 5, 10, 20, 40]
    assert found[3].motions[-1] == "invented-8"
    assert {m.motions for m in found if m.growing == "seconds"} == {("invented",)}


def test_sizes_are_a_cross_whose_lines_meet() -> None:
    spec = question((8, 2, 4), (400, 50, 200, 100))
    assert spec.crossing == Size(4, 100)
    assert spec.lines["modules"] == (Size(2, 100), Size(4, 100), Size(8, 100))
    assert spec.lines["nodes"] == (Size(4, 50), Size(4, 100), Size(4, 200), Size(4, 400))
    assert len(spec.sizes) == 6
    assert len(spec.spec_of(2).configs) == 5 * 6 * 2


def labels_of(material: Material) -> int:
    return len(read_motions(question().point(material, Size(2, 50))).labels)


def test_there_is_a_label_a_movement_and_four_in_one_that_is_cut() -> None:
    assert [labels_of(material) for material in question().materials] == [1, 2, 3, 4, 4]


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


def test_the_words_say_what_the_numbers_say() -> None:
    spec = question()
    results = Results(spec, [run_of(config) for config in spec.spec_of(2).configs])
    assert saturation(results) == [
        "More movements, 50 nodes: enough modules are 4 for 1, 2, 3 movements.",
        "More movements, 4 modules: enough nodes are 100 for 1, 2, 3 movements.",
        "More movements: most modules used 1.0, 2.0, 3.0 for 1, 2, 3 movements; 8 is the most"
        " there are.",
        "More movements: p_e with 4 modules and 50 nodes is 0.45, 0.45, 0.45 % for 1, 2, 3"
        " movements.",
        "More seconds, 50 nodes: enough modules are 4 for 2, 4 s.",
        "More seconds, 4 modules: enough nodes are 100 for 2, 4 s.",
        "More seconds: most modules used 1.0, 1.0 for 2, 4 s; 8 is the most there are.",
        "More seconds: p_e with 4 modules and 50 nodes is 0.45, 0.45 % for 2, 4 s.",
    ]


def test_one_is_not_many() -> None:
    one, two, *_ = question().materials
    assert (amounts([one]), amounts([one, two])) == ("1 movement", "1, 2 movements")
    assert fixed("nodes", Size(1, 50)) == "1 module"
    assert fixed("modules", Size(1, 50)) == "50 nodes"


def test_a_single_size_says_nothing_about_enough() -> None:
    spec = question((2,), (50,))
    results = Results(spec, [run_of(config) for config in spec.spec_of(1).configs])
    assert not any("enough" in sentence for sentence in saturation(results))


def test_runs_that_are_missing_or_diverged_leave_dashes_and_are_told() -> None:
    spec = question()
    first, *others = spec.spec_of(1).configs
    runs = [RunResult(first, {"failed": "diverged"}, 1, 1.0), *map(run_of, others[:3])]
    markdown = as_markdown(Results(spec, runs), runs, len(others) + 1)
    assert "| 2 | 50 | – |" in markdown
    assert "1 of 20 runs diverged" in markdown
    assert "16 of 20 runs are missing" in markdown


def test_the_file_has_a_row_for_each_material_and_size() -> None:
    spec = question()
    rows = as_rows(Results(spec, [run_of(config) for config in spec.spec_of(2).configs]))
    assert len(rows) == 5 * 4
    assert rows[0] | {"growing": "movements", "amount": 1, "modules": 2, "nodes": 50} == rows[0]
    assert (rows[0]["runs"], rows[0]["converged"]) == (2, 2)
    assert rows[0]["entropy.sharing_mean"] == pytest.approx(0.2)
    assert rows[0]["p_e_percent_sd"] == 0.0


def test_the_picture_shows_something_whatever_there_is(tmp_path: Path) -> None:
    spec = question()
    path = tmp_path / "scale.png"
    write_figure(path, Results(spec, [run_of(config) for config in spec.spec_of(2).configs]))
    full = iio.imread(path)
    assert full.std() > 10
    write_figure(path, Results(spec, []))
    empty = iio.imread(path)
    assert empty.shape != full.shape or np.any(empty != full)


@pytest.mark.parametrize("command", ["table1", "ablate", "scale"])
def test_studies_can_be_of_the_papers_models_and_rule(command: str, refused: Refused) -> None:
    refused([command, "--rule", "gated", "--runs", "0"], "take --models posture")
    paper = ["--models", "posture", "--rule", "gated"]
    refused([command, *paper, "--runs", "0"], "runs is 0")  # and nothing else


def test_the_command_writes_tables_file_and_picture_and_goes_on(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(scale, "_EPOCHS", 2)
    words = ["scale", "ymca", "invented-1", "--lengths", "1", "2", "--modules", "2", "3"]
    words += ["--nodes", "5", "--runs", "1", "--out", str(tmp_path)]
    assert main(words) == 0
    first = capsys.readouterr().out
    assert first.splitlines()[-1] == str(tmp_path)
    assert (tmp_path / "scale.md").read_text() in first
    with (tmp_path / "scale.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [(row["growing"], row["amount"], row["modules"]) for row in rows[::2]] == [
        ("movements", "1", "2"),
        ("movements", "2", "2"),
        ("seconds", "1.0", "2"),
        ("seconds", "2.0", "2"),
    ]
    assert all(0.0 < float(row["p_e_percent_mean"]) < 20.0 for row in rows)
    assert all(0.0 <= float(row["entropy.sharing_mean"]) <= 1.0 for row in rows)
    assert (tmp_path / "scale.png").stat().st_size > 10_000
    kept = run_files(tmp_path)[1:]
    times = [path.stat().st_mtime_ns for path in kept]
    run_files(tmp_path)[0].unlink()
    assert main(words) == 0
    again = capsys.readouterr()
    assert again.out == first
    assert again.err.splitlines()[0] == "going on: 7 of 8 runs are there"
    assert [path.stat().st_mtime_ns for path in kept] == times


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--runs", "0"], "runs is 0"),
        (["--nodes", "0"], "nodes is 0"),
        (["--modules", "0"], "modules is 0"),
        (["--modules", "2", "2"], "modules has a value twice"),
        (["--lengths", "0"], "lengths has 0; expected seconds above 0"),
        (["--lengths", "2", "2"], "lengths has a value twice"),
        (["--lengths", "81"], "and invented, the longest movement, lasts 80.00 s"),
        (["ymca"], "ymca, the longest movement, lasts 3.80 s, less than 5 s"),
        (["gone.tsv"], "gone.tsv: no such file"),
        (["ymca", "ymca", "--lengths", "2"], "ymca is given twice"),
        (["--workers", "0"], "workers is 0"),
    ],
)
def test_bad_input_is_one_line_exit_2_and_no_folder(
    words: list[str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["scale", *words, "--out", str(tmp_path / "new")]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert len(printed.err.splitlines()) == 1
    assert message in printed.err
    assert not (tmp_path / "new").exists()


def test_no_size_is_refused() -> None:
    with pytest.raises(BadOptionError, match="modules has no value"):
        question(modules=())
