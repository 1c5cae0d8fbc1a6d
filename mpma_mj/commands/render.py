"""Command `mpma render`, and videos of runs for the commands that train."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import tyro

from mpma_mj.envs.gl import require_backend
from mpma_mj.errors import RenderingError

if TYPE_CHECKING:
    from mpma_mj.training.run_folder import RunFolder

__all__ = ["Render", "missing_opengl", "write_dance_video"]


@dataclass(frozen=True)
class Render:
    """Write the video of a trained run again, or from another camera."""

    run_folder: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="RUN")]
    """Folder of the run."""
    camera: Literal["front", "side", "three_quarter"] = "front"
    """Camera of the video."""

    def run(self) -> Path:
        """Write the video and return its path."""
        from mpma_mj.training.run_folder import RunFolder

        folder = RunFolder(self.run_folder)
        with folder.locked():
            require_backend()
            write_dance_video(folder, self.camera)
        return folder.video


def missing_opengl() -> str | None:
    """Look for OpenGL before a long computation; return the message to print after it, if any."""
    try:
        require_backend()
    except RenderingError as error:
        return f"mpma: {error}"
    return None


def write_dance_video(folder: RunFolder, camera: str) -> None:
    """Write the video of a run to its folder.

    Args:
        folder: Folder of the run.
        camera: Camera of the model.

    Raises:
        RenderingError: OpenGL does not draw.
        VideoError: The encoder is missing, or fails.
        MpmaError: The run is damaged.
    """
    from mpma_mj.utils.progress import show_frames
    from mpma_mj.visualization.video import write_video

    write_video(
        folder.video,
        folder.read_trace(),
        folder.read_motion(),
        options=folder.read_config().env,
        camera=camera,
        progress=show_frames,
    )
