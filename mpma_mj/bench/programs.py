"""How long whole programs take, from typing to the end."""

from __future__ import annotations

import tempfile

from mpma_mj.bench.child import program
from mpma_mj.bench.report import Report
from mpma_mj.bench.timing import Progress, bound, in_turn, spread

__all__ = ["measure"]

_ROUNDS = 5
_HELP, _IMITATE = "mpma --help", "mpma imitate ymca --no-video"
_WANTED = {_HELP: 0.5, _IMITATE: 3.0}  # s
_FIRST_STEP = "import mpma_mj; load(), reset() and the first step()"
_FIRST_STEP_CODE = """
import numpy as np
import mpma_mj
env = mpma_mj.load()
env.reset()
env.step(np.zeros(8))
"""


def measure(progress: Progress) -> Report:
    """Time programs, warm: each has run once before.

    Args:
        progress: Shows how far the rounds are.
    """
    with tempfile.TemporaryDirectory() as folder:
        imitate = [*_IMITATE.split()[1:], "--overwrite", "--out", f"{folder}/run"]
        cases = {
            _FIRST_STEP: program("-c", _FIRST_STEP_CODE),
            _HELP: program("-m", "mpma_mj", "--help"),
            _IMITATE: program("-m", "mpma_mj", *imitate),
        }
        times = in_turn(cases, progress(range(_ROUNDS), "timing programs"))
    return Report(
        seconds={name: spread(values) for name, values in times.items()},
        bounds={f"seconds of {name}": bound(times[name], most) for name, most in _WANTED.items()},
    )
