"""Detector of a person's pose in pictures: BlazePose of mediapipe (Bazarevsky et al. 2020).

Its weights are inside the wheel, so that nothing is downloaded: of the three models only the
middle one is there (`model_complexity=1`).
"""

from __future__ import annotations

import contextlib
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from mpma_mj.errors import BadOptionError, one_line
from mpma_mj.utils.silence import silenced

__all__ = ["LANDMARKS", "Detector", "Pose", "pose_detector"]

Array = NDArray[np.float64]
Picture = NDArray[np.uint8]

LANDMARKS = {
    f"{side}_{part}": first + offset
    for side, offset in (("left", 0), ("right", 1))
    for part, first in (("shoulder", 11), ("elbow", 13), ("wrist", 15), ("hip", 23))
}
"""Number of each point among the detector's landmarks."""

_CONFIDENCE = 0.5  # from which a person is taken as found, the library's default
_MARGIN = 0.15  # of the trunk's length by which hands and hair exceed the landmarks (choice)
_NEAR = 0.4  # of the first person's trunk, from which another is no passer-by far off (choice)


class Pose(NamedTuple):
    """A person in a picture, all arrays in the order of `LANDMARKS`.

    Attributes:
        places: Places in the picture, x to the right and y down, shape (8, 2), pixels.
        space: Places in space, z away from the camera, the origin between the hips, shape (8, 3),
            m, as the detector estimates them.
        visibility: Confidence that each point is seen, shape (8,), 0 to 1.
        extent: Lowest x and y and highest x and y of the whole body, shape (4,), pixels.
    """

    places: Array
    space: Array
    visibility: Array
    extent: Array

    @property
    def trunk(self) -> float:
        """Length of the trunk in the picture, pixels."""
        shoulders, hips = (self.places[i::4].mean(axis=0) for i in (0, 3))
        return float(np.linalg.norm(shoulders - hips))


class Detector(Protocol):
    """Detector of people in pictures, shape (height, width, 3)."""

    def find(self, picture: Picture) -> Pose | None:
        """Return the person, who is followed from picture to picture."""

    def find_other(self, picture: Picture, pose: Pose) -> bool:
        """Return whether there is another person than the one in a pose."""


@contextlib.contextmanager
def pose_detector(path: Path) -> Iterator[Detector]:
    """Open a detector, whose libraries write nothing to the standard error meanwhile.

    Args:
        path: The video, for messages.

    Raises:
        BadOptionError: mediapipe is not installed.
    """
    with silenced(), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            from mediapipe.python.solutions import pose
        except ImportError as error:
            missing = getattr(error, "name", None) == "mediapipe"
            why = "is not installed" if missing else f"cannot be imported ({one_line(error)})"
            raise BadOptionError(
                f"{path}: is a video, and reading one needs mediapipe 0.10.14, which {why}; in the"
                " checkout, pip install -e '.[video]'"
            ) from None
        fixed = {"model_complexity": 1, "min_detection_confidence": _CONFIDENCE}
        # Landmarks are not smoothed, which delays them; the recording is filtered without delay.
        with (
            pose.Pose(smooth_landmarks=False, **fixed) as following,
            pose.Pose(static_image_mode=True, **fixed) as looking,
        ):
            yield _Mediapipe(following, looking)


class _Mediapipe:
    """The detector of mediapipe, which follows one person, and one that looks at each picture."""

    def __init__(self, following: Any, looking: Any) -> None:
        self._following, self._looking = following, looking

    def find(self, picture: Picture) -> Pose | None:
        return _pose(self._following.process(picture), picture)

    def find_other(self, picture: Picture, pose: Pose) -> bool:
        low, high = pose.extent[:2], pose.extent[2:]
        margin = _MARGIN * pose.trunk
        (left, top), (right, bottom) = (
            np.clip(edge, 0, picture.shape[1::-1]).astype(int)
            for edge in (low - margin, high + margin)
        )
        painted = picture.copy()
        painted[top : bottom + 1, left : right + 1] = picture.mean(axis=(0, 1))
        other = _pose(self._looking.process(painted), painted)
        return other is not None and other.trunk > _NEAR * pose.trunk


def _pose(found: Any, picture: Picture) -> Pose | None:
    """Return a pose of what the library found."""
    if found.pose_landmarks is None or found.pose_world_landmarks is None:
        return None
    size = np.array(picture.shape[1::-1], np.float64)
    points, space = found.pose_landmarks.landmark, found.pose_world_landmarks.landmark
    body = np.array([[point.x, point.y] for point in points]) * size
    numbers = list(LANDMARKS.values())
    return Pose(
        body[numbers],
        np.array([[space[i].x, space[i].y, space[i].z] for i in numbers]),
        np.array([points[i].visibility for i in numbers]),
        np.concatenate([body.min(axis=0), body.max(axis=0)]),
    )
