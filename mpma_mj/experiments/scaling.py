"""How MPMA scales: more movements and longer ones, learned by more modules and larger ones."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple, TypeAlias

from mpma_mj.errors import BadOptionError
from mpma_mj.experiments.spec import SweepSpec, seeds
from mpma_mj.motions.options import ReadingOptions
from mpma_mj.motions.read import read_with_findings
from mpma_mj.training.config import RunConfig

__all__ = ["Growing", "Material", "Scale", "Size", "Varying", "materials"]

Growing: TypeAlias = Literal["movements", "seconds"]
Varying: TypeAlias = Literal["modules", "nodes"]

_EPOCHS = 12  # most of a run; those that converge do so in about 7 (choice)
# What is tried if nothing is given, so that it takes minutes (choice).
_INVENTED = tuple(f"invented-{number}" for number in range(1, 9))
_SHORTEST, _LONGEST = 5.0, 40.0  # s


@dataclass(frozen=True)
class Material:
    """What is learned.

    Attributes:
        growing: What there is more and more of.
        amount: How much of it: a number of movements, or seconds of one.
        motions: The movements.
        end: Where a movement is cut, s; None where it is not.
    """

    growing: Growing
    amount: float
    motions: tuple[str, ...]
    end: float | None = None


class Size(NamedTuple):
    """Size of what learns: number of modules, and nodes of each of their reservoirs."""

    modules: int
    nodes: int


@dataclass(frozen=True)
class Scale:
    """Every material, learned by every size.

    Modules are varied at the middle one of the numbers of nodes, and nodes at the middle one of
    the numbers of modules (choice; the lower of two in the middle): all pairs would take hours.

    Attributes:
        materials: What is learned.
        modules: Numbers of modules.
        nodes: Numbers of nodes.
        base: All other settings.

    Raises:
        BadOptionError: There is no number of modules, or of nodes.
    """

    materials: tuple[Material, ...]
    modules: tuple[int, ...]
    nodes: tuple[int, ...]
    base: RunConfig

    def __post_init__(self) -> None:
        """Check what the rest relies on."""
        for name in ("modules", "nodes"):
            if not getattr(self, name):
                raise BadOptionError(f"{name} has no value; expected at least 1 size")

    @property
    def lines(self) -> dict[Varying, tuple[Size, ...]]:
        """Sizes along which one thing varies, by its name."""
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

    def point(self, material: Material, size: Size) -> RunConfig:
        """Return the settings with which a size learns a material.

        There is a label for each movement, one if there is one; and a movement that is cut has
        four, of equal parts, however long it is (choice): so that growth in labels and growth in
        length can be told apart.
        """
        point = self.base.replace(
            motions=material.motions,
            end=material.end,
            modules=size.modules,
            nodes=size.nodes,
        )
        if material.end is not None:
            return point.replace(context="equal")
        if len(material.motions) == 1:  # joined with others it has one label too
            return point.replace(context="equal", segments=1)
        return point

    def spec_of(self, runs: int) -> SweepSpec:
        """Return the sweep.

        Args:
            runs: Runs of every material and size, with seeds from 0.

        Raises:
            BadOptionError: There are no runs, or a size or a material stands twice.
        """
        for name in ("modules", "nodes"):
            values = getattr(self, name)
            if len(set(values)) < len(values):
                raise BadOptionError(f"{name} has a value twice; leave one out")
        points = [self.point(m, size) for m in self.materials for size in self.sizes]
        return SweepSpec(tuple(run for point in points for run in seeds(point, runs)), _EPOCHS)


def materials(motions: Sequence[str], lengths: Sequence[float]) -> tuple[Material, ...]:
    """Return what is learned: the first 1, 2, 4, … movements, and the start of the longest.

    Args:
        motions: Names and files of movements; the invented dances if there are none.
        lengths: How much of the longest is learned, s; if there are none, 5, 10, 20 and 40 s, as
            far as it goes.

    Raises:
        MpmaError: A movement cannot be read, or a length is not one that can be had.
    """
    for motion in motions:
        if motions.count(motion) > 1:
            raise BadOptionError(f"{motion} is given twice; expected different movements")
    if motions:
        longest = {m: read_with_findings(m, ReadingOptions()).motion.duration for m in motions}
    else:
        motions = _INVENTED
        longest = {"invented": read_with_findings("invented", ReadingOptions()).motion.duration}
    name = max(longest, key=lambda motion: longest[motion])
    counts = [*_doublings(1, len(motions) - 1), len(motions)]
    seconds = lengths or _doublings(_SHORTEST, min(longest[name], _LONGEST))
    _check_lengths(seconds, name, longest[name])
    return (
        *(Material("movements", count, tuple(motions[: int(count)])) for count in counts),
        *(Material("seconds", length, (name,), length) for length in sorted(seconds)),
    )


def _doublings(first: float, last: float) -> list[float]:
    """Return a number, its double, and so on, up to another."""
    powers = itertools.takewhile(lambda x: x <= last, (first * 2**n for n in itertools.count()))
    return list(powers)


def _check_lengths(lengths: Sequence[float], name: str, duration: float) -> None:
    if not lengths:
        raise BadOptionError(
            f"{name}, the longest movement, lasts {duration:.2f} s, less than {_SHORTEST:g} s",
            remedy="give lengths with {lengths}",
        )
    if len(set(lengths)) < len(lengths):
        raise BadOptionError("lengths has a value twice; leave one out")
    for length in lengths:
        if not (math.isfinite(length) and length > 0):
            raise BadOptionError(f"lengths has {length:g}; expected seconds above 0")
        if length > duration:
            raise BadOptionError(
                f"lengths has {length:g} s, and {name}, the longest movement, lasts"
                f" {duration:.2f} s; give less, or a longer recording"
            )


def _middle(values: Sequence[int]) -> int:
    return sorted(values)[(len(values) - 1) // 2]
