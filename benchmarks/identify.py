"""Find perturbed parameters again from simulated logs; print how far off they are, as Markdown.

python benchmarks/identify.py
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import tyro
from dm_control.rl import control
from numpy.typing import NDArray
from rich.console import Console
from rich.progress import track

import mpma_mj
from mpma_mj.sysid import RobotLog, identify, record, write_model
from mpma_mj.sysid.parameters import REFERENCE, UNITS

Array = NDArray[np.float64]
Act = Callable[[Mapping[str, Array]], Array]

MIDDLE = np.array([0.5, 0.3, 0.0, 1.4] * 2)  # of the motion, rad
LATENCY = 2  # control steps
GROUPS = ("kv", "damping", "armature", "upper_arm_mass", "forearm_mass")


def dance(env: control.Environment, seed: int) -> Act:
    """Return the feedback controller, which dances YMCA."""
    agent = mpma_mj.make_agent(env, kind="feedback_only", seed=seed)
    agent.reset(0)
    return agent.act


def steps(env: control.Environment, seed: int) -> Act:
    """Return random velocities, each for 0.2 s, that lead back to the middle from farther off."""
    rng = np.random.default_rng(seed)
    moments = 0
    action = np.zeros(8)

    def act(observation: Mapping[str, Array]) -> Array:
        nonlocal moments, action
        if moments % 4 == 0:
            action = rng.uniform(-1.0, 1.0, 8)
            away = observation["joint_angles"] - MIDDLE
            far = np.abs(away) > rng.uniform(0.3, 1.0, 8) * np.array([1.5, 1.5, 1.5, 1.0] * 2)
            action = np.where(far, -np.sign(away) * np.abs(action), action)
        moments += 1
        return action

    return act


def sines(env: control.Environment, seed: int, size: float = 1.0) -> Act:
    """Return what follows six sines a joint, of 0.2 to 3 Hz."""
    rng = np.random.default_rng(seed)
    turn = 2.0 * np.pi * rng.uniform(0.2, 3.0, (6, 8))  # rad/s
    phase = rng.uniform(0.0, 2.0 * np.pi, (6, 8))
    wide = size * rng.uniform(0.3, 1.0, (6, 8)) / (1.0 + turn / (2.0 * np.pi))
    moments = 0

    def act(observation: Mapping[str, Array]) -> Array:
        nonlocal moments
        angle = turn * moments * env.control_timestep() + phase
        moments += 1
        wanted = MIDDLE + (wide * np.sin(angle)).sum(axis=0)
        wanted[3::4] = np.clip(wanted[3::4], 0.2, 2.6)
        ahead = (wide * turn * np.cos(angle)).sum(axis=0)
        velocity = ahead + 2.0 * (wanted - observation["joint_angles"])
        return velocity / env.task.max_joint_speed

    return act


def slow(env: control.Environment, seed: int) -> Act:
    """Return small sines, with which no actuator reaches its greatest force."""
    return sines(env, seed, 0.1)


EXCITATIONS = {"dance": dance, "steps": steps, "sines": sines, "slow": slow}


def simulated_log(
    factors: Mapping[str, float], excitation: str, seconds: float, noise: float, seed: int
) -> RobotLog:
    """Return the log of arms with other parameters."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "robot.xml"
        write_model(path, factors)
        env = mpma_mj.load(
            "ymca", model=path, latency=LATENCY, repeats=40, seed=seed, observation_noise=noise
        )
    return record(env, EXCITATIONS[excitation](env, seed), seconds)


def main(
    excitations: tuple[str, ...] = tuple(EXCITATIONS),
    noises: tuple[float, ...] = (0.0, 0.001, 0.005),
    seconds: float = 20.0,
    seeds: int = 3,
    off: float = 0.3,
) -> None:
    """Find them again.

    Args:
        excitations: What moves the arms.
        noises: Standard deviation of the noise on angles, rad; that on velocities is 12 to 20 1/s
            times it.
        seconds: Length of a log, s.
        seeds: Number of logs of each kind.
        off: How far each parameter is off at most, as a part.
    """
    console = Console(stderr=True)
    kinds = [(name, noise) for name in excitations for noise in noises]
    titles = ("log", "noise, rad", *(f"{group}, %" for group in GROUPS))
    print(f"| {' | '.join((*titles, 'latency', 'in the interval', 'not determined', 'time, s'))} |")
    print("|---" * (len(titles) + 4) + "|")
    for name, noise in track(kinds, "finding parameters", console=console, transient=True):
        results = [_one(name, noise, seconds, seed, off) for seed in range(seeds)]
        cells = [f"{max(r['errors'][group] for r in results):.2g}" for group in GROUPS]
        right = sum(r["latency"] for r in results)
        inside = 100 * np.mean([r["inside"] for r in results])
        open_ones = np.mean([r["open"] for r in results])
        took = np.median([r["seconds"] for r in results])
        cells += [f"{right} of {seeds}", f"{inside:.0f} %", f"{open_ones:.1f}", f"{took:.0f}"]
        print(f"| {name} | {noise:g} | {' | '.join(cells)} |", flush=True)


def _one(name: str, noise: float, seconds: float, seed: int, off: float) -> dict[str, Any]:
    """Return how far off everything is, for one robot."""
    rng = np.random.default_rng(seed)
    low, high = np.log([1.0 - off, 1.0 + off])
    true = {parameter: float(np.exp(rng.uniform(low, high))) for parameter in UNITS}
    log = simulated_log(true, name, seconds, noise, seed)
    began = time.perf_counter()
    found = identify(log)
    took = time.perf_counter() - began
    # Where the common scale is open, as `found` says, how far off ratios are is what counts.
    scale = found.factors[REFERENCE] / true[REFERENCE] if found.scale_is_open else 1.0
    errors = {n: 100.0 * abs(f / (scale * true[n]) - 1.0) for n, f in found.factors.items()}
    inside = [one.interval[0] <= true[one.name] <= one.interval[1] for one in found.estimates]
    return {
        "errors": {g: max(e for n, e in errors.items() if n.startswith(g)) for g in GROUPS},
        "latency": found.latency.control_steps == LATENCY and found.latency.is_integer,
        "inside": np.mean(inside),
        "open": sum(not one.determined for one in found.estimates),
        "seconds": took,
    }


if __name__ == "__main__":
    tyro.cli(main)
