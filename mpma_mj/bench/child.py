"""Programs in processes of their own."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Mapping

from mpma_mj.bench.timing import Case
from mpma_mj.errors import WorkerError

__all__ = ["program", "python"]


def python(*words: str, environment: Mapping[str, str] | None = None) -> str:
    """Run this Python and return what it prints.

    Args:
        words: What stands after `python`.
        environment: Its variables; ours if not given.

    Returns:
        Its standard output.

    Raises:
        WorkerError: It failed; gives the last line that it said.
    """
    command = [sys.executable, "-W", "ignore", *words]
    ended = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    if ended.returncode:
        said = ended.stderr.strip().splitlines() or ["nothing; was there too little memory?"]
        raise WorkerError(f"python {' '.join(words)} ended with {ended.returncode}: {said[-1]}")
    return ended.stdout


def program(*words: str) -> Case:
    """Return a whole program, from its start to its end, as what is timed."""

    def run() -> int:
        python(*words)
        return 1

    return Case(run)
