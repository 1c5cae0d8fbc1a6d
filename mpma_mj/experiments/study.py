"""Pipeline of all studies: folder, resuming, workers, progress, table, figure and video."""

from __future__ import annotations

import abc
import contextlib
import dataclasses
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, SupportsIndex

from mpma_mj.agents.extensions import load_class, path_of
from mpma_mj.errors import WorkerError, placeholder
from mpma_mj.experiments.backend import Backend, Work, get_done, open_backend
from mpma_mj.experiments.batching import cost, pieces, seeds, shares
from mpma_mj.experiments.folder import StudyFolder
from mpma_mj.experiments.records import Record, flat, of_agent, over_seeds, remarks
from mpma_mj.options import BackendName
from mpma_mj.training.config import RunConfig, versions
from mpma_mj.utils.atomic_files import write_text
from mpma_mj.utils.data_files import FORMAT, csv_text
from mpma_mj.utils.folder_lock import locked
from mpma_mj.utils.progress import show_runs
from mpma_mj.utils.text import shell_word
from mpma_mj.utils.validation import Bounds, check_fields

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from mpma_mj.agents import Agent
    from mpma_mj.motions import Motion
    from mpma_mj.trace import Trace
    from mpma_mj.visualization.video import Progress

__all__ = [
    "DRAWN",
    "Agents",
    "Count",
    "Record",
    "Study",
    "StudyJob",
    "batches",
    "of_agent",
    "over_seeds",
    "run_study",
]

Count = Annotated[int, Bounds(1, 10_000)]
"""Number of runs or epochs."""

Agents = Mapping[str, Mapping[str, Any]]
"""Options of the agents that a study compares, by the names of its rows."""

DRAWN = "drawn"
"""Entry of a record that a figure needs; it is no measure, and stays out of `results.csv`."""

_NO_RESULTS = ("seconds",)  # entries of a record that are not the same when it is repeated


@dataclass(frozen=True, eq=False, kw_only=True)
class StudyJob(Work):
    """Runs of one agent, which a worker trains and measures.

    `run_study` cuts it into batches of its runs; a run's records do not depend on the others.

    Attributes:
        agent: Name of the agent's row.
        configs: Config of each run; they differ in their seeds only.
        part: What distinguishes jobs with the same agent and seeds.
    """

    agent: str
    configs: tuple[RunConfig, ...]
    part: str = ""

    @property
    def name(self) -> str:
        """Name of the job, for messages and files."""
        return ", ".join(part for part in (self.part, self.agent) if part)

    @abc.abstractmethod
    def do(self) -> list[Record]:
        """Train and measure the runs, and return the records of each, with its `seed`."""

    def learn_and_imitate(
        self, learned: Motion, imitated: Motion, epochs: int
    ) -> tuple[Agent, NDArray[np.float64], list[Trace | None]]:
        """Let agents learn a motion, and then imitate one without learning.

        Args:
            learned: What agents learn, if they can.
            imitated: What they imitate then.
            epochs: Number of epochs E of learning.

        Returns:
            The R agents; p_e of each epoch, shape (E, R), percent; and each agent's trace without
            learning, None where it diverged.
        """
        from mpma_mj.agents import agent_class
        from mpma_mj.agents.wrappers import Frozen
        from mpma_mj.evaluation.evaluate import EVALUATION_EPISODE, learn_episodes
        from mpma_mj.training.factory import agent_of, make_environments, one_thread
        from mpma_mj.training.rollout import rollout

        config, own_seeds = self.configs[0], [config.seed for config in self.configs]
        learns = agent_class(config.agent_name).trainable
        with one_thread(), contextlib.ExitStack() as stack:
            envs, others = (
                stack.enter_context(
                    contextlib.closing(make_environments(config, own_seeds, motion))
                )
                for motion in (learned, imitated)
            )
            agent = agent_of(config, envs, own_seeds)
            course = learn_episodes(envs, agent, range(epochs if learns else 0))
            recorded = rollout(others, Frozen(agent), EVALUATION_EPISODE)
        return agent, course, [recorded.of_run(run) for run in range(len(own_seeds))]

    def __reduce_ex__(self, protocol: SupportsIndex) -> str | tuple[Any, ...]:
        """Travel to workers by the path of the class, where that is from a file of its own."""
        path = path_of(type(self))
        return (_blank, (path,), vars(self)) if path else super().__reduce_ex__(protocol)


def _blank(path: str) -> Any:
    """Return a job without its fields, which pickle sets."""
    return object.__new__(load_class(path, "study", (), base=StudyJob))


@dataclass(frozen=True, kw_only=True)
class Study(abc.ABC):
    """A study; its fields decide its results, and are options of `mpma study NAME`.

    Attributes:
        runs: Runs of each row, with seeds from `seed` up.
        seed: First seed.
    """

    name: ClassVar[str]
    runs: Count = 10
    seed: int = 0

    def __post_init__(self) -> None:
        """Check the fields.

        Raises:
            BadOptionError: One is out of bounds.
        """
        check_fields(self)

    @abc.abstractmethod
    def jobs(self) -> Sequence[StudyJob]:
        """Return all jobs, what takes longest first.

        Raises:
            MpmaError: A motion cannot be read, or an option is out of bounds.
        """

    @abc.abstractmethod
    def table(self, records: Sequence[Record]) -> str:
        """Return the results in Markdown."""

    def draw(self, path: Path, records: Sequence[Record]) -> None:  # noqa: B027
        """Write the figure, a PNG file; a study may have none."""

    def write_video(  # noqa: B027
        self, path: Path, records: Sequence[Record], progress: Progress
    ) -> None:
        """Write the video, an `.mp4` file; a study may have none."""


def run_study(
    study: Study,
    folder: Path,
    workers: int | None = None,
    *,
    backend: BackendName = "processes",
    address: str | None = None,
    video: Progress | None = None,
) -> str:
    """Run what is missing of a study in its folder, and write table and figure there.

    Args:
        study: The study.
        folder: The folder; one that was begun with the same study is continued.
        workers: Number of workers; as many as there are processors if not given.
        backend: Kind of workers.
        address: HOST:PORT of a Ray cluster; a local one if not given.
        video: Wraps the range of the video's frames; no video is written if not given, as where
            OpenGL does not draw.

    Returns:
        The table in Markdown.

    Raises:
        RunFolderError: The folder holds something else, or cannot be written.
        WorkerError: Workers died repeatedly; raised after the results of other runs are written.
        MpmaError: The study cannot be run.
    """
    # Workers start while the jobs are prepared.
    with locked(folder), open_backend(backend, workers, address) as pool:
        results = StudyFolder(folder, _header(study))
        jobs = study.jobs()
        results.begin()
        _run_missing(jobs, results, pool)
        runs = [(job, config) for job in jobs for config in job.configs]
        finished = [results.read(*run) for run in runs if results.has(*run)]
        records = [one for own in finished for one in own]
        table = "\n\n".join([study.table(records).rstrip(), *remarks(finished, len(runs))])
        write_text(folder / "table.md", f"{table}\n")
        write_text(folder / "results.csv", csv_text([_row(one) for one in records]))
        study.draw(folder / "figure.png", records)
        if video is not None:
            study.write_video(folder / "video.mp4", records, video)
    if missing := len(runs) - len(finished):
        given = placeholder("out", shell_word(folder))
        raise WorkerError(
            f"{missing} runs are missing, as their worker processes died repeatedly, perhaps for"
            " lack of memory; the results of the others are written; resume with the same command",
            remedy=f"{given} and fewer {{workers}}, or smaller {{nodes}}",
        )
    return f"{table}\n"


def batches(agents: Agents, base: RunConfig, runs: int) -> list[tuple[str, tuple[RunConfig, ...]]]:
    """Return the runs of all agents, with their names, what takes longest first.

    Args:
        agents: The agents.
        base: Config that they share, with the first seed.
        runs: Runs of each.

    Raises:
        BadOptionError: An option is out of bounds.
    """
    points = {name: base.replace(**options) for name, options in agents.items()}
    found = [(name, tuple(seeds(point, runs))) for name, point in points.items()]
    return sorted(found, key=lambda batch: cost(batch[1]), reverse=True)


def _header(study: Study) -> dict[str, Any]:
    """Return everything that decides the results, as JSON gives it back."""
    header = {"kind": "study", "format": FORMAT, "versions": versions(), "study": study.name}
    header["settings"] = {field.name: getattr(study, field.name) for field in fields(study)}
    return dict(json.loads(json.dumps(header, default=_plain)))


def _plain(value: Any) -> Any:
    if isinstance(value, RunConfig):
        return value.to_json()
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return dataclasses.asdict(value)
    return str(value)


def _run_missing(jobs: Sequence[StudyJob], results: StudyFolder, pool: Backend) -> None:
    """Let workers do what is missing; runs whose workers die repeatedly stay missing."""
    missing = {job: [c for c in job.configs if not results.has(job, c)] for job in jobs}
    count = shares(sum(map(bool, missing.values())), pool.workers)
    todo = [
        dataclasses.replace(job, configs=batch)
        for job, configs in missing.items()
        for batch in pieces(configs, count)
    ]
    total, left = (sum(len(job.configs) for job in some) for some in (jobs, todo))
    todo.sort(key=lambda job: cost(job.configs), reverse=True)
    with show_runs(total, total - left) as show:
        for job, records in get_done(todo, pool):
            if records is None:
                continue
            for config in job.configs:
                results.add(job, config, [one for one in records if one["seed"] == config.seed])
            show(len(job.configs), job.name)


def _row(record: Record) -> dict[str, Any]:
    """Return what a row of `results.csv` can hold of a record."""
    return {
        name: math.nan if value is None else value
        for name, value in flat({k: v for k, v in record.items() if k != DRAWN}).items()
        if not (isinstance(value, list) or name in _NO_RESULTS)
    }
