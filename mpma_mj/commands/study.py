"""Command `mpma study`."""

from __future__ import annotations

import abc
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, ClassVar

import tyro

from mpma_mj.commands.folders import free_folder, hint_at_resuming
from mpma_mj.commands.run_options import Motions
from mpma_mj.errors import BadOptionError
from mpma_mj.options import Arms
from mpma_mj.utils.text import did_you_mean

if TYPE_CHECKING:
    from mpma_mj.experiments import study

__all__ = ["Study", "check_study"]


@dataclass(frozen=True, kw_only=True)
class _Options(abc.ABC):
    """Options of all studies."""

    name: ClassVar[str]
    runs: int = 10
    """Runs of each agent."""
    seed: int = 0
    """Seed of the first run, which those of the others follow."""
    arms: Arms = "physics"
    """Simulated arms, or arms that move ideally."""
    workers: int | None = None
    """Number of parallel processes; as many as there are processors if not given."""
    out: Path | None = None
    """Folder of table and figure; runs/study-NAME-TIME if not given."""

    def run(self) -> Path:
        """Run the study, print its table and return its folder."""
        from mpma_mj.experiments.study import HEADER, run_study

        folder = self.out or free_folder(f"study-{self.name}")
        resume = f"the same command with --out {folder}"
        with hint_at_resuming((folder / HEADER).exists, resume):
            print(run_study(self._study(), folder, self.workers))
        return folder

    @abc.abstractmethod
    def _study(self) -> study.Study:
        """Return the study."""


@dataclass(frozen=True, kw_only=True)
class Switching(_Options):
    """Learn four plants one after the other, then imitate while they switch unannounced.

    Repeat the command with the same --out to resume.
    """

    name: ClassVar[str] = "switching"
    motion: str = "ymca"
    """Built-in motion, or path of a recording."""
    reverse: bool = False
    """Learn the plants in reverse order."""

    def _study(self) -> study.Study:
        from mpma_mj.experiments import switching

        return switching.Switching(
            motion=self.motion,
            reverse=self.reverse,
            runs=self.runs,
            seed=self.seed,
            arms=self.arms,
        )


@dataclass(frozen=True, kw_only=True)
class Unseen(_Options):
    """Learn all motions but one together, and imitate that one without learning.

    Repeat the command with the same --out to resume.
    """

    name: ClassVar[str] = "unseen"
    motions: Motions = ()
    """Recordings, or folders of them, beside ymca."""

    def _study(self) -> study.Study:
        from mpma_mj.experiments import unseen
        from mpma_mj.training.dataset import expand_folders

        motions = tuple(dict.fromkeys(("ymca", *expand_folders(self.motions))))
        return unseen.Unseen(motions=motions, runs=self.runs, seed=self.seed, arms=self.arms)


@dataclass(frozen=True, kw_only=True)
class Latency(_Options):
    """Learn a motion with late senses, and imitate it with them.

    Repeat the command with the same --out to resume.
    """

    name: ClassVar[str] = "latency"
    motion: str = "ymca"
    """Built-in motion, or path of a recording."""

    def _study(self) -> study.Study:
        from mpma_mj.experiments import latency

        return latency.Latency(motion=self.motion, runs=self.runs, seed=self.seed, arms=self.arms)


@dataclass(frozen=True, kw_only=True)
class Robustness(_Options):
    """Train agents, and evaluate them under disturbances.

    Repeat the command with the same --out to resume.
    """

    name: ClassVar[str] = "robustness"
    motion: str = "ymca"
    """Built-in motion, or path of a recording."""
    epochs: int = 30
    """Largest number of epochs of a training, which ends when it has converged."""
    fine_tune: int = 0
    """Epochs of fine-tuning in each condition; 0 for none."""
    disturbances: tuple[str, ...] = ()
    """Some of payload, strength, gravity, latency, noise, pushes, tempo, mirrored, locked, unseen;
    all that the arms can have if not given."""

    def _study(self) -> study.Study:
        from mpma_mj.experiments import robustness

        names = ("motion", "epochs", "fine_tune", "disturbances", "runs", "seed", "arms")
        return robustness.Robustness(**{name: getattr(self, name) for name in names})


_STUDIES = (Switching, Unseen, Latency, Robustness)
_NAMES = tuple(one.name for one in _STUDIES)


@dataclass(frozen=True)
class Study:
    """Study over many runs, with table and figure: switching, unseen, latency, robustness."""

    study: tyro.conf.OmitArgPrefixes[
        tyro.conf.OmitSubcommandPrefixes[
            Annotated[Switching, tyro.conf.subcommand(Switching.name)]
            | Annotated[Unseen, tyro.conf.subcommand(Unseen.name)]
            | Annotated[Latency, tyro.conf.subcommand(Latency.name)]
            | Annotated[Robustness, tyro.conf.subcommand(Robustness.name)]
        ]
    ]

    def run(self) -> Path:
        """Run the study and return its folder."""
        return self.study.run()


def check_study(words: Sequence[str]) -> None:
    """Refuse a command line that names no study.

    Args:
        words: Words after `mpma study`.

    Raises:
        BadOptionError: The first word is neither a study nor asks for help.
    """
    if not words:
        raise BadOptionError(f"no study given; expected one of {', '.join(_NAMES)}")
    if words[0] not in (*_NAMES, "--help", "-h"):
        remedy = did_you_mean(words[0], _NAMES)
        raise BadOptionError(
            f"no study '{words[0]}'; expected one of {', '.join(_NAMES)}", remedy=remedy
        )
