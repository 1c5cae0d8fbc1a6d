"""Workers of commands that train many runs."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from mpma_mj.commands.folders import hint_at_resuming, output_folder
from mpma_mj.errors import WorkerError
from mpma_mj.options import BackendName

if TYPE_CHECKING:
    from mpma_mj.experiments.folder import RunResult, SweepFolder
    from mpma_mj.experiments.spec import SweepSpec
    from mpma_mj.training.config import RunConfig

__all__ = ["SweepWorkers", "Workers", "require_all"]


@dataclass(frozen=True, kw_only=True)
class Workers:
    """Workers that train.

    Attributes:
        backend: Processes of this machine, or workers of a Ray cluster.
        workers: Number of parallel workers; as many as there are processors if not given.
        address: HOST:PORT of the head of a Ray cluster, or "auto" for the cluster of this machine;
            a new cluster is started if not given.
    """

    backend: BackendName = "processes"
    workers: int | None = None
    address: str | None = None

    @contextlib.contextmanager
    def trained(
        self,
        spec: SweepSpec,
        out: Path | None,
        command: str,
        title: Callable[[RunConfig], str] | None = None,
    ) -> Iterator[SweepFolder]:
        """Train the missing runs of a sweep, and lock its folder while results are written.

        Args:
            spec: The runs.
            out: The folder; a new one, named by the command and the time, if not given.
            command: Name of the command.
            title: Returns the title of a run; the options that vary if not given.

        Yields:
            The folder.

        Raises:
            WorkerError: Runs are missing; raised after the results of the others are written.
        """
        from mpma_mj.experiments.folder import SweepFolder

        with output_folder(out, command) as path:
            folder = SweepFolder(path, spec)
            self._train(folder, title)
            yield folder
            require_all(folder)

    def _train(self, folder: SweepFolder, title: Callable[[RunConfig], str] | None) -> None:
        from mpma_mj.experiments.backend import open_backend
        from mpma_mj.utils.progress import show_runs

        title_of = title or folder.title
        total, missing = len(folder.spec.configs), len(folder.missing())
        if not missing:
            return
        with (
            hint_at_resuming(lambda: folder.begun, f"the same command with --out {folder.path}"),
            open_backend(self.backend, self.workers, self.address) as backend,
        ):
            # Workers start while this module is imported.
            from mpma_mj.experiments.engine import finish

            with show_runs(total, total - missing) as show:

                def on_batch(batch: Sequence[RunResult]) -> None:
                    show(len(batch), title_of(batch[0].config))

                finish(folder, backend, on_batch)


SweepWorkers = Annotated[tyro.conf.OmitArgPrefixes[Workers], tyro.conf.arg(name="worker")]


def require_all(folder: SweepFolder) -> None:
    """Raise a `WorkerError` if runs are missing."""
    missing = len(folder.missing())
    if missing:
        raise WorkerError(
            f"{missing} runs are missing, their workers died repeatedly (memory?); resume with the"
            f" same command, --out {folder.path} and fewer --workers, or start again with smaller"
            " --nodes"
        )
