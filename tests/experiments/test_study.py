"""Studies: jobs that are done once, whatever the number of workers."""

import csv
import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar

import pytest

from mpma_mj.errors import BadOptionError, RunFolderError
from mpma_mj.experiments.study import (
    Record,
    Study,
    StudyJob,
    batches,
    lost,
    over_seeds,
    run_study,
)
from mpma_mj.training.config import RunConfig

BASE = RunConfig.of(nodes=5, seed=3)
AGENTS = {"small": {"agent": "mpma"}, "none, at all": {"agent": "random"}}


@dataclass(frozen=True, eq=False, kw_only=True)
class CountedJob(StudyJob):
    """Job that leaves a mark in a file whenever it is done."""

    marks: str

    def do(self) -> list[Record]:
        with Path(self.marks).open("a") as file:
            file.write(f"{self.name}\n")
        return [
            {"agent": self.agent, "seed": c.seed, "diverged": False, "p_e": {"here": 0.5 * c.seed}}
            for c in self.configs
        ]


@dataclass(frozen=True, kw_only=True)
class Counted(Study):
    """Study of such jobs."""

    name: ClassVar[str] = "counted"
    runs: int = 2
    marks: str
    agents: dict[str, dict[str, str]] = field(default_factory=lambda: AGENTS)

    def jobs(self) -> Sequence[StudyJob]:
        return [
            CountedJob(agent=agent, configs=configs, marks=self.marks)
            for agent, configs in batches(self.agents, BASE, self.runs)
        ]

    def table(self, records: Sequence[Record]) -> str:
        return f"{len(records)} records, {over_seeds(records, 'p_e', 'here').mean:g}\n"

    def draw(self, path: Path, records: Sequence[Record]) -> None:
        path.write_text(str(len(records)))


@pytest.fixture
def study(tmp_path: Path) -> Counted:
    return Counted(marks=str(tmp_path / "marks"))


def marks(study: Counted) -> list[str]:
    return sorted(Path(study.marks).read_text().split("\n")[:-1])


def test_a_study_writes_table_rows_and_figure(study: Counted, tmp_path: Path) -> None:
    folder = tmp_path / "out"
    assert run_study(study, folder, 1) == "4 records, 1.75\n"
    names = {path.name for path in folder.iterdir()}
    assert names == {"study.json", "jobs", "counted.md", "counted.csv", "counted.png"}
    rows = [*csv.DictReader((folder / "counted.csv").read_text().splitlines())]
    assert [(row["agent"], row["seed"], row["p_e.here"]) for row in rows] == [
        ("small", "3", "1.5"),
        ("small", "4", "2.0"),
        ("none, at all", "3", "1.5"),
        ("none, at all", "4", "2.0"),
    ]


def test_a_study_that_is_resumed_does_only_the_jobs_that_are_missing(
    study: Counted, tmp_path: Path
) -> None:
    folder = tmp_path / "out"
    run_study(study, folder, 1)
    assert marks(study) == ["none-at-all-seed-3", "small-seed-3"]
    (folder / "jobs" / "small-seed-3.json").unlink()
    table = run_study(study, folder, 2)
    assert marks(study) == ["none-at-all-seed-3", "small-seed-3", "small-seed-3"]
    assert table == (folder / "counted.md").read_text()


def test_another_study_or_a_strange_folder_is_refused(study: Counted, tmp_path: Path) -> None:
    folder = tmp_path / "out"
    run_study(study, folder, 1)
    with pytest.raises(RunFolderError, match="another study, with runs 2 where 3 is requested"):
        run_study(Counted(marks=study.marks, runs=3), folder, 1)
    strange = tmp_path / "strange"
    strange.mkdir()
    (strange / "notes.txt").write_text("mine")
    with pytest.raises(RunFolderError, match="is not empty and holds no study"):
        run_study(study, strange, 1)
    assert [path.name for path in strange.iterdir()] == ["notes.txt"]


def test_a_damaged_file_of_a_job_is_named(study: Counted, tmp_path: Path) -> None:
    folder = tmp_path / "out"
    run_study(study, folder, 1)
    (folder / "jobs" / "small-seed-3.json").write_text("{")
    with pytest.raises(RunFolderError, match=r"small-seed-3\.json: damaged.* remove it"):
        run_study(study, folder, 1)


def test_no_run_is_refused() -> None:
    with pytest.raises(BadOptionError, match="runs is 0; expected at least 1"):
        batches(AGENTS, BASE, 0)


def test_runs_that_diverged_are_counted_and_are_in_no_mean() -> None:
    records: list[Record] = [
        {"agent": "a", "seed": 0, "diverged": False, "p_e": {"here": 1.0}},
        {"agent": "a", "seed": 1, "diverged": True},
        {"agent": "a", "seed": 2, "diverged": False, "p_e": {"here": None}},
    ]
    assert over_seeds(records, "p_e", "here").mean == 1.0
    assert lost(records) == "\n\nDiverged: 1 run, which counts in no mean."
    assert lost([*records, {"agent": "b", "seed": 1, "diverged": True}]).startswith(
        "\n\nDiverged: 2 runs, which count in"
    )
    assert lost(records[:1]) == ""


def test_files_of_jobs_are_whole_json(study: Counted, tmp_path: Path) -> None:
    run_study(study, tmp_path / "out", 2)
    files = sorted((tmp_path / "out" / "jobs").iterdir())
    assert [len(json.loads(path.read_text())["records"]) for path in files] == [2, 2]
