"""Commands of the command line: a file for each, with its options and `run`."""

from typing import Any

from mpma_mj.commands.analyse import Analyse
from mpma_mj.commands.compare import Compare
from mpma_mj.commands.evaluate import Evaluate
from mpma_mj.commands.identify import Identify
from mpma_mj.commands.imitate import Imitate
from mpma_mj.commands.motion import InspectMotion
from mpma_mj.commands.play import Play
from mpma_mj.commands.record import Record
from mpma_mj.commands.robot import DescribeRobot
from mpma_mj.commands.study import Study
from mpma_mj.commands.sweep import Sweep

__all__ = ["COMMANDS", "EXAMPLES", "GROUPS"]

GROUPS: dict[str, dict[str, tuple[Any, str]]] = {
    "Train": {
        "imitate": (Imitate, "mpma imitate ymca --out runs/ymca"),
        "record": (Record, "mpma record ymca --out ymca.minari"),
        "sweep": (Sweep, "mpma sweep ymca --grid nodes=50,200 --runs 20"),
    },
    "Look": {
        "motion": (InspectMotion, "mpma motion dance.c3d --video"),
        "play": (Play, "mpma play runs/ymca --out dance.mp4"),
    },
    "Measure": {
        "evaluate": (Evaluate, "mpma evaluate runs/ymca"),
        "analyse": (Analyse, "mpma analyse runs/ymca modules"),
        "compare": (Compare, "mpma compare ymca --runs 5"),
        "study": (Study, "mpma study agents --runs 10"),
    },
    "Use another robot": {
        "robot": (DescribeRobot, "mpma robot my_robot.urdf"),
        "identify": (Identify, "mpma identify robot.csv"),
    },
}
"""Commands by group: the dataclass of each, and an example; those that are generic are for the
config of an agent."""

COMMANDS: dict[str, Any] = {
    name: command for group in GROUPS.values() for name, (command, _) in group.items()
}
"""Dataclasses of the commands by name."""

EXAMPLES: dict[str, str] = {
    name: example for group in GROUPS.values() for name, (_, example) in group.items()
}
"""Examples of the commands by name."""
