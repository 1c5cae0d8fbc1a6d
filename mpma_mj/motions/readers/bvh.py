"""Reader for BVH, Biovision's hierarchy of joints with a row of channels for every frame."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpma_mj.errors import MotionFileError
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.readers.recording import Recording, Tracks
from mpma_mj.motions.readers.skeleton import (
    Joint,
    ancestry,
    euler_turns,
    joint_positions,
    tracks_of,
)
from mpma_mj.motions.readers.text import FARTHEST, Grid, TextFile, is_number, printable

__all__ = ["is_bvh", "read_bvh"]

Array = NDArray[np.float64]

_MOST_LINES = 50_000  # of a hierarchy: hands and faces have hundreds of joints
_SHORTEST = 1e-6  # s between frames


@dataclass
class _Skeleton:
    """A hierarchy, and which column of a row turns or moves which joint."""

    joints: dict[str, Joint] = field(default_factory=dict)
    names: list[str] = field(default_factory=list)  # in the file's order, double ones twice
    twice: int = 0  # how many of them
    turning: dict[str, list[int]] = field(default_factory=dict)
    moving: dict[str, list[int]] = field(default_factory=dict)  # columns of x, y, z
    columns: int = 0


def is_bvh(head: list[str]) -> bool:
    """Return whether the first lines are those of a BVH."""
    return next((line.strip() for line in head if line.strip()), "").upper() == "HIERARCHY"


def read_bvh(file: TextFile, report: ImportReport) -> Recording:
    """Read the hierarchy of a BVH.

    The points are the joints; NAME_end is where the bone of the last joint NAME ends.

    Raises:
        MotionFileError: The hierarchy is damaged.
    """
    lines = enumerate(map(printable, itertools.islice(file.lines(), _MOST_LINES)), 1)
    try:
        skeleton = _read_hierarchy(lines)
        frames = _number(*_header_value(lines, "FRAMES"))
        frame_time = _header_value(lines, "FRAME TIME")
        seconds = _number(*frame_time)
    except StopIteration:
        raise MotionFileError(
            f"{file.path}: ends within the hierarchy or before the first frame; export it again"
        ) from None
    except (ValueError, IndexError) as error:
        raise MotionFileError(f"{file.path}: {error}; export the BVH again") from None
    number, row = next(((n, row) for n, row in lines if row.strip()), (0, ""))
    if row and len(row.split()) != skeleton.columns:
        raise MotionFileError(
            f"{file.path}: line {number} has {len(row.split())} values, but the hierarchy has"
            f" {skeleton.columns} channels; export the BVH again"
        )
    grid = Grid(file, number - 1, None, skeleton.columns)
    return Recording(
        file.path,
        "BVH",
        tuple(skeleton.names),
        lambda names: _load(file.path, grid if row else None, skeleton, names, report),
        rate=_rate(seconds, frame_time[0]),
        up="y",
        frames=int(frames),
    )


def _read_hierarchy(lines: Iterator[tuple[int, str]]) -> _Skeleton:
    """Read from HIERARCHY up to MOTION."""
    skeleton = _Skeleton()
    open_joints: list[str] = []  # whose braces are open
    name = ""
    for number, line in lines:
        words = line.replace("{", " { ").replace("}", " } ").split()
        key = words[0].upper() if words else ""
        if key in ("ROOT", "JOINT"):
            name = _add_joint(skeleton, " ".join(w for w in words[1:] if w != "{"), open_joints)
        elif key == "END":
            name = _add_joint(skeleton, f"{open_joints[-1]}_end", open_joints)
        elif key == "OFFSET":
            offset = np.array([_number(word, number) for word in words[1:4]])
            if len(offset) < 3 or not name:
                raise ValueError(f"line {number}: expected a joint's OFFSET and three numbers")
            skeleton.joints[name] = replace(skeleton.joints[name], offset=offset)
        elif key == "CHANNELS":
            _add_channels(skeleton, name, words, number)
        elif key == "MOTION":
            _check_offsets(skeleton)
            return skeleton
        if "{" in words:
            open_joints.append(name)
        if "}" in words:
            open_joints.pop()
    raise StopIteration


def _add_joint(skeleton: _Skeleton, name: str, open_joints: list[str]) -> str:
    """Add a joint, and return its unique name: a repeated name gets a number."""
    skeleton.names.append(name)
    if name in skeleton.joints:
        skeleton.twice += 1
        name = f"{name} #{skeleton.twice}"
    parent = open_joints[-1] if open_joints else None
    skeleton.joints[name] = Joint(name, parent, np.full(3, np.nan), "", np.eye(3))
    return name


def _check_offsets(skeleton: _Skeleton) -> None:
    for name, joint in skeleton.joints.items():
        if np.isnan(joint.offset).any():
            raise ValueError(f"{name} has no OFFSET")


def _add_channels(skeleton: _Skeleton, name: str, words: list[str], number: int) -> None:
    channels = [word.upper() for word in words[2:]]
    known = [f"{axis}{kind}" for axis in "XYZ" for kind in ("POSITION", "ROTATION")]
    if len(words) < 2 or str(len(channels)) != words[1] or not set(channels) <= set(known):
        raise ValueError(f"line {number}: '{' '.join(words)[:60]}' is not a list of channels")
    if len(set(channels)) < len(channels) or name in skeleton.turning:
        raise ValueError(f"line {number}: a channel is given twice")
    if not name:
        raise ValueError(f"line {number}: CHANNELS outside a joint")
    place = {channel: skeleton.columns + i for i, channel in enumerate(channels)}
    skeleton.columns += len(channels)
    turns = [channel for channel in channels if channel.endswith("ROTATION")]
    axes = "".join(channel[0] for channel in turns)
    skeleton.joints[name] = replace(skeleton.joints[name], axes=axes)
    skeleton.turning[name] = [place[channel] for channel in turns]
    if all(f"{axis}POSITION" in place for axis in "XYZ"):
        skeleton.moving[name] = [place[f"{axis}POSITION"] for axis in "XYZ"]


def _rate(seconds: float, text: str) -> float | None:
    """Return the frame rate, Hz: a whole one if its frame time is rounded to this one."""
    if seconds < _SHORTEST:
        return None
    whole = max(1, round(1.0 / seconds))
    decimals = len(text.strip().partition(".")[2])
    is_rounded = abs(1.0 / whole - seconds) <= 0.51 * 10.0**-decimals
    is_cut = 0.0 <= 1.0 / whole - seconds < 10.0**-decimals
    return float(whole) if is_rounded or is_cut else 1.0 / seconds


def _header_value(lines: Iterator[tuple[int, str]], key: str) -> tuple[str, int]:
    """Return what the next line, `KEY: value`, gives, and the line's number."""
    number, line = next((n, line) for n, line in lines if line.strip())
    found, _, value = line.partition(":")
    if " ".join(found.upper().split()) != key:
        raise ValueError(f"line {number}: expected '{key.capitalize()}:', found '{line[:40]}'")
    return value, number


def _number(word: str, number: int) -> float:
    if not is_number(word) or not abs(float(word)) < FARTHEST:
        raise ValueError(f"line {number}: '{word.strip()[:40]}' is not a number")
    return float(word)


def _placed(joint: Joint, places: Array) -> Array:
    """Return a joint's places, shape (T, 3); 0, 0, 0 below the root stands for the offset."""
    if joint.parent is None:
        return places
    return np.where(places.any(axis=1, keepdims=True), places, joint.offset)


def _load(
    path: Path,
    grid: Grid | None,
    skeleton: _Skeleton,
    names: Sequence[str],
    report: ImportReport,
) -> Tracks:
    """Compute where joints are, each shape (T, 3)."""
    chain = ancestry(skeleton.joints, names)
    columns = sorted(
        {
            c
            for name in chain
            for of in (skeleton.turning, skeleton.moving)
            for c in of.get(name, ())
        }
    )
    place = {column: i for i, column in enumerate(columns)}
    turning, moving = (
        {name: [place[c] for c in of[name]] for name in chain if of.get(name)}
        for of in (skeleton.turning, skeleton.moving)
    )

    def positions(block: Array) -> Array:
        angles = {name: np.radians(block[:, where]) for name, where in turning.items()}
        translations = {
            name: _placed(skeleton.joints[name], block[:, where]) for name, where in moving.items()
        }
        translations.setdefault(chain[0], np.zeros((len(block), 3)))
        turns = euler_turns(skeleton.joints, angles)
        return joint_positions(skeleton.joints, names, turns, translations)

    if grid is None:
        raise MotionFileError(f"{path}: has a hierarchy but no frames; export the motion too")
    return tracks_of(map(positions, grid.blocks(columns, report)), names)
