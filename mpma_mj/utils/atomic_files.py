"""Files that are either whole or not there: written beside their place, then renamed."""

from __future__ import annotations

import contextlib
import csv
import io
import json
import math
import os
import zipfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpma_mj.errors import CheckpointError, RunFolderError

__all__ = [
    "FORMAT",
    "atomic_write",
    "csv_text",
    "not_writable",
    "read_arrays",
    "write_arrays",
    "write_atomically",
    "write_json",
    "write_text",
]

FORMAT = 4
"""Version of the files' format; what another version wrote is refused."""

_META = "meta"
# What damaged archives make numpy, zipfile and json raise.
_UNREADABLE = (
    *(OSError, EOFError, KeyError, TypeError, ValueError),
    *(NotImplementedError, RuntimeError, zipfile.BadZipFile),
)


def csv_text(rows: Sequence[Mapping[str, object]]) -> str:
    """Return a table with a header of all names; what is not a number, or not there, is empty."""
    columns = list(dict.fromkeys(name for row in rows for name in row))
    text = io.StringIO()
    writer = csv.DictWriter(text, columns, lineterminator="\n")
    writer.writeheader()
    for row in rows:
        writer.writerow({name: "" if _is_nan(entry) else entry for name, entry in row.items()})
    return text.getvalue()


def _is_nan(entry: object) -> bool:
    return isinstance(entry, float) and math.isnan(entry)


def write_atomically(path: Path, write: Callable[[Path], None]) -> None:
    """Write a file under a temporary name and rename it.

    Args:
        path: Where it is to be; folders on the way are made.
        write: Called with the temporary path, which has the same suffix.

    Raises:
        RunFolderError: The folder cannot be written.
    """
    with atomic_write(path) as temporary:
        write(temporary)


@contextlib.contextmanager
def atomic_write(path: Path) -> Iterator[Path]:
    """Give a temporary path, which becomes the file where all went well, and else vanishes.

    Args:
        path: Where it is to be; folders on the way are made.

    Yields:
        The temporary path, which has the same suffix.

    Raises:
        RunFolderError: The folder cannot be written.
    """
    temporary = path.with_name(f".{path.stem}.{os.getpid()}{path.suffix}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        yield temporary
        temporary.replace(path)
    except OSError as error:
        raise not_writable(path, error) from None
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink()


def not_writable(path: Path, error: OSError) -> RunFolderError:
    """Return what to raise if a file or folder cannot be written."""
    reason = error.strerror or error
    return RunFolderError(
        f"{path}: cannot be written ({reason}); mend that, or choose another folder"
    )


def write_text(path: Path, text: str) -> None:
    """Write a text file; bytes in it, of a file's name, that are no UTF-8 become escapes."""

    def write(temporary: Path) -> None:
        temporary.write_text(text, encoding="utf-8", errors="backslashreplace")

    write_atomically(path, write)


def write_json(path: Path, content: Mapping[str, Any]) -> None:
    """Write a JSON file; what is not a number becomes null."""
    write_text(path, json.dumps(_finite(content), indent=2) + "\n")


def write_arrays(
    path: Path, kind: str, arrays: Mapping[str, NDArray[Any]], meta: Mapping[str, Any]
) -> None:
    """Write arrays by name with what describes them.

    Args:
        path: The `.npz` file.
        kind: What the file is, such as "checkpoint"; checked when it is read.
        arrays: Arrays of numbers by name.
        meta: What JSON can hold.
    """
    header = json.dumps({"format": FORMAT, "kind": kind} | dict(meta))
    content: dict[str, Any] = {_META: np.array(header), **arrays}
    write_atomically(path, lambda temporary: np.savez(temporary, **content))


def read_arrays(path: Path, kind: str) -> tuple[dict[str, NDArray[Any]], dict[str, Any]]:
    """Read what `write_arrays` wrote.

    Args:
        path: The `.npz` file.
        kind: What the file has to be.

    Returns:
        Arrays by name, and the description.

    Raises:
        CheckpointError: There is no such file, or it is damaged, or something else.
    """
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
        meta = json.loads(str(arrays.pop(_META)))
    except FileNotFoundError:
        raise CheckpointError(
            f"{path}: missing; the run stopped before its first epoch was over, or lost the file:"
            " train anew with --overwrite"
        ) from None
    except _UNREADABLE:
        raise CheckpointError(
            f"{path}: damaged, or not a {kind} of this program; train anew with --overwrite"
        ) from None
    if not isinstance(meta, dict) or meta.get("kind") != kind or meta.get("format") != FORMAT:
        raise CheckpointError(
            f"{path}: not a {kind} of format {FORMAT}; train anew with this version"
        )
    return arrays, meta


def _finite(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    if isinstance(value, float | np.floating):
        return float(value) if np.isfinite(value) else None
    return value
