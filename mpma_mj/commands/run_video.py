"""Videos of runs, for the commands that train."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mpma_mj.envs.gl import require_backend
from mpma_mj.errors import RenderingError

if TYPE_CHECKING:
    from mpma_mj.training.run_folder import RunFolder
    from mpma_mj.visualization.scene import Scene

__all__ = ["missing_opengl", "run_scene", "write_run_video"]


def missing_opengl() -> str | None:
    """Look for OpenGL before a long computation; return the message to print after it, if any."""
    try:
        require_backend()
    except RenderingError as error:
        return f"mpma: {error}"
    return None


def run_scene(folder: RunFolder) -> Scene:
    """Return the scene of a run's best epoch.

    Raises:
        MpmaError: The run is damaged.
    """
    from mpma_mj.envs.soundtrack import Soundtrack
    from mpma_mj.visualization.scene import Scene

    trace, motion, options = folder.read_trace(), folder.read_motion(), folder.read_config().env
    sound = Soundtrack.of(folder.sound, motion, len(trace), options.repeats)
    return Scene(trace, motion, options, sound=sound)


def write_run_video(folder: RunFolder) -> None:
    """Write the video of a run to its folder.

    Raises:
        RenderingError: OpenGL does not draw.
        VideoError: The encoder is missing, or fails.
        MpmaError: The run is damaged.
    """
    from mpma_mj.utils.progress import show_frames
    from mpma_mj.visualization.video import write_video

    write_video(folder.video, run_scene(folder), show_frames)
