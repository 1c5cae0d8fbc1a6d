"""Reader for videos: shoulders, elbows, wrists and hips of one person, frame by frame."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mpma_mj.errors import BadOptionError, MotionFileError
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.options import ReadingOptions, given
from mpma_mj.motions.readers.recording import Recording, Tracks
from mpma_mj.motions.readers.video.detector import LANDMARKS, Pose, pose_detector
from mpma_mj.motions.readers.video.frames import Clip, open_clip
from mpma_mj.motions.readers.video.view import bridge_end_on, check_view
from mpma_mj.utils.text import listing

__all__ = ["FORMAT", "read_video"]

Array = NDArray[np.float64]

FORMAT = "video"

# Options for recordings of points; a video has its own points, axes, unit and rate.
_OF_POINTS = {"map", "skeleton", "unit", "up", "left_handed", "rate_in"}
_FEWEST = 8  # frames
_SEEN = 0.5  # visibility from which a point counts as seen
_UNSURE = 0.8  # usual visibility of a point below which it may be a guess (choice, as measured)
_OUTSIDE = 0.02  # of the picture's side, by which a point that is seen may be outside of it
_HARDLY = 0.1  # share of the frames, below which a person or a point is not there (choice)
_SEARCH_EVERY = 1.0  # s, for another person (choice)
_OFTEN = 0.5  # share of those searches, from which the video is one of two people (choice)
_JUMP = 0.5  # of the trunk's length from one frame to the next, which no hips move (choice)


class People(NamedTuple):
    """People that are found in a video.

    Attributes:
        poses: The person in each frame, None where nobody is found.
        others: For each frame that was searched for it, whether there is another person.
        size: Width and height of the picture, pixels.
    """

    poses: tuple[Pose | None, ...]
    others: dict[int, bool]
    size: tuple[int, int]


def read_video(path: Path, options: ReadingOptions, report: ImportReport) -> Recording:
    """Find a person in a video, and read it as a recording of points.

    Args:
        path: The video.
        options: How to read it; frames outside of `start` and `end` are not looked at.
        report: Gets what is doubtful.

    Raises:
        BadOptionError: An option is one of other recordings, or mediapipe is not installed.
        MotionFileError: The video cannot be decoded, or does not show one person with arms.
    """
    if refused := given(options) & _OF_POINTS:
        raise BadOptionError(
            f"{path}: is a video",
            remedy=f"leave out {{{min(refused)}}}, which is for recordings of points",
        )
    clip = open_clip(path, options.start, options.end)
    file = path.stat()
    people = _find_people(clip, file.st_mtime_ns, file.st_size)
    report.warn(
        "poses from a video are experimental: "
        + (
            "directions within the frontal plane are off by some 4°, at times by 20°, and what"
            " points forward is taken as flat"
            if options.depth == "flat"
            else "with estimated depth directions are off by 8° to 40°, of forearms most"
        ),
        remedy="dance frontally, the whole body in the picture",
    )
    _check_people(clip, people, report)
    tracks, visibility = _tracks(people, depth=options.depth == "estimated")
    names = _seen_names(path, tracks, visibility, options, report)
    check_view({name: tracks[name] for name in names}, clip.start, clip.rate, report)
    if options.depth == "flat":
        bridge_end_on(tracks)
    before = np.full((clip.frames_before, 3), np.nan)  # which is cut off

    def load(wanted: Sequence[str]) -> Tracks:
        return {name: np.concatenate([before, tracks[name]]) for name in wanted}

    return Recording(
        path, FORMAT, names, load, rate=clip.rate, unit=1.0, up="-y", from_pictures=True
    )


@functools.lru_cache(maxsize=1)  # a tempo that is looked for reads the file many times
def _find_people(clip: Clip, modified: int, size: int) -> People:
    """Find people in all frames of a clip.

    Args:
        clip: The clip.
        modified: Time at which its file was modified, ns, by which a changed file is read again.
        size: Size of its file, bytes; likewise.
    """
    poses: list[Pose | None] = []
    others: dict[int, bool] = {}
    width = height = next_search = 0
    with pose_detector(clip.path) as detector:
        for number, picture in enumerate(clip.frames()):
            height, width = picture.shape[:2]
            pose = detector.find(picture)
            poses.append(pose)
            if pose is not None and number >= next_search:
                others[number] = detector.find_other(picture, pose)
                next_search = number + round(_SEARCH_EVERY * clip.rate)
    return People(tuple(poses), others, (width, height))


def _check_people(clip: Clip, people: People, report: ImportReport) -> None:
    """Refuse what does not show one person, and warn of frames that may show another.

    Raises:
        MotionFileError: There are too few frames, nobody, or two people.
    """
    path, frames = clip.path, len(people.poses)
    if frames < _FEWEST:
        raise MotionFileError(
            f"{path}: has {frames} frame{'s' * (frames != 1)}; a motion needs at least {_FEWEST}"
        )
    if clip.is_cut_short(frames):
        report.warn(
            f"only {frames} of {clip.declared_frames} frames can be decoded: the file is damaged or"
            " cut short"
        )
    found = {i: pose for i, pose in enumerate(people.poses) if pose is not None}
    if len(found) < max(2, _HARDLY * frames):
        where = f"in {len(found)} of" if found else "in any of"
        raise MotionFileError(
            f"{path}: no person is found {where} {frames} frames; film one person from the front,"
            " the whole body in the picture"
        )
    seconds = [clip.start + i / clip.rate for i, other in people.others.items() if other]
    if len(seconds) > _OFTEN * len(people.others):
        raise MotionFileError(
            f"{path}: shows two people or more, as at {seconds[0]:.1f} s; cut the picture to one of"
            " them"
        )
    if seconds:
        report.warn(
            f"another person is in the picture at {listing([f'{s:.1f}' for s in seconds], 5)} s;"
            " check that the same one is followed"
        )
    hips = np.array([pose.places[3::4].mean(axis=0) for pose in found.values()])
    trunk = np.median([pose.trunk for pose in found.values()])
    far = np.linalg.norm(np.diff(hips, axis=0), axis=1) > _JUMP * trunk
    if far.any():
        numbers = np.array([*found])[1:][far]
        jumps = [f"{clip.start + number / clip.rate:.2f}" for number in numbers]
        report.warn(
            f"the person jumps within the picture at {listing(jumps, 5)} s: a cut in the video, or"
            " another person"
        )


def _tracks(people: People, *, depth: bool) -> tuple[Tracks, dict[str, Array]]:
    """Return places of the person's points in m, NaN where not seen, and their visibility.

    x and y are those of the picture, which are more accurate than the detector's in space, scaled
    by the length of the trunk; z is the estimated one, or 0.
    """
    frames = len(people.poses)
    places = np.full((frames, len(LANDMARKS), 3), np.nan)
    visibility = np.zeros((frames, len(LANDMARKS)))
    scales = []
    for i, pose in enumerate(people.poses):
        if pose is None:
            continue
        places[i, :, :2] = pose.places
        places[i, :, 2] = pose.space[:, 2] if depth else 0.0
        visibility[i] = pose.visibility
        trunk = pose.space[[0, 4], :2].mean(axis=0) - pose.space[[3, 7], :2].mean(axis=0)
        scales.append(np.linalg.norm(trunk) / max(pose.trunk, 1.0))
    size = np.array(people.size)
    outside = (places[:, :, :2] < -_OUTSIDE * size) | (places[:, :, :2] > (1.0 + _OUTSIDE) * size)
    places[outside.any(axis=2) | (visibility < _SEEN)] = np.nan
    places[:, :, :2] *= np.median(scales)
    tracks = {name: places[:, i].copy() for i, name in enumerate(LANDMARKS)}
    return tracks, {name: visibility[:, i] for i, name in enumerate(LANDMARKS)}


def _seen_names(
    path: Path,
    tracks: Tracks,
    visibility: dict[str, Array],
    options: ReadingOptions,
    report: ImportReport,
) -> tuple[str, ...]:
    """Return the points that are seen: without hips that are not, nor an arm that may be missing.

    Raises:
        MotionFileError: An arm is not seen.
    """
    share = {name: float(np.isfinite(track[:, 0]).mean()) for name, track in tracks.items()}
    unseen = [name for name in tracks if share[name] < _HARDLY]
    hips = [name for name in tracks if name.endswith("hip")]
    if any(share[name] < _OFTEN for name in hips):
        unseen = [*dict.fromkeys([*unseen, *hips])]
        report.note("hips are hardly in the picture, and left out")
    arms = [name for name in unseen if name not in hips]
    sides = {name.split("_")[0] for name in arms}
    if len(sides) == 2 or (sides and options.other_arm is None):
        raise MotionFileError(
            f"{path}: the person's {', '.join(arms).replace('_', ' ')} cannot be seen in most"
            " frames; film the whole body from the front"
            + ("" if len(sides) == 2 else ", or let the other arm hang with {other_arm=hang}")
        )
    if sides:
        unseen += [f"{side}_{part}" for side in sides for part in ("elbow", "wrist")]
    names = tuple(name for name in tracks if name not in unseen)
    unsure = [
        name
        for name in names
        if name not in hips and np.median(visibility[name][visibility[name] > 0.0]) < _UNSURE
    ]
    if unsure:
        report.warn(
            f"the {', '.join(unsure).replace('_', ' ')} may be hidden or guessed: the detector is"
            " unsure of it"
        )
    return names
