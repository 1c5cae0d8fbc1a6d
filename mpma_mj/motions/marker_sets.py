"""Points of the body among a file's markers, by marker set (`marker_sets.toml`) or mapping."""

from __future__ import annotations

import functools
import itertools
import re
import tomllib
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from mpma_mj.errors import BadOptionError, MotionFileError, placeholder
from mpma_mj.kinematics import SIDES
from mpma_mj.motions.body import ARM_POINTS, TORSO_POINTS
from mpma_mj.utils.input_files import SMALL_FILE, file_problem

__all__ = ["Groups", "choose_markers", "mapping_option", "parse_mapping"]

Groups = dict[str, tuple[str, ...]]
"""For each point of the body the markers or joints whose mean it is."""

# "left", or an l at the start before a separator or a capital, or at the end after one.
_SIDED = {
    "left": re.compile(r"[Ll]eft|LEFT|(?<![^\W_])[lL](?=[\W_A-Z])|[\W_]l$|(?<=[a-z\W_])L$"),
    "right": re.compile(r"[Rr]ight|RIGHT|(?<![^\W_])[rR](?=[\W_A-Z])|[\W_]r$|(?<=[a-z\W_])R$"),
}
_MOST_GUESSED = 2
_FEWEST = 3  # points that have to fit before names are taken for those of a set
_MOST_NAMED = 120  # names in a message
# Parts of names that do not identify a point.
_PREFIX = re.compile(r"^mixamorig\d*")
_SUFFIX = re.compile(r"(positions?|pos|jointcent(er|re))$")

_PARTS = ("shoulder", "elbow", "wrist")
_Choices = list[tuple[str, ...]]  # groups of names, of which the first complete one is taken


@dataclass(frozen=True)
class _MarkerSets:
    """Content of `marker_sets.toml`."""

    arms: list[dict[str, _Choices]]
    torso: dict[str, _Choices]
    only_with: dict[str, str]
    guesses: dict[str, re.Pattern[str]]


@functools.cache
def _marker_sets() -> _MarkerSets:
    content = tomllib.loads(Path(__file__).with_suffix(".toml").read_text("utf-8"))

    def choices(table: dict[str, list[str]]) -> dict[str, _Choices]:
        return {point: [tuple(c.split("+")) for c in groups] for point, groups in table.items()}

    return _MarkerSets(
        [choices(table) for table in content["set"]],
        choices(content["torso"]),
        content["only_with"],
        {part: re.compile(pattern, re.IGNORECASE) for part, pattern in content["guess"].items()},
    )


def parse_mapping(option: str) -> Groups:
    """Read the mapping from points to markers that the user gave.

    Args:
        option: "left_elbow=EPICl+EPICm,…", where + is the mean, or the path of a TOML file
            with lines such as left_elbow = "EPICl+EPICm" or ["EPICl", "EPICm"].

    Raises:
        BadOptionError: It is neither, or names no point of the body.
    """
    given = _read_toml(Path(option)) if option.endswith(".toml") else _read_inline(option)
    groups: Groups = {}
    for point, names in given:
        if point in groups:
            problem = f"has {point} twice; join all its markers with +"
            raise BadOptionError(problem, option="map")
        if point not in (*ARM_POINTS, *TORSO_POINTS):
            known = ", ".join((*ARM_POINTS, *TORSO_POINTS))
            problem = f"has unknown point '{point}'; expected {known}"
            raise BadOptionError(problem, option="map")
        groups[point] = names
    return groups


def mapping_option(groups: Groups) -> str:
    """Return the option with which the arms are these groups, for a remedy."""
    entries = (f"{point}={'+'.join(groups[point])}" for point in ARM_POINTS)
    return placeholder("map", f'"{",".join(entries)}"')


def choose_markers(path: Path, names: Sequence[str], mapping: Groups) -> Groups:
    """Find which of a file's points show the arms and, if it has some, the torso.

    Args:
        path: The file, for messages.
        names: The names that it has.
        mapping: Markers that the user gave; other points are recognised by name.

    Returns:
        A group for every one of `ARM_POINTS`, and for `TORSO_POINTS` where the pelvis is shown.

    Raises:
        MotionFileError: A point is not recognised, or two people are, or a name that is needed
            appears twice; the message lists the file's names and a mapping to edit.
    """
    given = {p: tuple(_exact(path, n, names) for n in group) for p, group in mapping.items()}
    recognised = _recognised(names)
    # The torso must be that of the person whose arms the user chose.
    meant = [groups for groups in recognised if _subjects(groups) & _subjects(given)]
    found = [groups | given for groups in meant or recognised] or [given]
    complete = [groups for groups in found if groups.keys() >= set(ARM_POINTS)]
    if len({tuple(groups[p] for p in ARM_POINTS) for groups in complete}) > 1:
        raise MotionFileError(
            f"{path}: shows {len(complete)} people",
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
    """Refuse names that appear twice in the file."""
    counts = Counter(names)
    twice = next((n for group in groups.values() for n in group if counts[n] > 1), None)
    if twice is not None:
        raise MotionFileError(f"{path}: {twice} appears twice; rename or remove one")


def _exact(path: Path, name: str, names: Sequence[str]) -> str:
    """Return the file's spelling of a name that the user gave."""
    if name in names:
        return name
    alike = [n for n in names if _short_name(n) == _short_name(name)]
    if len(set(alike)) != 1:
        raise MotionFileError(
            f"{path}: map names {name}, which the file"
            f" {'does not have' if not alike else 'has twice'}; it has {_listed(names)}"
        )
    return alike[0]


def _subjects(groups: Groups) -> set[str]:
    return {name.rpartition(":")[0] for group in groups.values() for name in group}


def _recognised(names: Sequence[str]) -> list[Groups]:
    """Return what is recognised of each subject of the file, the most first."""
    subjects: dict[str, dict[str, str]] = {}
    common = _common_prefix(names)
    for name in names:
        subject, _, rest = name.rpartition(":")
        short = _short_name(rest.removeprefix(common) if rest != common else rest)
        subjects.setdefault(subject, {}).setdefault(short, name)
    found = [_recognise(short) for short in subjects.values()]
    return sorted((groups for groups in found if groups), key=len, reverse=True)


def _recognise(short: Mapping[str, str]) -> Groups:
    """Return the groups of one subject: arms by the first set that fits, and torso."""
    best: Groups = {}
    sets = _marker_sets()
    for words in sets.arms:
        groups = {
            f"{side}_{part}": group
            for side in SIDES
            for part in _PARTS
            if (group := _first_group(words[part], short, side))
        }
        if len(groups) > len(best):
            best = groups
        if len(best) == len(ARM_POINTS):
            break
    if len(best) < _FEWEST:
        return {}
    for point, choices in sets.torso.items():
        for choice in choices:
            needed = {*choice, *(sets.only_with[w] for w in choice if w in sets.only_with)}
            if needed <= short.keys():
                best[point] = tuple(short[word] for word in choice)
                break
    return best


def _first_group(choices: _Choices, short: Mapping[str, str], side: str) -> tuple[str, ...] | None:
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
        guesses = _marker_sets().guesses
        one = {part: [n for n in names if rule.search(n)] for part, rule in guesses.items()}
        if all(one.values()):
            return MotionFileError(
                f"{path}: shows a single arm, named neither left nor right"
                f" ({'; '.join('+'.join(group[:2]) for group in one.values())}); both arms are"
                " needed"
            )
    for side in SIDES:
        if any(guess.values()) and not any(guess[p] for p in ARM_POINTS if p.startswith(side)):
            return MotionFileError(
                f"{path}: has no {side} arm, and both arms are needed; {has}",
                remedy=f"if that arm is among them, name its points with {mapping}",
            )
    return MotionFileError(
        f"{path}: no point is recognised as the {', the '.join(missing)}; {has}",
        remedy=f"name the points with {mapping}",
    )


def _guess(point: str, names: Sequence[str]) -> tuple[str, ...]:
    """Return names that look like a point: with the right word, a side, and a twin opposite."""
    side, _, part = point.partition("_")
    mine, other = _SIDED[side], _SIDED[SIDES[1 - SIDES.index(side)]]
    rule = _marker_sets().guesses[part]
    twins = {other.sub("*", name) for name in names if other.search(name)}
    fitting = (
        name
        for name in names
        if rule.search(name) and mine.search(name) and mine.sub("*", name) in twins
    )
    return tuple(itertools.islice(fitting, _MOST_GUESSED))


def _listed(names: Sequence[str]) -> str:
    more = f" and {len(names) - _MOST_NAMED} more" if len(names) > _MOST_NAMED else ""
    return ", ".join(names[:_MOST_NAMED]) + more


def _common_prefix(names: Sequence[str]) -> str:
    """Return the beginning that most names share, such as "Bip01 ", or ""."""
    starts = [re.match(r"[^\W_]+[\W_]+", name.rpartition(":")[2]) for name in names]
    prefix, count = Counter(start[0] if start else "" for start in starts).most_common(1)[0]
    is_side = re.fullmatch(r"(l|r|left|right)[\W_]+", prefix.lower())
    return prefix if 5 * count > 3 * len(names) and not is_side else ""


def _short_name(name: str) -> str:
    """Return a name without subject, case, separators and insignificant parts."""
    letters = re.sub(r"[\W_]+", "", name.rpartition(":")[2].lower())
    return _SUFFIX.sub("", _PREFIX.sub("", letters))


def _read_toml(path: Path) -> Iterator[tuple[str, tuple[str, ...]]]:
    if problem := file_problem(path, largest=SMALL_FILE):
        raise BadOptionError(f"names {path}: {problem}", option="map")
    try:
        content = tomllib.loads(path.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        problem = f"names {path}, which is not a TOML file ({error})"
        raise BadOptionError(problem, option="map") from None
    for point, value in content.items():
        names = [name.strip() for name in value.split("+")] if isinstance(value, str) else value
        if not (isinstance(names, list) and names and all(isinstance(n, str) and n for n in names)):
            problem = f"names {path}, where {point} is '{value}'; expected a name or names"
            raise BadOptionError(problem, option="map")
        yield point, tuple(names)


def _read_inline(option: str) -> Iterator[tuple[str, tuple[str, ...]]]:
    for entry in filter(None, (part.strip() for part in option.split(","))):
        point, equals, names = entry.partition("=")
        group = tuple(name.strip() for name in names.split("+"))
        if not equals or not all(group):
            problem = f"has '{entry}', not POINT=NAME or POINT=NAME+NAME, such as left_elbow=LELB"
            raise BadOptionError(problem, option="map")
        yield point.strip(), group
