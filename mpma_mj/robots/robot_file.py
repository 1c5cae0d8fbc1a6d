"""Robot files: TOML that names a robot's model, its joints and their physical values.

    name = "my_robot"                    # letters, digits, _ and -
    title = "My Robot, second edition"
    licence = "Apache-2.0, My Company"

    [model]                              # or [[model]] several times: the first found is taken
    file = "my_robot.xml"                # MJCF or URDF, relative to this file
    left = ["…", "…", "…", "…"]          # joints, from the shoulder outward
    right = ["…", "…", "…", "…"]
    wrist = ["…", "…"]                   # joints at the forearms' ends; or: forearm = "tip"
    up = [0, 0, 1]                       # of the torso, in the model's frame
    [model.rest]                         # angles, rad, of joints that do not move, if not 0
    waist = 0.1

    [speed]                              # likewise force, armature, damping and kv
    values = [9.0, 9.0, 20.0, 20.0]      # rad/s, from the shoulder outward
    source = "data sheet of the maker"   # or "unknown", without values

A model of a package has `package`, or of a registry `menagerie`, besides `file`, or `description`
in its place. A model with the joints, sites and actuators of `two_arm.xml` has `file` alone.
"""

from __future__ import annotations

import json
import math
import os
import re
import tomllib
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

from mpma_mj.errors import BadOptionError, one_line, printable
from mpma_mj.robots.model_sources import REGISTRIES, find_model
from mpma_mj.robots.robot import FASTEST, QUANTITIES, UNKNOWN, JointValues, Robot
from mpma_mj.utils.atomic_files import write_text
from mpma_mj.utils.input_files import SMALL_FILE, file_problem
from mpma_mj.utils.text import did_you_mean, shell_word
from mpma_mj.utils.validation import is_number

__all__ = ["CATALOGUE", "NAME", "TIP", "catalogue", "read_robot", "robot_name", "write_robot"]

CATALOGUE = Path(__file__).with_name("catalogue")
"""Folder of the robots that are known by name."""

TIP = "tip"
"""Value of `forearm`: it ends with the vertices that are farthest from the elbow."""

NAME = re.compile(r"[A-Za-z0-9][\w-]*", re.ASCII)
"""What names of robots consist of."""

_NO_NAMES = ("robot", "model", "scene", "main")  # of files that tell nothing
_MODELS = (".xml", ".mjcf")
_TEXTS = ("name", "title", "licence")
_GEOMETRY = ("left", "right", "wrist", "forearm", "up", "rest", "range")
_MAY_BE_ZERO = ("armature", "damping")


def catalogue() -> list[str]:
    """Return the names of all known robots, sorted."""
    return sorted(path.stem for path in CATALOGUE.glob("*.toml"))


def read_robot(robot: str | Path) -> Robot:
    """Read a robot of the catalogue, a robot file, or a model that is one already.

    Args:
        robot: Name in the catalogue; path of a robot file, `.toml`; or of an MJCF file with the
            joints, sites and actuators of `two_arm.xml`.

    Raises:
        BadOptionError: There is no such robot; its file has a fault, and is named with the key; or
            its model is not installed.
    """
    if not str(robot).strip():
        raise BadOptionError(option="robot", value=robot, expected=f"one of {_expected()}")
    if str(robot) in catalogue():
        return _read(CATALOGUE / f"{robot}.toml")
    path = Path(robot)
    kind = path.suffix.lower()
    if kind == ".toml":
        return _read(path)
    if kind == ".urdf":
        raise BadOptionError(
            f"{path}: a URDF file alone is no robot",
            remedy=f"mpma robot {shell_word(path)} writes its robot file",
        )
    if kind in _MODELS or len(path.parts) > 1 or path.exists():
        name = re.sub(r"[^\w-]+", "_", path.stem, flags=re.ASCII) or "robot"
        return Robot(name, path.name, UNKNOWN, path, path, complete=True)
    raise BadOptionError(
        option="robot",
        value=robot,
        expected=f"one of {_expected()}",
        remedy=did_you_mean(str(robot).lower(), catalogue()),
    )


def robot_name(path: Path) -> str:
    """Return a name for the robot of a model: that of its file, or of its folder."""
    words = (
        re.sub(r"[^\w-]+", "_", part, flags=re.ASCII).strip("_-")
        for part in (path.stem, path.absolute().parent.name)
    )
    return next((word for word in words if word and word not in _NO_NAMES), "robot")


def _expected() -> str:
    return f"{', '.join(catalogue())}, or the path of a robot file (.toml)"


def write_robot(path: Path, robot: Robot, comments: Mapping[str, str] | None = None) -> None:
    """Write a robot file, whose model is named relative to it.

    Args:
        path: The file, `.toml`.
        robot: The robot.
        comments: Comments on physical values by their quantity.

    Raises:
        RunFolderError: The file cannot be written.
    """
    lines = [f"{key} = {_toml(getattr(robot, key))}" for key in _TEXTS]
    try:
        file = os.path.relpath(robot.model, path.parent)
    except ValueError:  # another drive of Windows
        file = str(robot.model)
    lines += ["", "[model]", f"file = {_toml(Path(file).as_posix())}"]
    if not robot.complete:
        lines += [
            f"left = {_toml(robot.joints[:4])}  # from the shoulder outward",
            f"right = {_toml(robot.joints[4:])}",
            f'forearm = "{TIP}"' if robot.wrists is None else f"wrist = {_toml(robot.wrists)}",
            f"up = {_toml(robot.up)}  # of the torso, in the model's frame",
            *["[model.rest]  # rad"] * bool(robot.rest),
            *(f"{_toml(joint)} = {_toml(angle)}" for joint, angle in robot.rest.items()),
            *["[model.range]  # rad"] * bool(robot.ranges),
            *(f"{_toml(joint)} = {_toml(limits)}" for joint, limits in robot.ranges.items()),
        ]
        for quantity, unit in QUANTITIES.items():
            known = robot.physical.get(quantity, JointValues())
            lines += ["", f"[{quantity}]  # {unit}"]
            if comments and quantity in comments:
                lines += [f"# {printable(comments[quantity])}"]
            if known.values is not None:
                lines += [f"values = {_toml(known.values)}"]
            lines += [f"source = {_toml(known.source)}"]
    write_text(path, "\n".join(lines) + "\n")


def _toml(value: Any) -> str:
    """Return a string, number, or a sequence of them, as TOML."""
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, float):
        return repr(value)
    return f"[{', '.join(map(_toml, value))}]"


def _read(path: Path) -> Robot:
    """Read a robot file; errors as of `read_robot`."""
    if problem := file_problem(path, largest=SMALL_FILE):
        raise BadOptionError(f"{path}: {problem}")
    try:
        content = tomllib.loads(path.read_text("utf-8"))
    except (ValueError, RecursionError) as error:  # ValueError: neither TOML nor UTF-8
        problem = f"{path}: is no TOML file: {one_line(error)}"
        raise BadOptionError(f"{problem}; correct it{_hint(error)}") from None
    table = _Table(path, content)
    listed = content.get("model")
    models: list[Any] = listed if isinstance(listed, list) else [listed]
    if not models or not all(isinstance(model, dict) for model in models):
        raise table.refuse("model", "expected a table [model], with file = the path of its model")
    complete = not any(set(_GEOMETRY) & model.keys() for model in models)
    table.check_keys((*_TEXTS, "model", *(() if complete else QUANTITIES)))
    name, title, licence = (table.text(key) for key in _TEXTS)
    if not NAME.fullmatch(name):
        raise table.refuse("name", "expected letters, digits, _ and -")
    geometries = [_geometry(_Table(path, model, "model."), complete=complete) for model in models]
    physical = {quantity: _joint_values(table, quantity) for quantity in QUANTITIES}
    index, model_path = find_model(path, models)
    if complete:
        return Robot(name, title, licence, path, model_path, complete=True)
    return Robot(name, title, licence, path, model_path, physical=physical, **geometries[index])


def _hint(error: Exception) -> str:
    """Return what is often wrong where a value of TOML is none."""
    return ", such as 0.05 for .05" if "Invalid value" in str(error) else ""


def _geometry(model: _Table, *, complete: bool) -> dict[str, Any]:
    """Return what a table of a model says of the arms; raises a BadOptionError."""
    model.check_keys((*REGISTRIES, "file", *_GEOMETRY))
    given = model.content.keys()
    places = [key for key in REGISTRIES if key in given]
    if len(places) > 1:
        raise model.refuse(places[1], f"leave it out, or {places[0]}")
    for key in (*places, *(() if "description" in places else ("file",))):
        model.text(key)
    if complete:
        return {}
    if ("wrist" in given) == ("forearm" in given) or model.content.get("forearm", TIP) != TIP:
        raise model.refuse(
            "forearm",
            f'expected forearm = "{TIP}", where it ends with what is farthest from the elbow, or'
            " wrist = [the joint at the end of the left forearm, that of the right]",
        )
    up = model.numbers("up", 3)
    if not math.hypot(*up) > 0.0:
        raise model.refuse("up", "expected a direction, such as [0, 0, 1]")
    return {
        "joints": model.names("left", 4) + model.names("right", 4),
        "wrists": model.names("wrist", 2) if "wrist" in given else None,
        "up": up,
        "rest": model.angles("rest"),
        "ranges": _ranges(model),
    }


def _ranges(model: _Table) -> dict[str, tuple[float, ...]]:
    """Return the ranges that replace those of the model; raises a BadOptionError."""
    content = model.content.get("range", {})
    if not isinstance(content, dict):
        raise model.refuse("range", "expected a table of joints with their ranges, rad")
    inner = _Table(model.path, content, "model.range.")
    ranges = {name: inner.numbers(name, 2) for name in content}
    for name, (low, high) in ranges.items():
        if not low < high:
            raise inner.refuse(name, "expected the lowest angle, then the highest, rad")
    return ranges


def _joint_values(table: _Table, quantity: str) -> JointValues:
    """Return a physical value; raises a BadOptionError."""
    content = table.content.get(quantity, {"source": UNKNOWN})
    if not isinstance(content, dict):
        raise table.refuse(quantity, "expected a table with values and source")
    inner = _Table(table.path, content, f"{quantity}.")
    inner.check_keys(("values", "source"))
    source = inner.text("source")
    if source == UNKNOWN:
        if "values" in content:
            raise inner.refuse(
                "source", "name the document that gives the values, or leave them out"
            )
        return JointValues()
    values = inner.numbers("values", 4)
    lowest_is_right = min(values) >= 0.0 if quantity in _MAY_BE_ZERO else min(values) > 0.0
    if not lowest_is_right:
        most = "0 or more" if quantity in _MAY_BE_ZERO else "above 0"
        raise inner.refuse("values", f"expected four numbers, {most}, {QUANTITIES[quantity]}")
    if quantity == "speed" and max(values) > FASTEST:
        raise inner.refuse("values", f"expected at most {FASTEST:g} rad/s; are they degrees?")
    return JointValues(values, source)


class _Table:
    """A table of a robot file, whose values are checked when they are taken."""

    def __init__(self, path: Path, content: Mapping[str, Any], prefix: str = "") -> None:
        """Take the file, the content and what stands before its keys in messages."""
        self.path, self.content, self._prefix = path, content, prefix

    def refuse(self, key: str, mend: str) -> BadOptionError:
        """Return the error for a key, with its value and how to mend it."""
        value = repr(self.content[key])[:100] if key in self.content else "missing"
        return BadOptionError(f"{self.path}: {self._prefix}{key} is {value}; {mend}")

    def check_keys(self, known: Collection[str]) -> None:
        """Check that all keys are known."""
        for key in self.content:
            if key not in known:
                meant = did_you_mean(key, known) or f"expected one of {', '.join(known)}"
                raise BadOptionError(
                    f"{self.path}: has an unknown key {self._prefix}{key}; {meant}"
                )

    def text(self, key: str) -> str:
        """Return a text that is not empty."""
        value = self.content.get(key)
        if not isinstance(value, str) or not value.strip():
            raise self.refuse(key, "expected a text in quotation marks")
        return value

    def names(self, key: str, number: int) -> tuple[str, ...]:
        """Return names of joints, all different."""
        value = self.content.get(key)
        if (
            not isinstance(value, list)
            or len(value) != number
            or not all(isinstance(name, str) and name for name in value)
            or len(set(value)) != number
        ):
            what = "four joints, from the shoulder outward: three of the shoulder, then the elbow"
            raise self.refuse(
                key, f"expected {what if number == 4 else 'two joints, that of the left arm first'}"
            )
        return tuple(value)

    def numbers(self, key: str, number: int) -> tuple[float, ...]:
        """Return finite numbers."""
        value = self.content.get(key)
        if not isinstance(value, list) or len(value) != number or not all(map(_is_finite, value)):
            raise self.refuse(key, f"expected a list of {number} finite numbers")
        return tuple(map(float, value))

    def angles(self, key: str) -> dict[str, float]:
        """Return a table of finite numbers; an empty one where there is none."""
        value = self.content.get(key, {})
        if not isinstance(value, dict) or not all(map(_is_finite, value.values())):
            raise self.refuse(key, "expected a table of joints with their angles, rad")
        return {name: float(angle) for name, angle in value.items()}


def _is_finite(value: object) -> bool:
    try:
        return is_number(value) and math.isfinite(float(value))
    except OverflowError:
        return False
