"""Videos of runs, for the commands that write them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mpma_mj.envs.gl import require_backend
from mpma_mj.errors import RenderingError

if TYPE_CHECKING:
    from mpma_mj.training.run_folder import RunFolder

__all__ = ["missing_opengl", "write_dance_video"]


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
