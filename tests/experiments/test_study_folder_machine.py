"""A folder of a study in any order of running, kills, damage and other studies."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest
from hypothesis import strategies as st
from hypothesis.stateful import (
    RuleBasedStateMachine,
    invariant,
    precondition,
    rule,
)

from benchmarks.campaign.folder_damage import damage
from benchmarks.campaign.snapshots import differences, snapshot
from mpma_mj.errors import RunFolderError
from mpma_mj.experiments import study as pipeline
from mpma_mj.experiments.study import Record, Study, StudyJob, batches, run_study
from mpma_mj.training.config import RunConfig
from tests.experiments.runs import Here
from tests.killed import killed_at
from tests.state_machines import run_machine

AGENTS = {"small": {"nodes": 3}, "large": {"nodes": 4}}


@dataclass(frozen=True, eq=False, kw_only=True)
class QuickJob(StudyJob):
    """Runs whose results are known without training."""

    def do(self) -> list[Record]:
        return [
            {"agent": self.agent, "seed": one.seed, "diverged": False, "p_e": one.seed / 7}
            for one in self.configs
        ]


@dataclass(frozen=True, kw_only=True)
class Quick(Study):
    """Study of such runs."""

    name: ClassVar[str] = "quick"
    runs: int = 2

    def jobs(self) -> Sequence[StudyJob]:
        base = RunConfig.of(seed=self.seed)
        return [
            QuickJob(agent=name, configs=configs)
            for name, configs in batches(AGENTS, base, self.runs)
        ]

    def table(self, records: Sequence[Record]) -> str:
        return "\n".join(f"{one['agent']} {one['seed']} {one['p_e']}" for one in records)


@cache
def finished(seed: int) -> tempfile.TemporaryDirectory[str]:
    """Return the folder of a study that nobody disturbed."""
    place = tempfile.TemporaryDirectory()
    run(seed, Path(place.name) / "study")
    return place


def run(seed: int, folder: Path) -> None:
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(pipeline, "open_backend", lambda *_: Here())
        run_study(Quick(seed=seed), folder)


def results(folder: Path) -> dict[str, str]:
    """Return the contents but for locks and files that were being written."""
    found = snapshot(folder)
    return {name: content for name, content in found.items() if not Path(name).name.startswith(".")}


class StudyFolderMachine(RuleBasedStateMachine):
    """A study in a folder.

    Attributes:
        seed: That of the study that the folder holds; None where there may be none.
        sound: Whether nothing has damaged it.
    """

    def __init__(self) -> None:
        super().__init__()
        self.place = tempfile.TemporaryDirectory()
        self.folder = Path(self.place.name) / "study"
        self.seed: int | None = None
        self.sound = True

    def teardown(self) -> None:
        self.place.cleanup()

    @rule(seed=st.integers(0, 1), kill=st.none() | st.integers(0, 70))
    def run(self, seed: int, kill: int | None) -> None:
        before = results(self.folder)
        over = False
        try:
            with killed_at(kill):
                run(seed, self.folder)
                over = True
        except RunFolderError as error:
            other = self.seed is not None and seed != self.seed
            message = str(error)
            assert other or not self.sound
            assert other or "remove it" in message or "choose another folder" in message
            if other:
                assert not differences(before, results(self.folder))
            else:
                self._mend(Path(message.partition(": ")[0]))
        else:
            if over:
                assert not differences(snapshot(self.of(seed)), snapshot(self.folder))
                self.seed, self.sound = seed, True
            elif (self.folder / "study.json").exists() and self.seed is None:
                self.seed = seed

    @precondition(lambda self: self.seed is not None and self.sound)
    @rule(seed=st.integers(0, 1 << 32))
    def damage(self, seed: int) -> None:
        files = [
            str(path.relative_to(self.folder))
            for path in sorted(self.folder.rglob("*"))
            if path.is_file() and not path.name.startswith(".")
        ]
        rng = np.random.default_rng(seed)
        damage(self.folder, files, self.of(2), rng, crafted=False)
        self.sound = False

    @precondition(lambda self: self.seed is not None and self.sound)
    @invariant()
    def each_result_is_one_of_an_undisturbed_study(self) -> None:
        assert self.seed is not None
        whole = snapshot(self.of(self.seed))
        assert results(self.folder).items() <= whole.items()

    def of(self, seed: int) -> Path:
        return Path(finished(seed).name) / "study"

    def _mend(self, named: Path) -> None:
        """Do what the message says: remove a file, or choose another folder."""
        if named.parent.name == "runs":
            shutil.rmtree(named) if named.is_dir() and not named.is_symlink() else named.unlink()
            return
        shutil.rmtree(self.folder)
        self.seed, self.sound = None, True


def test_a_folder_of_a_study_never_loses_or_invents_a_result() -> None:
    run_machine(StudyFolderMachine, examples=10, steps=10)


@pytest.mark.slow
def test_a_folder_of_a_study_never_loses_or_invents_a_result_in_many_orders() -> None:
    run_machine(StudyFolderMachine, examples=100, steps=20)
