"""Reader for landmarks in JSON: a list of frames, or a frame a line, as pose estimators write them.

A frame is a list of points, or an object that holds one, perhaps with its time; a point is [x, y,
z], or an object with x, y, z and perhaps a name; or an object has the points by name. World
landmarks are preferred to those in the picture.
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from types import NoneType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpma_mj.errors import MotionFileError
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.readers.cells import positive, seconds_of
from mpma_mj.motions.readers.joint_arrays import FEWEST, NAME_LISTS, Joints, read_joints
from mpma_mj.motions.readers.recording import Recording
from mpma_mj.motions.readers.tables.times import arrangement, continuous, rate_of
from mpma_mj.motions.readers.tables.titles import is_rate, is_time, time_unit
from mpma_mj.motions.readers.text import FARTHEST, TextFile

__all__ = ["is_json", "read_landmarks"]

_LARGEST = 1 << 25  # bytes: as objects of Python they take up to fifty times as much memory
_FRAMES = ("frames", "poses", "data", "results", "sequence", "instance_info")
# What holds a frame's points, the places in space first.
_POINTS = (
    *("pose_world_landmarks", "poseworldlandmarks", "world_landmarks", "worldlandmarks"),
    *("pose_keypoints_3d", "keypoints3d", "keypoints_3d", "joints3d", "joints_3d"),
    *("pose_landmarks", "poselandmarks"),
    *("landmarks", "landmark", "keypoints", "joints", "points", "markers", "positions", "pose"),
    *("joint_positions", "bodies", "instances", "people"),
)
_PLACES = ("position", "pos", "location", "translation")  # of a point that has more than that
_NAMES = ("name", "label", "part", "joint", "keypoint", "id", "index")
_MOST = 2000  # points
_EXPECTED = 'expected a list of frames, each a list of points {"x": …, "y": …, "z": …} or [x, y, z]'

Array = NDArray[np.float64]
Point = tuple[float, float, float]


def is_json(head: list[str]) -> bool:
    """Return whether the first lines are those of a JSON document."""
    first = next((line.strip() for line in head if line.strip()), "")
    return first[:1] == "{" or (first[:1] == "[" and first[1:].lstrip()[:1] in ("", *'[{"]nN-0.1'))


def read_landmarks(file: TextFile, report: ImportReport) -> Recording:
    """Read landmarks.

    Raises:
        MotionFileError: It is no JSON, or one without landmarks in space.
    """
    path = file.path
    document = _document(file)
    _refuse_others(path, document)
    top = _lower(document)
    frames = _frames(path, top, document)
    found = [_points(path, number, frame) for number, frame in enumerate(frames, 1)]
    names = tuple(dict.fromkeys(name for points in found for name in points))
    if all(name.isdecimal() and int(name) < _MOST for name in names):
        names = tuple(map(str, range(1 + max(map(int, names), default=-1))))
    if not FEWEST <= len(names) <= _MOST:
        raise MotionFileError(f"{path}: is JSON without points of a body; {_EXPECTED}")
    missing = (math.nan,) * 3
    places = np.array([[points.get(name, missing) for name in names] for points in found])
    if names[0] == "0":
        given: list[Any] = next(
            (top[key] for key in NAME_LISTS if isinstance(top.get(key), list)), []
        )
        names = tuple(map(str, given)) if len(given) == len(names) else ()
    rate = next((positive(str(value)) for key, value in top.items() if is_rate(key)), None)
    titled = _times(frames)
    if titled is not None:
        title, times = titled
        rate = rate_of(times, rate, report, time_unit(title))
        arrange = arrangement(times, None, lambda frame: f"frame {frame + 1}", report)
        places = places if arrange is None else arrange(places)
    return read_joints(path, Joints(places, names), report, format_name="JSON", rate=rate)


def _frames(path: Path, top: dict[str, Any], document: Any) -> list[Any]:
    """Return the list of frames in a document, or make it of tracks by name."""
    tracks = {name: track for name, track in top.items() if _is_track(track)}
    if len(tracks) >= FEWEST and len({len(track) for track in tracks.values()}) == 1:
        rows = zip(*tracks.values(), strict=True)
        return [dict(zip(tracks, row, strict=True)) for row in rows]
    frames = next((top[key] for key in _FRAMES if isinstance(top.get(key), list)), document)
    if not isinstance(frames, list):
        raise MotionFileError(f"{path}: is JSON without a list of frames; {_EXPECTED}")
    return frames


def _lower(value: Any) -> dict[str, Any]:
    """Return an object with keys in lower case; of anything else an empty one."""
    return {str(k).lower(): v for k, v in value.items()} if isinstance(value, dict) else {}


def _is_track(value: Any) -> bool:
    """Return whether a value is a point in every frame."""
    return (
        isinstance(value, list)
        and bool(value)
        and all(_place(point) is not None for point in value)
    )


def _document(file: TextFile) -> Any:
    """Return the content of a file, of which each line may be a document."""
    path = file.path
    size = path.stat().st_size
    if size > _LARGEST:
        raise MotionFileError(f"{path}: is {size >> 20} MB of JSON; save the points as npz")
    text = path.read_text(file.encoding, errors="replace")
    try:
        try:
            return json.loads(text)
        except json.JSONDecodeError as error:
            if not error.msg.startswith("Extra data"):
                raise
            return [json.loads(line) for line in text.splitlines() if line.strip()]
    except json.JSONDecodeError as error:
        raise MotionFileError(
            f"{path}: line {error.lineno}: is damaged or cut short JSON ({error.msg.lower()});"
            " export it again"
        ) from None
    except (RecursionError, ValueError):
        raise MotionFileError(f"{path}: is JSON of another kind; {_EXPECTED}") from None


def _refuse_others(path: Path, document: Any) -> None:
    """Refuse JSON of kinds that are known and hold no landmarks in space."""
    if not isinstance(document, dict):
        return
    if "asset" in document:
        raise MotionFileError(f"{path}: is a glTF scene", remedy="export it as BVH")
    if "people" in document:
        raise MotionFileError(
            f"{path}: is one frame of OpenPose; give three-dimensional joints of all frames in one"
            " file, as a list of such documents"
        )


def _points(path: Path, number: int, frame: Any) -> dict[str, Point]:
    """Return a frame's points by name, or by number where they have no name."""
    frame = _held(frame)
    if isinstance(frame, list) and len(frame) == 1 and _place(frame[0]) is None:
        frame = _held(frame[0])  # one person
    frame = _parted(frame)
    if not frame:
        return {}
    if not isinstance(frame, dict | list):
        raise MotionFileError(f"{path}: frame {number} is '{str(frame)[:40]}'; {_EXPECTED}")
    named = frame if isinstance(frame, dict) else {_name(p, i): p for i, p in enumerate(frame)}
    places = {str(name): _place(point) for name, point in named.items()}
    points = {name: place for name, place in places.items() if place is not None}
    if not points and any(point and isinstance(point, list | dict) for point in named.values()):
        raise MotionFileError(
            f"{path}: frame {number} has several people, or points without x, y, z; {_EXPECTED}"
        )
    for name, point in named.items():
        is_point = isinstance(frame, list) or bool(_lower(point).keys() & set("xyz"))
        if is_point and point and places[str(name)] is None:
            raise MotionFileError(
                f"{path}: frame {number}: point {str(name)[:40]} has no x, y, z; {_EXPECTED}"
            )
    return points


def _held(frame: Any) -> Any:
    """Return what holds the points of a frame."""
    while isinstance(frame, dict):
        lower = _lower(frame)
        key = next((name for name in _POINTS if name in lower), None)
        if key is None:
            break
        frame = lower[key]
    return frame


def _parted(frame: Any) -> Any:
    """Return the points of a flat list x, y, z, or x, y, z and a confidence in 0-1, in turn.

    Triples whose third number is in 0-2 are in a picture: it is a confidence, or COCO's visibility.
    """
    if not isinstance(frame, list) or not all(type(n) in (float, int, NoneType) for n in frame):
        return frame
    shares = len(frame) % 4 == 0 and all(0 <= (share or 0) <= 1 for share in frame[3::4])
    count = 4 if shares else 3
    flat = count == 3 and all(0 <= (share or 0) <= 2 for share in frame[2::3])
    if len(frame) % count or len(frame) < FEWEST * count or flat:
        return frame
    return [frame[i : i + count] for i in range(0, len(frame), count)]


def _name(point: Any, number: int) -> str:
    """Return the name of a point in a list, or its number."""
    if isinstance(point, dict):
        return str(next((point[key] for key in _NAMES if key in point), number))
    return str(number)


def _place(point: Any) -> Point | None:
    """Return x, y, z of a point, NaN for what is no coordinate; None of what is no point."""
    if isinstance(point, dict) and "x" not in point:
        lower = _lower(point)
        point = next((lower[key] for key in _PLACES if key in lower), lower)
    if isinstance(point, dict):
        point = [point.get(axis, "") for axis in "xyz"]
    if not isinstance(point, list) or len(point) not in (3, 4):
        return None
    if not all(type(cell) in (float, int, NoneType) for cell in point[:3]):
        return None
    x, y, z = (math.nan if c is None or not abs(c) < FARTHEST else float(c) for c in point[:3])
    return x, y, z


def _times(frames: list[Any]) -> tuple[str, Array] | None:
    """Return the title of the frames' times, and the times, shape (T,), if all frames have one."""
    rows = [frame if isinstance(frame, dict) else {} for frame in frames]
    title = next((t for t in rows[0] if is_time(t) and all(t in row for row in rows)), None)
    if title is None:
        return None
    return title, continuous(np.array([seconds_of(str(row[title])) for row in rows]))
