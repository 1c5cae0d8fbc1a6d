"""Commands of the command line: a file for each, with its options and `run`."""

from typing import Any

from mpma_mj.commands.analyse import Analyse
from mpma_mj.commands.bench import Bench
from mpma_mj.commands.compare import Compare
from mpma_mj.commands.evaluate import Evaluate
from mpma_mj.commands.identify import Identify
from mpma_mj.commands.imitate import Imitate
from mpma_mj.commands.motion import InspectMotion
from mpma_mj.commands.render import Render
from mpma_mj.commands.study import Study
from mpma_mj.commands.sweep import Sweep
from mpma_mj.commands.view import View

__all__ = ["COMMANDS"]

COMMANDS: dict[str, Any] = {
    "imitate": Imitate,
    "motion": InspectMotion,
    "render": Render,
    "view": View,
    "sweep": Sweep,
    "study": Study,
    "bench": Bench,
    "compare": Compare,
    "evaluate": Evaluate,
    "analyse": Analyse,
    "identify": Identify,
}
"""Dataclasses of the commands by name; those of a generic one are for the config of an agent."""
