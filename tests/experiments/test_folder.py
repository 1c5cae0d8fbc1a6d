"""The folder of a study: what it keeps, and what it refuses."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import pytest

from mpma_mj.errors import RunFolderError
from mpma_mj.experiments.folder import HEADER, StudyFolder
from mpma_mj.experiments.study import StudyJob
from mpma_mj.experiments.training import TrainingJob
from mpma_mj.utils import data_files
from tests.experiments.runs import finished, run_files, sweep_of

SETTINGS: dict[str, Any] = {"kind": "study", "versions": {"numpy": "2.0"}, "settings": {"runs": 2}}


def jobs_of(*grid: str, runs: int = 2) -> list[TrainingJob]:
    return sweep_of(*grid, runs=runs).jobs()


@pytest.fixture(scope="module")
def job() -> StudyJob:
    return jobs_of()[0]


def begun(path: Path) -> StudyFolder:
    folder = StudyFolder(path, SETTINGS)
    folder.begin()
    return folder


def changed(**settings: Any) -> dict[str, Any]:
    return SETTINGS | {"settings": SETTINGS["settings"] | settings}


def test_records_return_as_they_were_with_their_attempts(tmp_path: Path, job: StudyJob) -> None:
    folder, (first, second) = begun(tmp_path / "new" / "study"), job.configs
    record = finished({}, 1)
    folder.add(job, second, [record, record])
    again = StudyFolder(folder.path, SETTINGS)
    assert again.read(job, second) == [record, record]
    assert (again.has(job, first), again.has(job, second)) == (False, True)


def test_what_is_not_finite_returns_as_none(tmp_path: Path, job: StudyJob) -> None:
    folder = begun(tmp_path)
    folder.add(job, job.configs[0], [finished({}, nmi=math.nan)])
    assert folder.read(job, job.configs[0])[0]["nmi"] is None


def test_files_are_named_by_what_varies_and_never_meet(tmp_path: Path) -> None:
    grid = ("context_signal=halves,labels", "labels=a/b.csv,a_b.csv," + "x" * 300)
    jobs, folder = jobs_of(*grid[:1]), begun(tmp_path)
    for job in jobs:
        for config in job.configs:
            for labels in ("a/b.csv", "a_b.csv", "x" * 300):
                folder.add(job, config.replace(labels=labels), [finished({}, config.seed)])
    names = [path.name for path in run_files(tmp_path)]
    assert len(names) == 2 * 2 * 3
    assert sum("halves" in name and "seed-1" in name for name in names) == 3


def test_a_check_writes_nothing(tmp_path: Path) -> None:
    StudyFolder(tmp_path / "new", SETTINGS)
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize(
    ("other", "message"),
    [
        (changed(runs=3), "with runs 2 where 3 is requested"),
        (changed(nodes=3), "with other settings"),
        (SETTINGS | {"versions": {"numpy": "1.0"}}, r"with numpy 2.0 where 1.0 is requested"),
        (SETTINGS | {"study": "table1"}, "with study None where table1 is requested"),
    ],
)
def test_a_folder_of_another_study_is_refused(
    tmp_path: Path, other: dict[str, Any], message: str
) -> None:
    begun(tmp_path)
    with pytest.raises(RunFolderError) as raised:
        StudyFolder(tmp_path, other)
    assert f"contains another study, {message}" in str(raised.value)
    assert "choose another folder with out" in str(raised.value)
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize("text", ["", "[]", "{", "3", '"study"'])
def test_a_damaged_header_is_refused(tmp_path: Path, text: str) -> None:
    (tmp_path / HEADER).write_text(text)
    with pytest.raises(RunFolderError, match="damaged, or not part of a study"):
        StudyFolder(tmp_path, SETTINGS)


@pytest.mark.parametrize("header", [{}, {"kind": "study", "versions": 3, "settings": None}])
def test_a_foreign_header_is_refused(tmp_path: Path, header: dict[str, object]) -> None:
    data_files.write_json(tmp_path / HEADER, header)
    with pytest.raises(RunFolderError, match="contains another study"):
        StudyFolder(tmp_path, SETTINGS)


def test_files_and_folders_of_something_else_are_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(RunFolderError, match="is a file"):
        StudyFolder(tmp_path / "file", SETTINGS)
    with pytest.raises(RunFolderError, match="is not empty and contains no study"):
        StudyFolder(tmp_path, SETTINGS)


@pytest.mark.parametrize(
    "text", ["", "[]", "{", '{"config": {}}', '{"config": {}, "attempts": 1, "records": [3]}']
)
def test_a_damaged_run_is_refused_by_name(tmp_path: Path, job: StudyJob, text: str) -> None:
    folder = begun(tmp_path)
    folder.add(job, job.configs[0], [finished({})])
    (path,) = run_files(tmp_path)
    path.write_text(text)
    with pytest.raises(RunFolderError, match=rf"{path.name}: damaged.*remove it"):
        folder.read(job, job.configs[0])


def test_a_changed_digit_is_refused(tmp_path: Path, job: StudyJob) -> None:
    folder = begun(tmp_path)
    folder.add(job, job.configs[0], [finished({})])
    (path,) = run_files(tmp_path)
    assert "0.5" in path.read_text()
    path.write_text(path.read_text().replace("0.5", "0.4"))
    with pytest.raises(RunFolderError, match=rf"{path.name}: damaged.*remove it"):
        folder.read(job, job.configs[0])


def test_a_run_under_the_name_of_another_is_refused(tmp_path: Path, job: StudyJob) -> None:
    folder = begun(tmp_path)
    for config in job.configs:
        folder.add(job, config, [finished({}, config.seed)])
    one, other = run_files(tmp_path)
    other.write_text(one.read_text())
    with pytest.raises(RunFolderError, match="belongs to another run; remove it"):
        [folder.read(job, config) for config in job.configs]


def test_files_are_json_with_config_attempts_and_records(tmp_path: Path, job: StudyJob) -> None:
    begun(tmp_path).add(job, job.configs[0], [finished({})])
    content = json.loads(run_files(tmp_path)[0].read_text())
    assert content["config"]["agent"]["nodes"] == 5
    assert content["attempts"] == 1
    assert content["records"][0]["p_e_percent"] == 0.5
