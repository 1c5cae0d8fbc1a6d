"""Command `mpma identify`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from mpma_mj.commands.folders import results_folder
from mpma_mj.options import TWO_ARM

__all__ = ["Identify"]


@dataclass(frozen=True)
class Identify:
    """Identify the parameters with which simulated arms reproduce a robot's log.

    Writes identified.xml (the model with the identified parameters), identified.json and
    identified.png.
    """

    log: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="LOG")]
    """CSV file of commands and measurements: time, and command_, angle_ and velocity_ of each
    joint."""
    robot: str = TWO_ARM
    """MJCF file of your arms, with initial guesses of the parameters."""
    gravity_compensation: bool = False
    """Whether the robot compensates for gravity."""
    out: Path | None = None
    """Folder of the result; runs/identify-TIME if not given."""

    def run(self) -> Path:
        """Identify the parameters and return the folder."""
        from mpma_mj.sysid import identify, read_log, write_model
        from mpma_mj.sysid.figure import write_figure
        from mpma_mj.sysid.report import as_markdown
        from mpma_mj.utils.data_files import write_json
        from mpma_mj.utils.progress import show_count

        log = read_log(self.log)
        with results_folder(self.out, "identify") as folder:
            with show_count("simulating the log with other parameters") as tick:
                identified = identify(
                    log,
                    robot=self.robot,
                    gravity_compensation=self.gravity_compensation,
                    tick=tick,
                )
            write_json(folder / "identified.json", {"log": str(self.log)} | identified.as_json())
            write_model(folder / "identified.xml", identified.factors, self.robot)
            write_figure(folder / "identified.png", identified)
            print(as_markdown(identified))
            return folder
