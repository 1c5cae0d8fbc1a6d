"""Command `mpma study`."""

from __future__ import annotations

import importlib
import inspect
from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Generic, TypeVar

import tyro

from mpma_mj.commands.workers import StudyWorkers, Workers
from mpma_mj.errors import BadOptionError
from mpma_mj.utils.text import did_you_mean

if TYPE_CHECKING:
    from mpma_mj.experiments import study

__all__ = ["STUDIES", "RunStudy", "Study", "parse_study", "remedy_for_unused"]

StudyT = TypeVar("StudyT", bound="study.Study")

STUDIES = {
    "table1": "Table1",
    "agents": "CompareAgents",
    "ablation": "Ablation",
    "scaling": "Scaling",
    "unseen": "Unseen",
    "switching": "Switching",
    "latency": "Latency",
    "robustness": "Robustness",
}
"""Classes of the built-in studies by name, which is also the name of their module."""

_EXPECTED = f"{', '.join(STUDIES)}, or the path of a class, such as my_study.py:MyStudy"


@dataclass(frozen=True, kw_only=True)
class Study:
    """Study over many runs, with table and figure; mpma study NAME --help shows its options.

    These are built in:
    - table1: Table 1 of the paper
    - agents: all agents, on several motions, with both kinds of arms
    - ablation: MPMA with one component changed at a time
    - scaling: more motions and longer ones, more modules and larger ones
    - unseen: motions that were not learned
    - switching: plants that change unannounced
    - latency: late senses
    - robustness: disturbances

    Attributes:
        name: One of these, or the path of a class, such as my_study.py:MyStudy.
    """

    name: Annotated[str, tyro.conf.Positional, tyro.conf.arg(metavar="NAME")]


@dataclass(frozen=True, kw_only=True)
class RunStudy(Generic[StudyT]):
    """A study, and who runs it.

    Attributes:
        study: The study.
        who: Workers that train.
        out: Folder of table and figure; runs/study-NAME-TIME if not given.
    """

    study: Annotated[tyro.conf.OmitArgPrefixes[StudyT], tyro.conf.arg(name="")]
    who: StudyWorkers = Workers()
    out: Path | None = None

    def run(self) -> Path:
        """Run the study, print its table and return its folder."""
        return self.who.run(self.study, self.out, f"study-{self.study.name}")


def parse_study(words: Sequence[str]) -> RunStudy[Any] | None:
    """Return the study that a command line describes, None if it asks for the general help.

    Args:
        words: Words after `mpma study`.

    Raises:
        BadOptionError: The first word is no study.
    """
    if not words:
        raise BadOptionError(f"no study given; expected one of {_EXPECTED}")
    name, *options = words
    if name in ("--help", "-h"):
        return None
    kind = _study_class(name)
    about = inspect.cleandoc(kind.__doc__ or "").partition("\n\nAttributes:")[0]
    generic: Any = RunStudy
    command: RunStudy[Any] = tyro.cli(
        generic[kind],
        prog=f"mpma study {name}",
        description=f"{about}\n\nRepeat the command with the same --out to resume.",
        args=options,
    )
    return command


def remedy_for_unused(words: Sequence[str]) -> str:
    """Return what to do with a word after `mpma study` for which the study has no use."""
    has_motion = any(field.name == "motion" for field in fields(_study_class(words[0])))
    return "give a motion with --motion" if has_motion else "leave it out"


def _study_class(name: str) -> type[study.Study]:
    """Return the class of a study.

    Raises:
        BadOptionError: There is none of this name, or the class is no study.
    """
    if name in STUDIES:
        module = importlib.import_module(f"mpma_mj.experiments.{name}")
        found: type[study.Study] = getattr(module, STUDIES[name])
        return found
    if ":" not in name:
        remedy = did_you_mean(name, STUDIES)
        raise BadOptionError(f"no study '{name}'; expected one of {_EXPECTED}", remedy=remedy)
    from mpma_mj.agents.extensions import load_class
    from mpma_mj.experiments.study import Study as Base

    try:
        found = load_class(name, "study", (), base=Base)
        if not issubclass(found, Base):
            home = "mpma_mj.experiments"
            remedy = f"inherit from {home}.study.Study or {home}.training.TrainingStudy"
            raise BadOptionError(option="study", expected="a study", remedy=remedy)
        return load_class(name, "study", ("name",), base=Base)
    except BadOptionError as error:  # there is no option of this name
        problem = f"no study '{name}': expected {error.expected}"
        raise BadOptionError(problem, remedy=error.remedy) from None
