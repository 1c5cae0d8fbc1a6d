"""Studies whose runs are trained: that results are those of a run alone."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import pytest

from mpma_mj.errors import BadOptionError
from mpma_mj.experiments.study import run_study
from mpma_mj.training import trainer
from mpma_mj.training.dataset import read_motions
from mpma_mj.training.trainer import train_batch
from tests.experiments.runs import TINY, sweep_of


def results(folder: Path) -> list[dict[str, str]]:
    return [*csv.DictReader((folder / "results.csv").read_text().splitlines())]


def test_results_are_those_of_a_run_alone_whoever_trains(tmp_path: Path) -> None:
    study = sweep_of("nodes=5,6", runs=3)
    tables = [run_study(study, tmp_path / str(workers), workers) for workers in (1, 3)]
    assert tables[0] == tables[1]
    rows = results(tmp_path / "1")
    assert rows == results(tmp_path / "3")
    config = TINY.replace(nodes=6, seed=2)
    (alone,) = train_batch([config], read_motions(config), study.epochs)
    assert float(rows[-1]["p_e_percent"]) == alone["p_e_percent"]
    assert len({row["p_e_percent"] for row in rows}) == 6


def test_a_run_has_its_share_of_the_time() -> None:
    (job,) = sweep_of(runs=2, epochs=1).jobs()
    first, second = (record["seconds"] for record in job.do())
    assert first == second > 0


def test_a_run_that_diverges_is_a_result(monkeypatch: pytest.MonkeyPatch) -> None:
    def train(configs: tuple[object, ...], *_: object, stop: bool) -> list[dict[str, str]]:
        return [{"failed": "diverged, at step 3"} for _ in configs]

    study = sweep_of(runs=2)
    (job,) = study.jobs()
    monkeypatch.setattr(trainer, "train_batch", train)
    records = job.do()
    assert [one["diverged"] for one in records] == [True, True]
    assert "| 0 of 2 | – ± – |" in study.table(records)


def test_options_that_change_the_reading_give_other_motions() -> None:
    whole, half = (job.motion for job in sweep_of("tempo=1,0.5", runs=1).jobs())
    assert len(half) > 1.9 * len(whole)


@pytest.mark.parametrize(
    ("words", "options", "message"),
    [
        (["nodes=5,0"], {}, "nodes is 0"),
        (["reference_noise=0,-1"], {}, "reference_noise is -1"),
        (["nodes=5,30000"], {}, "nodes is 30000"),
        ([], {"runs": 0}, "runs is 0"),
        ([], {"epochs": 0}, "epochs is 0"),
    ],
)
def test_what_no_run_can_have_is_refused_before_anything_is_written(
    words: list[str], options: dict[str, Any], message: str, tmp_path: Path
) -> None:
    with pytest.raises(BadOptionError, match=message):
        run_study(sweep_of(*words, **options), tmp_path / "new", 1)
    assert not (tmp_path / "new").exists()
