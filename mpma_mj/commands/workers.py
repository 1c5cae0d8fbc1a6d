"""Workers of commands that train many runs."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from mpma_mj.errors import WorkerError
from mpma_mj.options import BackendName

if TYPE_CHECKING:
    from mpma_mj.sweep.folder import RunResult, SweepFolder
    from mpma_mj.training.config import RunConfig

__all__ = ["Workers", "require_all"]


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

    def train(self, folder: SweepFolder, title: Callable[[RunConfig], str] | None = None) -> None:
        """Train the missing runs of a sweep, and show the progress.

        Args:
            folder: Folder of the sweep.
            title: Returns the title of a run; the options that vary if not given.
        """
        from mpma_mj.sweep.backend import open_backend
        from mpma_mj.utils.progress import show_runs

        title_of = title or folder.title
        total, missing = len(folder.spec.configs), len(folder.missing())
        if not missing:
            return
        with (
            _hint_at_resuming(folder),
            open_backend(self.backend, self.workers, self.address) as backend,
        ):
            # Workers start while this module is imported.
            from mpma_mj.sweep.engine import finish

            with show_runs(total, total - missing) as show:

                def on_batch(batch: Sequence[RunResult]) -> None:
                    show(len(batch), title_of(batch[0].config))

                finish(folder, backend, on_batch)


def require_all(folder: SweepFolder) -> None:
    """Raise an error if runs are missing; call it after the results of the others are written.

    Raises:
        WorkerError: Runs are missing.
    """
    missing = len(folder.missing())
    if missing:
        raise WorkerError(
            f"{missing} runs are missing, their workers died repeatedly (memory?); resume with the"
            f" same command, --out {folder.path} and fewer --workers, or start again with smaller"
            " --nodes"
        )


@contextlib.contextmanager
def _hint_at_resuming(folder: SweepFolder) -> Iterator[None]:
    """Print how to resume an interrupted sweep, if some of its runs are saved."""
    try:
        yield
    except KeyboardInterrupt:
        if folder.begun:
            print(f"mpma: to resume: the same command with --out {folder.path}", file=sys.stderr)
        raise
