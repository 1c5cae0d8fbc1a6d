"""Kills and interruptions of real commands, with their workers, at random moments."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from benchmarks.campaign.children import warm_up
from benchmarks.campaign.continuation import go_on
from benchmarks.campaign.faults import Fault, Part
from benchmarks.campaign.kills import KilledCommand, verdict
from benchmarks.campaign.scenarios import SCENARIOS, TINY, Scenario
from benchmarks.campaign.workers import spread

__all__ = ["kill_at_random"]

_TRIES = 300
_CHOSEN = {
    name: SCENARIOS[name] for name in ("imitate", "imitate --resume", "imitate --overwrite")
} | {
    "sweep": Scenario(
        f"sweep ymca --grid nodes=3,4 {TINY} --epochs 2 --runs 2 --workers 2 --out s"
    ),
    "compare": SCENARIOS["compare"],
}
_SIGNALS = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT)
_SECONDS = 120.0
_PATIENCE = 10.0  # s, in which workers have to end after their command


def kill_at_random(seed: int, seconds: float, workers: int) -> list[Part]:
    """Kill, end or interrupt commands at random moments, and go on, until time is up.

    Args:
        seed: Seed of commands and moments.
        seconds: For all.
        workers: Processes.
    """
    warm_up(one.words for one in _CHOSEN.values() if not one.before)
    with tempfile.TemporaryDirectory() as home:
        killings = {
            name: KilledCommand(one, Path(home, str(i)))
            for i, (name, one) in enumerate(_CHOSEN.items())
        }
        durations = {name: _duration(killing) for name, killing in killings.items()}

        def do(number: int) -> list[Fault]:
            rng = np.random.default_rng([seed, number])
            name = list(killings)[rng.integers(len(killings))]
            after = float(rng.uniform(0.2, 1.1)) * durations[name]
            how = _SIGNALS[rng.integers(len(_SIGNALS))]
            wrong = _try(killings[name], after, how)
            again = f"mpma {' '.join(killings[name].words)}, {how.name} after {after:.2f} s"
            return [Fault(wrong, f"{again}, number {number}")] if wrong else []

        done, faults = spread(range(_TRIES), do, workers=workers, seconds=seconds)
    return [Part("kills at random moments", done, _TRIES, faults)]


def _start(killing: KilledCommand, folder: Path) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-m", "mpma_mj", *killing.words],
        cwd=folder,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )


def _duration(killing: KilledCommand) -> float:
    """Return how long a command takes, s."""
    with tempfile.TemporaryDirectory() as home:
        began = time.monotonic()
        _start(killing, killing.fresh(home)).communicate(timeout=_SECONDS)
        return time.monotonic() - began


def _try(killing: KilledCommand, after: float, how: signal.Signals) -> str:
    """Stop a command after some seconds, go on, and return what is wrong, if anything."""
    with tempfile.TemporaryDirectory() as home:
        folder = killing.fresh(home)
        process = _start(killing, folder)
        try:
            _, err = process.communicate(timeout=after)
        except subprocess.TimeoutExpired:
            # As a terminal does, Ctrl-C reaches the workers too.
            os.killpg(process.pid, how) if how == signal.SIGINT else process.send_signal(how)
            try:
                _, err = process.communicate(timeout=_SECONDS)
            except subprocess.TimeoutExpired:
                os.killpg(process.pid, signal.SIGKILL)
                return f"did not end in {_SECONDS:g} s"
        # It was over, or Python had not begun it yet, or its message names what follows.
        if process.returncode not in (0, -how, 128 + how):
            return f"ended with {process.returncode}: {' | '.join(err.splitlines()[-4:])}"
        if "Traceback" in err and process.returncode != -how:
            return f"a traceback: {' | '.join(err.splitlines()[-4:])}"
        if _has_workers(process.pid):
            return f"has workers {_PATIENCE:g} s after its end"
        return verdict(go_on(killing.words, folder), killing.expected, folder)


def _has_workers(group: int) -> bool:
    """Return whether processes of a group are there, for longer than it takes them to end."""
    until = time.monotonic() + _PATIENCE
    while time.monotonic() < until:
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return False
        time.sleep(0.05)
    os.killpg(group, signal.SIGKILL)
    return True
