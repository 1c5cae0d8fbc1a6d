"""Commands of the command line: a file for each, with its options and `run`."""

from typing import Any

from mpma_mj.commands.ablate import Ablate
from mpma_mj.commands.benchmark import Benchmark
from mpma_mj.commands.capture import Capture
from mpma_mj.commands.compare import Compare
from mpma_mj.commands.free_running import FreeRunningCommand
from mpma_mj.commands.identify import Identify
from mpma_mj.commands.imitate import Imitate
from mpma_mj.commands.lesion import Lesion
from mpma_mj.commands.motion import InspectMotion
from mpma_mj.commands.play import Play
from mpma_mj.commands.scale import Scale
from mpma_mj.commands.stress import Stress
from mpma_mj.commands.study import Study
from mpma_mj.commands.sweep import Sweep
from mpma_mj.commands.table1 import Table1

__all__ = ["COMMANDS", "GROUPS"]

GROUPS: dict[str, dict[str, tuple[Any, str]]] = {
    "Train": {
        "imitate": (Imitate, "mpma imitate ymca --out runs/ymca"),
        "sweep": (Sweep, "mpma sweep ymca --grid nodes=50,200 --runs 20"),
    },
    "Look": {
        "motion": (InspectMotion, "mpma motion dance.c3d --video"),
        "play": (Play, "mpma play runs/ymca --out dance.mp4"),
    },
    "Measure a run": {
        "stress": (Stress, "mpma stress runs/ymca"),
        "capture": (Capture, "mpma capture runs/ymca"),
        "free-running": (FreeRunningCommand, "mpma free-running runs/ymca"),
        "lesion": (Lesion, "mpma lesion runs/ymca"),
    },
    "Measure many runs": {
        "compare": (Compare, "mpma compare ymca --runs 5"),
        "table1": (Table1, "mpma table1 --runs 20"),
        "benchmark": (Benchmark, "mpma benchmark --runs 10"),
        "ablate": (Ablate, "mpma ablate --runs 10"),
        "scale": (Scale, "mpma scale dances/"),
        "study": (Study, "mpma study switching --runs 10"),
    },
    "Fit the model to a robot": {
        "identify": (Identify, "mpma identify robot.csv"),
    },
}
"""Commands by group: the dataclass of each, and an example; those that are generic are for the
config of an agent."""

COMMANDS: dict[str, Any] = {
    name: command for group in GROUPS.values() for name, (command, _) in group.items()
}
"""Dataclasses of the commands by name."""
