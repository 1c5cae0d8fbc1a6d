"""How long whole programs take, from typing to the end; and videos, by each OpenGL."""

from __future__ import annotations

import collections
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.speed.timing import Case, Report, Sizes, Target, in_own_process, in_turn, ratio
from mpma_mj.envs.gl import environment_of, require_backend
from mpma_mj.errors import RenderingError

__all__ = ["measure"]

_HELP, _IMITATE = "mpma --help", "mpma imitate ymca --no-video"
_OURS = "import mpma_mj; env = mpma_mj.load()"
_THEIRS = 'from dm_control import suite; suite.load("reacher", "easy")'
_FIRST_STEP = f"{_OURS}; env.reset(); env.step([0] * 8)"
_FRAMES = {"drawn": 200.0, "drawn and encoded": 100.0}  # a second, wanted


def measure(sizes: Sizes) -> Report:
    """Time programs, warm, each after it has run once, and the video of the built-in dance."""
    with tempfile.TemporaryDirectory() as folder:
        imitate = [*_IMITATE.split()[1:], "--overwrite", "--out", f"{folder}/run"]
        cases = {code: _program("-c", code) for code in (_OURS, _THEIRS, _FIRST_STEP)}
        cases[_HELP] = _program("-m", "mpma_mj", "--help")
        cases[_IMITATE] = _program("-m", "mpma_mj", *imitate)
        times = in_turn("timing programs", cases, sizes.half)
    targets = {
        "import and first environment over dm_control's": ratio(times[_OURS], times[_THEIRS], 1.5),
        f"seconds of {_HELP}": Target(times[_HELP], 0.5, "s"),
        f"seconds of {_IMITATE}": Target(times[_IMITATE], 3.0, "s"),
    }
    notes = []
    for backend in ("egl", "osmesa"):
        # A process draws with one OpenGL for its whole life.
        found = in_own_process(_seconds_of_a_frame, sizes.half, environment_of(backend))
        if isinstance(found, str):
            notes.append(f"Not timed with {backend}: {found}")
            continue
        for name, seconds in found.items():
            title = f"video frames a second, {name}, {backend}"
            targets[title] = Target(1.0 / seconds, _FRAMES[name], "/s", at_least=True)
    return Report(times, targets, tuple(notes))


def _program(*words: str) -> Case:
    """Return a run of this Python, from its start to its end, as what is timed."""

    def run() -> int:
        command = [sys.executable, "-W", "ignore", *words]
        ended = subprocess.run(command, capture_output=True, text=True, check=False)
        if ended.returncode:
            sys.exit(f"python {' '.join(words)} failed:\n{ended.stderr}")
        return 1

    return Case(run)


def _seconds_of_a_frame(rounds: int) -> dict[str, NDArray[np.float64]] | str:
    """Return seconds a frame of each round, shape (R,), with MUJOCO_GL; or why it does not draw."""
    try:
        require_backend()  # before MuJoCo is imported
    except RenderingError as error:
        return str(error)
    from mpma_mj.motions import ymca
    from mpma_mj.training.config import RunConfig
    from mpma_mj.training.factory import agent_of, make_environments
    from mpma_mj.training.rollout import record_epoch
    from mpma_mj.visualization.scene import Scene
    from mpma_mj.visualization.video import episode_frames, write_frames

    config, motion = RunConfig.of(nodes=20), ymca()
    env = make_environments(config, config.seed, motion)
    trace = record_epoch(env, agent_of(config, env, config.seed), 0)
    scene = Scene(trace, motion)

    def draw() -> int:
        collections.deque(episode_frames(scene), maxlen=0)
        return len(trace)

    with tempfile.TemporaryDirectory() as folder:

        def write() -> int:
            write_frames(Path(folder) / "dance.mp4", episode_frames(scene), motion.rate)
            return len(trace)

        cases = dict(zip(_FRAMES, (Case(draw), Case(write)), strict=True))
        return in_turn("timing videos", cases, rounds)
