"""Where a command writes if it is not told."""

from __future__ import annotations

import itertools
import time
from pathlib import Path

from mpma_mj.names import printable

__all__ = ["default_folder"]


def default_folder(stem: str, parent: Path = Path("runs")) -> Path:
    """Return a folder that is not there yet, named by a stem and the time."""
    name = f"{printable(stem)}-{time.strftime('%Y%m%d-%H%M%S')}"
    names = itertools.chain([name], (f"{name}-{i}" for i in itertools.count(2)))
    return next(path for path in (parent / n for n in names) if not path.exists())
