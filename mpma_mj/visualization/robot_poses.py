"""Picture of a robot in plain poses, in which faults of its description are seen."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import mujoco
import numpy as np
from numpy.typing import NDArray

from mpma_mj.envs.gl_context import BoundContext
from mpma_mj.kinematics import SIDES
from mpma_mj.robots.geometry import POINTS
from mpma_mj.robots.report import PoseResult
from mpma_mj.visualization.colours import INK, hex_to_rgb, module_colours
from mpma_mj.visualization.figure_file import figure_file, fitting

__all__ = ["write_poses"]

Array = NDArray[np.float64]
Picture = NDArray[np.uint8]

_CAMERAS = ("front", "three_quarter")
_WIDTH, _HEIGHT = 480, 400  # pixels of a picture
_INCHES = 3.4  # width of a picture on the page
_SEGMENT, _WANTED = 0.025, 0.012  # radii of lines, in lengths of an arm
_COLOURS = dict(zip(SIDES, module_colours(2), strict=True))


def write_poses(
    path: Path,
    model: mujoco.MjModel,
    joints: Sequence[str],
    poses: Mapping[str, PoseResult],
    title: str,
) -> None:
    """Draw a robot in poses, each from in front and from the side, with a caption.

    The segments that take part in imitation, from shoulder over elbow to wrist, are drawn in blue
    on the left and in orange on the right, and thin black lines show where they should be.

    Args:
        path: The PNG file.
        model: The robot, assembled.
        joints: Names of its eight joints.
        poses: How near it comes to each pose, by the pose's name.
        title: Title of the page.

    Raises:
        RenderingError: OpenGL does not draw.
        RunFolderError: The file cannot be written.
    """
    pictures = _pictures(model, joints, poses)
    width, height = _INCHES * len(poses), _INCHES * _HEIGHT / _WIDTH * len(_CAMERAS) + 0.9
    with figure_file(path, width, height) as figure:
        axes = figure.subplots(len(_CAMERAS), len(poses), squeeze=False)
        for column, (name, result) in enumerate(poses.items()):
            for row, _ in enumerate(_CAMERAS):
                axes[row, column].imshow(pictures[name][row])
                axes[row, column].set_axis_off()
            axes[0, column].set_title(name)
            below = {"transform": axes[-1, column].transAxes, "ha": "center", "va": "top"}
            axes[-1, column].text(0.5, -0.02, str(result), **below)
        figure.suptitle(fitting(title, 0.9 * width))


def _pictures(
    model: mujoco.MjModel, joints: Sequence[str], poses: Mapping[str, PoseResult]
) -> dict[str, list[Picture]]:
    """Return the pictures of each pose, one of each camera."""
    buffer = model.vis.global_
    buffer.offwidth, buffer.offheight = max(buffer.offwidth, _WIDTH), max(buffer.offheight, _HEIGHT)
    data = mujoco.MjData(model)
    places = [int(model.joint(name).qposadr[0]) for name in joints]
    options = mujoco.MjvOption()
    options.flags[mujoco.mjtVisFlag.mjVIS_TRANSPARENT] = True  # bones are seen within limbs
    context = BoundContext(lambda: mujoco.Renderer(model, _HEIGHT, _WIDTH), mujoco.Renderer.close)
    try:
        renderer = context.get()
        pictures: dict[str, list[Picture]] = {}
        for name, result in poses.items():
            data.qpos[places] = result.joint_angles
            mujoco.mj_forward(model, data)
            pictures[name] = []
            for camera in _CAMERAS:
                renderer.update_scene(data, camera, options)
                _add_segments(renderer.scene, data, result.directions.reshape(2, 2, 3))
                pictures[name].append(renderer.render().copy())
    finally:
        context.release()
    return pictures


def _add_segments(scene: mujoco.MjvScene, data: mujoco.MjData, wanted: Array) -> None:
    """Add lines along the segments of both arms, and lines where they should be."""
    for side, directions in zip(SIDES, wanted, strict=True):
        points = [data.site(f"{side}_{point}").xpos for point in POINTS]
        lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
        goal = points[0]
        for start, end, length, direction in zip(
            points[:-1], points[1:], lengths, directions, strict=True
        ):
            next_goal = goal + length * direction
            _add_line(scene, goal, next_goal, _WANTED * lengths.sum(), INK)
            _add_line(scene, start, end, _SEGMENT * lengths.sum(), _COLOURS[side])
            goal = next_goal


def _add_line(scene: mujoco.MjvScene, start: Array, end: Array, radius: float, colour: str) -> None:
    kind, geom = mujoco.mjtGeom.mjGEOM_CAPSULE, scene.geoms[scene.ngeom]
    rgba = np.array([*(value / 255.0 for value in hex_to_rgb(colour)), 1.0], np.float32)
    mujoco.mjv_initGeom(geom, kind, np.full(3, radius), start, np.eye(3).ravel(), rgba)
    mujoco.mjv_connector(geom, kind, radius, start, end)
    geom.emission = 0.6
    scene.ngeom += 1
