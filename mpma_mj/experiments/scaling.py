"""Study `scaling`: more motions and longer ones, learned by more modules and larger ones."""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, Literal, NamedTuple, TypeAlias

from mpma_mj.errors import BadOptionError
from mpma_mj.experiments.records import Record, matching, mean_std_over_seeds
from mpma_mj.experiments.study import Count
from mpma_mj.experiments.training import Point, TrainingStudy
from mpma_mj.motions.options import ReadingOptions
from mpma_mj.options import Arms, Models
from mpma_mj.training.config import RunConfig

__all__ = ["Amount", "Scaling", "Size", "Unit", "Varying"]

Unit: TypeAlias = Literal["motions", "seconds"]
Varying: TypeAlias = Literal["modules", "nodes"]

# What is learned if nothing is given, so that it takes minutes (choice).
_BUILT_IN = tuple(f"synthetic-{number}" for number in range(1, 9))
_SHORTEST, _LONGEST = 5.0, 40.0  # s


class Amount(NamedTuple):
    """How much is learned.

    Attributes:
        unit: What is counted: motions, or seconds of one.
        number: Number of motions, or seconds.
        motions: The motions.
        end: End of the part of a motion that is learned, s; None for whole motions.
    """

    unit: Unit
    number: float
    motions: tuple[str, ...]
    end: float | None = None


class Size(NamedTuple):
    """Size of an agent: number of modules, and nodes of each of their reservoirs."""

    modules: int
    nodes: int


@dataclass(frozen=True, kw_only=True)
class Scaling(TrainingStudy):
    """Train on increasing numbers of motions, and on motions of increasing length.

    Reports at which size the agents saturate. Modules vary at the middle one of the numbers of
    nodes, and nodes at the middle number of modules (choice; the lower of two in the middle): all
    pairs would take hours.

    Attributes:
        motions: Recordings, or folders of them; the first 1, 2, 4, … are learned together, and the
            first seconds of the longest one. Synthetic motions if none are given.
        lengths: Lengths of the longest motion, s; 5, 10, 20 and 40, up to its length, if none are
            given.
        modules: Numbers of modules.
        nodes: Neurons of each reservoir; modules vary at the middle value, and nodes at the middle
            number of modules.
        models: Joint models (ours), or posture models (the paper's).
        rule: Learning rule: weighted (ours), gated (the paper's), or the path of a class.
        arms: Simulated arms, or arms that move ideally.
        proprioception: Whether posture models receive the joint angles too; the paper's do not.
    """

    name: ClassVar[str] = "scaling"
    motions: tuple[str, ...] = ()
    lengths: tuple[float, ...] = ()
    modules: tuple[int, ...] = (2, 4, 8, 16)
    nodes: tuple[int, ...] = (50, 100, 200, 400)
    runs: Count = 3
    epochs: Count = 12  # those that converge do so in about 7 (choice)
    models: Models = "joint"
    rule: str = "weighted"
    arms: Arms = "physics"
    proprioception: bool = True

    @property
    def lines(self) -> dict[Varying, tuple[Size, ...]]:
        """Sizes along which one number varies, by its name."""
        modules, nodes = self.crossing
        return {
            "modules": tuple(Size(count, nodes) for count in sorted(self.modules)),
            "nodes": tuple(Size(modules, count) for count in sorted(self.nodes)),
        }

    @property
    def crossing(self) -> Size:
        """The size that is on both lines."""
        return Size(_middle(self.modules), _middle(self.nodes))

    @property
    def sizes(self) -> tuple[Size, ...]:
        """All sizes, each once."""
        return tuple(dict.fromkeys(itertools.chain(*self.lines.values())))

    @functools.cached_property
    def amounts(self) -> tuple[Amount, ...]:
        """How much is learned: the first 1, 2, 4, … motions, and starts of the longest one.

        Raises:
            MpmaError: A motion cannot be read, or a length is out of bounds.
        """
        from mpma_mj.motions.loader import import_motion
        from mpma_mj.training.dataset import expand_folders

        motions = expand_folders(self.motions) or _BUILT_IN
        for motion in motions:
            if motions.count(motion) > 1:
                raise BadOptionError(f"{motion} is given twice; expected different motions")
        candidates = motions if self.motions else ("synthetic",)
        durations = {m: import_motion(m, ReadingOptions()).motion.duration for m in candidates}
        longest = max(durations, key=lambda motion: durations[motion])
        counts = [*_doublings(1, len(motions) - 1), len(motions)]
        seconds = self.lengths or _doublings(_SHORTEST, min(durations[longest], _LONGEST))
        _check_lengths(seconds, longest, durations[longest])
        return (
            *(Amount("motions", count, tuple(motions[: int(count)])) for count in counts),
            *(Amount("seconds", length, (longest,), length) for length in sorted(seconds)),
        )

    def points(self) -> list[Point]:
        """Return a point for each amount and size.

        There is a label for each motion, one if there is one; and a part of a motion has four, of
        equal parts, however long it is (choice): so that the effects of labels and of length can
        be separated.
        """
        for name in ("modules", "nodes"):
            values = getattr(self, name)
            if not values:
                raise BadOptionError("has no value; expected at least 1 size", option=name)
            if len(set(values)) < len(values):
                raise BadOptionError("has a value twice; leave one out", option=name)
        base = RunConfig.of(
            models=self.models,
            rule=self.rule,
            arms=self.arms,
            proprioception=self.proprioception,
            seed=self.seed,
        )
        points = []
        for amount in self.amounts:
            context: dict[str, Any] = {}
            if amount.end is not None:
                context = {"context": "equal"}
            elif len(amount.motions) == 1:  # as joined with others
                context = {"context": "equal", "segments": 1}
            options = {"motions": amount.motions, "end": amount.end} | context
            points += [
                Point(labels(amount, size), base.replace(**options, **size._asdict()))
                for size in self.sizes
            ]
        return points

    def mean(self, records: Sequence[Record], amount: Amount, size: Size, measure: str) -> float:
        """Return the mean of a measure over seeds; NaN if there is none."""
        own = matching(records, labels(amount, size))
        return mean_std_over_seeds(own, *measure.split(".")).mean

    def table(self, records: Sequence[Record]) -> str:
        """Return a table for each measure, and where it saturates."""
        from mpma_mj.experiments.scaling_report import as_markdown

        return as_markdown(self, records)

    def draw(self, path: Path, records: Sequence[Record]) -> None:
        """Write the figure."""
        from mpma_mj.experiments.scaling_report import write_figure

        write_figure(path, self, records)


def labels(amount: Amount, size: Size) -> dict[str, Any]:
    """Return the entries of a record that belong to an amount and a size."""
    return {"unit": amount.unit, "amount": amount.number, **size._asdict()}


def _doublings(first: float, last: float) -> list[float]:
    """Return a number, its double, and so on, up to another."""
    powers = itertools.takewhile(lambda x: x <= last, (first * 2**n for n in itertools.count()))
    return list(powers)


def _check_lengths(lengths: Sequence[float], name: str, duration: float) -> None:
    if not lengths:
        raise BadOptionError(
            f"{name}, the longest motion, lasts {duration:.2f} s, less than {_SHORTEST:g} s",
            remedy="give lengths with {lengths}",
        )
    if len(set(lengths)) < len(lengths):
        raise BadOptionError("has a value twice; leave one out", option="lengths")
    for length in lengths:
        if not (math.isfinite(length) and length > 0):
            problem = f"has {length:g}; expected seconds above 0"
            raise BadOptionError(problem, option="lengths")
        if length > duration:
            raise BadOptionError(
                f"has {length:g} s, and {name}, the longest motion, lasts {duration:.2f}"
                " s; give a shorter length, or a longer recording",
                option="lengths",
            )


def _middle(values: Sequence[int]) -> int:
    return sorted(values)[(len(values) - 1) // 2]
