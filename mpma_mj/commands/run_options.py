"""Options of a run on the command line: those of reading, of the environment and of the agent."""

from __future__ import annotations

import collections.abc
import dataclasses
import functools
import re
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Annotated, Any, Generic, TypeVar, get_args, get_origin

import tyro
from tyro.constructors import ConstructorRegistry, StructConstructorSpec, StructTypeInfo

from mpma_mj.agents.config import CONFIG_TYPES, AgentConfig
from mpma_mj.commands.typed_values import some_values, typed_value
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.errors import BadOptionError
from mpma_mj.motions.built_in import HAND_MADE
from mpma_mj.motions.options import ReadingOptions
from mpma_mj.training.config import RunConfig
from mpma_mj.utils.text import field_name, option_name

__all__ = [
    "MOTION",
    "REFUSED_OPTIONS",
    "Given",
    "MotionName",
    "Motions",
    "Outside",
    "OutsideClasses",
    "Reading",
    "RunFolders",
    "RunOptions",
    "Source",
    "config_type",
    "registry",
    "typed_options",
]

AgentT = TypeVar("AgentT", bound=AgentConfig)

_AGENT = "--agent"
_WHOLE = "training imitates whole episodes"

MOTION = (
    f"{HAND_MADE}; or a recording: C3D, BVH, AMC, TRC, CSV and others (docs/guides/recordings.md)"
)
"""Description of a motion in help texts."""

_MOTIONS = (
    tyro.conf.Positional,
    tyro.conf.arg(
        metavar="MOTION...",
        help=f"{MOTION}; several, or a folder, form a repertoire that is learned together.",
    ),
)
Motions = Annotated[(tuple[str, ...], *_MOTIONS)]
MotionName = Annotated[
    str, tyro.conf.Positional, tyro.conf.arg(metavar="MOTION", help=f"{MOTION}.")
]
Source = Annotated[
    str,
    tyro.conf.Positional,
    tyro.conf.arg(
        metavar="RUN|MOTION",
        help=f"Folder of a run, of which --from and --to are seconds of its episode; or {MOTION}.",
    ),
]
RunFolders = Annotated[tuple[Path, ...], tyro.conf.Positional, tyro.conf.arg(metavar="RUN...")]
Reading = Annotated[
    tyro.conf.OmitArgPrefixes[ReadingOptions],
    tyro.conf.arg(name="recording", help="How a recording is read, cleaned and labelled."),
]

Given = Annotated[frozenset[str], tyro.conf.Fixed, tyro.conf.Suppress]
"""Options that the command line contains, by their names in Python; `mpma_mj.cli` fills it in."""

_METAVARS = {
    "agent": "NAME",
    "agents": "[NAME ...]",
    **dict.fromkeys(("audio", "labels", "skeleton"), "PATH"),
    "robot": "NAME|PATH",
    **dict.fromkeys(("latency_every", "switch_every"), "LOW HIGH"),
    "locked_joint": "JOINT",
    "map": "POINTS|PATH",
    "motion": "MOTION",
    "perturbation": "RATE SIZE",
    "reward_weights": "[TERM WEIGHT ...]",
    "rule": "NAME",
    "unseen": "[PATH ...]",
}


@dataclass(frozen=True, kw_only=True)
class RunOptions(Generic[AgentT]):
    """Options that determine the result.

    Attributes:
        agent: mpma, mosaic, hammer, single, adaptive, oracle, bc, dagger, promp or dmp; or the path
            of a class, such as my_agents.py:MyAgent.
        seed: Seed of all random numbers.
        config: Each --agent has its own; --agent mosaic --help lists those of MOSAIC.
        env: Arms, demonstration, delays and disturbances, the same for all agents.
        reading: How recordings are read.
    """

    agent: str = "mpma"
    seed: int = 0
    config: Annotated[tyro.conf.OmitArgPrefixes[AgentT], tyro.conf.arg(name="agent")]
    env: Annotated[
        tyro.conf.OmitArgPrefixes[EnvironmentOptions], tyro.conf.arg(name="environment")
    ] = EnvironmentOptions()
    reading: Reading = ReadingOptions()

    def run_config(self, motions: tuple[str, ...], command: str) -> RunConfig:
        """Return the config of a run.

        Args:
            motions: Names of built-in motions, and paths of recordings and folders of them.
            command: Name of the command, for the message where no motion is given.

        Raises:
            BadOptionError: No motion is given, or an option is none of training.
        """
        from mpma_mj.training.dataset import expand_folders

        if not motions:
            raise BadOptionError(f"no motion given; try: mpma {command} ymca")
        return RunConfig(
            motions=expand_folders(motions),
            reading=self.reading,
            env=self.env,
            agent=self.config,
            # That of an earlier run, where its own config was parsed without being named.
            agent_name="" if self._is_of_run else self.agent,
            seed=self.seed,
        )

    @property
    def _is_of_run(self) -> bool:
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


Outside = Annotated[tyro.conf.OmitArgPrefixes[OutsideClasses], tyro.conf.arg(name="outside-class")]


def registry(hidden: Collection[str] = ()) -> ConstructorRegistry:
    """Return the rules by which fields of dataclasses become options.

    Help texts leave out None, which cannot be typed, and empty defaults; fields of other options
    that they name are written as flags.

    Args:
        hidden: Names of fields that are no options of the command.
    """
    rules = ConstructorRegistry()
    rules.primitive_rule(typed_value)
    rules.primitive_rule(some_values)
    under_way: list[StructTypeInfo] = []

    @rules.struct_rule
    def as_options(info: StructTypeInfo) -> StructConstructorSpec | None:
        if under_way or not dataclasses.is_dataclass(info.type):
            return None
        under_way.append(info)  # so that the next line returns what tyro itself makes of it
        spec = ConstructorRegistry.get_struct_spec(info)
        under_way.clear()
        if not isinstance(spec, StructConstructorSpec):
            return None
        fields = []
        for one in spec.fields:
            notes = [tyro.conf.DisallowNone, tyro.conf.arg(help_behavior_hint=_default)]
            in_code_only = _is_nested(one.type)
            notes += [tyro.conf.Suppress] * (one.name in hidden or in_code_only)
            notes += [tyro.conf.Fixed] * in_code_only
            notes += _MOTIONS * (one.name == "motions" and get_origin(one.type) is tuple)
            notes += [tyro.conf.arg(name=option_name(one.name))] * (info.type is ReadingOptions)
            if one.name in _METAVARS:
                notes.append(tyro.conf.arg(metavar=_METAVARS[one.name]))
            kind: Any = Annotated[(one.type, *notes)]
            others = _names(info.type) - {one.name}
            text = functools.partial(_help, one.helptext, others)
            fields.append(dataclasses.replace(one, type=kind, helptext=text))
        return dataclasses.replace(spec, fields=tuple(fields))

    return rules


def _is_nested(kind: Any) -> bool:
    """Return whether a type is a mapping of mappings, which cannot be typed."""
    mappings = collections.abc.Mapping
    return get_origin(kind) is mappings and get_origin(get_args(kind)[1]) is mappings


def _help(text: str | Callable[[], str | None] | None, fields: Collection[str]) -> str | None:
    """Return a help text on one line, with fields of the dataclass as flags, without backticks."""
    text = text() if callable(text) else text
    if text is None:
        return None
    return re.sub(
        r"`(\w+)`",
        lambda found: f"--{option_name(found[1])}" if found[1] in fields else found[1],
        " ".join(text.split()),
    )


def _default(value: str) -> str:
    """Return what the help says of a default."""
    return "" if value in ("", "None") else f"(default: {value})"


REFUSED_OPTIONS = {"random_start": _WHOLE, "termination_distance": _WHOLE}
"""Options of environments that training does not have, and why."""


def config_type(words: Sequence[str]) -> type[AgentConfig]:
    """Return the class of the config of the agent that a command line names.

    Args:
        words: Words of the command line, the first being the command.

    Raises:
        BadOptionError: There is no such agent, or the command or the agent lacks an option.
    """
    typed = typed_options(words)
    for option, reason in REFUSED_OPTIONS.items():
        if option in typed:
            problem = f"{words[0]} has no option --{option_name(option)}"
            raise BadOptionError(problem, remedy=f"leave it out: {reason}")
    name = _value(words, _AGENT) or _saved_agent(words) or "mpma"
    if name in CONFIG_TYPES:
        kind = CONFIG_TYPES[name]
    else:
        from mpma_mj.agents.registry import agent_class, check_trainable

        if words[0] not in ("record", "sweep"):  # for which agents that learn nothing will do
            check_trainable(name)
        kind = agent_class(name).config_type
    for option in sorted(typed - _names(kind)):
        owners = [one for one, other in CONFIG_TYPES.items() if option in _names(other)]
        if owners:
            remedy = f"leave it out, or choose another {{agent}}: {', '.join(owners)}"
            raise BadOptionError(f"{name} has no option --{option_name(option)}", remedy=remedy)
    return kind


def _saved_agent(words: Sequence[str]) -> str | None:
    """Return the built-in agent of the run that a command line continues, None without one."""
    folder = _value(words, "--resume") or _value(words, "--init")
    if folder is None:
        return None
    from mpma_mj.training.run_folder import RunFolder

    name = RunFolder(Path(folder)).read_config().agent_name
    return name if name in CONFIG_TYPES else None


def typed_options(words: Sequence[str]) -> set[str]:
    """Return the options that a command line contains, by their names in Python."""
    flags = {word.split("=")[0].removeprefix("--") for word in words if word.startswith("--")}
    return {field_name(flag).removeprefix("no_") for flag in flags}


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
