"""The folder of a sweep: what it keeps, and what it refuses."""

import csv
import dataclasses
import json
import math
from pathlib import Path

import pytest

from mpma_mj.errors import RunFolderError
from mpma_mj.experiments import folder as module
from mpma_mj.experiments.folder import SweepFolder
from mpma_mj.experiments.spec import SweepSpec
from mpma_mj.training.config import RunConfig
from mpma_mj.utils import atomic_files
from tests.experiments.runs import finished, run_files, spec_of


def begun(path: Path, sweep: SweepSpec) -> SweepFolder:
    folder = SweepFolder(path, sweep)
    folder.begin()
    return folder


def test_runs_come_back_as_they_were_in_the_order_they_were_asked_for(tmp_path: Path) -> None:
    sweep = spec_of("context_signal=halves,labels")
    folder = begun(tmp_path / "new" / "sweep", sweep)
    runs = [finished(config, attempts=i + 1) for i, config in enumerate(sweep.configs)]
    for run in reversed(runs[1:]):
        folder.add(run)
    again = SweepFolder(folder.path, sweep)
    assert again.finished() == runs[1:]
    assert again.missing() == [sweep.configs[0]]


def test_what_is_not_finite_comes_back_as_nothing(tmp_path: Path) -> None:
    sweep = spec_of(runs=1)
    folder = begun(tmp_path, sweep)
    folder.add(finished(sweep.configs[0], nmi=math.nan))
    assert folder.finished()[0].summary["nmi"] is None


def test_files_tell_what_varies_and_never_meet(tmp_path: Path) -> None:
    sweep = spec_of("context_signal=halves,labels", "labels=a/b.csv,a_b.csv," + "x" * 300)
    folder = begun(tmp_path, sweep)
    for config in sweep.configs:
        folder.add(finished(config))
    names = [path.name for path in run_files(tmp_path)]
    assert len(names) == len(sweep.configs)
    assert sum("halves" in name and "seed-1" in name for name in names) >= 2
    assert folder.missing() == []


def test_a_title_is_short_however_many_movements_there_are(tmp_path: Path) -> None:
    one, many = (RunConfig.of(motions=names) for names in [("ymca",), ("ymca", "a.bvh", "b.bvh")])
    folder = SweepFolder(tmp_path, SweepSpec((one, many), 1))
    assert [folder.title(c) for c in (one, many)] == ["motions ymca", "motions ymca and 2 more"]


def test_looking_writes_nothing(tmp_path: Path) -> None:
    SweepFolder(tmp_path / "new", spec_of())
    assert not (tmp_path / "new").exists()


def test_training_time_adds_up(tmp_path: Path) -> None:
    folder = begun(tmp_path, spec_of())
    assert folder.seconds() == 0.0
    folder.add_seconds(1.5)
    SweepFolder(tmp_path, spec_of()).add_seconds(2.0)
    assert folder.seconds() == 3.5


def test_rows_have_every_measure_and_the_settings_that_vary(tmp_path: Path) -> None:
    sweep = spec_of("context_signal=halves,labels", runs=1)
    folder = begun(tmp_path, sweep)
    runs = [finished(sweep.configs[0]), finished(sweep.configs[1], attempts=2)]
    runs[1] = dataclasses.replace(runs[1], summary={"failed": "diverged, at step 3"})
    folder.write_rows(runs)
    with (tmp_path / "results.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["context_signal"] for row in rows] == ["halves", "labels"]
    assert rows[0]["active_modules.M"] == "2"
    assert rows[0]["p_e_percent"] == "0.5"
    assert rows[1]["attempts"] == "2"
    assert rows[1]["failed"] == "diverged, at step 3"
    assert rows[1]["p_e_percent"] == ""


@pytest.mark.parametrize(
    ("other", "message"),
    [
        (spec_of("nodes=5,7"), "of another grid"),
        (spec_of("nodes=5,6", runs=3), "of 4 runs where 6 are requested"),
        (spec_of("nodes=5,6", epochs=3), "with epochs 2 where 3 is requested"),
        (spec_of("context_signal=halves,labels"), "of another grid"),
        (spec_of("nodes=5,6", "arms=kinematic"), "with arms physics where kinematic is requested"),
    ],
)
def test_a_folder_of_another_sweep_is_refused(
    tmp_path: Path, other: SweepSpec, message: str
) -> None:
    begun(tmp_path, spec_of("nodes=5,6"))
    with pytest.raises(RunFolderError) as raised:
        SweepFolder(tmp_path, other)
    assert message in str(raised.value)
    assert "choose another folder with out" in str(raised.value)
    assert "\n" not in str(raised.value)


def test_a_folder_of_another_version_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun(tmp_path, spec_of())
    older = module.versions() | {"numpy": "1.0"}
    monkeypatch.setattr(module, "versions", lambda: older)
    with pytest.raises(RunFolderError, match=r"where 1\.0 is"):
        SweepFolder(tmp_path, spec_of())
    monkeypatch.undo()
    monkeypatch.setattr(atomic_files, "FORMAT", 99)
    with pytest.raises(RunFolderError, match="where 99 is requested"):
        SweepFolder(tmp_path, spec_of())


@pytest.mark.parametrize("text", ["", "[]", "{", "3", '"sweep"'])
def test_a_damaged_header_is_refused(tmp_path: Path, text: str) -> None:
    begun(tmp_path, spec_of())
    (tmp_path / "sweep.json").write_text(text)
    with pytest.raises(RunFolderError, match="damaged, or not of a sweep"):
        SweepFolder(tmp_path, spec_of())


@pytest.mark.parametrize("text", ["{}", '{"kind": "sweep", "settings": 3, "runs": null}'])
def test_a_foreign_header_is_refused(tmp_path: Path, text: str) -> None:
    (tmp_path / "sweep.json").write_text(text)
    with pytest.raises(RunFolderError, match="holds another sweep"):
        SweepFolder(tmp_path, spec_of())


def test_files_and_folders_of_something_else_are_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(RunFolderError, match="is a file"):
        SweepFolder(tmp_path / "file", spec_of())
    with pytest.raises(RunFolderError, match="is not empty and holds no sweep"):
        SweepFolder(tmp_path, spec_of())


@pytest.mark.parametrize("text", ["", "[]", "{", '{"config": {}}'])
def test_a_damaged_run_is_refused_by_name(tmp_path: Path, text: str) -> None:
    sweep = spec_of(runs=1)
    folder = begun(tmp_path, sweep)
    folder.add(finished(sweep.configs[0]))
    (path,) = run_files(tmp_path)
    path.write_text(text)
    with pytest.raises(RunFolderError, match=rf"{path.name}: damaged.*remove it"):
        folder.finished()


def test_a_run_under_another_ones_name_is_refused(tmp_path: Path) -> None:
    sweep = spec_of(runs=2)
    folder = begun(tmp_path, sweep)
    for config in sweep.configs:
        folder.add(finished(config))
    one, other = run_files(tmp_path)
    other.write_text(one.read_text())
    with pytest.raises(RunFolderError, match="is of another run"):
        folder.finished()


@pytest.mark.parametrize("text", ["", "[]", '{"training_seconds": "long"}'])
def test_a_damaged_clock_is_refused(tmp_path: Path, text: str) -> None:
    folder = begun(tmp_path, spec_of())
    (tmp_path / "time.json").write_text(text)
    with pytest.raises(RunFolderError, match=r"time\.json: damaged"):
        folder.seconds()


def test_the_header_says_what_was_asked(tmp_path: Path) -> None:
    begun(tmp_path, spec_of("nodes=5,6", runs=1))
    content = json.loads((tmp_path / "sweep.json").read_text())
    assert content["runs"] == [{"nodes": 5, "seed": 0}, {"nodes": 6, "seed": 0}]
    assert content["settings"]["rule"] == "weighted"
    assert content["settings"]["motions"] == ["ymca"]
    assert content["epochs"] == 2
    assert "numpy" in content["versions"]
