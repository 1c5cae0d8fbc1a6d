"""Contents of folders, compared."""

from __future__ import annotations

import contextlib
import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

__all__ = ["differences", "snapshot"]

_NOT_RESULTS = ("seconds", "digest")  # how long a run took, and what depends on that
_LARGEST = 1 << 30  # bytes of a file that is read


def snapshot(folder: Path) -> dict[str, str]:
    """Return what each file under a folder contains, as a digest, and each folder, as its kind.

    Times that a run took are left out.
    """
    found = {}
    for path in sorted(folder.rglob("*")):
        name = str(path.relative_to(folder))
        if path.is_symlink() or not (path.is_file() or path.is_dir()):
            found[name] = "special"
        else:
            found[name] = "folder" if path.is_dir() else _digest(path)
    return found


def differences(expected: Mapping[str, str], found: Mapping[str, str]) -> str:
    """Return in a few words how the second snapshot differs from the first; nothing if not."""
    missing = sorted(expected.keys() - found.keys())
    added = sorted(found.keys() - expected.keys())
    other = sorted(k for k in expected.keys() & found.keys() if expected[k] != found[k])
    named = {"missing": missing, "left over": added, "different": other}
    return "; ".join(f"{kind}: {', '.join(names)}" for kind, names in named.items() if names)


def _digest(path: Path) -> str:
    if path.stat().st_size > _LARGEST:
        return "huge"
    data = path.read_bytes()
    if path.suffix == ".json":
        with contextlib.suppress(ValueError, RecursionError):  # a damaged file is compared as it is
            data = json.dumps(_timeless(json.loads(data))).encode()
    return hashlib.sha256(data).hexdigest()


def _timeless(value: Any) -> Any:
    if isinstance(value, dict):
        return {k: _timeless(one) for k, one in value.items() if k not in _NOT_RESULTS}
    return [_timeless(one) for one in value] if isinstance(value, list) else value
