"""Program that reads recordings: a request a line in, an answer a line out, both JSON.

An empty line comes first, when it is ready.

It uses nothing of `benchmarks`, and only what `mpma_mj` has had for long, so that the package of
any checkout can be tried.
"""

from __future__ import annotations

import importlib
import json
import resource
import sys
import warnings
from pathlib import Path
from typing import Any

from mpma_mj.errors import MpmaError
from mpma_mj.motions.loader import import_motion
from mpma_mj.motions.options import ReadingOptions

_MEMORY = 4 << 30  # bytes


def answer(path: str, rate: float, options: dict[str, Any]) -> dict[str, Any]:
    """Read a recording at a rate, Hz.

    Returns:
        Error and whether it is one of the package's, or posture, times, warnings and steps.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            motion, report = import_motion(Path(path), ReadingOptions(**options), rate=rate)
        except MpmaError as error:
            return {"error": str(error), "own": True}
        except Exception as error:  # which is what is looked for
            return {"error": repr(error), "own": False}
    return {
        "posture": motion.posture.tolist(),
        "times": report.times.tolist(),
        "warnings": report.warnings,
        "steps": report.steps,
    }


if __name__ == "__main__":
    resource.setrlimit(resource.RLIMIT_AS, (_MEMORY, _MEMORY))
    for slow in ("interpolate", "signal", "spatial.transform"):  # which readers import when needed
        importlib.import_module(f"scipy.{slow}")
    print(flush=True)  # all is imported
    for line in sys.stdin:
        print(json.dumps(answer(**json.loads(line))), flush=True)
