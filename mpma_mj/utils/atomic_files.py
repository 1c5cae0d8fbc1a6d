"""Atomic writing of files: under a temporary name in the same folder, then renamed."""

from __future__ import annotations

import contextlib
import csv
import io
import json
import math
import os
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpma_mj.errors import CheckpointError, RunFolderError

__all__ = [
    "FORMAT",
    "TRAIN_AGAIN",
    "atomic_write",
    "csv_text",
    "not_writable",
    "read_arrays",
    "write_arrays",
    "write_json",
    "write_text",
]

FORMAT = 5
"""Version of the format of files; files of other versions are refused."""

TRAIN_AGAIN = "train again with {overwrite}"
"""Remedy for a damaged run."""

_META = "meta"
# Exceptions that numpy, zipfile and json raise for damaged archives.
_UNREADABLE = (
    *(OSError, EOFError, KeyError, TypeError, ValueError),
    *(NotImplementedError, RuntimeError, zipfile.BadZipFile),
)


def csv_text(rows: Sequence[Mapping[str, object]]) -> str:
    """Return rows as CSV with a header of all names; cells that are NaN or missing are empty."""
    columns = list(dict.fromkeys(name for row in rows for name in row))
    text = io.StringIO()
    writer = csv.DictWriter(text, columns, lineterminator="\n")
    writer.writeheader()
    for row in rows:
        writer.writerow({name: "" if _is_nan(entry) else entry for name, entry in row.items()})
    return text.getvalue()


def _is_nan(entry: object) -> bool:
    return isinstance(entry, float) and math.isnan(entry)


@contextlib.contextmanager
def atomic_write(path: Path) -> Iterator[Path]:
    """Yield a temporary path, which is renamed on success and removed on failure.

    Args:
        path: Path of the file; missing folders are created.

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
    """Return the error for a file or folder that cannot be written."""
    reason = error.strerror or error
    return RunFolderError(
        f"{path}: cannot be written ({reason}); fix that, or choose another folder"
    )


def write_text(path: Path, text: str) -> None:
    """Write a UTF-8 text file; characters that UTF-8 cannot encode become escapes."""
    with atomic_write(path) as temporary:
        temporary.write_text(text, encoding="utf-8", errors="backslashreplace")


def write_json(path: Path, content: Mapping[str, Any]) -> None:
    """Write a JSON file; arrays become lists, NaN and infinite numbers null."""
    write_text(path, json.dumps(_finite(content), indent=2) + "\n")


def write_arrays(
    path: Path, kind: str, arrays: Mapping[str, NDArray[Any]], meta: Mapping[str, Any]
) -> None:
    """Write arrays by name, with a header.

    Args:
        path: The `.npz` file.
        kind: Kind of the file, such as "checkpoint"; checked when the file is read.
        arrays: Arrays of numbers by name.
        meta: Entries of the header, as in JSON.
    """
    header = json.dumps({"format": FORMAT, "kind": kind} | dict(meta))
    content: dict[str, Any] = {_META: np.array(header), **arrays}
    with atomic_write(path) as temporary:
        np.savez(temporary, **content)


def read_arrays(path: Path, kind: str) -> tuple[dict[str, NDArray[Any]], dict[str, Any]]:
    """Read a file that `write_arrays` wrote.

    Args:
        path: The `.npz` file.
        kind: Expected kind of the file.

    Returns:
        Arrays by name, and the header.

    Raises:
        CheckpointError: The file is missing or damaged, or of another kind or format.
    """
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
        meta = json.loads(str(arrays.pop(_META)))
    except FileNotFoundError:
        raise CheckpointError(
            f"{path}: missing; it was removed, or the run stopped before its first epoch was over",
            remedy=TRAIN_AGAIN,
        ) from None
    except _UNREADABLE:
        raise CheckpointError(
            f"{path}: damaged, or not a {kind} of this program", remedy=TRAIN_AGAIN
        ) from None
    if not isinstance(meta, dict) or meta.get("kind") != kind or meta.get("format") != FORMAT:
        raise CheckpointError(
            f"{path}: not a {kind} of format {FORMAT}", remedy="train again with this version"
        )
    return arrays, meta


def _finite(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _finite(item) for key, item in value.items()}
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    if isinstance(value, float | np.floating):
        return float(value) if np.isfinite(value) else None
    return value
