"""All agents by name."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection

from mpma_mj.agents.adaptive import Adaptive
from mpma_mj.agents.base import Agent
from mpma_mj.agents.baselines import FeedbackOnly, OpenLoop, RandomAgent, ResolvedRate
from mpma_mj.agents.cloning import BC, DAgger
from mpma_mj.agents.config import AgentConfig
from mpma_mj.agents.extensions import load_class
from mpma_mj.agents.hammer import HAMMER
from mpma_mj.agents.mosaic import MOSAIC
from mpma_mj.agents.movement_primitives import DMP, ProMP
from mpma_mj.agents.mpma import MPMA, Oracle, Single
from mpma_mj.errors import BadOptionError
from mpma_mj.utils.text import did_you_mean

__all__ = ["AGENTS", "agent_class", "check_trainable"]

AGENTS: dict[str, type[Agent]] = {
    "mpma": MPMA,
    "mosaic": MOSAIC,
    "hammer": HAMMER,
    "single": Single,
    "adaptive": Adaptive,
    "oracle": Oracle,
    "bc": BC,
    "dagger": DAgger,
    "promp": ProMP,
    "dmp": DMP,
    "resolved_rate": ResolvedRate,
    "feedback_only": FeedbackOnly,
    "open_loop": OpenLoop,
    "random": RandomAgent,
}
"""Classes of agents, made by `AGENTS[name](config, spec, seed=seed)`."""

_REQUIRED = (
    *("act", "reset", "observe", "learn", "signals", "select_runs"),
    *("state_dict", "load_state_dict"),
    *("config_type", "trainable", "fine_tunable", "has_modules", "observes_plant"),
)


def agent_class(name: str) -> type[Agent]:
    """Return the class of an agent.

    Args:
        name: A name of `AGENTS`, or the path of a class, such as my_agents.py:MyAgent or
            package.module:MyAgent.

    Raises:
        BadOptionError: There is no such agent, or it cannot be imported, configured or saved.
    """
    if not _is_known(name):
        raise _unknown(name, AGENTS)
    if name in AGENTS:
        return AGENTS[name]
    loaded: type[Agent] = load_class(name, "agent", _REQUIRED, base=Agent)
    _check_outside(name, loaded)
    return loaded


def check_trainable(name: str) -> None:
    """Refuse an agent that does not learn.

    Args:
        name: A name of `AGENTS`, or the path of a class.

    Raises:
        BadOptionError: There is no such agent, or it does not learn.
    """
    learners = [one for one, kind in AGENTS.items() if kind.trainable]
    if not _is_known(name):
        raise _unknown(name, learners)
    if not agent_class(name).trainable:
        expected = f"an agent that learns, such as {', '.join(learners)}"
        raise BadOptionError(option="agent", value=name, expected=expected)


def _is_known(name: object) -> bool:
    """Return whether a name is of a built-in agent, or may be the path of a class."""
    return isinstance(name, str) and (name in AGENTS or ":" in name)


def _unknown(name: object, known: Collection[str]) -> BadOptionError:
    """Return the error of an agent that there is not, which lists those that can be chosen."""
    expected = f"one of {', '.join(known)}, or the path of a class, such as my_agents.py:MyAgent"
    remedy = did_you_mean(str(name), known)
    return BadOptionError(option="agent", value=name, expected=expected, remedy=remedy)


def _check_outside(name: str, loaded: type[Agent]) -> None:
    """Refuse a class from outside that could not be configured or saved.

    Raises:
        BadOptionError: It could not.
    """

    def refusal(expected: str) -> BadOptionError:
        return BadOptionError(option="agent", value=name, expected=f"an agent {expected}")

    config_type: object = loaded.config_type
    if not (isinstance(config_type, type) and issubclass(config_type, AgentConfig)):
        raise refusal(f"whose config_type is a subclass of {AgentConfig.__qualname__}")
    # A subclass without the decorator would silently have the fields of its base only.
    if "__dataclass_fields__" not in vars(config_type):
        raise refusal(f"whose config_type, {config_type.__qualname__}, is a frozen dataclass")
    missing = dataclasses.MISSING
    for field in dataclasses.fields(config_type):
        if field.default is missing and field.default_factory is missing:
            raise refusal(f"whose config_type has a default for {field.name}")
    saved = (loaded.state_dict, loaded.load_state_dict)
    if loaded.trainable and (Agent.state_dict in saved or Agent.load_state_dict in saved):
        raise refusal("that defines state_dict and load_state_dict, since it is trainable")
