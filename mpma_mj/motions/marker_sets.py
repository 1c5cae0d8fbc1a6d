"""Which of a file's points show the arms and the torso: told by their names."""

from __future__ import annotations

import itertools
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path

from mpma_mj.errors import MotionFileError
from mpma_mj.kinematics import SIDES
from mpma_mj.motions.body import ARM_POINTS
from mpma_mj.motions.mapping import Groups, mapping_option
from mpma_mj.motions.marker_names import (
    ACCLAIM,
    ACCLAIM_PELVIS,
    SETS,
    TORSO,
    Words,
    common_prefix,
    short_name,
)

__all__ = ["choose_markers"]

# For guesses: what names of a point usually have in them.
_GUESS = {
    "shoulder": re.compile(r"sho|shldr|acr|saj|humer|up(per)?_?arm|uarm|gleno", re.I),
    "elbow": re.compile(r"elb|epic|hle|hme|fore_?arm|low(er)?_?arm|farm", re.I),
    "wrist": re.compile(r"wri|styl|rsp|usp|uln|radi|wr[ab]\b|hand|carp", re.I),
}
# "left", or an l at the start before a separator or a capital, or at the end after one.
_SIDED = {
    "left": re.compile(r"[Ll]eft|LEFT|(?<![^\W_])[lL](?=[\W_A-Z])|[\W_]l$|(?<=[a-z\W_])L$"),
    "right": re.compile(r"[Rr]ight|RIGHT|(?<![^\W_])[rR](?=[\W_A-Z])|[\W_]r$|(?<=[a-z\W_])R$"),
}
_MOST_GUESSED = 2
_FEWEST = 3  # points that have to fit before names are taken for those of a set
_MOST_NAMED = 120  # names in a message


def choose_markers(path: Path, names: Sequence[str], mapping: Groups) -> Groups:
    """Find which of a file's points show the arms and, if it has some, the torso.

    Args:
        path: The file, for messages.
        names: The names that it has.
        mapping: What the user says; the rest is recognised by name.

    Returns:
        A group for every one of `ARM_POINTS`, and for `TORSO_POINTS` where the pelvis is shown.

    Raises:
        MotionFileError: A point is not recognised, or two dancers are, or a name that is needed
            stands twice; tells the file's names and a mapping to edit.
    """
    given = {p: tuple(_exact(path, n, names) for n in group) for p, group in mapping.items()}
    recognised = _recognised(names)
    # The torso has to be of the dancer whose arms the user means.
    meant = [groups for groups in recognised if _subjects(groups) & _subjects(given)]
    found = [groups | given for groups in meant or recognised] or [given]
    complete = [groups for groups in found if groups.keys() >= set(ARM_POINTS)]
    if len({tuple(groups[p] for p in ARM_POINTS) for groups in complete}) > 1:
        raise MotionFileError(
            f"{path}: shows {len(complete)} dancers",
            remedy=f"choose one with {mapping_option(complete[0])}, or"
            f" {mapping_option(complete[1])}",
        )
    if not complete:
        best = max(found, key=len)
        guessed = {p: _guess(p, names) for p in ARM_POINTS if p not in best}
        _check_once(path, names, {p: g for p, g in guessed.items() if len(set(g)) == 1})
        raise _not_recognised(path, names, best)
    groups = complete[0]
    if "pelvis" in groups:
        shoulders = (*groups["left_shoulder"], *groups["right_shoulder"])
        groups.setdefault("neck", shoulders)
    else:
        groups.pop("neck", None)
    _check_once(path, names, groups)
    return groups


def _check_once(path: Path, names: Sequence[str], groups: Groups) -> None:
    """Refuse names that stand twice in the file."""
    counts = Counter(names)
    twice = next((n for group in groups.values() for n in group if counts[n] > 1), None)
    if twice is not None:
        raise MotionFileError(
            f"{path}: {twice} stands twice; which of them is meant cannot be told, so rename or"
            " remove one"
        )


def _exact(path: Path, name: str, names: Sequence[str]) -> str:
    """Return the file's spelling of a name that the user gave."""
    if name in names:
        return name
    alike = [n for n in names if short_name(n) == short_name(name)]
    if len(set(alike)) != 1:
        raise MotionFileError(
            f"{path}: map names {name}, which the file {'has not' if not alike else 'has twice'};"
            f" it has {_listed(names)}"
        )
    return alike[0]


def _subjects(groups: Groups) -> set[str]:
    return {name.rpartition(":")[0] for group in groups.values() for name in group}


def _recognised(names: Sequence[str]) -> list[Groups]:
    """Return what is recognised of each subject of the file, the most first."""
    subjects: dict[str, dict[str, str]] = {}
    common = common_prefix(names)
    for name in names:
        subject, _, rest = name.rpartition(":")
        short = short_name(rest.removeprefix(common) if rest != common else rest)
        subjects.setdefault(subject, {}).setdefault(short, name)
    found = [_recognise(short) for short in subjects.values()]
    return sorted((groups for groups in found if groups), key=len, reverse=True)


def _recognise(short: Mapping[str, str]) -> Groups:
    """Return the groups of one subject: arms by the first set that fits, and torso."""
    best: Groups = {}
    for words in SETS:
        groups = {
            f"{side}_{point}": group
            for side in SIDES
            for point, choices in zip(_GUESS, words, strict=True)
            if (group := _first_group(choices, short, side))
        }
        if len(groups) > len(best):
            best = groups
        if len(best) == len(ARM_POINTS):
            break
    if len(best) < _FEWEST:
        return {}
    for point, choices in TORSO.items():
        for choice in choices:
            fits = choice != ACCLAIM_PELVIS or ACCLAIM in short
            if fits and all(word in short for word in choice):
                best[point] = tuple(short[word] for word in choice)
                break
    return best


def _first_group(choices: Words, short: Mapping[str, str], side: str) -> tuple[str, ...] | None:
    """Return the names of the first choice that is there on a side."""
    for choice in choices:
        spellings = (
            tuple(pattern.format(side=s, word=word) for word in choice)
            for s, pattern in itertools.product((side, side[0]), ("{side}{word}", "{word}{side}"))
        )
        for spelling in spellings:
            if all(word in short for word in spelling):
                return tuple(short[word] for word in spelling)
    return None


def _not_recognised(path: Path, names: Sequence[str], found: Groups) -> MotionFileError:
    """Return an error with the missing points, the file's names, and a mapping to edit."""
    guess = {point: found.get(point) or _guess(point, names) for point in ARM_POINTS}
    mapping = mapping_option({point: group or ("?",) for point, group in guess.items()})
    missing = [point.replace("_", " ") for point in ARM_POINTS if point not in found]
    has = f"it has {_listed(names)}"
    if not any(guess.values()):
        one = {point: [n for n in names if rule.search(n)] for point, rule in _GUESS.items()}
        if all(one.values()):
            return MotionFileError(
                f"{path}: shows one arm only, none that is named left or right"
                f" ({'; '.join('+'.join(group[:2]) for group in one.values())}): there is no left"
                " arm beside a right one, and both are needed"
            )
    for side in SIDES:
        if any(guess.values()) and not any(guess[p] for p in ARM_POINTS if p.startswith(side)):
            return MotionFileError(
                f"{path}: has no {side} arm, and both arms are needed; {has}",
                remedy=f"if that arm is among them, say it with {mapping}",
            )
    return MotionFileError(
        f"{path}: cannot tell which point is the {', the '.join(missing)}; {has}",
        remedy=f"say it with {mapping}",
    )


def _guess(point: str, names: Sequence[str]) -> tuple[str, ...]:
    """Return names that look like a point: with the right word, a side, and a twin opposite."""
    side, _, part = point.partition("_")
    mine, other = _SIDED[side], _SIDED[SIDES[1 - SIDES.index(side)]]
    twins = {other.sub("*", name) for name in names if other.search(name)}
    fitting = (
        name
        for name in names
        if _GUESS[part].search(name) and mine.search(name) and mine.sub("*", name) in twins
    )
    return tuple(itertools.islice(fitting, _MOST_GUESSED))


def _listed(names: Sequence[str]) -> str:
    more = f" and {len(names) - _MOST_NAMED} more" if len(names) > _MOST_NAMED else ""
    return ", ".join(names[:_MOST_NAMED]) + more
