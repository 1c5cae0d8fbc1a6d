"""What all commands have in common that train many runs."""

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
    """Who trains.

    Attributes:
        backend: Processes of this machine, or workers of a Ray cluster.
        workers: How many at a time; as many as there are processors if not given.
        address: HOST:PORT of the Ray cluster's head, or "auto" for the cluster of this machine;
            one is started if not given.
    """

    backend: BackendName = "processes"
    workers: int | None = None
    address: str | None = None

    def train(self, folder: SweepFolder, title: Callable[[RunConfig], str] | None = None) -> None:
        """Train what is missing in the folder of a sweep, showing how far it is.

        Args:
            folder: The sweep.
            title: What to call a run; the settings that vary if not given.
        """
        from mpma_mj.sweep.backend import open_backend
        from mpma_mj.utils.progress import show_runs

        titled = title or folder.title
        total, missing = len(folder.spec.configs), len(folder.missing())
        if not missing:
            return
        with (
            _hint_at_resuming(folder),
            open_backend(self.backend, self.workers, self.address) as backend,
        ):
            # Workers get ready while this is imported.
            from mpma_mj.sweep.engine import finish

            with show_runs(total, total - missing) as show:

                def on_batch(batch: Sequence[RunResult]) -> None:
                    show(len(batch), titled(batch[0].config))

                finish(folder, backend, on_batch)


def require_all(folder: SweepFolder) -> None:
    """Fail if runs are missing, after all that can be had from the others is written.

    Raises:
        WorkerError: Runs are missing.
    """
    missing = len(folder.missing())
    if missing:
        raise WorkerError(
            f"{missing} runs are missing, their workers died time and again (memory?); the same"
            f" command with --out {folder.path} and fewer --workers goes on with them, or start"
            " anew with smaller --nodes"
        )


@contextlib.contextmanager
def _hint_at_resuming(folder: SweepFolder) -> Iterator[None]:
    """Say where an interrupted sweep can be gone on with, if some of it is saved."""
    try:
        yield
    except KeyboardInterrupt:
        if folder.begun:
            print(f"mpma: to go on: the same command with --out {folder.path}", file=sys.stderr)
        raise
