"""Study of a user's own grid of options, which `mpma sweep` trains."""

from __future__ import annotations

import itertools
import types
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, Literal, Union, get_args, get_origin

from mpma_mj.errors import BadOptionError
from mpma_mj.experiments.records import Record, matching
from mpma_mj.experiments.training import COLUMNS, Point, TrainingStudy
from mpma_mj.training.config import RunConfig, option_types
from mpma_mj.utils.text import did_you_mean, markdown_table, option_name

__all__ = ["Sweep", "points"]

_MEASURES = ("epochs", "p_e_percent", "feedback_ratio", "learned_share", "nmi", "modules_used")
_COLUMNS = [COLUMNS[name] for name in _MEASURES]


@dataclass(frozen=True, kw_only=True)
class Sweep(TrainingStudy):
    """Runs at all points of a grid; see `TrainingStudy`.

    Attributes:
        grid: Options that vary, each "name=value,value,…".
        base: All other options, with the first seed.
    """

    name: ClassVar[str] = "sweep"
    grid: tuple[str, ...] = ()
    base: RunConfig = field(default_factory=RunConfig)

    def points(self) -> list[Point]:
        """Return all points of the grid, with the options that vary as labels."""
        configs = points(self.grid, self.base)
        options = [config.options() for config in configs]
        names = dict.fromkeys(name for own in options for name in own)
        # An option that only some agents have varies together with the agent's name.
        varying = [
            name for name in names if len({str(own[name]) for own in options if name in own}) > 1
        ]
        return [
            Point({name: config.option(name) for name in varying}, config) for config in configs
        ]

    def table(self, records: Sequence[Record]) -> str:
        """Return how many runs converged, and means ± standard deviations over seeds."""
        points = self.points()
        titles = [*map(option_name, points[0].labels), "converged", *(c.title for c in _COLUMNS)]
        rows = [
            [*map(_shown, labels.values()), *self.cells(matching(records, labels), _COLUMNS)]
            for labels, _ in points
        ]
        return markdown_table(titles, rows)


def _shown(value: Any) -> str:
    return "–" if value is None else str(value)


_TRUTH = {"true": True, "yes": True, "false": False, "no": False}


def points(words: Sequence[str], base: RunConfig) -> list[RunConfig]:
    """Return the settings of all points of a grid, the last axis running fastest.

    Args:
        words: Axes, each `name=value,value,…`; a name is an option of a run, or what the
            command line calls it. None are a grid of one point.
        base: All other settings.

    Raises:
        BadOptionError: A name is unknown or given twice, or a value is not what it may be.
    """
    agent = next((word.partition("=")[2] for word in words if word.startswith("agent=")), "")
    hints: dict[str, Any] = {}
    for name in agent.split(",") if agent else [base.agent_name]:
        try:
            hints |= option_types(name)
        except BadOptionError as error:
            problem = f"has agent '{name}'; expected {error.expected}"
            raise BadOptionError(problem, option="grid", remedy=error.remedy) from None
    axes: dict[str, list[Any]] = {}
    for word in words:
        name, values = _axis(word, hints)
        if name in axes:
            typed = word.partition("=")[0]
            problem = f"has {typed} twice; give all its values at once"
            raise BadOptionError(problem, option="grid")
        axes[name] = values
    chosen = (
        base.replace(**dict(zip(axes, values, strict=True)))
        for values in itertools.product(*axes.values())
    )
    return list(dict.fromkeys(chosen))  # agents without a size are one point for all sizes


def _axis(word: str, hints: dict[str, Any]) -> tuple[str, list[Any]]:
    """Return the field and the values of an axis."""
    typed, equals, texts = word.partition("=")
    if not equals:
        raise BadOptionError(
            f"has '{word}'",
            option="grid",
            remedy="expected name=value,value,…; put motions before {grid}",
        )
    fields = {option_name(name): name for name in hints} | {name: name for name in hints}
    if typed not in fields:
        hint = did_you_mean(typed, fields) or f"expected one of {', '.join(sorted(hints))}"
        raise BadOptionError(f"has unknown '{typed}'; {hint}", option="grid")
    name = fields[typed]
    if name == "seed":
        raise BadOptionError(
            "has seed",
            option="grid",
            remedy="give the first with {seed}, their number with {runs}",
        )
    choices = _choices(hints[name])
    if not all(map(_has_text, choices)) or choices == (types.NoneType,):
        raise BadOptionError(
            f"has {typed}, which takes several values at once",
            option="grid",
            remedy=f"give it with {{{name}}}",
        )
    values = [_value(typed, text, hints[name]) for text in texts.split(",")]
    if len(set(values)) < len(values):
        problem = f"has a value of {typed} twice: '{texts}'; leave one out"
        raise BadOptionError(problem, option="grid")
    return name, values


def _value(name: str, text: str, hint: Any) -> Any:
    """Return what a text means to a field of a type."""
    if not text:
        problem = f"has an empty value of {name}; expected {_expected(hint)}"
        raise BadOptionError(problem, option="grid")
    for choice in _choices(hint):
        try:
            return _parsed(text, choice)
        except (ValueError, KeyError):
            continue
    raise BadOptionError(f"has {name} '{text}'; expected {_expected(hint)}", option="grid")


def _parsed(text: str, hint: Any) -> Any:
    """Return the value of one plain type that a text stands for.

    Raises:
        ValueError, KeyError: It stands for none.
    """
    if get_origin(hint) is Literal:
        return {str(allowed): allowed for allowed in get_args(hint)}[text]
    if hint is bool:
        return _TRUTH[text.lower()]
    if hint is types.NoneType:
        return {"none": None}[text.lower()]
    if hint not in (int, float, str):
        raise ValueError
    return hint(text)


def _choices(hint: Any) -> tuple[Any, ...]:
    """Return the types of a union but for tuples, which are no texts between commas.

    None is the first, so that "none" is not taken for a text.
    """
    if get_origin(hint) not in (Union, types.UnionType):
        return (hint,)
    single = (choice for choice in get_args(hint) if get_origin(choice) is not tuple)
    return tuple(sorted(single, key=lambda choice: choice is not types.NoneType))


def _has_text(choice: Any) -> bool:
    """Return whether values of a type can be texts between commas."""
    return get_origin(choice) is Literal or choice in (bool, int, float, str, types.NoneType)


def _expected(hint: Any) -> str:
    """Return in words what a type lets through."""
    if get_origin(hint) is Literal:
        return "one of " + ", ".join(str(allowed) for allowed in get_args(hint))
    plain = {int: "a whole number", float: "a number", bool: "true or false", str: "text"}
    if hint in plain:
        return plain[hint]
    if hint is types.NoneType:
        return "none"
    return " or ".join(_expected(choice) for choice in reversed(_choices(hint)))
