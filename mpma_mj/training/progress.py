"""What is shown while a run is under way."""

from __future__ import annotations

from collections.abc import Iterable
from types import TracebackType
from typing import Self

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, track

__all__ = ["EpochDisplay", "track_frames"]


class EpochDisplay:
    """A line for each epoch and, on a terminal, a bar below them.

    Goes to standard error, so that standard output stays for results.
    """

    def __init__(self, epochs: int) -> None:
        """Prepare to show at most `epochs` more epochs."""
        self._console = Console(stderr=True, highlight=False)
        self._bar = Progress(
            TextColumn("training"),
            BarColumn(),
            TextColumn("epoch {task.completed} of at most {task.total}"),
            TimeElapsedColumn(),
            console=self._console,
            transient=True,
            disable=not self._console.is_terminal,
        )
        self._task = self._bar.add_task("training", total=epochs)

    def __enter__(self) -> Self:
        self._bar.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._bar.stop()

    def show(self, row: dict[str, float]) -> None:
        """Show the measures of an epoch."""
        self._console.print(
            f"epoch {row['epoch']:3.0f}   p_e {row['p_e_percent']:5.2f} %"
            f"   feedback ratio {row['feedback_ratio']:4.2f}"
            f"   K {row['gain_feedback']:4.2f}   L {row['gain_inverse']:4.2f}"
        )
        self._bar.advance(self._task)


def track_frames(steps: range) -> Iterable[int]:
    """Count the frames of a video on a bar."""
    console = Console(stderr=True)
    return track(
        steps, "drawing ", console=console, transient=True, disable=not console.is_terminal
    )
