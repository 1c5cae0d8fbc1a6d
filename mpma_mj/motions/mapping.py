"""Mapping from points of the body to a file's markers, as users give it."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from pathlib import Path

from mpma_mj.errors import BadOptionError, one_line, placeholder
from mpma_mj.motions.body import ARM_POINTS, TORSO_POINTS
from mpma_mj.utils.input_files import SMALL_FILE, file_problem

__all__ = ["TRUNK_OPTION", "Groups", "mapping_option", "parse_mapping"]

Groups = dict[str, tuple[str, ...]]
"""For each point of the body the markers or joints whose mean it is."""
TRUNK_OPTION = placeholder("map", '"pelvis=?,neck=?"')
"""Option that names the trunk, to complete, for a remedy."""


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
    """Return the option with which the arms' points are these groups, for a remedy."""
    entries = (f"{p}={'+'.join(groups[p])}" for p in ARM_POINTS if p in groups)
    return placeholder("map", f'"{",".join(entries)}"')


def _read_toml(path: Path) -> Iterator[tuple[str, tuple[str, ...]]]:
    if problem := file_problem(path, largest=SMALL_FILE):
        raise BadOptionError(f"names {path}: {problem}", option="map")
    try:
        content = tomllib.loads(path.read_text(encoding="utf-8"))
    except UnicodeDecodeError:
        problem = f"names {path}, which is not a TOML file: it is not text in UTF-8"
        raise BadOptionError(problem, option="map") from None
    except tomllib.TOMLDecodeError as error:
        problem = f"names {path}, which is not a TOML file ({one_line(error)})"
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
