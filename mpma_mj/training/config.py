"""Config of a run: motions, how they are read, environment, agent and seed."""

from __future__ import annotations

import dataclasses
import importlib.metadata
import platform
from collections.abc import Collection
from dataclasses import dataclass, field, fields
from typing import Any, get_origin, get_type_hints

from mpma_mj._version import __version__
from mpma_mj.agents.config import CONFIG_TYPES, AgentConfig, MPMAConfig
from mpma_mj.envs.options import EnvironmentOptions, check_seed
from mpma_mj.errors import BadOptionError
from mpma_mj.motions.options import ReadingOptions
from mpma_mj.training.config_json import (
    OutsideConfig,
    agent_from_json,
    agent_to_json,
    config_class,
    exact,
    plain,
)
from mpma_mj.utils.text import did_you_mean

__all__ = ["Init", "RunConfig", "option_types", "versions"]

_PARTS = ("reading", "env", "agent")
_KINDS = {"reading": ReadingOptions, "env": EnvironmentOptions, "agent": AgentConfig}
_SIZES = ("modules", "nodes")  # every agent may stand in a grid of sizes, also one that has none


@dataclass(frozen=True, kw_only=True)
class Init:
    """Where a run begins that does not begin with nothing learned.

    Attributes:
        path: Folder of the earlier run, as it was given.
        digest: SHA-256 of the checkpoint of its best epoch, in hexadecimal.
    """

    path: str
    digest: str

    def __post_init__(self) -> None:
        """Check the fields, which may come from a file.

        Raises:
            BadOptionError: One is not text.
        """
        for name, value in vars(self).items():
            if not isinstance(value, str):
                raise BadOptionError(option=f"init.{name}", value=value, expected="text")


@dataclass(frozen=True, kw_only=True)
class RunConfig:
    """Everything that decides the result of a run.

    Attributes:
        motions: What is imitated: names of built-in motions, such as "ymca", or paths of
            recordings; several are a repertoire.
        reading: How recordings are read.
        env: Options of the environment.
        agent: The agent's own config.
        agent_name: Name of the agent, or the path of its class; by its config if not given.
        seed: Seed of everything random.
        init: Where the run begins; with nothing learned if not given. See
            `mpma_mj.training.initial_state`.
    """

    motions: tuple[str, ...] = ("ymca",)
    reading: ReadingOptions = field(default_factory=ReadingOptions)
    env: EnvironmentOptions = field(default_factory=EnvironmentOptions)
    agent: AgentConfig = field(default_factory=MPMAConfig)
    agent_name: str = ""
    seed: int = 0
    init: Init | None = None

    def __post_init__(self) -> None:
        """Check what the parts do not check themselves.

        Raises:
            BadOptionError: The agent has no name, or an option is none of training.
        """
        object.__setattr__(self, "seed", check_seed(self.seed))
        names = self.motions
        if not (isinstance(names, tuple) and names and all(isinstance(n, str) for n in names)):
            expected = 'names or paths as a tuple, such as ("ymca",)'
            raise BadOptionError(option="motions", value=names, expected=expected)
        for name, kind in _KINDS.items():
            value = getattr(self, name)
            if not isinstance(value, kind):
                raise BadOptionError(
                    option=name, value=value, expected=f"an object of {kind.__name__}"
                )
        if not self.agent_name:
            found = [name for name, kind in CONFIG_TYPES.items() if type(self.agent) is kind]
            if not found:
                expected = "a config of a built-in agent"
                remedy = "give the path of its class as {agent_name=my_agents.py:MyAgent}"
                raise BadOptionError(
                    option="agent", value=self.agent, expected=expected, remedy=remedy
                )
            object.__setattr__(self, "agent_name", found[0])
        own = CONFIG_TYPES.get(self.agent_name, type(self.agent))
        if type(self.agent) is not own and not isinstance(self.agent, OutsideConfig):
            expected = f"a {own.__name__}, the config of {self.agent_name}"
            raise BadOptionError(option="agent", value=self.agent, expected=expected)
        for name in ("random_start", "termination_distance"):
            value = getattr(self.env, name)
            if value not in (False, None):
                expected = "the default: training imitates whole episodes"
                raise BadOptionError(option=name, value=value, expected=expected)

    def __reduce__(self) -> tuple[Any, ...]:
        """Travel to workers by the name of the agent, whose class they import themselves."""
        if ":" not in self.agent_name or isinstance(self.agent, OutsideConfig):
            return super().__reduce__()  # type: ignore[return-value]
        return _from_own_process, (self.to_json(),)

    @classmethod
    def of(cls, *motions: str, **options: Any) -> RunConfig:
        """Return a config of motions, "ymca" if not given, with options as of `replace`."""
        return cls(motions=motions or ("ymca",)).replace(**options)

    def replace(self, *, agent: str | None = None, **options: Any) -> RunConfig:
        """Return the config with other options, given by their flat names.

        Args:
            agent: Name of another agent, or the path of its class; it takes over the options that
                both have, and sizes that it does not have are passed over.
            **options: Options of reading, environment or agent, or `motions` or `seed`.

        Raises:
            BadOptionError: There is no such option, the agent does not have it, or it is out of
                bounds.
        """
        changed = self if agent is None else self._with_agent(agent)
        parts: dict[str, dict[str, Any]] = {part: {} for part in _PARTS}
        own: dict[str, Any] = {}
        for name, value in options.items():
            if name in ("motions", "seed"):
                own[name] = value
            else:
                part = changed._part(name)
                if part:
                    parts[part][name] = value
        replaced = {
            part: dataclasses.replace(getattr(changed, part), **values)
            for part, values in parts.items()
            if values
        }
        return dataclasses.replace(changed, **own, **replaced)

    def options(self) -> dict[str, Any]:
        """Return all options by their flat names."""
        own = {"motions": self.motions, "agent": self.agent_name, "seed": self.seed}
        nested = (getattr(self, part) for part in _PARTS)
        return own | {f.name: getattr(p, f.name) for p in nested for f in fields(p)}

    def option(self, name: str) -> Any:
        """Return an option by its flat name; None if the agent does not have it."""
        return self.options().get(name)

    def to_json(self) -> dict[str, Any]:
        """Return what JSON can hold of the config."""
        reading, env = (dataclasses.asdict(part) for part in (self.reading, self.env))
        return {
            "motions": list(self.motions),
            "reading": {name: plain(value) for name, value in reading.items()},
            "env": {name: plain(value) for name, value in env.items()},
            "agent": agent_to_json(self.agent, self.agent_name),
            "seed": self.seed,
        } | ({} if self.init is None else {"init": dataclasses.asdict(self.init)})

    @classmethod
    def from_json(cls, content: dict[str, Any], trusted: Collection[str] = ()) -> RunConfig:
        """Return the config that `to_json` returned; no code from outside is imported.

        Args:
            content: What JSON held.
            trusted: Paths of outside classes that the user has named, which may be imported.

        Raises:
            KeyError, TypeError, ValueError: An option is missing, unknown or out of bounds.
        """
        if content.keys() - {"init"} != {"motions", "reading", "env", "agent", "seed"}:
            raise TypeError("other parts than these")
        if not isinstance(content["motions"], list):
            raise TypeError("motions")
        return cls(
            motions=tuple(content["motions"]),
            reading=exact(ReadingOptions, content["reading"]),
            env=exact(EnvironmentOptions, content["env"]),
            agent=agent_from_json(content["agent"], trusted),
            agent_name=content["agent"]["name"],
            seed=content["seed"],
            init=exact(Init, content["init"]) if "init" in content else None,
        )

    def _with_agent(self, name: str) -> RunConfig:
        kind = config_class(name)
        # Options with their default stay with the agent's own, which may be another.
        given = {
            f.name: value
            for f in fields(self.agent)
            if (value := getattr(self.agent, f.name)) != f.default
        }
        agent = kind(**{option: given[option] for option in given.keys() & _names(kind)})
        return dataclasses.replace(self, agent=agent, agent_name=name)

    def _part(self, name: str) -> str | None:
        """Return the part of the config that has an option; None for a size the agent lacks."""
        for part in _PARTS:
            if name in _names(getattr(self, part)):
                return part
        owners = [one for one, kind in CONFIG_TYPES.items() if name in _names(kind)]
        if name in _SIZES:
            return None
        if owners:
            raise BadOptionError(
                f"{self.agent_name} has no option {name}, which {', '.join(owners)} have",
                remedy=f"leave {{{name}}} out, or choose another {{agent}}",
            )
        remedy = did_you_mean(name, self.options(), "{{{}}}")
        raise BadOptionError(f"no option '{name}'", remedy=remedy)


def _from_own_process(content: dict[str, Any]) -> RunConfig:
    agent = content["agent"]
    rule = agent.get("rule", "")
    path = rule["class"] if isinstance(rule, dict) else rule
    return RunConfig.from_json(content, (agent["name"], path))


def option_types(agent: str) -> dict[str, Any]:
    """Return the types of all options of a run with an agent by flat names, but for `motions`."""
    hints: dict[str, Any] = {"agent": str, "seed": int}
    for owner in (ReadingOptions, EnvironmentOptions, config_class(agent)):
        hints |= get_type_hints(owner)
    return {name: hint for name, hint in hints.items() if get_origin(hint) is not dict}


def versions() -> dict[str, str]:
    """Return the versions of the libraries that determine the result."""
    packages = ("mujoco", "dm-control", "numpy", "scipy")
    installed = {name: importlib.metadata.version(name) for name in packages}
    return {"mpma-mj": __version__, "python": platform.python_version()} | installed


def _names(kind: Any) -> set[str]:
    return {f.name for f in fields(kind)}
