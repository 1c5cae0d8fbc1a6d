"""Earlier run in the folder of a new one: set aside until the new one has saved an epoch."""

from __future__ import annotations

import contextlib
import os
import shutil
from pathlib import Path

from mpma_mj.utils.atomic_files import discard

__all__ = ["ANALYSES", "forget", "put_back", "set_aside"]

ANALYSES = ("modules", "lesion", "free_running")
"""Names of analyses, whose results a run folder holds."""

# Contents of a run folder; other files belong to the user. config.json, which identifies a run,
# comes last, so that what is interrupted can be repeated.
_CONTENTS = (
    "metrics.csv",
    "summary.json",
    *(f"{analysis}.json" for analysis in ANALYSES),
    "trace.npz",
    "checkpoint",
    "figures",
    "evaluations",
    "dance.mp4",
    "sound",
    "config.json",
)
_ASIDE = ".mpma-set-aside"


def set_aside(folder: Path) -> None:
    """Move the contents of a run within its folder, which is locked.

    Raises:
        OSError: They cannot be moved.
    """
    present = [name for name in _CONTENTS if os.path.lexists(folder / name)]
    if present:
        (folder / _ASIDE).mkdir()
    for name in present:
        (folder / name).rename(folder / _ASIDE / name)


def put_back(folder: Path) -> None:
    """Put back what was set aside, in place of what the new run has written; if anything was.

    Raises:
        OSError: It cannot be moved.
    """
    aside = folder / _ASIDE
    if not aside.is_dir():
        return
    # Its config.json was moved last, and comes back first: until then the contents are of the new
    # run, and afterwards what is there has been put back.
    if os.path.lexists(aside / "config.json"):
        for name in _CONTENTS:
            _remove(folder / name)
    for name in reversed(_CONTENTS):
        if os.path.lexists(aside / name):
            _remove(folder / name)
            (aside / name).rename(folder / name)
    aside.rmdir()


def forget(folder: Path) -> None:
    """Remove what was set aside."""
    if (folder / _ASIDE).is_dir():
        discard(folder / _ASIDE)


def _remove(path: Path) -> None:
    with contextlib.suppress(FileNotFoundError):
        shutil.rmtree(path) if path.is_dir() and not path.is_symlink() else path.unlink()
