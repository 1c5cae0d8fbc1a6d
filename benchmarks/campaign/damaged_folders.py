"""Damaged folders of runs and sweeps: a command gives the undamaged result, or refuses."""

from __future__ import annotations

import importlib.util
import os
import shutil
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from benchmarks.campaign.children import Ended, command, in_fork, warm_up
from benchmarks.campaign.faults import Fault, Part
from benchmarks.campaign.folder_damage import damage
from benchmarks.campaign.scenarios import TINY
from benchmarks.campaign.snapshots import differences, snapshot
from benchmarks.campaign.workers import spread

__all__ = ["DamagedFolders", "damage_folders"]

_RUNS, _SWEEPS = 1000, 300
_COMMANDS = 1  # for each damaged folder: its kind matters more (choice)
_SHARE_OF_SWEEPS = 0.2  # of the time
_SECONDS = 30.0  # after which a command hangs; the slowest takes two

_READERS = (
    "play run --out joints.csv",
    "play run --out joints.bvh",
    "evaluate run --disturbances payload --levels 1 --out e",
    "evaluate run other --disturbances payload --levels 1 --no-baselines --out e",
    "analyse run",
    "analyse run lesion --fine-tune 0",
    "analyse run free-running",
    "imitate --resume run --epochs 2 --no-video",
    f"imitate ymca {TINY} --init run --epochs 1 --no-video --out next",
    "record run --episodes 1 --out data",
)
_RUN = f"imitate ymca {TINY} --no-video --epochs 2"
_SWEEP = f"sweep ymca {TINY} --epochs 1 --runs 2 --workers 1"
_SWEPT = f"{_SWEEP} --grid nodes=3,4 --out s"
_REMOVE = "remove it"  # what a message says of a file that can be made again


class DamagedFolders:
    """Folders that are damaged, commands that read them, and what these do with undamaged ones."""

    def __init__(
        self, home: Path, before: Sequence[str], readers: Sequence[str], folder: str, other: str
    ) -> None:
        """Make the folders, and run each command on them.

        Args:
            home: Where there is place.
            before: Commands that make the folders.
            readers: Commands that read them.
            folder: Name of the folder that is damaged.
            other: Name of another one of its kind.
        """
        self._whole, self._name, self._other = home / "whole", folder, home / "whole" / other
        self._whole.mkdir(parents=True)
        for words in before:
            _run(words, self._whole)
        self._files = [
            str(path.relative_to(self._whole / folder))
            for path in sorted((self._whole / folder).rglob("*"))
            if path.is_file()
            for _ in range(5 if path.suffix in (".json", ".npz") else 1)
        ]
        start = snapshot(self._whole)
        self.expected: dict[str, tuple[str, dict[str, str]]] = {}
        for number, words in enumerate(readers):
            work = Path(shutil.copytree(self._whole, home / str(number)))
            ended = _run(words, work)
            found = snapshot(work)
            made = {k: v for k, v in found.items() if start.get(k) != v}
            self.expected[words] = ended.out, made or found  # a sweep is as it was

    def damage(self, seed: Sequence[int]) -> list[Fault]:
        """Damage the folder, run some of the commands, and return what is wrong.

        Args:
            seed: Seed of the damage and of the choice of commands.
        """
        faults = []
        rng = np.random.default_rng(seed)
        words = list(self.expected)
        for one in map(str, rng.choice(words, min(_COMMANDS, len(words)), replace=False)):
            with tempfile.TemporaryDirectory() as home:
                work = Path(shutil.copytree(self._whole, Path(home) / "work"))
                same = np.random.default_rng([*seed, 1])  # for all commands
                kind = damage(work / self._name, self._files, self._other, same)
                if wrong := self._judge(one, work, crafted=kind.startswith("crafted")):
                    faults.append(Fault(f"{wrong} ({kind})", f"mpma {one}, seed {list(seed)}"))
        return faults

    def _judge(self, words: str, work: Path, *, crafted: bool) -> str:
        """Return what a command does wrong with a damaged folder, if anything."""
        out, expected = self.expected[words]
        start = snapshot(work)
        ended = in_fork(lambda: command(words.split()), work, _SECONDS)
        for _ in range(3):
            path = work / ended.last_line.removeprefix("mpma: ").partition(": ")[0]
            if not (ended.is_refusal and _REMOVE in ended.err and os.path.lexists(path)):
                break
            _remove(path)
            ended = in_fork(lambda: command(words.split()), work, _SECONDS)
        if problem := _problem(ended):
            return problem
        found = snapshot(work)
        if ended.code != 0:
            left = [name for name in found if ".mpma" in name]
            return f"left over: {', '.join(left)}" if left else ""
        made = {k: v for k, v in found.items() if k in expected or start.get(k) != v}
        if wrong := differences(expected, made):
            return "" if crafted else f"another result without a warning: {wrong}"
        return "" if out == ended.out else "another result without a warning on standard output"


def _remove(path: Path) -> None:
    shutil.rmtree(path) if path.is_dir() and not path.is_symlink() else path.unlink()


def _problem(ended: Ended) -> str:
    if ended.code is None:
        return f"did not end in {_SECONDS:g} s"
    if ended.code == 0:
        return "a traceback" if "Traceback" in ended.err else ""
    if "memory" in ended.err:
        return f"blames memory: {ended.last_line}"
    last = " | ".join(ended.err.splitlines()[-3:])
    return "" if ended.is_refusal else f"ended with {ended.code}, not in one line: {last}"


def _run(words: str, folder: Path) -> Ended:
    ended = in_fork(lambda: command(words.split()), folder)
    if ended.code != 0:
        raise RuntimeError(f"mpma {words} ended with {ended.code}: {ended.err}")
    return ended


def damage_folders(seed: int, seconds: float, workers: int) -> list[Part]:
    """Damage folders of runs and of sweeps in many ways, until time is up.

    Args:
        seed: Seed of the damage.
        seconds: For all.
        workers: Processes.
    """
    readers = _READERS if importlib.util.find_spec("minari") else _READERS[:-1]
    warm_up([f"{_RUN} --out run", _SWEPT])
    with tempfile.TemporaryDirectory() as home:
        before = (f"{_RUN} --out run", f"{_RUN} --seed 1 --out other")
        runs = DamagedFolders(Path(home) / "runs", before, readers, "run", "other")
        before = (_SWEPT, f"{_SWEEP} --grid nodes=4,5 --seed 1 --out other")
        sweeps = DamagedFolders(Path(home) / "sweeps", before, (_SWEPT,), "s", "other")
        cases = (
            ("damaged run folders", runs, _RUNS, 1 - _SHARE_OF_SWEEPS),
            ("damaged sweep folders", sweeps, _SWEEPS, _SHARE_OF_SWEEPS),
        )
        parts = []
        for name, damaging, count, share in cases:
            tries = [(seed, number) for number in range(count)]
            found = spread(tries, damaging.damage, workers=workers, seconds=share * seconds)
            parts.append(Part(name, found[0], count, found[1]))
    return parts
