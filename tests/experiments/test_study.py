"""The pipeline of studies: what is done once, whatever the number and the fate of workers."""

from __future__ import annotations

import csv
import errno
import json
import multiprocessing
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar

import pytest

from mpma_mj.cli import main
from mpma_mj.commands.study import STUDIES
from mpma_mj.errors import BadOptionError, RunFolderError, WorkerError
from mpma_mj.experiments import study as pipeline
from mpma_mj.experiments.backend import Work
from mpma_mj.experiments.study import Record, Study, StudyJob, batches, over_seeds, run_study
from mpma_mj.training.config import RunConfig
from mpma_mj.utils import atomic_files
from mpma_mj.utils.folder_lock import locked
from tests.conftest import Refused
from tests.experiments.runs import Here, run_files

BASE = RunConfig.of(nodes=5, seed=3)
AGENTS = {"small": {"agent": "mpma"}, "none, at all": {"agent": "random"}}


@dataclass(frozen=True, eq=False, kw_only=True)
class CountedJob(StudyJob):
    """Job that leaves a mark in a file for each of its runs."""

    marks: str

    def do(self) -> list[Record]:
        with Path(self.marks).open("a") as file:
            file.writelines(f"{self.name} {config.seed}\n" for config in self.configs)
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


@pytest.fixture
def here(monkeypatch: pytest.MonkeyPatch) -> Here:
    """Return the backend that does the work of all studies in this process."""
    backend = Here()
    monkeypatch.setattr(pipeline, "open_backend", lambda *_: backend)
    return backend


def marks(study: Counted) -> list[str]:
    return sorted(Path(study.marks).read_text().splitlines())


@pytest.mark.usefixtures("here")
def test_a_study_writes_table_rows_and_figure(study: Counted, tmp_path: Path) -> None:
    folder = tmp_path / "out"
    assert run_study(study, folder) == "4 records, 1.75\n"
    names = {path.name for path in folder.iterdir()}
    assert names == {"study.json", "runs", "table.md", "results.csv", "figure.png"}
    rows = [*csv.DictReader((folder / "results.csv").read_text().splitlines())]
    assert [(row["agent"], row["seed"], row["p_e.here"], row["attempts"]) for row in rows] == [
        ("small", "3", "1.5", "1"),
        ("small", "4", "2.0", "1"),
        ("none, at all", "3", "1.5", "1"),
        ("none, at all", "4", "2.0", "1"),
    ]
    header = json.loads((folder / "study.json").read_text())
    assert (header["study"], header["settings"]["runs"]) == ("counted", 2)
    assert "numpy" in header["versions"]


def test_a_study_that_is_resumed_does_only_the_runs_that_are_missing(
    study: Counted, tmp_path: Path
) -> None:
    folder = tmp_path / "out"
    table = run_study(study, folder, 1)
    assert marks(study) == ["none, at all 3", "none, at all 4", "small 3", "small 4"]
    (lost,) = (path for path in run_files(folder) if path.name.startswith("small-seed-3"))
    before = lost.read_text()
    lost.unlink()
    assert run_study(study, folder, 2) == table == (folder / "table.md").read_text()
    assert len(marks(study)) == 5
    assert lost.read_text() == before
    assert multiprocessing.active_children() == []


@pytest.mark.usefixtures("here")
def test_another_study_or_a_strange_folder_is_refused(study: Counted, tmp_path: Path) -> None:
    folder = tmp_path / "out"
    run_study(study, folder)
    with pytest.raises(RunFolderError, match="another study, with runs 2 where 3 is requested"):
        run_study(Counted(marks=study.marks, runs=3), folder)
    strange = tmp_path / "strange"
    strange.mkdir()
    (strange / "notes.txt").write_text("mine")
    with pytest.raises(RunFolderError, match="is not empty and contains no study"):
        run_study(study, strange)
    assert [path.name for path in strange.iterdir()] == ["notes.txt"]


@pytest.mark.usefixtures("here")
def test_a_study_of_other_versions_is_refused(
    study: Counted, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run_study(study, tmp_path / "out")
    monkeypatch.setattr(pipeline, "FORMAT", 99)
    with pytest.raises(RunFolderError, match="where 99 is requested"):
        run_study(study, tmp_path / "out")


@pytest.mark.usefixtures("here")
def test_a_folder_into_which_another_command_writes_is_refused(
    study: Counted, tmp_path: Path
) -> None:
    with (
        locked(tmp_path / "out"),
        pytest.raises(RunFolderError, match="another command is writing into it"),
    ):
        run_study(study, tmp_path / "out")


@pytest.mark.usefixtures("here")
def test_a_damaged_file_of_a_run_is_named(study: Counted, tmp_path: Path) -> None:
    folder = tmp_path / "out"
    run_study(study, folder)
    run_files(folder)[-1].write_text("{")
    with pytest.raises(RunFolderError, match=r"small-seed-4-\w+\.json: damaged.* remove it"):
        run_study(study, folder)


def test_runs_of_lost_workers_are_done_again_and_the_table_says_so(
    study: Counted, tmp_path: Path, here: Here
) -> None:
    here.losses = 1
    table = run_study(study, tmp_path / "out")
    assert table.startswith("4 records, 1.75\n\n1 of 4 runs were tried again, because")


def test_runs_that_are_always_lost_are_missing_and_the_others_are_written(
    study: Counted, tmp_path: Path, here: Here
) -> None:
    def next_done() -> tuple[Work, Any]:
        job: Any = here.jobs.popleft()
        return job, None if job.agent == "small" else job.do()

    here.next_done = next_done  # type: ignore[method-assign]
    folder = tmp_path / "out"
    with pytest.raises(WorkerError) as raised:
        run_study(study, folder)
    assert str(raised.value) == (
        "2 runs are missing, as their worker processes died repeatedly, perhaps for lack of"
        " memory; the results of the others are written; resume with the same command;"
        f" out={folder} and fewer workers, or smaller nodes"
    )
    table = (folder / "table.md").read_text()
    assert table.startswith("2 records, 1.75\n\n2 of 4 runs are missing")
    del here.next_done
    assert run_study(study, folder) == "4 records, 1.75\n"


def test_a_full_disk_loses_the_runs_in_flight_only(
    study: Counted, tmp_path: Path, here: Here, monkeypatch: pytest.MonkeyPatch
) -> None:
    room = iter(range(3))
    write_text = atomic_files.Path.write_text

    def until_full(path: Path, *args: str, **options: str) -> int:
        if next(room, None) is None:
            raise OSError(errno.ENOSPC, "No space left on device")
        return write_text(path, *args, **options)

    monkeypatch.setattr(atomic_files.Path, "write_text", until_full)
    with pytest.raises(RunFolderError, match=r"cannot be written \(No space left"):
        run_study(study, tmp_path / "out")
    monkeypatch.setattr(atomic_files.Path, "write_text", write_text)
    assert len(run_files(tmp_path / "out")) == 2  # and the header
    assert [p for p in (tmp_path / "out").rglob(".*") if p.is_file()] == []
    here.jobs.clear()
    assert run_study(study, tmp_path / "out") == "4 records, 1.75\n"


def test_no_run_is_refused() -> None:
    with pytest.raises(BadOptionError, match="runs is 0; expected at least 1"):
        batches(AGENTS, BASE, 0)


OWN = '''
from dataclasses import dataclass
from typing import ClassVar

from mpma_mj.experiments.study import Study, StudyJob, batches, over_seeds
from mpma_mj.experiments.training import TrainingStudy
from mpma_mj.training.config import RunConfig


@dataclass(frozen=True)
class Factor:
    value: float


@dataclass(frozen=True, eq=False, kw_only=True)
class MyJob(StudyJob):
    factor: Factor

    def do(self):
        return [
            {"agent": self.agent, "seed": c.seed, "diverged": False,
             "p_e": self.factor.value * c.seed}
            for c in self.configs
        ]


@dataclass(frozen=True, kw_only=True)
class MyStudy(Study):
    """Multiply seeds."""

    name: ClassVar[str] = "mine"
    factor: float = 2.0

    def jobs(self):
        agents = {"one": {"agent": "random"}}
        base = RunConfig.of(seed=self.seed)
        return [
            MyJob(agent=agent, configs=configs, factor=Factor(self.factor))
            for agent, configs in batches(agents, base, self.runs)
        ]

    def table(self, records):
        return f"{over_seeds(records, 'p_e').mean:g}"


class Lacking(Study):
    name = "lacking"


class Pointless(TrainingStudy):
    name = "pointless"


class NoStudy:
    name, jobs, table = "none", None, None
'''


@pytest.fixture
def own_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the folder, with a file of studies, in which commands are typed."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "my_study.py").write_text(OWN)
    return tmp_path


def test_a_study_of_an_own_file_runs_in_workers_with_its_own_options(
    own_file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["study", "my_study.py:MyStudy", "--runs", "3", "--seed", "1", "--factor", "1.5"]
    assert main([*words, "--workers", "2", "--out", "out"]) == 0
    assert capsys.readouterr().out.splitlines() == ["3", "", "out"]
    assert len(run_files(own_file / "out")) == 3


def test_the_help_of_a_study_has_its_options(
    own_file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in (*STUDIES, "my_study.py:MyStudy"):
        with pytest.raises(SystemExit, match="0"):
            main(["study", name, "--help"])
        printed = capsys.readouterr().out
        assert printed.startswith(f"usage: mpma study {name} ")
        about, resume, _ = printed.partition("Repeat the command with the same --out to resume.")
        assert resume
        assert "\n\n\n" not in about
        assert "\n  " not in about
        assert all(option in printed for option in ("--runs", "--seed", "--workers", "--out"))
        assert ("--factor" in printed) == (":" in name)
    with pytest.raises(SystemExit, match="0"):
        main(["study", "--help"])
    printed = capsys.readouterr().out
    assert all(f"{name}: " in printed for name in STUDIES)
    assert "\n\n\n" not in printed


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ([], "no study given; expected one of table1, agents, ablation, scaling, unseen,"),
        (["switchin"], "such as my_study.py:MyStudy; did you mean switching?"),
        (["--runs", "1"], "no study '--runs'; expected one of table1"),
        (["my_study.py:Mine"], "expected a class of my_study.py, but it has no Mine"),
        (["my_study.py:Pointless"], "expected a class with points, table, which Pointless lacks"),
        (["gone.py:MyStudy"], "no study 'gone.py:MyStudy': expected a file of Python, but"),
        (
            ["my_study.py:Lacking"],
            "no study 'my_study.py:Lacking': expected a class with jobs, table, which",
        ),
        (["my_study.py:NoStudy"], "inherit from mpma_mj.experiments.study.Study"),
        (
            ["my_study.py:MyStudy", "--runs", "0"],
            "--runs is 0; expected a whole number from 1 to 10000",
        ),
        (["switching", "--runs", "0"], "--runs is 0; expected a whole number from 1 to 10000"),
        (["switching", "--workers", "0"], "--workers is 0; expected at least 1"),
        (["table1", "--address", "head:6379"], "add --backend ray, or leave"),
        (["table1", "--epochs", "0"], "--epochs is 0; expected a whole number from 1 to 10000"),
        (["switching", "--motion", "nope"], "no motion 'nope'"),
        (["latency", "--epochs", "-1"], "--epochs is -1"),
        (["unseen"], "expected at least 3 motions, not only ymca, as each"),
        (["unseen", "synthetic-1", "ymca"], "not only ymca and synthetic-1"),
        (["agents", "--agents", "mpma", "nobody"], "--agents has 'nobody'; expected one of mpma"),
    ],
)
def test_bad_input_is_refused_in_one_line_and_leaves_nothing(
    words: list[str], message: str, refused: Refused, own_file: Path
) -> None:
    refused(["study", *words], message)
    assert {path.name for path in own_file.iterdir()} <= {"my_study.py", "__pycache__"}


@pytest.mark.parametrize("name", ["table1", "ablation", "scaling"])
def test_studies_can_be_of_the_papers_models_and_rule(
    name: str, refused: Refused, tmp_path: Path
) -> None:
    words = ["study", name, "--rule", "gated", "--out", str(tmp_path / "new")]
    refused(words, "choose --models posture")
    refused([*words, "--models", "posture", "--nodes", "0"], "nodes is 0")  # and nothing else
