"""Workers: processes that are killed, work that is lost, errors on their way back."""

from __future__ import annotations

import importlib
import multiprocessing
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from mpma_mj.errors import BadOptionError
from mpma_mj.experiments.backend import Processes, Work, get_done, open_backend
from tests.experiments.runs import Here

ROOT = Path(__file__).parents[2]


@dataclass(frozen=True, eq=False, kw_only=True)
class Double(Work):
    """Work that doubles a number, and may take a while."""

    number: Any
    seconds: float = 0.0

    def do(self) -> Any:
        time.sleep(self.seconds)
        return self.number.doubled if self.number is None else 2 * self.number


class Deadly(Processes):
    """Processes, of which the first is killed while it works."""

    deaths = 1

    def submit(self, work: Work) -> None:
        before = set(multiprocessing.active_children())
        super().submit(work)
        if self.deaths > 0:
            self.deaths -= 1
            (set(multiprocessing.active_children()) - before).pop().kill()


@pytest.fixture
def pool() -> Iterator[Processes]:
    with Processes(2) as processes:
        yield processes


def works(*numbers: int, seconds: float = 0.0) -> list[Double]:
    return [Double(number=number, seconds=seconds) for number in numbers]


def doubled(done: Iterator[tuple[Double, Any]]) -> dict[int, Any]:
    return {work.number: result for work, result in done}


def test_all_work_is_done_whoever_does_it(pool: Processes) -> None:
    wanted = {number: 2 * number for number in range(7)}
    assert doubled(get_done(works(*range(7)), Here())) == wanted
    assert doubled(get_done(works(*range(7)), pool)) == wanted


def test_no_more_work_is_out_than_there_are_workers() -> None:
    backend = Here()
    assert len([*get_done(works(*range(7)), backend)]) == 7
    assert backend.most == backend.workers


def test_lost_work_is_done_again_and_counts_its_attempts() -> None:
    done = [*get_done(works(1, 2, 3), Here(losses=1))]
    assert sorted((work.number, work.attempts, result) for work, result in done) == [
        (1, 2, 2),
        (2, 1, 4),
        (3, 1, 6),
    ]


def test_work_that_is_always_lost_is_given_up_and_the_rest_is_done() -> None:
    backend = Here()
    backend.next_done = lambda: (  # type: ignore[method-assign]
        (work := backend.jobs.popleft()),
        None if work.number == 2 else work.do(),  # type: ignore[attr-defined]
    )
    assert doubled(get_done(works(1, 2, 3), backend)) == {1: 2, 2: None, 3: 6}


def test_a_process_that_is_killed_is_replaced_and_only_its_work_is_done_again() -> None:
    with Deadly(2) as backend:
        done = [*get_done(works(1, 2, 3, seconds=0.1), backend)]
    assert sorted((work.number, result) for work, result in done) == [(1, 2), (2, 4), (3, 6)]
    assert sorted(work.attempts for work, _ in done) == [1, 1, 2]
    assert multiprocessing.active_children() == []


def test_a_worker_that_dies_idle_costs_an_attempt_and_nothing_else() -> None:
    work = Double(number=3)
    with Processes(1) as backend:
        backend.submit(work)
        assert backend.next_done() == (work, 6)
        (worker,) = multiprocessing.active_children()
        worker.kill()
        worker.join()
        backend.submit(work)
        assert backend.next_done() == (work, None)
        backend.submit(work)
        assert backend.next_done() == (work, 6)


def test_an_error_in_a_worker_arrives_with_its_traceback(pool: Processes) -> None:
    pool.submit(Double(number=None))
    with pytest.raises(AttributeError, match="NoneType") as raised:
        pool.next_done()
    assert "in do\n" in raised.value.__notes__[0]


class Elsewhere(Double):
    """Work of a class that workers do not find."""

    def __reduce__(self) -> tuple[Any, ...]:
        return importlib.import_module, ("no_such_module",)


def test_work_that_a_worker_cannot_import_is_an_error_and_no_death(pool: Processes) -> None:
    pool.submit(Elsewhere(number=1))
    with pytest.raises(ModuleNotFoundError, match="no_such_module"):
        pool.next_done()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("processes", 0, None), "workers is 0"),
        (("ray", -1, None), "workers is -1"),
        (("processes", None, "head:6379"), "add backend=ray, or leave"),
    ],
)
def test_workers_that_cannot_be_are_refused(
    options: tuple[str, int | None, str | None], message: str
) -> None:
    with pytest.raises(BadOptionError, match=message):
        open_backend(*options)  # type: ignore[arg-type]


def test_workers_need_no_socket_where_its_name_would_be_too_long(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / ("x" * 200)
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    with Processes(1) as pool:
        assert [done for _, done in get_done([Double(number=3)], pool)] == [6]
        assert pool._context.get_start_method() == "spawn"


def test_workers_find_the_modules_that_this_process_finds(tmp_path: Path) -> None:
    library = tmp_path / "library"
    library.mkdir()
    (library / "found.py").write_text(
        f"import os; open({str(tmp_path / 'imported')!r}, 'a').write(f'{{os.getpid()}}\\n')\n"
        "import dataclasses\n"
        "from mpma_mj.experiments.backend import Work\n"
        "@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)\n"
        "class Three(Work):\n"
        "    def do(self): return 3\n"
    )
    program = tmp_path / "program.py"
    program.write_text(
        f"import sys; sys.path[:0] = [{str(library)!r}, {str(ROOT)!r}]\n"
        "from mpma_mj.experiments import backend\n"
        "if __name__ == '__main__':\n"
        "    backend._PRELOADED[:] = ['found']\n"
        "    with backend.Processes(2) as pool:\n"
        "        from found import Three\n"
        "        for _ in range(2):\n"
        "            pool.submit(Three())\n"
        "        assert [pool.next_done()[1] for _ in range(2)] == [3, 3]\n"
    )
    subprocess.run([sys.executable, program], check=True, cwd=tmp_path)
    imported = (tmp_path / "imported").read_text().split()
    assert len(imported) == 2  # by the program, and by the server for both workers
    assert str(os.getpid()) not in imported
