"""Dance for 24 simulated hours in many environments; print memory and what was seen as Markdown.

python benchmarks/day.py
"""

from __future__ import annotations

import resource
import time
from pathlib import Path

import numpy as np
import tyro
from rich.console import Console
from rich.progress import track

import mpma_mj


def main(hours: float = 24.0, members: int = 64, payload: float = 1.0) -> None:
    """Act at random, with latency, noise, pushes and contacts on.

    Args:
        hours: Simulated time of all members together.
        members: Number of environments.
        payload: Mass in each hand, kg.
    """
    envs = mpma_mj.make_vec(
        members,
        "ymca",
        random_start=True,
        observation_noise=0.02,
        latency=1,
        perturbation=(0.5, 30.0),
        payload=payload,
        collisions=True,
    )
    steps = round(hours * 3600 / envs.control_timestep / members)
    rng = np.random.default_rng(0)
    actions = np.zeros((members, 8))
    envs.reset()
    numbers = ends = diverged = 0
    memory = []
    began = time.perf_counter()
    for step in track(range(steps), "dancing", console=Console(stderr=True), transient=True):
        # A walk, so that arms go everywhere, elbows into their limits too.
        actions = np.clip(actions + rng.normal(0.0, 0.2, actions.shape), -1.0, 1.0)
        observations, rewards, terminated, truncated, _ = envs.step(actions)
        assert all(np.isfinite(values).all() for values in observations.values())
        assert ((rewards >= 0.0) & (rewards <= 1.0)).all()
        numbers += sum(values.size for values in observations.values()) + members
        ends += int(truncated.sum())
        diverged += int(terminated.sum())
        if step % -(-steps // 8) == 0:
            memory.append(resident_mib())
    seconds = time.perf_counter() - began
    memory.append(resident_mib())
    print("| environment steps | simulated time | real time | episodes | diverged | not finite |")
    print("|---|---|---|---|---|---|")
    print(
        f"| {steps * members:,} | {steps * members * envs.control_timestep / 3600:.1f} h"
        f" | {seconds:.0f} s | {ends:,} | {diverged} | 0 of {numbers:,} numbers |"
    )
    print("\nResident memory at the start, at each eighth, and at the end, MiB:")
    print(", ".join(f"{value:.1f}" for value in memory))
    print(f"Peak: {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:.1f} MiB.")


def resident_mib() -> float:
    """Return the resident memory of this process, MiB."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * resource.getpagesize() / 2**20


if __name__ == "__main__":
    tyro.cli(main)
