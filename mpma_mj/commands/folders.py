"""Files and folders that commands write."""

from __future__ import annotations

import contextlib
import itertools
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mpma_mj.errors import BadOptionError, RunFolderError
from mpma_mj.utils.atomic_files import remove_leftovers, write_text
from mpma_mj.utils.data_files import FORMAT, write_json
from mpma_mj.utils.folder_lock import locked
from mpma_mj.utils.text import did_you_mean, printable

if TYPE_CHECKING:
    from mpma_mj.commands.run_options import OutsideClasses
    from mpma_mj.training.run_folder import RunFolder

__all__ = [
    "check_new_file",
    "free_folder",
    "given_runs",
    "hint_if_interrupted",
    "locked_runs",
    "output_folder",
    "results_folder",
    "write_result",
    "write_tables",
]


def check_new_file(
    option: str, path: Path | None, endings: Sequence[str], *, overwrite: bool
) -> None:
    """Check the file that an option names before a command computes what it will contain.

    What commands left beside it when they were killed is removed.

    Args:
        option: Name of the option in Python.
        path: The file; nothing is checked if None.
        endings: Endings of names that the command can write.
        overwrite: Whether a file that exists may be replaced.

    Raises:
        BadOptionError: The name has another ending, or the file exists.
    """
    if path is None:
        return
    if path.suffix not in endings:
        expected = f"a file name that ends in {' or '.join(endings)}"
        near = did_you_mean(path.suffix.lower(), endings)
        raise BadOptionError(option=option, value=str(path), expected=expected, remedy=near)
    if path.exists() and not overwrite:
        raise BadOptionError(f"{path}: already exists", remedy="{overwrite} replaces it")
    remove_leftovers(path.parent)


@contextlib.contextmanager
def results_folder(out: Path | None, stem: str, parent: Path = Path("runs")) -> Iterator[Path]:
    """Lock the output folder of a command that trains no run of its own; see `output_folder`.

    Raises:
        RunFolderError: The folder is that of a run or a study, or as of `output_folder`.
    """
    from mpma_mj.experiments.folder import HEADER

    with output_folder(out, stem, parent) as folder:
        for name, content in (("config.json", "a run"), (HEADER, "a study")):
            if (folder / name).exists():
                problem = f"{folder}: contains {content}"
                raise RunFolderError(problem, remedy="choose another folder with {out}")
        yield folder


@contextlib.contextmanager
def output_folder(out: Path | None, stem: str, parent: Path = Path("runs")) -> Iterator[Path]:
    """Lock the output folder of a command while the command runs.

    Args:
        out: The folder; a new one, named by the stem and the time, if not given.
        stem: Beginning of the name of a new folder.
        parent: Parent of a new folder.

    Yields:
        The folder.

    Raises:
        RunFolderError: Another command writes into the folder, or it cannot be written.
    """
    with contextlib.ExitStack() as stack:
        for folder in _new_folders(stem, parent) if out is None else [out]:
            with contextlib.suppress(FileExistsError):  # just created by another command
                stack.enter_context(locked(folder, new=out is None))
                break
        yield folder


def given_runs(
    paths: Sequence[Path], outside: OutsideClasses | None, command: str
) -> Sequence[RunFolder]:
    """Open the runs that a command names, for reading.

    Raises:
        BadOptionError: No run is given.
        MpmaError: As of `open_runs`.
    """
    from mpma_mj.training.run_folder import RunFolder, open_runs

    if not paths:
        raise BadOptionError(f"no run given; try: mpma {command} runs/ymca")
    if outside is None:
        return [RunFolder(path) for path in paths]
    return open_runs(paths, **vars(outside))


@contextlib.contextmanager
def locked_runs(
    paths: Sequence[Path], outside: OutsideClasses | None, command: str
) -> Iterator[Sequence[RunFolder]]:
    """Open runs for a command and lock them, each once even if it is given several times.

    Raises:
        MpmaError: As of `given_runs` and `RunFolder.locked`.
    """
    folders = given_runs(paths, outside, command)
    with contextlib.ExitStack() as stack:
        for folder in {folder.path.resolve(): folder for folder in folders}.values():
            stack.enter_context(folder.locked())
        yield folders


@contextlib.contextmanager
def hint_if_interrupted(hint: str, begun: Callable[[], bool] = lambda: True) -> Iterator[None]:
    """Print how to go on after Ctrl-C, if something has begun."""
    try:
        yield
    except KeyboardInterrupt:
        if begun():
            print(f"mpma: {hint}", file=sys.stderr)
        raise


def write_tables(folder: Path, name: str, markdown: str, csv: str = "") -> None:
    """Write a table as Markdown and, where there is one, as CSV; print it."""
    write_text(folder / f"{name}.md", markdown)
    if csv:
        write_text(folder / f"{name}.csv", csv)
    print(markdown)


def write_result(path: Path, motion: str, content: Mapping[str, Any]) -> None:
    """Write the results of an analysis as JSON, with the name of the motion."""
    write_json(path, {"format": FORMAT, "motion": motion} | dict(content))


def free_folder(stem: str) -> Path:
    """Return the path of a folder, named by a stem and the time, that does not exist yet."""
    return next(path for path in _new_folders(stem, Path("runs")) if not path.exists())


def _new_folders(stem: str, parent: Path) -> Iterator[Path]:
    """Yield candidates for the path of a new folder."""
    name = f"{printable(stem)}-{time.strftime('%Y%m%d-%H%M%S')}"
    yield parent / name
    yield from (parent / f"{name}-{i}" for i in itertools.count(2))
