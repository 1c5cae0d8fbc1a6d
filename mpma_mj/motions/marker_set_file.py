"""Marker sets that are known by name: the content of `marker_sets.toml`."""

from __future__ import annotations

import functools
import itertools
import re
import tomllib
import unicodedata
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from mpma_mj.kinematics import SIDES

__all__ = ["PARTS", "MarkerSet", "MarkerSets", "marker_sets", "short_name"]

# Parts of names that do not identify a point.
_PREFIX = re.compile(r"^mixamorig\d*")
_SUFFIX = re.compile(r"(positions?|pos|jointcent(er|re))$")

PARTS = ("shoulder", "elbow", "wrist")
_Choices = list[tuple[str, ...]]  # groups of names, of which the first complete one is taken


@dataclass(frozen=True)
class MarkerSet:
    """A marker set or skeleton, by its names of the arms."""

    parts: dict[str, _Choices]
    sides: dict[str, tuple[str, ...]]
    bones: bool

    def spellings(self, part: str, side: str) -> Iterator[tuple[str, ...]]:
        """Iterate over the names that a part has on a side, the first choice first; "" is none."""
        for choice in self.parts[part]:
            for word_of_side in self.sides.get(side, ("",)):
                yield tuple(word_of_side + word for word in choice)
                yield tuple(word + word_of_side for word in choice)


@dataclass(frozen=True)
class MarkerSets:
    """Content of `marker_sets.toml`."""

    arms: list[MarkerSet]
    torso: dict[str, _Choices]
    half_pelvis: dict[Literal["front", "back"], re.Pattern[str]]
    facing: list[tuple[tuple[str, ...], tuple[str, ...]]]
    stand_ins: frozenset[str]
    only_with: dict[str, list[str]]
    markers: frozenset[str]
    words: frozenset[str]


@functools.cache
def marker_sets() -> MarkerSets:
    """Return the sets that are known."""
    content = tomllib.loads(Path(__file__).with_name("marker_sets.toml").read_text("utf-8"))

    def choices(groups: list[str]) -> _Choices:
        return [tuple(map(short_name, group.split("+"))) for group in groups]

    arms = [
        MarkerSet(
            {part: choices(table[part]) for part in PARTS},
            {side: tuple(table.get(side, (side, side[0]))) for side in SIDES},
            table.get("bones", False),
        )
        for table in content["set"]
    ]
    markers = content["markers"]["words"]

    def torso(point: str) -> _Choices:
        own = (choices(table.get(point, [])) for table in content["set"])
        return choices(content["torso"][point]) + list(itertools.chain(*own))

    hips = [
        tuple(map(short_name, pair))
        for marker_set, table in zip(arms, content["set"], strict=True)
        for word in table.get("hip", [])
        for left, right in itertools.product(*(marker_set.sides[side] for side in SIDES))
        for pair in ((left + word, right + word), (word + left, word + right))
    ]
    return MarkerSets(
        arms,
        {
            "pelvis": [*torso("pelvis"), *hips, *choices(content["stand_ins"]["pelvis"])],
            "neck": torso("neck"),
        },
        {end: re.compile(pattern) for end, pattern in content["half_pelvis"].items()},
        [
            (front, back)
            for pair in content["facing"]["pairs"]
            for front, back in [choices(pair.split(" > "))]
        ],
        frozenset(content["stand_ins"]["pelvis"]),
        content["only_with"],
        frozenset(s + w for w in markers for s in "lr") | {w + s for w in markers for s in "lr"},
        frozenset(
            word
            for marker_set, part, side in itertools.product(arms, PARTS, SIDES)
            for spelling in marker_set.spellings(part, side)
            for word in spelling
        ),
    )


def short_name(name: str) -> str:
    """Return a name without subject, case, accents, separators and insignificant parts."""
    plain = unicodedata.normalize("NFKD", name.rpartition(":")[2].lower())
    return _SUFFIX.sub("", _PREFIX.sub("", re.sub(r"[\W_]+", "", plain)))
