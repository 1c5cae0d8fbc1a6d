"""Kills at each change of a file that a command makes, after which the command has to go on."""

from __future__ import annotations

import importlib.util
import shutil
import signal
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks.campaign.children import Ended, command, in_fork, warm_up
from benchmarks.campaign.continuation import go_on
from benchmarks.campaign.faults import Fault, Part
from benchmarks.campaign.file_operations import die_at, list_operations
from benchmarks.campaign.scenarios import SCENARIOS, Scenario
from benchmarks.campaign.snapshots import differences, snapshot
from benchmarks.campaign.workers import spread

__all__ = ["Kill", "KilledCommand", "kill_everywhere", "verdict"]


class Kill(NamedTuple):
    """A kill: of which command, at which change of a file, and whether that file is begun."""

    command: str
    number: int
    torn: bool


class KilledCommand:
    """A command, the files that it finds, and those that it leaves when nobody kills it.

    Attributes:
        operations: Changes of files that it makes.
    """

    def __init__(self, scenario: Scenario, home: Path) -> None:
        """Run it once, in a folder of its own.

        Raises:
            RuntimeError: It fails undisturbed.
        """
        self.words = scenario.words.split()
        self._start = home / "start"
        self._start.mkdir(parents=True)
        for words in scenario.before:
            _must_work(words, in_fork(lambda words=words: command(words.split()), self._start))
        whole, listed = home / "whole", home / "operations"
        shutil.copytree(self._start, whole)

        def undisturbed() -> int:
            list_operations(whole, listed)
            return command(self.words)

        _must_work(scenario.words, in_fork(undisturbed, whole))
        self.operations = listed.read_text().split()
        self.expected = snapshot(whole)

    def fresh(self, folder: str) -> Path:
        """Return a copy of the files that the command finds."""
        return Path(shutil.copytree(self._start, Path(folder) / "work"))

    def kill(self, number: int, *, torn: bool) -> str:
        """Kill the command at a change of a file, go on, and return what is wrong, if anything."""
        with tempfile.TemporaryDirectory() as home:
            folder = self.fresh(home)

            def killed() -> int:
                die_at(folder, number, torn=torn)
                return command(self.words)

            ended = in_fork(killed, folder)
            if ended.code != -signal.SIGKILL:
                return f"was not killed, but ended with {ended.code}: {ended.last_line}"
            return verdict(go_on(self.words, folder), self.expected, folder)


def verdict(attempts: Sequence[Ended], expected: dict[str, str], folder: Path) -> str:
    """Return what is wrong after going on; nothing if all is as it has to be."""
    last = attempts[-1]
    for one in attempts:
        if "Traceback" in one.err or not (one.code == 0 or one.is_refusal):
            return f"going on ended with {one.code}: {' | '.join(one.err.splitlines()[-4:])}"
    if last.code != 0:
        return f"no way to go on: {last.last_line}"
    return differences(expected, snapshot(folder))


def _must_work(words: str, ended: Ended) -> None:
    if ended.code != 0:
        raise RuntimeError(f"mpma {words} ended with {ended.code}: {ended.err}")


def kill_everywhere(
    seed: int, seconds: float, workers: int, names: Sequence[str] = tuple(SCENARIOS)
) -> list[Part]:
    """Kill each command at each change of a file, in random order, until time is up.

    Args:
        seed: Seed of the order.
        seconds: For all.
        workers: Processes.
        names: Which of SCENARIOS.
    """
    chosen = {
        name: SCENARIOS[name] for name in names if importlib.util.find_spec(SCENARIOS[name].needs)
    }
    warm_up(words for one in chosen.values() if not one.before for words in [one.words])
    with tempfile.TemporaryDirectory() as home:
        places = {name: Path(home, str(i)) for i, name in enumerate(chosen)}
        killings = {name: KilledCommand(one, places[name]) for name, one in chosen.items()}
        kills = [
            Kill(name, number, torn)
            for name, killing in killings.items()
            for number, operation in enumerate(killing.operations)
            for torn in ((False, True) if operation == "open" else (False,))
        ]
        np.random.default_rng(seed).shuffle(kills)

        def do(kill: Kill) -> list[Fault]:
            name, number, torn = kill
            wrong = killings[name].kill(number, torn=torn)
            operation = f"operation {number} ({killings[name].operations[number]}"
            again = f"mpma {' '.join(killings[name].words)}, {operation}{', torn' * torn})"
            return [Fault(wrong, again)] if wrong else []

        done, faults = spread(kills, do, workers=workers, seconds=seconds)
        counts = ", ".join(f"{name} {len(one.operations)}" for name, one in killings.items())
    return [Part("kills at changes of files", done, len(kills), faults, counts)]
