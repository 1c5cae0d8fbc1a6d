"""How time and memory of training grow with the length of the dance and the size of what learns."""

from __future__ import annotations

import dataclasses
import resource
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.speed.timing import Report, Sizes, Target, in_own_process, ratio
from mpma_mj.envs.load import arm_limits
from mpma_mj.motions import Motion, ymca
from mpma_mj.motions.transforms import repeat
from mpma_mj.training.config import RunConfig
from mpma_mj.training.factory import one_thread
from mpma_mj.training.trainer import Trainer
from mpma_mj.utils.progress import show_range

__all__ = ["AMOUNTS", "BASE", "Measured", "exponent", "measure", "motion_of", "report", "train"]

BASE = {"steps": 227, "modules": 4, "nodes": 200, "runs": 1}
"""What is trained: steps of an epoch, modules, neurons of each reservoir, runs side by side."""
AMOUNTS = {
    "steps": (1_000, 3_000, 10_000, 30_000, 100_000),
    "modules": (1, 2, 4, 8, 16, 32, 64),
    "nodes": (50, 100, 200, 400, 800, 1600),
    "runs": (1, 2, 4, 8, 16, 32, 64),
}
"""Amounts of what is varied; the rest is as in `BASE`."""

_STEPS = 5_000  # of all epochs of a point together (choice)
# At least two epochs, since training keeps the best while it dances another.
_LEAST, _MOST = 2, 5


@dataclass(frozen=True)
class Measured:
    """What a training took.

    Attributes:
        amount: How much there is of what is varied.
        seconds: Time of each epoch, s.
        memory: Most memory that the process had, bytes.
        inherent: What motion and trace of an epoch hold of it, bytes; of many runs the motion only.
    """

    amount: int
    seconds: tuple[float, ...]
    memory: int
    inherent: int


def measure(sizes: Sizes) -> Report:
    """Train at every point, one after the other, each in a process of its own."""
    points = [(axis, BASE | {axis: amount}) for axis, all_ in AMOUNTS.items() for amount in all_]
    found: dict[str, list[Measured]] = {axis: [] for axis in AMOUNTS}
    for number in show_range(range(len(points)), "training at every size"):
        axis, point = points[number]
        found[axis].append(dataclasses.replace(in_own_process(train, point), amount=point[axis]))
    return report(found)


def train(point: Mapping[str, int]) -> Measured:
    """Train for a few epochs and measure each, and what memory this process took in all."""
    motion, runs = motion_of(point["steps"]), point["runs"]
    config = RunConfig.of(modules=point["modules"], nodes=point["nodes"], repeats=1)
    configs = [dataclasses.replace(config, seed=seed) for seed in range(runs)]
    inherent, seconds = motion.posture.nbytes + motion.context.nbytes, []
    with one_thread():
        trainer = Trainer(configs, motion, keep_states=runs == 1)
        for _ in range(max(_LEAST, min(_MOST, _STEPS // point["steps"]))):
            began = time.perf_counter()
            trainer.run_epoch(stop=False)
            seconds.append(time.perf_counter() - began)
        if runs == 1:
            signals = trainer.histories[0].best.trace.to_arrays().values()
            inherent += sum(signal.nbytes for signal in signals)
    return Measured(0, tuple(seconds), _peak_memory(), inherent)


def motion_of(steps: int) -> Motion:
    """Return YMCA over and over, an epoch of which has so many steps."""
    dance = ymca()
    times = -(-(steps + 1) // len(dance))
    posture, context, _ = repeat(dance, times, arm_limits("physics").max_speed)
    return dataclasses.replace(dance, posture=posture[: steps + 1], context=context[: steps + 1])


def _peak_memory() -> int:
    """Return the peak resident memory of this process, bytes.

    On Linux it is read from /proc, because the peak of `getrusage` includes that of the process
    that started this one.
    """
    status = Path("/proc/self/status")
    if status.exists():
        lines = dict(line.split(":", 1) for line in status.read_text("ascii").splitlines())
        return 1024 * int(lines["VmHWM"].split()[0])
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else 1024 * peak


def exponent(amounts: Sequence[float], values: Sequence[float]) -> float:
    """Fit the exponent b of values a·amount^b by least squares of logarithms.

    The larger half of the amounts is fitted, since fixed costs bend the curve below.

    Args:
        amounts: Amounts, the least first, shape (N,), N at least 3.
        values: What was measured of each, shape (N,).
    """
    half = slice(len(amounts) // 2, None)
    slope, _ = np.polyfit(np.log(amounts[half]), np.log(values[half]), 1)
    return float(slope)


def report(found: Mapping[str, Sequence[Measured]]) -> Report:
    """Return what was wanted and reached, and tables of all points and of the exponents."""
    rows = ["| varied | amount | an epoch, s | least to greatest | peak memory, MB |"]
    rows.append("|---|---|---|---|---|")
    ends = ["| varied | exponent of time | exponent of memory |", "|---|---|---|"]
    targets = {}
    for axis, points in found.items():
        amounts, memory = [one.amount for one in points], [one.memory for one in points]
        epochs = [float(np.median(one.seconds)) for one in points]
        rows += [
            f"| {axis} | {one.amount:,} | {epoch:.3g}"
            f" | {min(one.seconds):.3g} to {max(one.seconds):.3g} | {one.memory / 1e6:.0f} |"
            for one, epoch in zip(points, epochs, strict=True)
        ]
        of_time = exponent(amounts, epochs)
        ends.append(f"| {axis} | {of_time:.2f} | {exponent(amounts, memory):.2f} |")
        if axis in ("steps", "modules"):
            targets[f"exponent of an epoch's time in {axis}"] = Target(np.array([of_time]), 1.1)
    *_, before, last = found["steps"]
    held = Target(np.array([last.memory / 1e9]), 1.0, "GB")
    targets[f"peak memory of {last.amount:,} steps"] = held
    grown = np.array([last.memory - before.memory]), np.array([last.inherent - before.inherent])
    targets["memory of a further step over that of motion and trace"] = ratio(*grown, 1.0)
    return Report(targets=targets, notes=("\n".join(rows), "\n".join(ends)))
