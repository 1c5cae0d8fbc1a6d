"""Progress of commands, on standard error; standard output is for results."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.markup import escape
from rich.progress import (
    BarColumn,
    Progress,
    ProgressColumn,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
    track,
)

from mpma_mj.utils.text import printable

__all__ = ["show_count", "show_epochs", "show_frames", "show_range", "show_runs"]


# Metrics of an epoch that are shown, where the agent has them.
_SHOWN: dict[str, Callable[[float], str]] = {
    "epoch": "epoch {:3.0f}".format,
    "learner_acts": lambda acts: "learner" if acts else "expert ",
    "p_e_percent": "p_e {:5.2f} %".format,
    "feedback_ratio": "feedback ratio {:4.2f}".format,
    "gain_feedback": "K {:4.2f}".format,
    "gain_inverse": "L {:4.2f}".format,
}


@contextmanager
def show_epochs(epochs: int | None) -> Iterator[Callable[[dict[str, float]], None]]:
    """Show a line for each epoch and, on a terminal, a bar below them.

    Args:
        epochs: Largest number of epochs, None if it is not known.

    Yields:
        Function that takes the metrics of each epoch.
    """
    text = "epoch {task.completed}" + (" of at most {task.total}" if epochs else "")
    with _bar(TextColumn("training"), BarColumn(), TextColumn(text), TimeElapsedColumn()) as bar:
        task = bar.add_task("training", total=epochs)

        def show(row: dict[str, float]) -> None:
            shown = (form(row[name]) for name, form in _SHOWN.items() if name in row)
            bar.console.print("   ".join(shown), soft_wrap=True)
            bar.advance(task)

        yield show


@contextmanager
def show_runs(
    runs: int, over: int, doing: str = "training"
) -> Iterator[Callable[[int, str], None]]:
    """Show a bar with the remaining time on a terminal, and lines elsewhere.

    Args:
        runs: Number of requested runs.
        over: Number of runs that were finished before.
        doing: Title of the bar.

    Yields:
        Function that takes the number of newly finished runs, and their description.
    """
    counted = TextColumn("{task.completed} of {task.total} runs")
    times = TimeElapsedColumn(), TextColumn("left"), TimeRemainingColumn()
    if over:
        _console().print(f"resuming: {over} of {runs} runs are done", soft_wrap=True)
    with _bar(TextColumn(doing), BarColumn(), counted, *times) as bar:
        task = bar.add_task(doing, total=runs, completed=over)

        def show(count: int, which: str) -> None:
            nonlocal over
            over += count
            if bar.disable:
                bar.console.print(f"{over:4d} of {runs} runs   {which}".rstrip(), soft_wrap=True)
            bar.update(task, completed=over)

        yield show


def show_frames(steps: range) -> Iterable[int]:
    """Show the progress of drawing the frames of a video."""
    return show_range(steps, f"drawing {len(steps)} frames")


def show_range(steps: range, title: str) -> Iterable[int]:
    """Show a title and, on a terminal, the progress through a range."""
    console, title = _console(), printable(title)
    disable = not console.is_terminal
    if disable:
        console.print(title, soft_wrap=True)
    return track(steps, escape(title), console=console, transient=True, disable=disable)


@contextmanager
def show_count(title: str) -> Iterator[Callable[[], None]]:
    """Show a title and, on a terminal, a count whose end is not known.

    Yields:
        Function that counts one more.
    """
    counted = TextColumn("{task.completed} times")
    with _bar(TextColumn(title), counted, TimeElapsedColumn()) as bar:
        task = bar.add_task(title, total=None)
        title_printed = False

        def tick() -> None:
            nonlocal title_printed
            if bar.disable and not title_printed:
                bar.console.print(title, soft_wrap=True)
            title_printed = True
            bar.advance(task)

        yield tick


def _bar(*columns: ProgressColumn) -> Progress:
    """Return a bar that disappears at the end, and shows on terminals only."""
    console = _console()
    return Progress(*columns, console=console, transient=True, disable=not console.is_terminal)


def _console() -> Console:
    """Return standard error without markup, because names may contain "[b]"."""
    return Console(stderr=True, highlight=False, markup=False, emoji=False)
