"""Training all runs of a sweep that are not over yet."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

from mpma_mj.experiments.backend import Backend, get_done
from mpma_mj.experiments.batching import cut
from mpma_mj.experiments.folder import RunResult, SweepFolder
from mpma_mj.experiments.job import Job
from mpma_mj.experiments.spec import SweepSpec, by_point, without_seed
from mpma_mj.motions import Motion
from mpma_mj.training.config import RunConfig, versions
from mpma_mj.training.dataset import read_motions
from mpma_mj.training.trainer import check

__all__ = ["OnBatch", "finish"]

OnBatch = Callable[[Sequence[RunResult]], None]


def finish(folder: SweepFolder, backend: Backend, on_batch: OnBatch = lambda batch: None) -> None:
    """Train the runs of a sweep that are missing in its folder, and write them there.

    Runs whose workers die time and again stay missing.

    Args:
        folder: The sweep.
        backend: Who trains.
        on_batch: Called with the runs of every batch that is over.

    Raises:
        MpmaError: A movement cannot be read, a setting is outside what it may be, or the folder
            cannot be written; what is over stays in the folder.
    """
    jobs = _jobs(folder.spec, folder.missing(), backend.workers)
    folder.begin()
    began = time.perf_counter()
    for job, done in get_done(jobs, backend):
        if done is None:
            continue
        batch = [
            RunResult(config, summary, job.attempts, done.seconds)
            for config, summary in zip(job.configs, done.summaries, strict=True)
        ]
        for run in batch:
            folder.add(run)
        now = time.perf_counter()
        folder.add_seconds(now - began)
        began = now
        on_batch(batch)


def _jobs(spec: SweepSpec, configs: Sequence[RunConfig], workers: int) -> list[Job]:
    """Return the work to do, longest first, after a look at whether it can be done."""
    motions: dict[RunConfig, Motion] = {}
    read: dict[tuple[object, ...], Motion] = {}  # by what reading looks at
    for point, runs in by_point(configs).items():
        source = (point.motions, point.reading, point.env.arms)
        if source not in read:
            read[source] = read_motions(point)
        motions[point] = read[source]
        check(runs[0], motions[point])
    ours = versions()
    return [
        Job(batch, motions[without_seed(batch[0])], spec.epochs, spec.stop, ours)
        for batch in cut(configs, workers)
    ]
