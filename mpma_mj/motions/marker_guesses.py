"""Refusal of names that are not recognised, with a mapping to edit."""

from __future__ import annotations

import functools
import itertools
import re
import tomllib
import unicodedata
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from mpma_mj.errors import MotionFileError
from mpma_mj.kinematics import SIDES
from mpma_mj.motions.body import ARM_POINTS
from mpma_mj.motions.mapping import Groups, mapping_option
from mpma_mj.utils.text import listing

__all__ = [
    "check_joints",
    "check_once",
    "hands_for_wrists",
    "is_no_place",
    "listed",
    "not_recognised",
]

# "left", or an l at the start before a separator or a capital, or at the end after one.
_SIDED = {
    "left": re.compile(
        r"[Ll]eft|LEFT|(?<![^\W_])[lL](?=[\W_A-Z])|[\W_]l$|(?<=[a-z\W_])L(?=[\W_]|$)"
    ),
    "right": re.compile(
        r"[Rr]ight|RIGHT|(?<![^\W_])[rR](?=[\W_A-Z])|[\W_]r$|(?<=[a-z\W_])R(?=[\W_]|$)"
    ),
}
_LONGEST = 60  # letters of a name in a message
_MOST_LISTED = 120  # names in a message
_MOST_CENTRES = 3


@dataclass(frozen=True)
class _Guesses:
    """Content of `marker_guesses.toml`."""

    markers: dict[str, re.Pattern[str]]
    bones: dict[str, re.Pattern[str]]
    pairs: frozenset[frozenset[str]]
    no_places: re.Pattern[str]
    centres: re.Pattern[str]
    centre_of_bodies: str
    bodies: re.Pattern[str]


@functools.cache
def _guesses() -> _Guesses:
    content = tomllib.loads(Path(__file__).with_suffix(".toml").read_text("utf-8"))
    rules = {
        kind: {part: re.compile(rf"\b[lmr]?({rule})") for part, rule in content[kind].items()}
        for kind in ("markers", "bones")
    }
    pairs = frozenset(frozenset(pair.split()) for pair in content["pairs"]["differences"])
    centres = content["centres_of_mass"]
    return _Guesses(
        rules["markers"],
        rules["bones"],
        pairs,
        re.compile(content["no_places"]["ends"]),
        re.compile(centres["words"]),
        centres["with"],
        re.compile(centres["bodies"]),
    )


def not_recognised(
    path: Path, names: Sequence[str], found: Groups, single: Groups | None
) -> MotionFileError:
    """Return an error with the missing points, the file's names, and a mapping to edit.

    Args:
        path: The file.
        names: The names that it has.
        found: What is recognised.
        single: The only whole arm, if there is one.

    Raises:
        MotionFileError: A name that looks like one of the points appears twice.
    """
    guess = {point: found.get(point) or _guess(point, names) for point in ARM_POINTS}
    check_once(path, names, guess)
    if not any(guess[f"{side}_elbow"] for side in SIDES):  # then it may be the collar bone
        for point in ("left_shoulder", "right_shoulder"):
            if any(_words(name) == "shoulder" for name in guess[point]):
                guess[point] = ()
    mapping = mapping_option({point: group or ("?",) for point, group in guess.items()})
    has = f"it has {listed(names)}"
    ways = f"name the points with {mapping}"
    if single is not None:
        other = SIDES["left_wrist" in single]
        without = (
            "{other_arm=hang} lets the other arm hang, {other_arm=mirror} makes it the mirror image"
        )
        named = "; ".join("+".join(single[p]) for p in ARM_POINTS if p in single)
        if not any(found.get(point) for point in ARM_POINTS):
            return MotionFileError(
                f"{path}: shows a single arm, named neither left nor right ({named}), and both arms"
                " are needed",
                remedy=without,
            )
        if not any(guess[f"{other}_{part}"] for part in ("shoulder", "elbow", "wrist")):
            return MotionFileError(
                f"{path}: has no {other} arm, and both arms are needed; {has}",
                remedy=f"{without}; if that arm is among them, {ways}",
            )
        ways = f"{ways}, or do without that arm: {without}"
    missing = [point.replace("_", " ") for point in ARM_POINTS if point not in found]
    return MotionFileError(
        f"{path}: no point is recognised as the {', the '.join(missing)}; {has}", remedy=ways
    )


def check_once(path: Path, names: Sequence[str], groups: Groups) -> None:
    """Refuse names that appear twice in the file.

    Raises:
        MotionFileError: There is one.
    """
    counts = Counter(names)
    twice = next((n for group in groups.values() for n in group if counts[n] > 1), None)
    if twice is not None:
        raise MotionFileError(f"{path}: {twice} appears twice; rename or remove one")


def check_joints(path: Path, names: Sequence[str], groups: Groups) -> None:
    """Refuse arms of which a file holds the segments' centres of mass.

    Args:
        path: The file.
        names: The names that it has.
        groups: Points that are recognised in it.

    Raises:
        MotionFileError: It does.
    """
    rules = _guesses()
    of_bodies = any(_words(name) == rules.centre_of_bodies for name in names)
    centres = [
        name
        for point in ARM_POINTS
        for name in groups.get(point, ())
        if _is_centre(name) or (of_bodies and rules.bodies.match(_words(name)))
    ]
    if centres:
        raise MotionFileError(
            f"{path}: {listing(centres, _MOST_CENTRES)} are centres of mass of segments, which are"
            " no joints",
            remedy="export places of joints; if they are joints, name them with {map}",
        )


def hands_for_wrists(groups: Groups) -> list[str]:
    """Return the hands in place of wrists: those of arms whose elbows are no bones."""
    rules = _guesses()
    return [
        "+".join(groups[f"{side}_wrist"])
        for side in SIDES
        if f"{side}_wrist" in groups
        and all(re.search(r"\b[lr]?(hand|main|mano)\b", _words(n)) for n in groups[f"{side}_wrist"])
        and any(rules.markers["elbow"].search(_words(n)) for n in groups[f"{side}_elbow"])
    ]


def _is_centre(name: str) -> bool:
    return _guesses().centres.search(_words(name)) is not None


def is_no_place(end: str) -> bool:
    """Return whether a name with such an end, in lower case, shows no place of a joint."""
    return _guesses().no_places.fullmatch(end) is not None


def listed(names: Sequence[str]) -> str:
    """Return names for a message, those that look like arms first."""
    rules = _guesses()
    patterns = [*rules.markers.values(), *rules.bones.values()]
    first = [n for n in names if any(pattern.search(_words(n)) for pattern in patterns)]
    ordered = list(dict.fromkeys((*first, *names)))
    short = [f"{name[:_LONGEST]}{'…' * (len(name) > _LONGEST)}" for name in ordered]
    return listing(short, _MOST_LISTED)


def _guess(point: str, names: Sequence[str]) -> tuple[str, ...]:
    """Return the name, or the pair of names, that looks like a point and has a twin opposite."""
    side, _, part = point.partition("_")
    mine, other = _SIDED[side], _SIDED[SIDES[1 - SIDES.index(side)]]
    rules = _guesses()
    are_markers = any(rules.markers["sure"].search(_words(name)) for name in names)
    # A bone of the forearm begins at the elbow, a marker on the forearm lies anywhere on it.
    are_bones = not are_markers and any(rules.bones["shoulder"].search(_words(n)) for n in names)
    rule = (rules.bones if are_bones else rules.markers)[part]
    twins = {other.sub("*", name) for name in names if other.search(name)}
    sided = [n for n in names if mine.search(n) and mine.sub("*", n) in twins]
    alike = [n for n in sided if rule.search(_words(n)) and not rules.no_places.search(_words(n))]
    fitting = tuple(name for name in dict.fromkeys(alike) if not _is_centre(name))
    is_clear = len(fitting) == 1 or (len(fitting) == 2 and _is_pair(*fitting))
    return fitting if is_clear else ()


def _is_pair(first: str, second: str) -> bool:
    """Return whether two names are those of markers at either side of one joint."""
    both = [_words(name).replace(" ", "") for name in (first, second)]
    for _ in range(2):  # without a common beginning, then without a common end
        shared = itertools.takewhile(
            lambda letters: len(set(letters)) == 1, zip(*both, strict=False)
        )
        count = sum(1 for _ in shared)
        both = [name[count:][::-1] for name in both]
    return frozenset(both) in _guesses().pairs


@functools.lru_cache(maxsize=1 << 16)
def _words(name: str) -> str:
    """Return a name in lower case without subject, side and accents, its words apart."""
    plain = unicodedata.normalize("NFKD", name.rpartition(":")[2])
    for pattern in _SIDED.values():
        plain = pattern.sub(" ", plain)
    plain = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", re.sub("[\u0300-\u036f]", "", plain))
    return re.sub(r"[\W_]+", " ", plain).strip().lower()
