"""How many frames of a video a second are drawn and encoded, by each OpenGL without a display.

A process draws with one of them for its whole life, so each is timed in a process of its own: this
module as a program.
"""

from __future__ import annotations

import collections
import json
import tempfile
from pathlib import Path

import numpy as np

from mpma_mj.bench.child import python
from mpma_mj.bench.report import Report
from mpma_mj.bench.timing import Case, Progress, bound, in_turn, spread
from mpma_mj.envs.gl import environment_of, require_backend
from mpma_mj.errors import WorkerError

__all__ = ["measure"]

_BACKENDS = ("egl", "osmesa")
_ROUNDS = 5
_DRAWN, _WRITTEN = "drawn", "drawn and encoded"
_WANTED = {_DRAWN: 200.0, _WRITTEN: 100.0}  # frames a second


def measure(progress: Progress) -> Report:
    """Time the video of three rounds of the built-in dance, 640 × 480 and the strip below.

    Args:
        progress: Shows how far the backends are.
    """
    seconds, bounds, notes = {}, {}, []
    for number in progress(range(len(_BACKENDS)), "timing videos"):
        backend = _BACKENDS[number]
        try:
            said = python("-m", "mpma_mj.bench.drawing", environment=environment_of(backend))
        except WorkerError as error:
            notes.append(f"No video with {backend}: {error}")
            continue
        for name, values in json.loads(said).items():
            times = np.array(values)
            seconds[f"a video frame, {name}, {backend}"] = spread(times)
            bounds[f"video frames a second, {name}, {backend}"] = bound(
                1.0 / times, _WANTED[name], "/s", at_least=True
            )
    return Report(seconds, {}, bounds, tuple(notes))


def main() -> None:
    """Time frames by the OpenGL that MUJOCO_GL names; print seconds a frame as JSON."""
    require_backend()  # before MuJoCo is imported
    from mpma_mj.motions import ymca
    from mpma_mj.training.config import RunConfig
    from mpma_mj.training.factory import agent_of, make_environments
    from mpma_mj.training.rollout import record_epoch
    from mpma_mj.visualization.video import dance_frames, write_frames

    config = RunConfig.of(nodes=20)
    motion = ymca()
    env = make_environments(config, config.seed, motion)
    trace = record_epoch(env, agent_of(config, env, config.seed), 0)
    frames = len(trace)

    def draw() -> int:
        collections.deque(dance_frames(trace, motion), maxlen=0)
        return frames

    with tempfile.TemporaryDirectory() as folder:

        def write() -> int:
            write_frames(Path(folder) / "dance.mp4", dance_frames(trace, motion), motion.rate)
            return frames

        times = in_turn({_DRAWN: Case(draw), _WRITTEN: Case(write)}, range(_ROUNDS))
    print(json.dumps({name: values.tolist() for name, values in times.items()}))


if __name__ == "__main__":
    main()
