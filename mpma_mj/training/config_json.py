"""Configs of agents as JSON, opened without importing code from outside the package."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any, get_args, get_origin, get_type_hints

import numpy as np

from mpma_mj.agents.config import CONFIG_TYPES, RULE_MEMBERS, AgentConfig
from mpma_mj.agents.extensions import load_class
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.errors import BadOptionError
from mpma_mj.motions.options import ReadingOptions

__all__ = ["OutsideConfig", "agent_from_json", "agent_to_json", "config_class", "exact", "plain"]

_OWN_RULES = "mpma_mj.agents.learning_rules"


@dataclass(frozen=True, kw_only=True)
class OutsideConfig(AgentConfig):
    """Config in a run folder that names a class from outside the package, which is not imported.

    Attributes:
        options: The agent's options by name, as in the file.
    """

    options: Mapping[str, Any] = field(hash=False)

    @property
    def outside(self) -> dict[str, str]:
        """Paths of the outside classes by the options that name them."""
        rule = self.options.get("rule")
        path = rule.get("class") if isinstance(rule, Mapping) else rule
        # Not by the start of the path: a folder may have the name of this package.
        if isinstance(rule, Mapping) and str(path).rpartition(":")[0] == _OWN_RULES:
            path = None
        named = {"agent": self.options["name"], "rule": path}
        return {
            option: path for option, path in named.items() if isinstance(path, str) and ":" in path
        }


def config_class(agent: str) -> type[AgentConfig]:
    """Return the class of an agent's config; only that of an outside agent is imported.

    Args:
        agent: Name of the agent, or the path of its class.

    Raises:
        BadOptionError: There is no such agent, or its config cannot be one of a run.
    """
    if isinstance(agent, str) and agent in CONFIG_TYPES:
        return CONFIG_TYPES[agent]
    from mpma_mj.agents.registry import agent_class

    kind = agent_class(agent).config_type
    taken = {f.name for part in (ReadingOptions, EnvironmentOptions) for f in fields(part)}
    clashing = sorted({f.name for f in fields(kind)} & (taken | {"motions", "agent", "seed"}))
    if clashing:
        expected = f"an agent without {clashing[0]} among its options, which every run has"
        raise BadOptionError(option="agent", value=agent, expected=expected)
    return kind


def agent_to_json(agent: AgentConfig, name: str) -> dict[str, Any]:
    """Return what JSON can hold of an agent's config, and of its name or the path of its class.

    Raises:
        BadOptionError: The learning rule is an object whose options cannot be written.
    """
    if isinstance(agent, OutsideConfig):
        return dict(agent.options)
    options = {f.name: plain(getattr(agent, f.name)) for f in fields(agent) if f.name != "rule"}
    rule = getattr(agent, "rule", None)
    return {"name": name} | options | ({} if rule is None else {"rule": _rule_to_json(rule)})


def agent_from_json(options: Any, trusted: Collection[str]) -> AgentConfig:
    """Return the config that `agent_to_json` returned.

    Args:
        options: What JSON held.
        trusted: Paths of outside classes that the user has named, which may be imported.

    Returns:
        The config; an `OutsideConfig` where it names other outside classes.

    Raises:
        BadOptionError: A trusted class cannot be imported, or an option is out of bounds.
        KeyError, TypeError: An option is missing or unknown.
    """
    name = options["name"]
    if not isinstance(name, str):
        raise TypeError("name of the agent")
    outside = OutsideConfig(options=dict(options))
    if not set(outside.outside.values()) <= set(trusted):
        return outside
    own = {option: value for option, value in options.items() if option != "name"}
    if isinstance(own.get("rule"), dict):
        own["rule"] = _rule_from_json(own["rule"])
    return exact(config_class(name), own)


def exact(kind: Any, options: Any) -> Any:
    """Return a dataclass from exactly its fields; lists become tuples where the types require it.

    Raises:
        TypeError: Other fields are given.
    """
    if not isinstance(options, dict) or options.keys() != {f.name for f in fields(kind)}:
        raise TypeError(f"{kind.__name__} with other fields")
    return kind(
        **{
            name: tuple(value) if name in _tuples(kind) and isinstance(value, list) else value
            for name, value in options.items()
        }
    )


def plain(value: Any) -> Any:
    """Return a value as JSON can hold it: paths as text, numbers of NumPy as plain ones."""
    if isinstance(value, Path):
        return str(value)
    if isinstance(value, Mapping):
        return dict(value)
    return value.item() if isinstance(value, np.generic) else value


@functools.cache
def _tuples(kind: type) -> set[str]:
    """Return the names of the fields of a dataclass that may be tuples."""
    return {name for name, hint in get_type_hints(kind).items() if _is_tuple(hint)}


def _is_tuple(hint: Any) -> bool:
    return get_origin(hint) is tuple or hint is tuple or any(map(_is_tuple, get_args(hint)))


def _rule_to_json(rule: Any) -> Any:
    if isinstance(rule, str):
        return rule
    kind = type(rule)
    names = {f.name for f in fields(rule)} if dataclasses.is_dataclass(rule) else set()
    # A subclass with an __init__ of its own is a dataclass by inheritance only.
    inherited = "__init__" in vars(kind) and "__dataclass_fields__" not in vars(kind)
    written = vars(rule).keys() <= names and not (names and inherited)
    if not written or not kind.__qualname__.isidentifier():
        expected = "a rule whose class is a dataclass of a module, so that it can be written"
        raise BadOptionError(option="rule", value=rule, expected=expected)
    options = {f.name: plain(getattr(rule, f.name)) for f in fields(rule)} if vars(rule) else {}
    return {"class": f"{kind.__module__}:{kind.__qualname__}", "options": options}


def _rule_from_json(content: dict[str, Any]) -> Any:
    from mpma_mj.agents.learning_rules import LearningRule

    # Only a class with the methods of a rule is called, whatever the file names.
    kind = load_class(content["class"], "rule", RULE_MEMBERS, base=LearningRule)
    return kind(**content["options"])
