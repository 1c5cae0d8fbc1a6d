"""A run folder in any order of training, kills, resuming, overwriting and damage."""

from __future__ import annotations

import shutil
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

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
from mpma_mj.errors import MpmaError, RunFolderError
from mpma_mj.motions import Motion, ymca
from mpma_mj.training.config import RunConfig
from mpma_mj.training.run import resume, train
from mpma_mj.training.run_folder import RunFolder
from mpma_mj.utils.folder_lock import locked
from tests.killed import killed_at
from tests.state_machines import run_machine

FILES = (
    *("config.json", "trace.npz", "metrics.csv"),
    *(f"checkpoint/{name}.npz" for name in ("best", "latest", "motion")),
)
SEEDS = st.integers(0, 1)
EPOCHS = st.integers(1, 2)
KILLS = st.none() | st.integers(0, 60)


@cache
def motion() -> Motion:
    """Return a motion of a second, so that an epoch takes milliseconds."""
    whole = ymca()
    return Motion(whole.posture[:20], whole.context[:20], whole.labels, whole.rate, "part", "here")


@cache
def home() -> Any:
    return tempfile.TemporaryDirectory()


@cache
def undisturbed(seed: int, epochs: int) -> Path:
    """Return the folder of a run that nobody disturbed."""
    folder = RunFolder(Path(home().name) / f"{seed}-{epochs}")
    train(config(seed), epochs, motion=motion(), folder=folder)
    return folder.path


@cache
def expected(seed: int, epochs: int) -> dict[str, str]:
    return snapshot(undisturbed(seed, epochs))


def config(seed: int) -> RunConfig:
    return RunConfig.of(nodes=3, modules=1, repeats=1, arms="kinematic", seed=seed)


class RunFolderMachine(RuleBasedStateMachine):
    """Runs of two seeds in one folder.

    Attributes:
        seeds: Seeds of which the folder may hold a run: after a kill, the earlier one's too.
        least: Epochs that it holds at least; 0 where it may hold no run that can be resumed.
        sound: Whether nothing has damaged it.
    """

    def __init__(self) -> None:
        super().__init__()
        self.place = tempfile.TemporaryDirectory()
        self.folder = RunFolder(Path(self.place.name) / "run")
        self.seeds: set[int] = set()
        self.least, self.sound = 0, True

    def teardown(self) -> None:
        self.place.cleanup()

    @rule(seed=SEEDS, epochs=EPOCHS, kill=KILLS)
    def train(self, seed: int, epochs: int, kill: int | None) -> None:
        begun = 0

        def on_epoch(_: object) -> None:
            nonlocal begun
            begun += 1

        over = False
        try:
            with killed_at(kill), locked(self.folder.path):
                train(
                    config(seed),
                    epochs,
                    motion=motion(),
                    folder=self.folder,
                    overwrite=True,
                    on_epoch=on_epoch,
                )
                over = True
        except MpmaError:
            assert not self.sound  # then a user removes the folder
            shutil.rmtree(self.folder.path)
            self.seeds, self.least, self.sound = set(), 0, True
        else:
            if over:
                self._check(seed, epochs)
            elif begun:
                self.seeds, self.least, self.sound = {seed}, begun, True
            else:
                self.seeds, self.least = self.seeds | {seed}, 0

    @precondition(lambda self: self.least and self.sound)
    @rule(seed=SEEDS)
    def train_without_overwriting(self, seed: int) -> None:
        before = snapshot(self.folder.path)
        with pytest.raises(RunFolderError, match="already contains a run"):
            train(config(seed), motion=motion(), folder=self.folder)
        assert snapshot(self.folder.path) == before

    @rule(epochs=EPOCHS, kill=KILLS)
    def resume(self, epochs: int, kill: int | None) -> None:
        run = None
        try:
            with killed_at(kill), self.folder.locked():
                run = resume(self.folder, epochs)
        except MpmaError:
            assert not (self.least and self.sound)
        else:
            if run is not None:
                assert len(run.history.rows) >= self.least  # as many if it has converged
                self._check(run.config.seed, len(run.history.rows))

    @precondition(lambda self: self.least and self.sound)
    @rule(seed=st.integers(0, 1 << 32))
    def damage(self, seed: int) -> None:
        other = undisturbed(2, 1)
        files = [name for name in FILES if (self.folder.path / name).is_file()]
        damage(self.folder.path, files, other, np.random.default_rng(seed), crafted=False)
        self.sound = False

    @precondition(lambda self: self.least and self.sound)
    @invariant()
    def an_agent_can_be_read(self) -> None:
        own = self.folder.read_config()
        assert own.seed in self.seeds
        assert self.folder.read_best(own)  # raises if it is not one of this config

    def _check(self, seed: int, epochs: int) -> None:
        """Check that the folder is that of an undisturbed run, and note it."""
        if not self.sound:  # bytes after the end harm nothing, and this file is not written again
            assert np.array_equal(self.folder.read_motion().posture, motion().posture)
            whole = RunFolder(undisturbed(seed, epochs)).checkpoint("motion")
            shutil.copy(whole, self.folder.checkpoint("motion"))
        assert not differences(expected(seed, epochs), snapshot(self.folder.path))
        self.seeds, self.least, self.sound = {seed}, epochs, True


def test_a_run_folder_never_loses_or_invents_a_result() -> None:
    run_machine(RunFolderMachine, examples=6, steps=8)


@pytest.mark.slow
def test_a_run_folder_never_loses_or_invents_a_result_in_many_orders() -> None:
    run_machine(RunFolderMachine, examples=50, steps=20)
