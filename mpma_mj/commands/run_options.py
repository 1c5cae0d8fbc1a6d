"""Options of a run on the command line: those of reading, of the environment and of the agent."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Annotated, Any, Generic, TypeVar

import tyro

from mpma_mj.agents.config import CONFIG_TYPES, AgentConfig
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.errors import BadOptionError
from mpma_mj.training.config import ReadingArguments, RunConfig
from mpma_mj.utils.text import option_name

__all__ = ["OutsideClasses", "RunOptions", "config_type", "typed_options"]

AgentT = TypeVar("AgentT", bound=AgentConfig)

_AGENT = "--agent"


@dataclass(frozen=True, kw_only=True)
class RunOptions(Generic[AgentT]):
    """Options that determine the result.

    Attributes:
        agent: mpma, growing, mosaic, hammer or single; or the path of a class, such as
            my_agents.py:MyAgent.
        seed: Seed of all random numbers.
        config: Options of the agent.
        env: Options of the environment.
        reading: Options of reading recordings.
    """

    agent: Annotated[str, tyro.conf.arg(metavar="NAME")] = "mpma"
    seed: int = 0
    config: Annotated[tyro.conf.OmitArgPrefixes[AgentT], tyro.conf.arg(name="agent")]
    env: Annotated[
        tyro.conf.OmitArgPrefixes[EnvironmentOptions], tyro.conf.arg(name="environment")
    ] = dataclasses.field(default_factory=EnvironmentOptions)
    reading: Annotated[
        tyro.conf.OmitArgPrefixes[ReadingArguments], tyro.conf.arg(name="recording")
    ] = dataclasses.field(default_factory=ReadingArguments)

    def run_config(self, motions: tuple[str, ...]) -> RunConfig:
        """Return the config of a run.

        Args:
            motions: Names of built-in motions, and paths of recordings.
        """
        return RunConfig(
            motions=motions,
            reading=self.reading.reading,
            env=self.env,
            agent=self.config,
            # That of a resumed run, where its own config was parsed without being named.
            agent_name="" if self._is_resumed else self.agent,
            seed=self.seed,
        )

    @property
    def _is_resumed(self) -> bool:
        return type(self.config) is not CONFIG_TYPES.get(self.agent, type(self.config))

    @property
    def outside(self) -> tuple[str, ...]:
        """Paths of the named classes from outside the package."""
        named = (self.agent, getattr(self.config, "rule", ""))
        return tuple(path for path in named if isinstance(path, str) and ":" in path)


@dataclass(frozen=True, kw_only=True)
class OutsideClasses:
    """Code from outside the package with which runs were trained; it is imported only if named.

    Attributes:
        agent: Path of the class of the agent, such as my_agents.py:MyAgent.
        rule: Path of the class of the learning rule, such as my_rules.py:MyRule.
    """

    agent: str | None = None
    rule: str | None = None


def config_type(words: Sequence[str]) -> type[AgentConfig]:
    """Return the class of the config of the agent that a command line names.

    Args:
        words: Words of the command line.

    Raises:
        BadOptionError: There is no such agent, or another option belongs to another agent.
    """
    name = _value(words, _AGENT) or _saved_agent(words) or "mpma"
    if name in CONFIG_TYPES:
        kind = CONFIG_TYPES[name]
    else:
        from mpma_mj.agents.registry import agent_class

        kind = agent_class(name).config_type
    names = {f.name for f in fields(kind)}
    for option in typed_options(words):
        owners = [one for one, other in CONFIG_TYPES.items() if option in _names(other)]
        if owners and option not in names:
            remedy = f"leave it out, or take another {{agent}}: {', '.join(owners)}"
            raise BadOptionError(f"{name} has no option --{option_name(option)}", remedy=remedy)
    return kind


def _saved_agent(words: Sequence[str]) -> str | None:
    """Return the built-in agent of the run that a command line resumes, None without one."""
    folder = _value(words, "--resume")
    if folder is None:
        return None
    from mpma_mj.training.run_folder import RunFolder

    name = RunFolder(Path(folder)).read_config().agent_name
    return name if name in CONFIG_TYPES else None


def typed_options(words: Sequence[str]) -> set[str]:
    """Return the options that a command line contains, by their names in Python."""
    flags = {word.split("=")[0].removeprefix("--") for word in words if word.startswith("--")}
    names = {flag.replace("-", "_").removeprefix("no_") for flag in flags}
    return {{"from": "start", "to": "end"}.get(name, name) for name in names}


def _value(words: Sequence[str], flag: str) -> str | None:
    """Return the last value of a flag; None if it is not given."""
    value = None
    for number, word in enumerate(words):
        if word == flag and number + 1 < len(words):
            value = words[number + 1]
        elif word.startswith(f"{flag}="):
            value = word.partition("=")[2]
    return value


def _names(kind: Any) -> set[str]:
    """Return the names of the fields of a dataclass."""
    return {f.name for f in fields(kind)}
