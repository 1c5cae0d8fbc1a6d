"""Files in which this program keeps its data: JSON, arrays by name, and tables."""

from __future__ import annotations

import csv
import hashlib
import io
import json
import math
import sys
import zipfile
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from tokenize import TokenError  # of a header that NumPy takes for Python 2
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpma_mj._version import __version__
from mpma_mj.errors import CheckpointError
from mpma_mj.utils.atomic_files import atomic_write, write_text
from mpma_mj.utils.input_files import MISSING, file_problem

__all__ = [
    "FORMAT",
    "TRAIN_AGAIN",
    "as_json",
    "csv_text",
    "is_archive",
    "is_json",
    "json_text",
    "read_arrays",
    "read_digest",
    "read_json",
    "write_arrays",
    "write_json",
]

FORMAT = 8
"""Version of the format of files; files of other versions are refused."""

TRAIN_AGAIN = "train again with {overwrite}"
"""Remedy for a damaged run."""

_LARGEST = 100_000_000  # bytes of a JSON file, such as the records of a long run (choice)
_MOST_FORMATS = 1000
_META, _DIGEST = "meta", "digest"
# Exceptions that numpy, zipfile and json raise for damaged archives; the last of deep nesting.
_UNREADABLE = (
    *(OSError, EOFError, KeyError, TypeError, ValueError, SyntaxError),
    *(NotImplementedError, RuntimeError, zipfile.BadZipFile, TokenError, RecursionError),
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


def write_json(path: Path, content: Mapping[str, Any]) -> None:
    """Write a JSON file with a digest; arrays become lists, NaN and infinite numbers null."""
    write_text(path, json_text(content))


def json_text(content: Mapping[str, Any]) -> str:
    """Return what `write_json` writes.

    Raises:
        TypeError, ValueError: JSON cannot hold the content.
    """
    plain = as_json(content)
    return json.dumps(plain | {_DIGEST: _digest(plain)}, indent=2) + "\n"


def read_json(path: Path, largest: int = _LARGEST) -> dict[str, Any]:
    """Read a file that `write_json` wrote.

    Args:
        path: The file.
        largest: Largest size that is sane, bytes.

    Returns:
        Its object, without the digest.

    Raises:
        FileNotFoundError: There is no such file.
        ValueError: The file is damaged, or was not written by this program.
        CheckpointError: It was written by another version.
    """
    if not path.exists():
        raise FileNotFoundError(path)
    if problem := file_problem(path, largest=largest):
        raise ValueError(problem.partition(";")[0])
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        digest = content.pop(_DIGEST, None)
        same = digest == _digest(content)
    except (*_UNREADABLE, AttributeError):  # the last of a list
        raise ValueError("damaged") from None
    number = content.get("format", FORMAT)
    if isinstance(number, int) and number != FORMAT and 0 < number < _MOST_FORMATS:
        versions = content.get("versions")
        writer = versions.get("mpma-mj") if isinstance(versions, dict) else None
        raise CheckpointError(
            f"{path}: format {number}, written by mpma-mj {writer or 'of another version'}; this is"
            f" {__version__}, which reads format {FORMAT}",
            remedy="train again",
        )
    if not same:
        raise ValueError("damaged")
    return content


def is_json(path: Path, keys: Collection[str]) -> bool:
    """Return whether a file is JSON with these keys, of whatever version."""
    try:
        return (
            not file_problem(path, largest=_LARGEST)
            and keys <= json.loads(path.read_bytes()).keys()
        )
    except (*_UNREADABLE, AttributeError):
        return False


def is_archive(path: Path, kind: str) -> bool:
    """Return whether a file is an archive of this kind, of whatever version."""
    try:
        return (
            not file_problem(path) and json.loads(str(_read_archive(path)[_META]))["kind"] == kind
        )
    except _UNREADABLE:
        return False


def as_json(content: Mapping[str, Any]) -> dict[str, Any]:
    """Return an object as JSON gives it back; NaN and infinite numbers become null."""
    return dict(json.loads(json.dumps(_finite(content))))


def _digest(content: Mapping[str, Any]) -> str:
    """Return the digest of an object as JSON gives it back."""
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def write_arrays(
    path: Path, kind: str, arrays: Mapping[str, NDArray[Any]], meta: Mapping[str, Any]
) -> None:
    """Write arrays by name, with a header and a digest.

    Args:
        path: The `.npz` file.
        kind: Kind of the file, such as "checkpoint"; checked when the file is read.
        arrays: Arrays of numbers by name.
        meta: Entries of the header, as in JSON.
    """
    header = json.dumps({"format": FORMAT, "kind": kind} | dict(meta))
    content: dict[str, Any] = {_META: np.array(header), **arrays}
    content[_DIGEST] = np.array(_digest_of_arrays(content))
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
    problem = file_problem(path, largest=sys.maxsize)  # as large as what was written
    if problem not in ("", MISSING):
        problem, _, remedy = problem.partition("; ")
        is_denied = problem.startswith("cannot be read")
        raise CheckpointError(f"{path}: {problem}", remedy=remedy if is_denied else TRAIN_AGAIN)
    try:
        arrays = _read_archive(path)
        digest = str(arrays.pop(_DIGEST, None))
        same = digest == _digest_of_arrays(arrays)
        meta = json.loads(str(arrays.pop(_META)))
    except FileNotFoundError:
        raise CheckpointError(f"{path}: missing", remedy=f"restore it, or {TRAIN_AGAIN}") from None
    except _UNREADABLE:
        raise CheckpointError(
            f"{path}: damaged, or not a {kind} of this program", remedy=TRAIN_AGAIN
        ) from None
    if not isinstance(meta, dict) or meta.get("kind") != kind or meta.get("format") != FORMAT:
        raise CheckpointError(
            f"{path}: not a {kind} of format {FORMAT}", remedy="train again with this version"
        )
    if not same:
        raise CheckpointError(f"{path}: damaged", remedy=TRAIN_AGAIN)
    return arrays, meta


def read_digest(path: Path) -> str:
    """Return the digest of the content of a file that `read_arrays` accepts."""
    return str(_read_archive(path)[_DIGEST])


def _read_archive(path: Path) -> dict[str, NDArray[Any]]:
    """Return the arrays of an archive that NumPy wrote, uncompressed.

    Raises:
        ValueError, ...: One of `_UNREADABLE`. No more memory is taken than the file has bytes.
    """
    with zipfile.ZipFile(path) as archive:
        members = archive.infolist()
        is_compressed = any(member.compress_type != zipfile.ZIP_STORED for member in members)
        if is_compressed or sum(member.file_size for member in members) > path.stat().st_size:
            raise ValueError("compressed")
        return {
            member.filename.removesuffix(".npy"): _read_array(archive, member) for member in members
        }


def _read_array(archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> NDArray[Any]:
    with archive.open(member) as file:
        np.lib.format.read_magic(file)
        shape, is_fortran, kind = np.lib.format.read_array_header_1_0(file)
        if kind.hasobject or math.prod(shape) * kind.itemsize != member.file_size - file.tell():
            raise ValueError("another number of bytes than the header says")
        content = np.ndarray(shape, kind, file.read(), order="F" if is_fortran else "C")
        return content.copy(order="K")  # which can be written


def _digest_of_arrays(arrays: Mapping[str, NDArray[Any]]) -> str:
    """Return the digest of arrays with their names, types and shapes."""
    digest = hashlib.sha256()
    for name, array in sorted(arrays.items()):
        digest.update(f"{name} {array.dtype.str} {array.shape}\n".encode())
        digest.update(array.tobytes())
    return digest.hexdigest()


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
