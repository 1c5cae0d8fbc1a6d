"""Memory, open files and threads of a process that makes, steps, draws and closes environments."""

from __future__ import annotations

import gc
import importlib.util
import json
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.campaign.children import in_fork
from benchmarks.campaign.faults import Fault, Part
from benchmarks.campaign.workers import spread
from benchmarks.day import resident_mib

__all__ = ["look_for_leaks"]

_CYCLES = 1000
_DRAWN = 100  # cycles with pictures
_GROWTH = 4.0  # MiB that the fit may grow over the second half of the cycles (choice)
_EVERY = 5  # cycles from one measurement to the next, which takes longer than a cycle
_LEAST = 8  # measurements, without which nothing is known
_OWN = Path("/proc/self")


def _dm_env() -> None:
    import mpma_mj

    env = mpma_mj.load()
    env.reset()
    env.step(np.zeros(8))
    env.close()


def _gymnasium(render_mode: str | None = None) -> None:
    import gymnasium

    env = gymnasium.make("mpma_mj:TwoArmImitation-v0", render_mode=render_mode)
    _steps(env, np.zeros(8))


def _drawn() -> None:
    _gymnasium("rgb_array")


def _vector(render_mode: str | None = None) -> None:
    import mpma_mj

    _steps(mpma_mj.make_vec(2, render_mode=render_mode), np.zeros((2, 8)))


def _drawn_vector() -> None:
    _vector("rgb_array")


def _steps(env: Any, action: Any) -> None:
    env.reset(seed=0)
    env.step(action)
    if env.render_mode is not None:
        env.render()
    env.close()


def _sb3() -> None:
    from mpma_mj.envs.sb3 import make_sb3_vec

    envs = make_sb3_vec(2)
    envs.reset()
    envs.step(np.zeros((2, 8)))
    envs.close()


_FACES: dict[str, tuple[Callable[[], None], int]] = {
    "load": (_dm_env, _CYCLES),
    "gymnasium.make": (_gymnasium, _CYCLES),
    "make_vec": (_vector, _CYCLES),
    "make_sb3_vec": (_sb3, _CYCLES),
    "gymnasium.make, drawn": (_drawn, _DRAWN),
    "make_vec, drawn": (_drawn_vector, _DRAWN),
}


def look_for_leaks(seed: int, seconds: float, workers: int) -> list[Part]:
    """Make, step, draw and close environments of each face, and fit what the process holds.

    Args:
        seed: Not used: nothing is random.
        seconds: For all faces.
        workers: Processes, each of which tries a face at a time.
    """
    has_sb3 = importlib.util.find_spec("stable_baselines3") is not None
    names = [name for name in _FACES if "sb3" not in name or has_sb3]
    each = seconds * workers / len(names)
    with tempfile.TemporaryDirectory() as home:

        def do(name: str) -> list[Fault]:
            cycle, cycles = _FACES[name]
            file = Path(home, name)
            ended = in_fork(lambda: _measure(cycle, cycles, each, file), Path(home), 2 * each + 60)
            if ended.code == 0 or "OpenGL" in ended.err:  # which need not be here
                return []
            return [Fault(f"ended with {ended.code}: {ended.last_line}", name)]

        _, faults = spread(names, do, workers=workers, seconds=seconds)
        return [_judge(name, Path(home, name), faults) for name in names]


def _judge(name: str, file: Path, faults: Sequence[Fault]) -> Part:
    """Return the result of a face, whose process wrote a file unless it failed."""
    title, (_, cycles) = f"make, step, close: {name}", _FACES[name]
    held = np.array(json.loads(file.read_text())) if file.exists() else np.zeros((0, 3))
    own = [fault for fault in faults if fault.repeat == name]
    done = len(held) * _EVERY
    if len(held) < _LEAST:
        return Part(title, done, cycles, own, "too few to tell")
    memory, files, threads = held[len(held) // 2 :].T
    growth = float(np.polyfit(np.arange(len(memory)), memory, 1)[0]) * len(memory)
    more_files, more_threads = (int(one[-1] - one[0]) for one in (files, threads))
    note = f"{growth:+.1f} MiB, {more_files:+d} files, {more_threads:+d} threads in the second half"
    if growth > _GROWTH or more_files > 0 or more_threads > 0:
        own.append(Fault(note, name))
    return Part(title, done, cycles, own, note)


def _measure(cycle: Callable[[], None], cycles: int, seconds: float, file: Path) -> int:
    """Write what this process holds, time and again: MiB, files, threads."""
    until, held = time.monotonic() + seconds, []
    while len(held) * _EVERY < cycles and time.monotonic() < until:
        for _ in range(_EVERY):
            cycle()
        gc.collect()  # so that what is left is held by something
        held.append((resident_mib(), *(len(list(_OWN.glob(f"{one}/*"))) for one in ("fd", "task"))))
    file.write_text(json.dumps(held))
    return 0
