"""Ways in which files of a folder get damaged: by disks, by copying, by hands and by programs."""

from __future__ import annotations

import json
import os
import shutil
import zipfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpma_mj.utils.data_files import write_arrays, write_json

__all__ = ["damage"]

_Way = Callable[[Path, Path, np.random.Generator], None]

_HUGE = 1 << 42  # bytes of a file that has holes
_DEEP = 100_000  # brackets
_TRIES = 20  # to find a damage that changes the file


def damage(
    folder: Path,
    files: Sequence[str],
    other: Path,
    rng: np.random.Generator,
    *,
    crafted: bool = True,
) -> str:
    """Damage a file in one way.

    Args:
        folder: A folder.
        files: Files in it, one of which is damaged.
        other: A folder of the same kind, from which files may be confused.
        rng: Random numbers.
        crafted: Whether it may be such that the file is a valid one, which only a program can do.

    Returns:
        What was done to which file; it begins with "crafted" where that is so.
    """
    for _ in range(_TRIES):
        name = files[rng.integers(len(files))]
        path = folder / name
        kinds = _OF_ALL | _OF_SUFFIX.get(path.suffix, {})
        names = [kind for kind in kinds if crafted or not kind.startswith("crafted")]
        kind = names[rng.integers(len(names))]
        before = path.read_bytes()
        kinds[kind](path, other, rng)
        if not path.is_file() or path.stat().st_size >= _HUGE or path.read_bytes() != before:
            return f"{kind}: {name}"
    raise RuntimeError(f"{folder}: none of {', '.join(files)} was changed")


def _bits(path: Path, _: Path, rng: np.random.Generator) -> None:
    data = bytearray(path.read_bytes())
    for place in rng.integers(len(data), size=rng.choice([1, 1, 2, 8])) if data else ():
        data[place] ^= 1 << int(rng.integers(8))
    path.write_bytes(data)


def _cut(path: Path, _: Path, rng: np.random.Generator) -> None:
    data = path.read_bytes()
    path.write_bytes(data[: rng.integers(len(data))] if data else b"")


def _zeros(path: Path, _: Path, rng: np.random.Generator) -> None:
    data = path.read_bytes()
    start = int(rng.integers(len(data))) if data else 0
    end = min(len(data), start + int(rng.integers(1, 4096)))
    path.write_bytes(data[:start] + bytes(end - start) + data[end:])


def _appended(path: Path, _: Path, rng: np.random.Generator) -> None:
    path.write_bytes(path.read_bytes() + rng.bytes(int(rng.integers(1, 100))))


def _empty(path: Path, _: Path, rng: np.random.Generator) -> None:
    path.write_bytes(b"")


def _gone(path: Path, _: Path, rng: np.random.Generator) -> None:
    path.unlink()


def _huge(path: Path, _: Path, rng: np.random.Generator) -> None:
    if rng.random() < 0.5:
        path.write_bytes(b"")
    os.truncate(path, _HUGE)


def _pipe(path: Path, _: Path, rng: np.random.Generator) -> None:
    path.unlink()
    os.mkfifo(path)


def _folder(path: Path, _: Path, rng: np.random.Generator) -> None:
    path.unlink()
    path.mkdir()


def _link(path: Path, _: Path, rng: np.random.Generator) -> None:
    path.unlink()
    places = ("/dev/zero", "/dev/null", "nowhere", path.name, "/")
    path.symlink_to(places[rng.integers(len(places))])


def _of_other(path: Path, other: Path, rng: np.random.Generator) -> None:
    """Put the file of the same name there, or another one of the same kind."""
    same = sorted(other.rglob(path.name))
    alike = sorted(other.rglob(f"*{path.suffix}"))
    choice = same if same and rng.random() < 0.5 else alike
    if choice:
        shutil.copyfile(choice[rng.integers(len(choice))], path)


def _neighbour(path: Path, _: Path, rng: np.random.Generator) -> None:
    alike = sorted(one for one in path.parent.iterdir() if one.is_file() and one != path)
    if alike:
        shutil.copyfile(alike[rng.integers(len(alike))], path)


_VALUES: tuple[Any, ...] = (
    *(None, True, [], {}, "", "text", "a\nb\x1b[31m", [[1]], {"epoch": 1}),
    *(-1, 0, 1, 2, 10**30, 10**400, 1e308, -1e308, 1e-308, float("nan"), float("inf")),
)


def _changed_json(content: Any, rng: np.random.Generator) -> Any:
    """Return JSON in which a random part is changed, removed or added."""
    places = list(_places(content))
    if not places or rng.random() < 0.05:
        return _VALUES[rng.integers(len(_VALUES))]
    owner, key = places[rng.integers(len(places))]
    choice = rng.random()
    if choice < 0.2:
        del owner[key]
    elif choice < 0.3 and isinstance(owner, dict):
        owner[f"{key}_"] = owner.pop(key) if choice < 0.25 else 1
    elif choice < 0.5 and isinstance(owner[key], int | float):
        owner[key] = type(owner[key])(owner[key] + rng.choice([-1, 1, 0.1]))
    else:
        owner[key] = _VALUES[rng.integers(len(_VALUES))]
    return content


def _places(content: Any) -> Any:
    """Yield each object or list inside of JSON with each of its keys or indices."""
    if isinstance(content, dict | list):
        for key in list(content) if isinstance(content, dict) else range(len(content)):
            yield content, key
            yield from _places(content[key])


def _json(path: Path, _: Path, rng: np.random.Generator) -> None:
    content = _changed_json(json.loads(path.read_text()), rng)
    path.write_text(json.dumps(content, indent=2) + "\n")


def _crafted_json(path: Path, _: Path, rng: np.random.Generator) -> None:
    content = json.loads(path.read_text())
    content.pop("digest", None)
    changed = _changed_json(content, rng)
    write_json(path, changed if isinstance(changed, dict) else {"content": changed})


def _deep_json(path: Path, _: Path, rng: np.random.Generator) -> None:
    path.write_text("[" * _DEEP + "]" * _DEEP if rng.random() < 0.5 else '{"a":' * _DEEP)


def _digit(path: Path, _: Path, rng: np.random.Generator) -> None:
    data = bytearray(path.read_bytes())
    digits = [place for place, byte in enumerate(data) if chr(byte).isdigit()]
    if digits:
        data[digits[rng.integers(len(digits))]] = ord(str(rng.integers(10)))
    path.write_bytes(data)


def _crafted_arrays(path: Path, _: Path, rng: np.random.Generator) -> None:
    """Change an array, or the header, of an archive, which stays a valid one."""
    with np.load(path) as file:
        arrays: dict[str, NDArray[Any]] = {n: file[n] for n in file.files if n != "digest"}
    name = list(arrays)[rng.integers(len(arrays))]
    if name == "meta" and rng.random() < 0.8:
        meta = json.loads(str(arrays["meta"]))
        arrays["meta"] = np.array(json.dumps(_changed_json(meta, rng)))
    else:
        changed = _changed_array(arrays.pop(name), rng)
        arrays |= {} if changed is None else {name: changed}
    _save(path, arrays)


def _changed_array(array: NDArray[Any], rng: np.random.Generator) -> NDArray[Any] | None:
    """Return another array, or None."""
    ways: list[Callable[[], Any]] = [
        lambda: None,
        lambda: array[:-1] if array.ndim else array[None],
        lambda: array[None],
        lambda: array.reshape(-1),
        lambda: array.T,
        lambda: np.concatenate([array, array]) if array.ndim else array,
        lambda: array.astype(str),
        lambda: array.astype("S8"),
        lambda: array.astype(np.complex128),
        lambda: array.astype(np.float32),
        lambda: array.astype(np.int8),
        lambda: array.astype(bool),
        lambda: array.astype(object),
        lambda: np.zeros(0),
        lambda: np.zeros(array.shape, "datetime64[s]"),
        *(
            lambda value=value: _with(array, value, rng)
            for value in (np.nan, np.inf, 1e300, -1e9, 1e-9)
        ),
    ]
    try:
        return ways[rng.integers(len(ways))]()
    except (TypeError, ValueError):  # of texts as numbers
        return None


def _with(array: NDArray[Any], value: float, rng: np.random.Generator) -> NDArray[Any]:
    changed = np.array(array, np.float64)
    if changed.size:
        changed.flat[rng.integers(changed.size)] = value
    return changed


def _save(path: Path, arrays: dict[str, NDArray[Any]]) -> None:
    """Write arrays, with a digest where that is possible."""
    try:
        meta = json.loads(str(arrays["meta"]))
    except (KeyError, ValueError):
        meta = None
    if isinstance(meta, dict) and all(array.dtype != object for array in arrays.values()):
        write_arrays(path, "", {n: array for n, array in arrays.items() if n != "meta"}, meta)
        return
    with zipfile.ZipFile(path, "w") as archive:
        for name, array in arrays.items():
            with archive.open(f"{name}.npy", "w") as member:
                np.lib.format.write_array(member, array)


_OF_ALL: dict[str, _Way] = {
    "flipped bits": _bits,
    "cut off": _cut,
    "zeros": _zeros,
    "appended bytes": _appended,
    "emptied": _empty,
    "removed": _gone,
    "huge": _huge,
    "a pipe": _pipe,
    "a folder": _folder,
    "a link": _link,
    "of another one": _of_other,
    "of a neighbour": _neighbour,
}
_OF_SUFFIX: dict[str, dict[str, _Way]] = {
    ".json": {
        "changed JSON": _json,
        "crafted JSON": _crafted_json,
        "crafted, other JSON": _crafted_json,
        "deep JSON": _deep_json,
        "digit": _digit,
    },
    ".npz": {f"crafted arrays{i}": _crafted_arrays for i in ("", " 2", " 3", " 4", " 5")},
    ".csv": {"digit": _digit},
    ".md": {"digit": _digit},
}
