"""All agents by name."""

from __future__ import annotations

from mpma_mj.agents.base import Agent
from mpma_mj.agents.baselines import FeedbackOnly, OpenLoop, RandomAgent
from mpma_mj.agents.config import AgentConfig
from mpma_mj.agents.extensions import load_class
from mpma_mj.agents.growing import GrowingMPMA
from mpma_mj.agents.hammer import HAMMER
from mpma_mj.agents.mosaic import MOSAIC
from mpma_mj.agents.mpma import MPMA, Single
from mpma_mj.errors import BadOptionError

__all__ = ["AGENTS", "agent_class", "check_trainable"]

AGENTS: dict[str, type[Agent]] = {
    "mpma": MPMA,
    "growing": GrowingMPMA,
    "mosaic": MOSAIC,
    "hammer": HAMMER,
    "single": Single,
    "feedback_only": FeedbackOnly,
    "open_loop": OpenLoop,
    "random": RandomAgent,
}
"""Classes of agents, made by `AGENTS[name](config, spec, seed=seed)`."""

_REQUIRED = (
    *("act", "reset", "observe", "learn", "signals", "select_runs"),
    *("state_dict", "load_state_dict"),
    *("config_type", "trainable", "fine_tunable", "has_modules"),
)


def agent_class(name: str) -> type[Agent]:
    """Return the class of an agent.

    Args:
        name: A name of `AGENTS`, or the path of a class, such as my_agents.py:MyAgent or
            package.module:MyAgent.

    Raises:
        BadOptionError: There is no such agent, or it cannot be imported.
    """
    if not isinstance(name, str) or (name not in AGENTS and ":" not in name):
        expected = (
            f"one of {', '.join(AGENTS)}, or the path of a class, such as my_agents.py:MyAgent"
        )
        raise BadOptionError(option="agent", value=name, expected=expected)
    if name in AGENTS:
        return AGENTS[name]
    loaded: type[Agent] = load_class(name, "agent", _REQUIRED, base=Agent)
    config_type: object = loaded.config_type
    if not (isinstance(config_type, type) and issubclass(config_type, AgentConfig)):
        expected = f"an agent whose config_type is a subclass of {AgentConfig.__qualname__}"
        raise BadOptionError(option="agent", value=name, expected=expected)
    return loaded


def check_trainable(name: str) -> None:
    """Refuse an agent that does not learn.

    Args:
        name: A name of `AGENTS`, or the path of a class.

    Raises:
        BadOptionError: There is no such agent, or it does not learn.
    """
    if not agent_class(name).trainable:
        learners = ", ".join(one for one, kind in AGENTS.items() if kind.trainable)
        expected = f"an agent that learns, such as {learners}"
        raise BadOptionError(option="agent", value=name, expected=expected)
