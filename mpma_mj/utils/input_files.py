"""Input files that a user names: checks before one is opened."""

from __future__ import annotations

import os
import re
import stat
from pathlib import Path

__all__ = ["FOLDER", "MISSING", "SMALL_FILE", "file_problem", "is_web_address"]

MISSING = "no such file; check the path"
FOLDER = "is a folder; give the path of a file in it"
"""Problems that callers treat in their own way."""

_LARGEST = 4_000_000_000  # bytes: days of a recording (choice)
SMALL_FILE = 16_000_000
"""Largest size, bytes, of a file that is written by hand or describes a body (choice)."""

_WEB_ADDRESS = re.compile(r"(https?|ftps?|s3|gs):/", re.IGNORECASE)  # a path keeps one slash
_KINDS = {
    stat.S_ISFIFO: "a pipe",
    stat.S_ISSOCK: "a socket",
    stat.S_ISCHR: "a device",
    stat.S_ISBLK: "a device",
}


def file_problem(path: str | Path, *, largest: int = _LARGEST) -> str:
    """Return why a file cannot be read as input, without opening it: a pipe may never end.

    Args:
        path: The file.
        largest: Largest size that is sane, bytes.

    Returns:
        What is wrong with it and how to mend it, to follow its name; empty where it is a regular
        file of a sane size that may be read.
    """
    try:
        found = Path(path).stat()
    except FileNotFoundError:
        if is_web_address(path):
            return "is a web address; download it first, and give the path of the file"
        if Path(path).is_symlink():
            return "is a link to a file that is not there; mend or remove the link"
        return MISSING
    except (OSError, ValueError) as error:  # ValueError: a NUL in the name
        return f"cannot be read ({getattr(error, 'strerror', error)}); check the path"
    if stat.S_ISDIR(found.st_mode):
        return FOLDER
    if not stat.S_ISREG(found.st_mode):
        kind = next((kind for is_kind, kind in _KINDS.items() if is_kind(found.st_mode)), "special")
        return f"is {kind}, not a file; save its content to a file first"
    if found.st_size > largest:
        return (
            f"has {found.st_size / 1e6:,.0f} MB; expected at most {largest / 1e6:,.0f} MB; check"
            " that it is the right file"
        )
    if not os.access(path, os.R_OK):
        return "cannot be read; check its permissions"
    return ""


def is_web_address(path: str | Path) -> bool:
    """Return whether a path is the address of a file on the web."""
    return _WEB_ADDRESS.match(str(path)) is not None
