"""One training, measured in a process of its own, so that its peak memory is its own.

python -m mpma_mj.bench.point '{"axis": "steps", "steps": 1000, ...}'
"""

from __future__ import annotations

import dataclasses
import functools
import json
import sys
import time
from collections.abc import Callable
from typing import Any

from mpma_mj.bench.scaling import Measured, Point
from mpma_mj.envs.load import arm_limits
from mpma_mj.motions import Motion, ymca
from mpma_mj.motions.transforms import repeat
from mpma_mj.training.config import RunConfig
from mpma_mj.training.factory import one_thread
from mpma_mj.training.trainer import Trainer
from mpma_mj.utils.system import peak_memory

__all__ = ["motion_of", "train"]

_STEPS = 5_000  # of all epochs of a point together (choice)
# At least two epochs, since training keeps the best while it dances another.
_LEAST, _MOST = 2, 5


def motion_of(steps: int) -> Motion:
    """Return YMCA over and over, an epoch of which has so many steps."""
    dance = ymca()
    times = -(-(steps + 1) // len(dance))
    posture, context = repeat(dance, times, arm_limits("physics")[0])
    return dataclasses.replace(dance, posture=posture[: steps + 1], context=context[: steps + 1])


def train(point: Point) -> Measured:
    """Train for a few epochs and measure each, and what memory it took in all.

    Args:
        point: What is trained. Along `runs` they are side by side, else one is alone.
    """
    motion = motion_of(point.steps)
    config = RunConfig.of(modules=point.modules, nodes=point.nodes, repeats=1)
    epochs = max(_LEAST, min(_MOST, _STEPS // point.steps))
    inherent = motion.posture.nbytes + motion.context.nbytes
    with one_thread():
        runs = point.runs if point.axis == "runs" else 1
        configs = [dataclasses.replace(config, seed=seed) for seed in range(runs)]
        trainer = Trainer(configs, motion, keep_states=runs == 1)
        epoch = functools.partial(trainer.run_epoch, stop=False)
        seconds = [_timed(epoch) for _ in range(epochs)]
        if runs == 1:
            signals = trainer.histories[0].best.trace.to_arrays().values()
            inherent += sum(signal.nbytes for signal in signals)
    return Measured(point, tuple(seconds), peak_memory(), inherent)


def _timed(run: Callable[[], Any]) -> float:
    began = time.perf_counter()
    run()
    return time.perf_counter() - began


if __name__ == "__main__":
    measured = train(Point(**json.loads(sys.argv[1])))
    print(json.dumps(dataclasses.asdict(measured)))
