"""Places of robot models: beside the robot file, in an installed package, or in a registry."""

from __future__ import annotations

import contextlib
import importlib
import importlib.util
import io
from collections.abc import Mapping, Sequence
from importlib import metadata
from pathlib import Path
from typing import Any

from mpma_mj.errors import BadOptionError, one_line

__all__ = ["REGISTRIES", "find_model"]

REGISTRIES = ("menagerie", "package", "description")
"""Keys of a robot file that name what holds the model; with none of them it is beside the file."""

_MODULES = {"menagerie": "mujoco_menagerie", "description": "robot_descriptions"}
_INSTALL = {
    "menagerie": "pip install 'mpma-mj[robots]'",
    "description": "pip install robot_descriptions",
}


class _AbsentError(Exception):
    """A model is not where it was looked for; the message says why."""


def find_model(robot_file: Path, sources: Sequence[Mapping[str, Any]]) -> tuple[int, Path]:
    """Find the first model that is on this machine, or else the first that can be fetched.

    Args:
        robot_file: File that describes the robot.
        sources: Places to look at, in this order: `file` beside the robot file; `file` of an
            installed `package`, which is not imported; `file` of a robot of `menagerie`; or a
            `description` of robot_descriptions.

    Returns:
        Index of the source, and path of the model.

    Raises:
        BadOptionError: No model is found; says what to install, or what cannot be reached.
    """
    problems: dict[str, None] = {}  # in order, each once
    for fetch in (False, True):
        for index, source in enumerate(sources):
            try:
                return index, _find(robot_file, source, fetch=fetch)
            except _AbsentError as problem:
                if fetch:
                    problems[str(problem)] = None
    raise BadOptionError(f"{robot_file}: finds no model: {', or '.join(problems)}")


def _find(robot_file: Path, source: Mapping[str, Any], *, fetch: bool) -> Path:
    if "menagerie" in source:
        return _in_menagerie(source["menagerie"], source["file"], fetch=fetch)
    if "description" in source:
        return _in_descriptions(source["description"], fetch=fetch)
    if "package" in source:
        return _in_package(source["package"], source["file"])
    return robot_file.parent / source["file"]


def _in_package(name: str, file: str) -> Path:
    """Return the path of a file that a package has installed, anywhere."""
    with contextlib.suppress(metadata.PackageNotFoundError, ValueError):
        for installed in metadata.files(name) or ():
            if f"/{installed.as_posix()}".endswith(f"/{file}"):
                return Path(str(installed.locate())).resolve()
    folder, _, rest = file.partition("/")
    # An editable install lists no files. With a dot in its name the packages around are imported.
    with contextlib.suppress(ImportError, ValueError):
        found = importlib.util.find_spec(folder) if folder.isidentifier() else None
        for place in (found and found.submodule_search_locations) or ():
            if (path := Path(place) / rest).is_file():
                return path
    raise _AbsentError(f"pip install --no-deps {name}")


def _in_menagerie(name: str, file: str, *, fetch: bool) -> Path:
    """Return the path of a model of MuJoCo Menagerie, which its package downloads once."""
    menagerie = _registry("menagerie")
    try:
        robot = menagerie.get(name)
        if not (fetch or menagerie.Cache().is_cached(robot)):
            raise _AbsentError
        return Path(robot.path(progress=None)) / file
    except (menagerie.MenagerieError, OSError) as error:
        raise _AbsentError(_unreachable("mujoco_menagerie", name, error)) from None


def _in_descriptions(name: str, *, fetch: bool) -> Path:
    """Return the path of a model of robot_descriptions, which importing its module clones."""
    _registry("description")
    if not fetch:
        raise _AbsentError
    if not name.isidentifier():
        raise _AbsentError(f"robot_descriptions has no {name}")
    try:
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            module = importlib.import_module(f"robot_descriptions.{name}")
    except Exception as error:  # git's errors, whose package may be absent
        raise _AbsentError(_unreachable("robot_descriptions", name, error)) from None
    return Path(getattr(module, "MJCF_PATH", None) or module.URDF_PATH)


def _registry(kind: str) -> Any:
    try:
        return importlib.import_module(_MODULES[kind])
    except ImportError:
        raise _AbsentError(_INSTALL[kind]) from None


def _unreachable(registry: str, name: str, error: Exception) -> str:
    return f"{registry} cannot fetch {name} ({one_line(error)}); check the network, or its name"
