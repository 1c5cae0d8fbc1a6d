"""Command `mpma render`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import tyro

from mpma_mj.commands.dance_video import write_dance_video
from mpma_mj.envs.gl import require_backend

__all__ = ["Render"]


@dataclass(frozen=True)
class Render:
    """Write the video of a trained run again, or from another camera."""

    run_folder: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="RUN")]
    """Folder of the run."""
    camera: Literal["front", "side", "three_quarter"] = "front"
    """Camera of the video."""

    def run(self) -> Path:
        """Write the video and return its path."""
        require_backend()
        from mpma_mj.training.run_folder import RunFolder

        folder = RunFolder(self.run_folder)
        with folder.locked():
            write_dance_video(folder, self.camera)
        return folder.video
