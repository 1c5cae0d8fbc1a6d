"""Settings of a run."""

from __future__ import annotations

import dataclasses
import importlib.metadata
import platform
from dataclasses import dataclass
from typing import Any

from mpma_mj import __version__
from mpma_mj.agents.learning import RuleName
from mpma_mj.envs.load import Arms

__all__ = ["RunConfig", "versions"]


@dataclass(frozen=True)
class RunConfig:
    """Everything that decides the result of a run.

    Attributes:
        motion: What is imitated: "ymca" or the path of a recording.
        arms: Simulated or kinematic arms.
        modules: Number of modules.
        nodes: Neurons of each reservoir.
        rule: Learning rule.
        seed: Seed of everything random.
        segments: Equal parts that label a recording without labels.
        tempo: Speed relative to the original.
        max_gap: Longest gap in a marker's trajectory that is bridged, s.
        repeats: How often the movement is danced in an epoch.
        noise: Noise on the demonstration.
    """

    motion: str = "ymca"
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

    def as_dict(self) -> dict[str, Any]:
        """Return the settings by name, as JSON can hold them."""
        return dataclasses.asdict(self)


def versions() -> dict[str, str]:
    """Return the versions of what computes the result."""
    packages = ("mujoco", "dm-control", "numpy", "scipy")
    installed = {name: importlib.metadata.version(name) for name in packages}
    return {"mpma-mj": __version__, "python": platform.python_version()} | installed
