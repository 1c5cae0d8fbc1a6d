"""Training what is missing, whoever trains, and whatever happens to them."""

import errno
import multiprocessing
import subprocess
import sys
from collections import deque
from pathlib import Path

import pytest

from mpma_mj.commands.workers import require_all
from mpma_mj.errors import BadOptionError, RunFolderError, WorkerError
from mpma_mj.experiments import job
from mpma_mj.experiments.backend import open_backend
from mpma_mj.experiments.engine import finish
from mpma_mj.experiments.folder import RunResult, SweepFolder
from mpma_mj.experiments.job import Job, JobResult
from mpma_mj.experiments.measures import remarks
from mpma_mj.experiments.processes import Processes
from mpma_mj.training.config import versions
from mpma_mj.training.dataset import read_motions
from mpma_mj.training.trainer import train_batch
from mpma_mj.utils import atomic_files
from tests.experiments.runs import TINY, finished, results, spec_of

ROOT = Path(__file__).parents[2]


class Here:
    """A backend that does the work itself, and loses its first jobs."""

    workers = 2

    def __init__(self, losses: int = 0) -> None:
        self.losses = losses
        self.jobs: deque[Job] = deque()
        self.most = 0

    def submit(self, job: Job) -> None:
        self.jobs.append(job)
        self.most = max(self.most, len(self.jobs))

    def next_done(self) -> tuple[Job, JobResult | None]:
        job = self.jobs.popleft()
        self.losses -= 1
        return job, None if self.losses >= 0 else job.do()


class Deadly(Processes):
    """Processes, of which some are killed while they work."""

    deaths = 1

    def submit(self, job: Job) -> None:
        before = set(multiprocessing.active_children())
        super().submit(job)
        if self.deaths > 0:
            self.deaths -= 1
            new = set(multiprocessing.active_children()) - before
            new.pop().kill()


def test_results_are_those_of_a_run_alone_whoever_trains(tmp_path: Path) -> None:
    sweep = spec_of("nodes=5,6", runs=3)
    here, processes = SweepFolder(tmp_path / "a", sweep), SweepFolder(tmp_path / "b", sweep)
    finish(here, Here())
    with open_backend("processes", 3, None) as backend:
        finish(processes, backend)
    assert results(here) == results(processes)
    for config in (sweep.configs[1], sweep.configs[-1]):
        (alone,) = train_batch([config], read_motions(config), sweep.epochs)
        assert results(here)[config]["p_e_percent"] == alone["p_e_percent"]
    assert len({summary["p_e_percent"] for summary in results(here).values()}) == 6
    assert multiprocessing.active_children() == []


def test_only_what_is_missing_is_trained_and_shown(tmp_path: Path) -> None:
    sweep = spec_of(runs=3)
    folder = SweepFolder(tmp_path, sweep)
    folder.begin()
    folder.add(finished(sweep.configs[1], p_e_percent=-1.0))
    shown: list[RunResult] = []
    finish(folder, Here(), shown.extend)
    assert {run.config for run in shown} == {sweep.configs[0], sweep.configs[2]}
    assert results(folder)[sweep.configs[1]]["p_e_percent"] == -1.0
    assert folder.missing() == []
    assert folder.seconds() > 0


def test_no_worker_has_two_jobs(tmp_path: Path) -> None:
    backend = Here()
    finish(SweepFolder(tmp_path, spec_of("nodes=5,6,7", runs=2)), backend)
    assert backend.most == backend.workers


def test_a_job_that_was_lost_is_done_again_and_the_table_says_so(tmp_path: Path) -> None:
    sweep = spec_of("nodes=5,6", runs=2)
    lossy, smooth = SweepFolder(tmp_path / "a", sweep), SweepFolder(tmp_path / "b", sweep)
    finish(lossy, Here(losses=1))
    finish(smooth, Here())
    assert results(lossy) == results(smooth)
    assert sum(run.attempts == 2 for run in lossy.finished()) == 1
    assert remarks(lossy.finished(), 4) == [
        "1 of 4 runs were tried again, because their worker died."
    ]


def test_a_job_that_is_always_lost_is_given_up_and_the_others_are_kept(tmp_path: Path) -> None:
    sweep = spec_of("nodes=5,6", runs=1)
    folder = SweepFolder(tmp_path, sweep)
    backend = Here()
    backend.next_done = lambda: (  # type: ignore[method-assign]
        (job := backend.jobs.popleft()),
        None if job.configs[0].option("nodes") == 6 else job.do(),
    )
    finish(folder, backend)
    assert [config.option("nodes") for config in folder.missing()] == [6]
    assert [run.config.option("nodes") for run in folder.finished()] == [5]
    assert "1 of 2 runs are missing" in remarks(folder.finished(), 2)[0]
    with pytest.raises(WorkerError) as error:
        require_all(folder)
    assert str(error.value) == (
        "1 runs are missing, their workers died repeatedly (memory?); resume with the same"
        f" command, --out {tmp_path} and fewer --workers, or start again with smaller --nodes"
    )


def test_a_process_that_is_killed_is_replaced_and_its_work_done_again(tmp_path: Path) -> None:
    sweep = spec_of("nodes=5,6", runs=2)
    folder, other = SweepFolder(tmp_path / "a", sweep), SweepFolder(tmp_path / "b", sweep)
    with Deadly(2) as backend:
        finish(folder, backend)
    finish(other, Here())
    assert results(folder) == results(other)
    assert sorted(run.attempts for run in folder.finished()) == [1, 1, 1, 2]


def test_a_worker_that_dies_idle_costs_a_try_and_nothing_else() -> None:
    job = Job((TINY,), read_motions(TINY), 1, True, versions())
    with Processes(1) as backend:
        backend.submit(job)
        assert backend.next_done()[1] is not None
        (worker,) = multiprocessing.active_children()
        worker.kill()
        worker.join()
        backend.submit(job)
        assert backend.next_done() == (job, None)
        backend.submit(job)
        assert backend.next_done()[1] is not None


def test_a_setting_that_no_run_can_have_is_refused_before_anything_is_written(
    tmp_path: Path,
) -> None:
    for grid, message in (
        ("nodes=5,0", "nodes is 0"),
        ("reference_noise=0,-1", "reference_noise is -1"),
        ("nodes=5,30000", "nodes is 30000"),
    ):
        with pytest.raises(BadOptionError, match=message):
            finish(SweepFolder(tmp_path / "new", spec_of(grid)), Here())
    assert not (tmp_path / "new").exists()


def test_an_error_in_a_worker_arrives_with_its_traceback() -> None:
    broken = Job(None, read_motions(TINY), 1, True, versions())  # type: ignore[arg-type]
    with Processes(1) as backend:
        backend.submit(broken)
        with pytest.raises(TypeError, match="NoneType") as raised:
            backend.next_done()
    assert "in train_batch" in raised.value.__notes__[0]


def test_workers_of_other_versions_are_refused() -> None:
    job = Job((TINY,), read_motions(TINY), 1, True, versions() | {"numpy": "0.1"})
    with Processes(1) as backend:
        backend.submit(job)
        with pytest.raises(WorkerError, match=r"has numpy .*, the command 0\.1; install the same"):
            backend.next_done()


def test_a_run_that_diverges_is_a_result(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def train(configs: tuple[object, ...], *_: object, stop: bool) -> list[dict[str, str]]:
        return [{"failed": "diverged, at step 3"} for _ in configs]

    monkeypatch.setattr(job, "train_batch", train)
    folder = SweepFolder(tmp_path, spec_of(runs=2))
    finish(folder, Here())
    assert [run.diverged for run in folder.finished()] == [True, True]
    assert folder.missing() == []
    assert remarks(folder.finished(), 2) == ["2 of 2 runs diverged; they count in no mean."]


def test_a_full_disk_loses_the_crowd_in_flight_only(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = SweepFolder(tmp_path, spec_of("nodes=5,6,7,8,9,10,11,12", runs=1))
    room = iter(range(5))
    write_text = atomic_files.Path.write_text

    def until_full(path: Path, *args: str, **options: str) -> int:
        if next(room, None) is None:
            raise OSError(errno.ENOSPC, "No space left on device")
        return write_text(path, *args, **options)

    with Processes(2) as backend:
        monkeypatch.setattr(atomic_files.Path, "write_text", until_full)
        with pytest.raises(RunFolderError, match=r"cannot be written \(No space left"):
            finish(folder, backend)
        monkeypatch.undo()
    assert multiprocessing.active_children() == []
    assert len(folder.finished()) == 2  # a header, and with each run a clock
    assert [p for p in tmp_path.rglob(".*") if p.is_file()] == []
    with Processes(2) as backend:
        finish(folder, backend)
    assert folder.missing() == []


def test_settings_that_read_the_movement_otherwise_give_other_movements(tmp_path: Path) -> None:
    folder = SweepFolder(tmp_path, spec_of("tempo=1,0.5", runs=1))
    finish(folder, Here())
    steps = {
        run.config.option("tempo"): run.summary["environment_steps"] for run in folder.finished()
    }
    assert steps[0.5] > 1.9 * steps[1.0]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("processes", 0, None), "workers is 0"),
        (("ray", -1, None), "workers is -1"),
        (("processes", None, "head:6379"), "add backend=ray, or drop it"),
    ],
)
def test_workers_that_cannot_be_are_refused(
    options: tuple[str, int | None, str | None], message: str
) -> None:
    with pytest.raises(BadOptionError, match=message):
        open_backend(*options)  # type: ignore[arg-type]


def test_workers_find_the_modules_that_this_process_finds(tmp_path: Path) -> None:
    library = tmp_path / "library"
    library.mkdir()
    (library / "found.py").write_text(
        f"import os; open({str(tmp_path / 'imported')!r}, 'a').write(f'{{os.getpid()}}\\n')"
    )
    program = tmp_path / "program.py"
    program.write_text(
        f"import sys; sys.path[:0] = [{str(library)!r}, {str(ROOT)!r}]\n"
        "from mpma_mj.experiments import processes, job\n"
        "from mpma_mj.training.config import RunConfig\n"
        "from mpma_mj.training.dataset import read_motions\n"
        "if __name__ == '__main__':\n"
        "    processes._PRELOADED.append('found')\n"
        "    config = RunConfig.of(nodes=5, modules=1, repeats=1)\n"
        "    job = job.Job((config,), read_motions(config), 1, True, {})\n"
        "    with processes.Processes(2) as backend:\n"
        "        for _ in range(2):\n"
        "            backend.submit(job)\n"
        "        assert all(backend.next_done()[1] for _ in range(2))\n"
    )
    subprocess.run([sys.executable, program], check=True, cwd=tmp_path)
    assert len((tmp_path / "imported").read_text().splitlines()) == 1  # by the server, for both


def test_a_run_knows_its_share_of_the_time(tmp_path: Path) -> None:
    folder = SweepFolder(tmp_path, spec_of(runs=4))
    finish(folder, Here())
    runs = folder.finished()
    assert all(run.seconds > 0 for run in runs)
    assert sum(run.seconds for run in runs) <= folder.seconds()
