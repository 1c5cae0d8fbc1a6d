"""Settings of a run."""

from __future__ import annotations

import importlib.metadata
import platform
from dataclasses import dataclass, fields
from typing import Annotated, Any, Literal, get_args, get_origin, get_type_hints

import tyro

from mpma_mj import __version__
from mpma_mj.motions.options import ReadingOptions
from mpma_mj.options import AgentName, Arms, ContextSignal, EfferenceCopy, RuleName

__all__ = ["ReadingArguments", "RunConfig", "Settings", "versions"]


@dataclass(frozen=True, kw_only=True)
class ReadingArguments(ReadingOptions):
    """How a recording is to be read, as options of a command: --from and --to."""

    start: Annotated[float | None, tyro.conf.arg(name="from")] = None
    end: Annotated[float | None, tyro.conf.arg(name="to")] = None

    @property
    def reading(self) -> ReadingOptions:
        """The same without what makes them options of a command."""
        return ReadingOptions(**{f.name: getattr(self, f.name) for f in fields(ReadingOptions)})


@dataclass(frozen=True, kw_only=True)
class Settings(ReadingArguments):
    """What decides the result of a run, apart from the movement: also how it is read.

    Attributes:
        arms: Simulated arms, or arms that move ideally.
        modules: Number of modules.
        nodes: Neurons of each of a module's three reservoirs.
        rule: Learning rule: ours, or the paper's.
        seed: Seed of everything random.
        repeats: How often the movement is danced in an epoch.
        reference_noise: Standard deviation of the noise on the demonstration, 0.01 is 1 %.
        agent: MPMA, or one to compare it with.
        context_signal: What it hears of the music: the labels as they are; or, to find out what
            they are good for, nothing, one constant sound, the labels shuffled, or each cut in two
            halves.
        responsibility_predictors: Whether it counts what they say; if not, all are as suited.
        forward_gating: Whether it counts whose forward model predicted well.
        efference_copy: Which command forward models hear: the total, or each module's own.
        proprioception: Whether models sense the joint angles too; the paper's do not.
        spectral_radius: Spectral radius of the reservoirs.
        reservoir_noise: Noise level of the reservoirs.
        ridge: Ridge of the readouts; 0.1 or more lets a dance go on without its demonstration.
    """

    arms: Arms = "physics"
    modules: int = 4
    nodes: int = 200
    rule: RuleName = "weighted"
    seed: int = 0
    repeats: int = 3
    reference_noise: float = 0.01
    agent: AgentName = "mpma"
    context_signal: ContextSignal = "labels"
    responsibility_predictors: bool = True
    forward_gating: bool = True
    efference_copy: EfferenceCopy = "total"
    proprioception: bool = True
    spectral_radius: float = 0.1
    reservoir_noise: float = 0.2
    ridge: float = 1e-4


@dataclass(frozen=True, kw_only=True)
class RunConfig(Settings):
    """Everything that decides the result of a run.

    Attributes:
        motions: What is imitated: "ymca", paths of recordings; several are a repertoire.
    """

    motions: tuple[str, ...] = ("ymca",)

    @classmethod
    def from_json(cls, content: dict[str, Any]) -> RunConfig:
        """Return what `dataclasses.asdict` and JSON made of settings.

        Raises:
            TypeError: A setting is missing, unknown, or of another type.
        """
        if content.keys() != {field.name for field in fields(cls)}:
            raise TypeError("other settings than these")
        config = cls(**content | {"motions": tuple(content["motions"])})
        for name, hint in get_type_hints(cls).items():
            value = getattr(config, name)
            if not _fits(value, hint):
                raise TypeError(name)
        return config


def _fits(value: object, hint: Any) -> bool:
    """Tell whether a value is of a type: a plain one, a literal, a union, or names."""
    if get_origin(hint) is Literal:
        return value in get_args(hint)
    if get_origin(hint) is tuple:
        return isinstance(value, tuple) and all(isinstance(entry, str) for entry in value)
    if get_args(hint):
        return any(_fits(value, choice) for choice in get_args(hint))
    return type(value) is hint or (hint is float and type(value) is int)


def versions() -> dict[str, str]:
    """Return the versions of what computes the result."""
    packages = ("mujoco", "dm-control", "numpy", "scipy")
    installed = {name: importlib.metadata.version(name) for name in packages}
    return {"mpma-mj": __version__, "python": platform.python_version()} | installed
