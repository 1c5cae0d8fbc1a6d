"""Commands of the command line: a file for each, with its options and `run`."""

from mpma_mj.commands.ablate import Ablate
from mpma_mj.commands.attractor import Attractor
from mpma_mj.commands.bench import Bench
from mpma_mj.commands.benchmark import Benchmark
from mpma_mj.commands.capture import Capture
from mpma_mj.commands.compare import Compare
from mpma_mj.commands.grow import Grow
from mpma_mj.commands.identify import Identify
from mpma_mj.commands.imitate import Imitate
from mpma_mj.commands.lesion import Lesion
from mpma_mj.commands.motion import InspectMotion
from mpma_mj.commands.render import Render
from mpma_mj.commands.scale import Scale
from mpma_mj.commands.stress import Stress
from mpma_mj.commands.sweep import Sweep
from mpma_mj.commands.table1 import Table1
from mpma_mj.commands.view import View

__all__ = [
    "Ablate",
    "Attractor",
    "Bench",
    "Benchmark",
    "Capture",
    "Compare",
    "Grow",
    "Identify",
    "Imitate",
    "InspectMotion",
    "Lesion",
    "Render",
    "Scale",
    "Stress",
    "Sweep",
    "Table1",
    "View",
]
