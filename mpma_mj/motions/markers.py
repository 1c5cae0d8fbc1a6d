"""Which of a file's points show the arms and the torso: told by their names."""

from __future__ import annotations

import itertools
import re
import tomllib
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from mpma_mj.arm import SIDES
from mpma_mj.errors import BadOptionError, MotionFileError
from mpma_mj.motions.body import ARM_POINTS, TORSO_POINTS

__all__ = ["Groups", "choose_markers", "mapping_option", "parse_mapping"]

Groups = dict[str, tuple[str, ...]]
"""For each point of the body the markers or joints whose mean it is."""

# Words for shoulder, elbow and wrist, without the side. Of each column the first that is there
# is taken; sets are tried in turn, skeletons first: their "shoulder" is often the collar bone.
_Words = tuple[tuple[str, ...], ...]
_SETS: tuple[tuple[_Words, _Words, _Words], ...] = (
    # CMU's BVH, Mixamo, MotionBuilder, Rokoko
    ((("arm",),), (("forearm",),), (("hand",),)),
    # Biped, Unity, Unreal, Xsens, Bandai-Namco, OptiTrack's bones
    (
        (("upperarm",), ("uparm",), ("uarm",)),
        (("forearm",), ("lowerarm",), ("lowarm",), ("farm",), ("fore arm",)),
        (("hand",), ("wrist",)),
    ),
    # Poser, DAZ, indian_13
    ((("shldr",), ("shldrbend",)), (("forearm",), ("forearmbend",)), (("hand",),)),
    # Acclaim: a bone is where it begins, and the forearm ends with the bone "wrist"; CMU's BVH
    # has its neck where the thorax begins, so both give one torso
    ((("humerus",),), (("radius",),), (("wristend",),)),
    # Markers and joint centres: Plug-in Gait, HDM05, Qualisys, ISB, OptiTrack, Kinect, Captury
    (
        (
            *(("sho",), ("saj",), ("acr",), ("acromion",), ("acrom",), ("acj",), ("ac",)),
            *(("shouldertop",), ("shouldertip",), ("shoulder",), ("shoulderjc",), ("sjc",)),
        ),
        (
            *(("hle", "hme"), ("lhe", "mhe"), ("lepi", "mepi"), ("epil", "epim")),
            *(("elbl", "elbm"), ("lel", "mel"), ("elblat", "elbmed"), ("elbowlat", "elbowmed")),
            *(("latelbow", "medelbow"), ("elbowlateral", "elbowmedial"), ("epicl", "epicm")),
            *(("elbowout", "elbowin"), ("elb", "elbm"), ("elb", "elbi"), ("elb", "melb")),
            *(("elb",), ("elbow",), ("elbowout",), ("elbowjc",), ("ejc",)),
        ),
        (
            *(("wra", "wrb"), ("rsp", "usp"), ("rsp", "uhe"), ("stylr", "stylu")),
            *(("wristin", "wristout"), ("wristinner", "wristouter"), ("radius", "ulna")),
            *(("rad", "uln"), ("wrl", "wrm"), ("wrr", "wru"), ("wristlat", "wristmed")),
            *(("iwr", "owr"), ("rs", "us"), ("wri",), ("wrist",), ("wristjc",), ("wjc",)),
        ),
    ),
)
_TORSO: dict[str, _Words] = {
    "pelvis": (
        *(("lasi", "rasi", "lpsi", "rpsi"), ("lfwt", "rfwt", "lbwt", "rbwt")),
        *(("lias", "rias", "lips", "rips"), ("lasis", "rasis", "lpsis", "rpsis")),
        *(("hipfl", "hipfr", "hipbl", "hipbr"), ("asisl", "asisr", "psisl", "psisr")),
        ("waistlfront", "waistrfront", "waistlback", "waistrback"),
        *(("lasi", "rasi", "sacr"), ("hips",), ("pelvis",), ("midhip",), ("hip",), ("root",)),
        *(("lefthip", "righthip"), ("hipleft", "hipright"), ("lhip", "rhip"), ("hipl", "hipr")),
    ),
    "neck": (
        *(("c7", "clav"), ("cv7", "snj"), ("c7", "ij"), ("thorax",), ("neck",)),
        *(("neck01",), ("spineshoulder",)),
    ),
}
# Parts of names that say nothing about which point it is.
_PREFIX = re.compile(r"^mixamorig\d*")
_SUFFIX = re.compile(r"(positions?|pos|jointcent(er|re))$")
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


def parse_mapping(option: str) -> Groups:
    """Read what the user says about which markers show which point.

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
            raise BadOptionError(f"map: {point} stands twice; give all its markers with +")
        if point not in (*ARM_POINTS, *TORSO_POINTS):
            raise BadOptionError(
                f"map: no point '{point}'; expected {', '.join((*ARM_POINTS, *TORSO_POINTS))}"
            )
        groups[point] = names
    return groups


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
            f"{path}: shows {len(complete)} dancers; choose one with"
            f" {mapping_option(complete[0])}, or {mapping_option(complete[1])}"
        )
    if not complete:
        best = max(found, key=len)
        guessed = {p: _guess(p, names) for p in ARM_POINTS if p not in best}
        _check_once(path, names, {p: g for p, g in guessed.items() if len(set(g)) == 1})
        raise MotionFileError(_not_recognised(path, names, best))
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


def _read_toml(path: Path) -> Iterator[tuple[str, tuple[str, ...]]]:
    try:
        content = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise BadOptionError(f"map: {path} cannot be read ({error.strerror})") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise BadOptionError(f"map: {path} is no TOML file ({error})") from None
    for point, value in content.items():
        names = [name.strip() for name in value.split("+")] if isinstance(value, str) else value
        if not (isinstance(names, list) and names and all(isinstance(n, str) and n for n in names)):
            raise BadOptionError(f"map: {path}: {point} is '{value}'; expected a name or names")
        yield point, tuple(names)


def _read_inline(option: str) -> Iterator[tuple[str, tuple[str, ...]]]:
    for entry in filter(None, (part.strip() for part in option.split(","))):
        point, equals, names = entry.partition("=")
        group = tuple(name.strip() for name in names.split("+"))
        if not equals or not all(group):
            raise BadOptionError(
                f"map: '{entry}' is not POINT=NAME or POINT=NAME+NAME, such as left_elbow=LELB"
            )
        yield point.strip(), group


def _exact(path: Path, name: str, names: Sequence[str]) -> str:
    """Return the file's spelling of a name that the user gave."""
    if name in names:
        return name
    alike = [n for n in names if _short(n) == _short(name)]
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
    common = _common_prefix(names)
    for name in names:
        subject, _, rest = name.rpartition(":")
        short = _short(rest.removeprefix(common) if rest != common else rest)
        subjects.setdefault(subject, {}).setdefault(short, name)
    found = [_recognise(short) for short in subjects.values()]
    return sorted((groups for groups in found if groups), key=len, reverse=True)


def _recognise(short: Mapping[str, str]) -> Groups:
    """Return the groups of one subject: arms by the first set that fits, and torso."""
    best: Groups = {}
    for words in _SETS:
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
    for point, choices in _TORSO.items():
        for choice in choices:
            if all(word in short for word in choice):
                best[point] = tuple(short[word] for word in choice)
                break
    return best


def _first_group(choices: _Words, short: Mapping[str, str], side: str) -> tuple[str, ...] | None:
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


def _common_prefix(names: Sequence[str]) -> str:
    """Return the beginning that most names share, such as "Bip01 ", or ""."""
    starts = [re.match(r"[^\W_]+[\W_]+", name.rpartition(":")[2]) for name in names]
    prefix, count = Counter(start[0] if start else "" for start in starts).most_common(1)[0]
    is_side = re.fullmatch(r"(l|r|left|right)[\W_]+", prefix.lower())
    return prefix if 5 * count > 3 * len(names) and not is_side else ""


def _short(name: str) -> str:
    """Return a name without subject, case, separators and what says nothing."""
    letters = re.sub(r"[\W_]+", "", name.rpartition(":")[2].lower())
    return _SUFFIX.sub("", _PREFIX.sub("", letters))


def _not_recognised(path: Path, names: Sequence[str], found: Groups) -> str:
    """Say which points are missing, what the file has, and a mapping to edit."""
    guess = {point: found.get(point) or _guess(point, names) for point in ARM_POINTS}
    mapping = mapping_option({point: group or ("?",) for point, group in guess.items()})
    missing = [point.replace("_", " ") for point in ARM_POINTS if point not in found]
    has = f"it has {_listed(names)}"
    if not any(guess.values()):
        one = {point: [n for n in names if rule.search(n)] for point, rule in _GUESS.items()}
        if all(one.values()):
            return (
                f"{path}: shows one arm only, none that is named left or right"
                f" ({'; '.join('+'.join(group[:2]) for group in one.values())}): there is no left"
                " arm beside a right one, and both are needed"
            )
    for side in SIDES:
        if any(guess.values()) and not any(guess[p] for p in ARM_POINTS if p.startswith(side)):
            return (
                f"{path}: has no {side} arm, and both arms are needed; {has}; if that arm is among"
                f" them, say it with {mapping}"
            )
    return (
        f"{path}: cannot tell which point is the {', the '.join(missing)}; {has}; say it with"
        f" {mapping}"
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


def mapping_option(groups: Groups) -> str:
    """Return what to type so that the arms are these groups."""
    entries = (f"{point}={'+'.join(groups[point])}" for point in ARM_POINTS)
    return f'--map "{",".join(entries)}"'


def _listed(names: Sequence[str]) -> str:
    more = f" and {len(names) - _MOST_NAMED} more" if len(names) > _MOST_NAMED else ""
    return ", ".join(names[:_MOST_NAMED]) + more
