"""Measure how many pictures of 640 x 480 a second this machine's OpenGL draws.

python benchmarks/frames.py
MUJOCO_GL=osmesa python benchmarks/frames.py
"""

from __future__ import annotations

import contextlib
import os
import statistics
import time

from mpma_mj.envs.gl import require_backend

PICTURES = 200
ROUNDS = 5


def main() -> None:
    """Print the median and the range over rounds, with and without the ghost."""
    backend = require_backend()
    from mpma_mj.envs.physics import PhysicsArms
    from mpma_mj.envs.rendering import ArmRenderer
    from mpma_mj.motions import ymca

    physics, postures = PhysicsArms.make(), ymca().posture
    print(f"{backend}, {os.cpu_count()} cores")
    with contextlib.closing(ArmRenderer(physics)) as renderer:
        for name, ghosts in {"arms": [None], "arms and ghost": list(postures)}.items():
            rates = []
            for _ in range(ROUNDS):
                began = time.perf_counter()
                for i in range(PICTURES):
                    renderer.picture(ghost=ghosts[i % len(ghosts)])
                rates.append(PICTURES / (time.perf_counter() - began))
            median, low, high = statistics.median(rates), min(rates), max(rates)
            print(f"{name}: {median:.0f} pictures/s ({low:.0f} to {high:.0f})")


if __name__ == "__main__":
    main()
