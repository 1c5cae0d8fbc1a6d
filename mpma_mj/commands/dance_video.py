"""What commands that make videos have in common."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mpma_mj.envs.gl import require_backend
from mpma_mj.errors import RenderingError

if TYPE_CHECKING:
    from mpma_mj.training.run_folder import RunFolder

__all__ = ["missing_opengl", "write_dance_video"]


def missing_opengl() -> str | None:
    """Look for OpenGL before long work; return what to say after it if there is none."""
    try:
        require_backend()
    except RenderingError as error:
        return f"mpma: {error}"
    return None


def write_dance_video(folder: RunFolder, camera: str) -> None:
    """Make the video of a run and put it into its folder.

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
        camera=camera,
        progress=show_frames,
    )
