"""Settings of a run."""

from __future__ import annotations

import importlib.metadata
import platform
from dataclasses import dataclass

from mpma_mj import __version__
from mpma_mj.options import Arms, RuleName

__all__ = ["RunConfig", "Settings", "versions"]


@dataclass(frozen=True, kw_only=True)
class Settings:
    """What decides the result of a run, apart from the movement.

    Attributes:
        arms: Simulated arms, or arms that move ideally.
        modules: Number of modules.
        nodes: Neurons of each of a module's three reservoirs.
        rule: Learning rule: ours, or the paper's.
        seed: Seed of everything random.
        segments: Number of equal parts that label a recording.
        tempo: Speed relative to the original; 0.5 takes twice as long.
        max_gap: Longest gap in a marker's trajectory that is bridged, in seconds.
        repeats: How often the movement is danced in an epoch.
        noise: Standard deviation of the noise on the demonstration, 0.01 is 1 %.
    """

    arms: Arms = "physics"
    modules: int = 4
    nodes: int = 200
    rule: RuleName = "weighted"
    seed: int = 0
    segments: int = 4
    tempo: float = 1.0
    max_gap: float = 0.25
    repeats: int = 3
    noise: float = 0.01


@dataclass(frozen=True, kw_only=True)
class RunConfig(Settings):
    """Everything that decides the result of a run.

    Attributes:
        motion: What is imitated: "ymca" or the path of a recording.
    """

    motion: str = "ymca"


def versions() -> dict[str, str]:
    """Return the versions of what computes the result."""
    packages = ("mujoco", "dm-control", "numpy", "scipy")
    installed = {name: importlib.metadata.version(name) for name in packages}
    return {"mpma-mj": __version__, "python": platform.python_version()} | installed
