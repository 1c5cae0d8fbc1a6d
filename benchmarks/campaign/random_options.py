"""Random options of agents and environments within their bounds, and at them."""

from __future__ import annotations

import contextlib
import dataclasses
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, get_args

import numpy as np

from benchmarks.campaign.children import in_fork
from benchmarks.campaign.faults import Fault, Part
from benchmarks.campaign.workers import spread
from mpma_mj.agents.config import CONFIG_TYPES
from mpma_mj.agents.registry import agent_class
from mpma_mj.envs.load import load
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.envs.plants import Plant
from mpma_mj.errors import BadOptionError, MpmaError
from mpma_mj.kinematics import JOINT_NAMES, SEGMENT_NAMES
from mpma_mj.motions import Motion, ymca
from mpma_mj.training.config import RunConfig
from mpma_mj.training.run import train
from mpma_mj.utils.validation import Bounds, _checked_fields

__all__ = ["draw_options", "try_options"]

Draw = Callable[[type, np.random.Generator], dict[str, Any]]

_TRIES = 1000
_STEPS = 40  # of the motion
_SECONDS = 120.0
_GIVEN = 0.3  # share of the options that are given
_AT_BOUNDS = 0.3  # share of the numbers that are at a bound
_LARGEST = {  # of what takes time and memory and is nothing but larger then
    **{"nodes": 60, "modules": 8, "max_plants": 5, "repeats": 2, "lookahead": 60},
    **{"expert_episodes": 2, "demonstrations": 3, "epochs_per_plant": 3, "max_latency": 20},
}
_NOT_OF_TRAINING = ("random_start", "termination_distance")  # it imitates whole episodes
_OUR_ERROR, _NOT_FINITE = 3, 4


def draw_options(rng: np.random.Generator) -> tuple[str, dict[str, Any], dict[str, Any]]:
    """Return the name of an agent, its options, and those of an environment, which agree."""
    name = list(CONFIG_TYPES)[rng.integers(len(CONFIG_TYPES))]
    return (
        name,
        _agreeing(_agent, CONFIG_TYPES[name], rng),
        _agreeing(_env, EnvironmentOptions, rng),
    )


def _agreeing(draw: Draw, kind: type, rng: np.random.Generator) -> dict[str, Any]:
    """Return options of a kind that do not contradict each other."""
    while True:
        options = draw(kind, rng)
        with contextlib.suppress(BadOptionError):
            kind(**options)
            return options


def _agent(kind: type, rng: np.random.Generator) -> dict[str, Any]:
    options = _draw(kind, rng)
    for size in sorted(_LARGEST.keys() & {field.name for field in dataclasses.fields(kind)}):
        options.setdefault(size, min(_LARGEST[size], getattr(kind(), size)))
    return options


def _env(kind: type, rng: np.random.Generator) -> dict[str, Any]:
    env = _draw(kind, rng) | {"repeats": int(rng.integers(1, 3))}
    if rng.random() < _GIVEN:
        env["plants"] = [_draw(Plant, rng) for _ in range(rng.integers(1, 4))]
        if rng.random() < 0.5:
            env["switch_every"] = tuple(sorted(rng.uniform(0.01, 3.0, 2).tolist()))
    others: dict[str, Any] = {
        "locked_joint": JOINT_NAMES[rng.integers(len(JOINT_NAMES))],
        "perturbation": (float(rng.uniform(0, 100)), float(10 ** rng.uniform(-2, 4))),
        "reward_weights": {SEGMENT_NAMES[0]: float(10 ** rng.uniform(-3, 6))},
    }
    env |= {key: value for key, value in others.items() if rng.random() < _GIVEN / 2}
    if "control_timestep" in env:  # a multiple of the physics' own
        env["control_timestep"] = 0.005 * int(rng.integers(1, 41))
    if isinstance(env.get("latency"), tuple) and rng.random() < 0.5:
        env["latency_every"] = (0.1, 0.5)
    return env


def _draw(kind: type, rng: np.random.Generator) -> dict[str, Any]:
    """Return values of some fields with declared bounds or choices."""
    drawn = {}
    for name, check in _checked_fields(kind).items():
        if rng.random() > _GIVEN:
            continue
        if check.kind is bool:
            drawn[name] = bool(rng.random() < 0.5)
        elif check.bounds is None:
            choices = get_args(check.kind)
            drawn[name] = choices[rng.integers(len(choices))]
        else:
            numbers = sorted(_number(name, check, rng) for _ in range(2))
            in_range = check.ranged and rng.random() < 0.3 and numbers[0] < numbers[1]
            drawn[name] = tuple(numbers) if in_range else numbers[rng.integers(2)]
    return drawn


def _number(name: str, check: Any, rng: np.random.Generator) -> float:
    bounds: Bounds = check.bounds
    low, high = bounds.low, min(bounds.high, _LARGEST.get(name, bounds.high))
    if rng.random() < _AT_BOUNDS:
        value = [low, high][rng.integers(2)]
        if not bounds.admit(value):
            value = np.nextafter(value, (low + high) / 2)
    elif low >= 0:  # by orders of magnitude
        least = max(low, 1e-6)
        value = float(np.exp(rng.uniform(np.log(least), np.log(max(high, least)))))
    else:
        value = float(rng.uniform(low, high))
    value = max(low, min(high, round(value))) if check.kind is int else value
    return check.kind(value)


def try_options(seed: int, seconds: float, workers: int) -> list[Part]:
    """Train agents in environments with random options, and act at random, until time is up.

    Args:
        seed: Seed of the options.
        seconds: For all.
        workers: Processes.
    """

    def do(number: int) -> list[Fault]:
        rng = np.random.default_rng([seed, number])
        name, agent, env = draw_options(rng)
        with tempfile.TemporaryDirectory() as folder:
            ended = in_fork(lambda: _use(name, agent, env, rng), Path(folder), _SECONDS)
        again = f"seed {seed}, number {number}: {name} {agent}, environment {env}"
        if ended.code in (0, _OUR_ERROR):
            return [Fault(ended.last_line, again)] if len(ended.out.splitlines()) > 1 else []
        if ended.code == _NOT_FINITE:
            return [Fault(f"not finite: {ended.out.strip()}", again)]
        return [Fault(f"ended with {ended.code}: {' | '.join(ended.lines[-3:])}", again)]

    done, faults = spread(range(_TRIES), do, workers=workers, seconds=seconds)
    return [Part("random options", done, _TRIES, faults)]


def _use(name: str, agent: dict[str, Any], env: dict[str, Any], rng: np.random.Generator) -> int:
    """Act at random in the environment, and train the agent; print what is wrong, in a line."""
    try:
        whole = ymca(rate=1.0 / env.get("control_timestep", 0.05))
        parts = whole.posture[:_STEPS], whole.context[:_STEPS], whole.labels, whole.rate
        motion = Motion(*parts, "part", "here")
        bad = _acted(motion, env, rng)
        if agent_class(name).trainable:
            imitated = {k: v for k, v in env.items() if k not in _NOT_OF_TRAINING}
            config = RunConfig.of(agent=name, **agent, **imitated)
            run = train(config, max(2, config.agent.least_epochs), motion=motion)
            bad += [f"state {k}" for k, array in run.state.items() if not _finite(array)]
            bad += [
                f"trace {k}" for k, array in run.trace.to_arrays().items() if not _finite(array)
            ]
    except MpmaError as error:
        print(error)
        return _OUR_ERROR
    if bad:
        print(", ".join(bad))
        return _NOT_FINITE
    return 0


def _acted(motion: Motion, options: dict[str, Any], rng: np.random.Generator) -> list[str]:
    """Return what was not finite in an environment with random actions."""
    env, bad = load(motion, **options), set()
    time_step = env.reset()
    for _ in range(2 * _STEPS):
        if time_step.last():
            time_step = env.reset()
        else:
            time_step = env.step(rng.uniform(-1.0, 1.0, 8))
            if not _finite(time_step.reward):
                bad.add("reward")
        bad |= {name for name, part in time_step.observation.items() if not _finite(part)}
    env.close()
    return sorted(bad)


def _finite(array: Any) -> bool:
    array = np.asarray(array)
    return array.dtype.kind not in "fc" or bool(np.isfinite(array).all())
