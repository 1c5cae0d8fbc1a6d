"""Points of the body among a file's markers, by marker set (`marker_sets.toml`) or mapping."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Literal

from mpma_mj.errors import MotionFileError
from mpma_mj.kinematics import SIDES
from mpma_mj.motions.body import ARM_POINTS
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.mapping import Groups, mapping_option
from mpma_mj.motions.marker_guesses import (
    check_joints,
    check_once,
    hands_for_wrists,
    is_no_place,
    listed,
    not_recognised,
)
from mpma_mj.motions.marker_set_file import PARTS, marker_sets, short_name
from mpma_mj.utils.text import listing

__all__ = ["choose_markers", "facing_markers", "half_pelvis", "unrecognised"]

_FEWEST = 3  # points that have to fit before names are taken for those of a set
_MOST_AFFIXES = 8  # that are tried
_MOST_LISTED = 20  # names that are not recognised, in a message
_Person = dict[str, str]  # the names of one person, by short name


def choose_markers(
    path: Path,
    names: Sequence[str],
    mapping: Groups,
    report: ImportReport | None = None,
    *,
    one_arm: bool = False,
    root: str | None = None,
) -> Groups:
    """Find which of a file's points show the arms and, if it has some, the torso.

    Args:
        path: The file, for messages.
        names: The names that it has.
        mapping: Markers that the user gave; other points are recognised by name.
        report: Gets what is assumed.
        one_arm: Whether one arm is enough.
        root: Joint of a skeleton from which its legs branch, which is taken for a pelvis that is
            not recognised.

    Returns:
        A group for every one of `ARM_POINTS`, or for those of one arm and perhaps the other
        shoulder, and for `TORSO_POINTS` where they are shown.

    Raises:
        MotionFileError: A point is not recognised, or two people are, or a name that is needed
            appears twice; the message lists the file's names and a mapping to edit.
    """
    given = {p: tuple(_exact(path, n, names) for n in group) for p, group in mapping.items()}
    mapped = {name for group in given.values() for name in group}
    people = _people(names)
    # The torso must be that of the person whose arms the user chose.
    meant = [person for person in people if mapped & set(person.values())]
    found = [_recognise(person) | given for person in meant or people] or [given]
    found.sort(key=len, reverse=True)
    complete = [groups for groups in found if groups.keys() >= set(ARM_POINTS)]
    single = [one for groups in found if (one := _single_arm(groups))]
    if not complete and not single:
        unsided = [_recognise(person, one_arm=True) | given for person in meant or people]
        single = [one for groups in unsided if (one := _single_arm(groups))]
        if single and one_arm and report is not None:
            report.warn(
                "the arm is named neither left nor right and taken as the right one",
                remedy=f"{mapping_option(_as_left(single[0]))} makes it the left one",
            )
    complete = complete or single * one_arm
    distinct = {tuple(groups.get(p) for p in ARM_POINTS): groups for groups in complete}
    if len(distinct) > 1:
        first, second, *_ = distinct.values()
        raise MotionFileError(
            f"{path}: shows {len(distinct)} people",
            remedy=f"choose one with {mapping_option(first)}, or {mapping_option(second)}",
        )
    if not complete:
        raise not_recognised(path, names, found[0], single[0] if single else None)
    groups = complete[0]
    stand_in = _stand_in(groups)
    if root is not None and ("pelvis" not in groups or stand_in):
        groups["pelvis"], stand_in = (root,), ""
    if not groups.keys() >= set(ARM_POINTS):
        pass  # of one arm any point of the torso shows where its other side is
    elif "pelvis" in groups:
        groups.setdefault("neck", (*groups["left_shoulder"], *groups["right_shoulder"]))
    else:
        groups.pop("neck", None)
    check_once(path, names, groups)
    check_joints(path, names, {p: group for p, group in groups.items() if p not in given})
    if report is not None:
        for hand in hands_for_wrists(groups):
            report.note(f"{hand} stands for a wrist, which the file does not name")
        if stand_in and "pelvis" not in given:
            report.warn(
                f"{stand_in} stands for the pelvis, which is not recognised: the torso may be off"
                " by some degrees",
                remedy='name it with {map="pelvis=?"}',
            )
    return groups


def unrecognised(names: Sequence[str], groups: Groups) -> str:
    """Return the names that show none of a person's points, for a message; "" if there are none."""
    used = {name for group in groups.values() for name in group}
    return listing([name for name in dict.fromkeys(names) if name not in used], _MOST_LISTED)


def half_pelvis(group: Sequence[str]) -> Literal["front", "back"] | None:
    """Return at which end of the pelvis its markers are, None if at both or unknown."""
    ends = {
        end
        for name in group
        for end, pattern in marker_sets().half_pelvis.items()
        if pattern.search(short_name(name))
    }
    return ends.pop() if len(ends) == 1 else None


def facing_markers(names: Sequence[str], groups: Groups) -> Groups:
    """Return groups "front" and "back" of points that show where a person faces, or empty ones.

    Args:
        names: The names that the file has.
        groups: The person's arms and torso.
    """
    arms = {name for point in ARM_POINTS for name in groups.get(point, ())}
    for person in _people(names):
        if arms <= set(person.values()):
            for pair in marker_sets().facing:
                if all(word in person for group in pair for word in group):
                    front, back = (tuple(person[word] for word in group) for group in pair)
                    return {"front": front, "back": back}
    return {"front": (), "back": ()}


def _stand_in(groups: Groups) -> str:
    """Return the point that stands for the pelvis, "" if it is the pelvis or is not there."""
    (name, *more) = groups.get("pelvis", ("",))
    return name if not more and short_name(name) in marker_sets().stand_ins else ""


def _exact(path: Path, name: str, names: Sequence[str]) -> str:
    """Return the file's spelling of a name that the user gave."""
    if name in names:
        return name
    alike = [n for n in names if short_name(n) == short_name(name)]
    if len(set(alike)) != 1:
        raise MotionFileError(
            f"{path}: has {'two points' if alike else 'no point'} {name}; it has {listed(names)}",
            remedy="correct the name in {map}",
        )
    return alike[0]


def _people(names: Sequence[str]) -> list[_Person]:
    """Return the names of each person by subject, and by what is glued to all their names."""
    subjects: dict[str, _Person] = {}
    for name in names:
        subject = name.rpartition(":")[0]
        subjects.setdefault(subject, {}).setdefault(short_name(name), name)
    people = []
    for person in subjects.values():
        people.append(person)
        if not _recognise(person).keys() >= set(ARM_POINTS):
            glued = [_without(person, *affixes) for affixes in _glued(person)]
            people += [one for one in glued if _whole_arms(_recognise(one))]
    return people


def _glued(person: _Person) -> list[tuple[str, str]]:
    """Return beginnings and ends that names of arms share, such as "anna" of AnnaLSHO."""
    sets = marker_sets()
    counts: Counter[tuple[str, str]] = Counter()
    longest = max(map(len, sets.words))
    for name in person:
        for i in range(1, min(len(name), longest + 1)):
            if name[-i:] in sets.words:
                counts[name[:-i], ""] += 1
            if name[:i] in sets.words and not is_no_place(name[i:]):
                counts["", name[i:]] += 1
    return [glued for glued, n in counts.most_common(_MOST_AFFIXES) if n >= _FEWEST]


def _without(person: _Person, start: str, end: str) -> _Person:
    """Return the names that have a beginning and an end, by what is between."""
    return {
        short.removeprefix(start).removesuffix(end): name
        for short, name in person.items()
        if short.startswith(start) and short.endswith(end) and len(short) > len(start + end)
    }


def _recognise(person: _Person, *, one_arm: bool = False) -> Groups:
    """Return the groups of one person: arms by the first set that fits, else the best; and torso.

    Args:
        person: Names of the person.
        one_arm: Whether names have no side; they are taken as those of the right arm.
    """
    best: Groups = {}
    sets = marker_sets()
    has_markers = not sets.markers.isdisjoint(person)
    for marker_set in sets.arms:
        if marker_set.bones and has_markers:
            continue
        groups = {
            f"{side}_{part}": group
            for side in (SIDES[1:] if one_arm else SIDES)
            for part in PARTS
            if (group := _first_group(marker_set.spellings(part, "" if one_arm else side), person))
        }
        if marker_set.bones and not any(point.endswith("shoulder") for point in groups):
            continue  # names such as "forearm" and "hand" may be markers on these segments
        # Elbows distinguish bones from markers best: a "shoulder" may be the collar bone.
        if _fit(groups) >= _fit(best):
            best = groups
        if len(best) == len(ARM_POINTS):
            break
    if len(best) < _FEWEST:
        best = {}
    return best | _torso(person)


def _torso(person: _Person) -> Groups:
    """Return the groups of the torso that a person has."""
    sets = marker_sets()
    groups: Groups = {}
    for point, choices in sets.torso.items():
        for choice in choices:
            company = [sets.only_with[word] for word in choice if word in sets.only_with]
            if person.keys() >= set(choice) and not any(map(person.keys().isdisjoint, company)):
                groups[point] = tuple(person[word] for word in choice)
                break
    return groups


def _fit(groups: Groups) -> int:
    return len(groups) + sum(point.endswith("elbow") for point in groups)


def _first_group(spellings: Iterator[tuple[str, ...]], person: _Person) -> tuple[str, ...] | None:
    """Return the names of the first spelling that is there."""
    for spelling in spellings:
        if all(word in person for word in spelling):
            return tuple(person[word] for word in spelling)
    return None


def _single_arm(groups: Groups) -> Groups | None:
    """Return the only whole arm with the other shoulder and the torso; None if there is none."""
    whole = _whole_arms(groups)
    if len(whole) != 1:
        return None
    other = SIDES[1 - SIDES.index(whole[0])]
    return {p: g for p, g in groups.items() if p not in (f"{other}_elbow", f"{other}_wrist")}


def _whole_arms(groups: Groups) -> list[str]:
    return [side for side in SIDES if all(f"{side}_{part}" in groups for part in PARTS)]


def _as_left(groups: Groups) -> Groups:
    return {f"left_{part}": groups[f"right_{part}"] for part in PARTS}
