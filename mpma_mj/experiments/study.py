"""The pipeline of all studies: folder, resuming, workers, progress, table and figure."""

from __future__ import annotations

import abc
import contextlib
import dataclasses
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents import Agent, agent_class
from mpma_mj.agents.wrappers import Frozen
from mpma_mj.errors import RunFolderError, WorkerError
from mpma_mj.evaluation.evaluate import EVALUATION_EPISODE, learn_episodes
from mpma_mj.evaluation.statistics import Interval, interval
from mpma_mj.experiments.backend import Work, get_done, open_backend
from mpma_mj.experiments.batching import cut
from mpma_mj.experiments.folder import check_folder, flat, read_json
from mpma_mj.experiments.spec import seeds, without_seed
from mpma_mj.motions import Motion
from mpma_mj.trace import Trace
from mpma_mj.training.config import RunConfig, versions
from mpma_mj.training.factory import agent_of, make_environments, one_thread
from mpma_mj.training.rollout import rollout
from mpma_mj.utils.atomic_files import FORMAT, csv_text, write_json, write_text
from mpma_mj.utils.folder_lock import locked
from mpma_mj.utils.progress import show_runs

__all__ = [
    "DRAWN",
    "HEADER",
    "Agents",
    "Record",
    "Study",
    "StudyJob",
    "batches",
    "lost",
    "of_agent",
    "over_seeds",
    "run_study",
]

Array = NDArray[np.float64]
Record = dict[str, Any]
"""What JSON can hold of one run: `agent`, `seed`, and measures by name, perhaps nested."""

Agents = Mapping[str, Mapping[str, Any]]
"""Options of the agents that a study compares, by the names of its rows."""

HEADER = "study.json"
DRAWN = "drawn"
"""Entry of a record that a figure needs; it is no measure, and stays out of tables."""


@dataclass(frozen=True, eq=False, kw_only=True)
class StudyJob(Work):
    """A batch of runs of one agent, which a worker trains and measures.

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
        """Name of the job's file."""
        seed = f"seed {self.configs[0].seed}"
        words = " ".join(part for part in (self.agent, self.part, seed) if part)
        return "-".join("".join(c if c.isalnum() else " " for c in words).split())

    @abc.abstractmethod
    def do(self) -> list[Record]:
        """Train and measure the runs, and return the record of each."""

    def learn_and_imitate(
        self, learned: Motion, imitated: Motion, epochs: int
    ) -> tuple[Agent, Array, list[Trace | None]]:
        """Let agents learn a motion, and then imitate one without learning.

        Args:
            learned: What agents learn, if they can.
            imitated: What they imitate then.
            epochs: Number of epochs E of learning.

        Returns:
            The R agents; p_e of each epoch, shape (E, R), percent; and each agent's trace without
            learning, None where it diverged.
        """
        config, seeds = self.configs[0], [config.seed for config in self.configs]
        learns = agent_class(config.agent_name).trainable
        with one_thread(), contextlib.ExitStack() as stack:
            envs, others = (
                stack.enter_context(contextlib.closing(make_environments(config, seeds, motion)))
                for motion in (learned, imitated)
            )
            agent = agent_of(config, envs, seeds)
            course = learn_episodes(envs, agent, range(epochs if learns else 0))
            recorded = rollout(others, Frozen(agent), EVALUATION_EPISODE)
        return agent, course, [recorded.of_run(run) for run in range(len(seeds))]


@dataclass(frozen=True, kw_only=True)
class Study(abc.ABC):
    """A study; its fields decide its results.

    Attributes:
        runs: Runs of each agent, with seeds from `seed` up.
        seed: First seed.
    """

    name: ClassVar[str]
    runs: int = 10
    seed: int = 0

    @abc.abstractmethod
    def jobs(self) -> Sequence[StudyJob]:
        """Return all jobs, what takes longest first; they do not depend on the workers.

        Raises:
            MpmaError: A motion cannot be read, or an option is out of bounds.
        """

    @abc.abstractmethod
    def table(self, records: Sequence[Record]) -> str:
        """Return the results in Markdown."""

    @abc.abstractmethod
    def draw(self, path: Path, records: Sequence[Record]) -> None:
        """Write the figure, a PNG file."""


def run_study(study: Study, folder: Path, workers: int | None = None) -> str:
    """Run the jobs of a study that are missing in its folder, and write table and figure there.

    Args:
        study: The study.
        folder: The folder; one that was begun with the same study is continued.
        workers: Number of processes; as many as there are processors if not given.

    Returns:
        The table in Markdown.

    Raises:
        RunFolderError: The folder holds something else, or cannot be written.
        WorkerError: Workers died repeatedly; the results of other jobs stay in the folder.
        MpmaError: The study cannot be run.
    """
    header = {"kind": "study", "format": FORMAT, "versions": versions(), "study": study.name}
    header = json.loads(json.dumps(header | {"settings": dataclasses.asdict(study)}))
    jobs = study.jobs()
    with locked(folder), open_backend("processes", workers, None) as backend:
        check_folder(folder, HEADER, header)
        write_json(folder / HEADER, header)
        files = {job.name: folder / "jobs" / f"{job.name}.json" for job in jobs}
        missing = [job for job in jobs if not files[job.name].exists()]
        total, left = (sum(len(job.configs) for job in some) for some in (jobs, missing))
        with show_runs(total, total - left) as show:
            for job, records in get_done(missing, backend):
                if records is not None:
                    write_json(files[job.name], {"records": records})
                    show(len(job.configs), job.name)
        found = [record for job in jobs for record in _records(files[job.name])]
        table = study.table(found)
        write_text(folder / f"{study.name}.md", table)
        write_text(folder / f"{study.name}.csv", csv_text([_scalars(one) for one in found]))
        study.draw(folder / f"{study.name}.png", found)
    return table


def batches(agents: Agents, base: RunConfig, runs: int) -> list[tuple[str, tuple[RunConfig, ...]]]:
    """Return the batches of runs of all agents, with their names, what takes longest first.

    Args:
        agents: The agents.
        base: Config that they share, with the first seed.
        runs: Runs of each.

    Raises:
        BadOptionError: An option is out of bounds.
    """
    points = {base.replace(**options): name for name, options in agents.items()}
    names = {without_seed(point): name for point, name in points.items()}
    configs = [config for point in points for config in seeds(point, runs)]
    # As for one worker, so that jobs and their files are the same for any number.
    return [(names[without_seed(batch[0])], batch) for batch in cut(configs, 1)]


def of_agent(records: Sequence[Record], agent: str) -> list[Record]:
    """Return the records of an agent, in the order of seeds."""
    return sorted((one for one in records if one["agent"] == agent), key=lambda one: one["seed"])


def over_seeds(records: Sequence[Record], *path: str) -> Interval:
    """Return mean and interval of a measure, given its path in a record, where there is one."""
    found = []
    for record in records:
        value: Any = record
        for name in path:
            value = None if value is None else value.get(name)
        if value is not None:
            found.append(float(value))
    return interval(found)


def lost(records: Sequence[Record]) -> str:
    """Return a sentence on runs that diverged; empty without any."""
    count = len({(one["agent"], one["seed"]) for one in records if one["diverged"]})
    runs = "1 run, which counts" if count == 1 else f"{count} runs, which count"
    return f"\n\nDiverged: {runs} in no mean." if count else ""


def _records(path: Path) -> list[Record]:
    try:
        return list(read_json(path)["records"])
    except FileNotFoundError:
        raise WorkerError(
            f"{path.stem}: its workers died repeatedly (memory?); resume with the same command,"
            " fewer --workers or fewer --runs"
        ) from None
    except (OSError, ValueError, KeyError, TypeError):
        remedy = "remove it and start again"
        raise RunFolderError(f"{path}: damaged, or not of a study", remedy=remedy) from None


def _scalars(record: Record) -> dict[str, Any]:
    """Return what a row of a table can hold of a record."""
    cells = flat(record).items()
    return {
        name: math.nan if value is None else value
        for name, value in cells
        if not (isinstance(value, list) or name.startswith(f"{DRAWN}."))
    }
