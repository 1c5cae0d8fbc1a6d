"""Pages of scenes: one file for a browser, which needs no network."""

from __future__ import annotations

import contextlib
import html
import io
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mpma_mj.envs.cameras import free_camera
from mpma_mj.utils.atomic_files import write_text
from mpma_mj.visualization.colours import hex_to_rgb, module_colours
from mpma_mj.visualization.episode import EpisodeArms
from mpma_mj.visualization.scene import Scene
from mpma_mj.visualization.video import Progress
from mpma_mj.visualization.viser_arms import ArmNodes, GhostNodes, require_web

if TYPE_CHECKING:
    import mujoco
    import viser

__all__ = ["write_html"]

Array = NDArray[np.float64]

# All of these are choices.
_FIELD = 50.0  # vertical field of view, degrees
_BARS = 0.5  # width of all bars, and height of the bar of responsibility 1, m
_FLAT = 1e-3  # least height of a bar, m
_LABEL = 0.3  # height of the label, m
_ASIDE, _BELOW = 0.38, 0.18  # where the bars begin, from the middle, relative to its distance
_UP = np.array([0.0, 0.0, 1.0])


def write_html(path: Path, scene: Scene, progress: Progress = iter) -> None:
    """Write a page that plays a scene: arms, ghost, bars of responsibilities, and label.

    Args:
        path: The `.html` file.
        scene: What is shown; the page has a size of its own, and the mouse turns its view.
        progress: Wraps the range of frames to show progress.

    Raises:
        MpmaError: viser is not installed.
        BadOptionError: The environment's model cannot be read, or has no such camera.
        RunFolderError: The file cannot be written.
    """
    require_web()
    import viser

    arms, moments = EpisodeArms(scene.trace, scene.options, scene.motion.angles_of), scene.moments
    physics = arms.physics
    # viser has no scene without a server, which prints its address also where it is not verbose.
    with contextlib.redirect_stdout(io.StringIO()), contextlib.ExitStack() as stack:
        server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
        stack.callback(server.stop)
        view = free_camera(physics, scene.camera)
        ahead = _look(server, view)
        nodes = ArmNodes(server.scene, physics.model.ptr, physics.data.ptr)
        ghost = GhostNodes(server.scene, physics.segment_lengths)
        captions = _Captions(server.scene, scene, view, ahead) if scene.captions else None
        recording = server.get_scene_serializer()
        for frame in progress(range(len(moments))):
            ghost.update(physics.site_positions(arms.pose(moments[frame])))
            nodes.update(physics.data.ptr)
            if captions is not None:
                captions.update(int(moments[frame]))
            recording.insert_sleep(1.0 / scene.rate)
        page = recording.as_html()
    title = f"<title>{html.escape(scene.motion.name)}</title>"
    write_text(path, page.replace("<title>Viser</title>", title, 1))


def _look(server: viser.ViserServer, view: mujoco.MjvCamera) -> Array:
    """Look at the scene as a camera does, and return the direction, shape (3,).

    Lights are viser's own: a page that begins again resets those that were changed.
    """
    turn, tilt = np.radians([view.azimuth, view.elevation])
    ahead = np.array([np.cos(turn) * np.cos(tilt), np.sin(turn) * np.cos(tilt), np.sin(tilt)])
    server.initial_camera.position = view.lookat - view.distance * ahead
    server.initial_camera.look_at = view.lookat
    server.initial_camera.fov = float(np.radians(_FIELD))
    return ahead


class _Captions:
    """Bars of responsibilities and the label, to the right of the arms as the page opens."""

    def __init__(
        self, nodes: viser.SceneApi, scene: Scene, view: mujoco.MjvCamera, ahead: Array
    ) -> None:
        self._shares, self._labels = scene.shares[0], scene.labels
        count = self._shares.shape[1]
        right = np.cross(ahead, _UP)
        right /= max(float(np.linalg.norm(right)), 1e-9)
        foot = view.lookat + view.distance * (_ASIDE * right - _BELOW * _UP)
        turn = float(np.arctan2(right[1], right[0])) / 2.0
        width = _BARS / count
        self._bars = []
        self._feet = foot + np.outer((np.arange(count) + 0.5) * width, right)
        for number, colour in enumerate(module_colours(count)):
            self._bars.append(
                nodes.add_box(
                    f"/responsibility/{number + 1}",
                    hex_to_rgb(colour),
                    (0.9 * width, 0.9 * width, _BARS),
                    wxyz=(np.cos(turn), 0.0, 0.0, np.sin(turn)),
                    position=self._feet[number],
                    cast_shadow=False,
                )
            )
        self._label = nodes.add_label(
            "/label",
            "",
            font_size_mode="scene",
            font_scene_height=_LABEL,
            anchor="bottom-center",
            position=foot + _BARS * (0.5 * right + 1.2 * _UP),
        )

    def update(self, step: int) -> None:
        """Show a step."""
        heights = np.maximum(self._shares[step].round(2), _FLAT / _BARS)  # a smaller file
        for bar, foot, height in zip(self._bars, self._feet, heights, strict=True):
            bar.scale = (1.0, 1.0, float(height))
            bar.position = foot + _BARS * height / 2.0 * _UP
        label = self._labels[step]
        self._label.text, self._label.visible = label, bool(label)
