"""Reader for BVH, Biovision's hierarchy of joints with a row of channels for every frame."""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpma_mj.errors import MotionFileError
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.readers.cells import is_number
from mpma_mj.motions.readers.recording import Recording, Tracks
from mpma_mj.motions.readers.skeleton import (
    AngleCheck,
    Joint,
    ancestry,
    compare_orders,
    compare_sides,
    euler_turn,
    joint_positions,
    root_of_legs,
    tracks_of,
)
from mpma_mj.motions.readers.text import FARTHEST, Grid, TextFile

__all__ = ["is_bvh", "read_bvh"]

Array = NDArray[np.float64]
_Rows = Callable[[Sequence[int], ImportReport], Iterator[Array]]

_CHUNK = 1 << 16  # letters that are read at once: all frames may be on one line
_ROWS = 256  # frames that are turned into numbers at once, where frames are no lines
_CHANNELS = {f"{axis}{kind}" for axis in "XYZ" for kind in ("POSITION", "ROTATION")}
_KEYS = {"ROOT", "JOINT", "END", "OFFSET", "CHANNELS", "MOTION", "{", "}"}
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
    return next((line.split()[0] for line in head if line.strip()), "").upper() == "HIERARCHY"


def read_bvh(file: TextFile, report: ImportReport) -> Recording:
    """Read the hierarchy of a BVH.

    The points are the joints; NAME_end is where the bone of the last joint NAME ends.

    Raises:
        MotionFileError: The hierarchy is damaged.
    """
    words = _words(file)
    try:
        skeleton = _read_hierarchy(words)
        frames = _number(*_header_value(words, "FRAMES"))
        text, line = _header_value(words, "FRAME TIME")
        seconds = _number(text, line)
    except StopIteration:
        raise MotionFileError(
            f"{file.path}: ends within the hierarchy or before the first frame; export it again"
        ) from None
    except ValueError as error:
        raise MotionFileError(f"{file.path}: {error}; export the BVH again") from None
    first = list(itertools.islice(words, skeleton.columns + 1))
    row = [word for word, number in first if number == first[0][1]]
    if first and first[0][1] > line and len(row) == skeleton.columns:
        comma = any("," in word for word in row)
        rows: _Rows = Grid(file, first[0][1] - 1, None, skeleton.columns, comma).blocks
    else:
        rows = _Stream(file, line, skeleton.columns).blocks
    return Recording(
        file.path,
        "BVH",
        tuple(skeleton.names),
        lambda names: _load(file.path, rows if first else None, skeleton, names, report),
        rate=_rate(seconds, text.replace(",", ".")),
        up="y",
        frames=int(frames),
        root=root_of_legs(skeleton.joints),
    )


def _words(file: TextFile) -> Iterator[tuple[str, int]]:
    """Iterate over words and the numbers of their lines; braces are words of their own."""
    rest, number = "", 1
    with file.path.open(encoding=file.encoding, errors="replace") as opened:
        while chunk := opened.read(_CHUNK):
            *lines, rest = re.sub("([{}])", r" \1 ", rest + chunk).split("\n")
            for line in lines:
                yield from ((word, number) for word in line.split())
                number += 1
            if len(rest) > _CHUNK:  # words that are whole need not wait for the line's end
                *whole, last = rest.split() or [""]
                rest = f"{last} " if rest[-1].isspace() else last
                yield from ((word, number) for word in whole)
    yield from ((word, number) for word in rest.split())


def _read_hierarchy(words: Iterator[tuple[str, int]]) -> _Skeleton:
    """Read from HIERARCHY up to MOTION."""
    skeleton = _Skeleton()
    open_joints: list[str] = []  # whose braces are open
    next(words)
    for word, line in words:
        key = word.upper()
        if key in ("ROOT", "JOINT"):
            open_joints.append(_add_joint(skeleton, _joint_name(words, line), open_joints))
        elif key == "MOTION":
            if open_joints:
                raise ValueError(f"line {line}: {len(open_joints)} joints lack their '}}'")
            _check_offsets(skeleton)
            return skeleton
        elif key not in _KEYS:
            raise ValueError(f"line {line}: '{word[:40]}' is no part of a hierarchy")
        elif not open_joints or key == "{":
            raise ValueError(f"line {line}: '{word}' outside a joint")
        elif key == "}":
            open_joints.pop()
        elif key == "END":
            _joint_name(words, line)
            open_joints.append(_add_joint(skeleton, f"{open_joints[-1]}_end", open_joints))
        elif key == "OFFSET":
            _set_offset(skeleton, open_joints[-1], words, line)
        else:
            _add_channels(skeleton, open_joints[-1], words, line)
    raise StopIteration


def _joint_name(words: Iterator[tuple[str, int]], line: int) -> str:
    """Return the words up to the brace that opens a joint."""
    name: list[str] = []
    for word, number in words:
        if word == "{":
            return " ".join(name)
        if number > line and word.upper() in _KEYS:
            raise ValueError(f"line {number}: expected '{{', found '{word}'")
        name.append(word)
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


def _set_offset(
    skeleton: _Skeleton, name: str, words: Iterator[tuple[str, int]], line: int
) -> None:
    cells = list(itertools.islice(words, 3))
    if len(cells) < 3 or any(word.upper() in _KEYS for word, _ in cells):
        raise ValueError(f"line {line}: expected a joint's OFFSET and three numbers")
    if not np.isnan(skeleton.joints[name].offset).any():
        raise ValueError(f"line {line}: a second OFFSET of {name}")
    offset = np.array([_number(word, number) for word, number in cells])
    skeleton.joints[name] = replace(skeleton.joints[name], offset=offset)


def _check_offsets(skeleton: _Skeleton) -> None:
    for name, joint in skeleton.joints.items():
        if np.isnan(joint.offset).any():
            raise ValueError(f"{name} has no OFFSET")


def _add_channels(
    skeleton: _Skeleton, name: str, words: Iterator[tuple[str, int]], line: int
) -> None:
    count = next(words)[0]
    cells = itertools.islice(words, int(count) if count in map(str, range(7)) else 0)
    channels = [word.upper() for word, _ in cells]
    if str(len(channels)) != count or not set(channels) <= _CHANNELS:
        found = " ".join([count, *channels])[:60]
        raise ValueError(
            f"line {line}: '{found}' is not a list of channels, such as 3 Zrotation Xrotation"
            " Yrotation"
        )
    if len(set(channels)) < len(channels) or name in skeleton.turning:
        raise ValueError(f"line {line}: a channel is given twice")
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


def _header_value(words: Iterator[tuple[str, int]], key: str) -> tuple[str, int]:
    """Return the value of the next words, `KEY: value`, and the number of its line."""
    expected = key.split()
    found: list[str] = []
    line = 0
    while len(found) <= len(expected):
        word, line = next(words)
        found += word.replace(":", " ").split()
    if [word.upper() for word in found[:-1]] != expected:
        text = " ".join(found)[:40]
        raise ValueError(f"line {line}: expected '{key.capitalize()}:', found '{text}'")
    return found[-1], line


def _number(word: str, number: int) -> float:
    """Return the number in a word, which may have a decimal comma."""
    text = word.replace(",", ".")
    if not is_number(text) or not abs(float(text)) < FARTHEST:
        raise ValueError(f"line {number}: '{word[:40]}' is not a number")
    return float(text)


@dataclass(frozen=True)
class _Stream:
    """Frames that are not one a line: words after the header's last line.

    Attributes:
        file: The file.
        header: Number of the line of the frame time.
        width: Numbers of a frame.
    """

    file: TextFile
    header: int
    width: int

    def blocks(self, columns: Sequence[int], report: ImportReport) -> Iterator[Array]:
        """Iterate over blocks of frames, as `Grid.blocks` does."""
        words = _words(self.file)
        for word, _ in words:  # up to the frame time
            if word.upper() == "MOTION":
                break
        _header_value(words, "FRAMES")
        _header_value(words, "FRAME TIME")
        frames, line = 0, self.header
        while cells := list(itertools.islice(words, _ROWS * self.width)):
            line = line if frames else cells[0][1]
            if len(cells) % self.width:
                raise MotionFileError(
                    f"{self.file.path}: line {line} has not the {self.width} values of a frame, and"
                    f" the {frames * self.width + len(cells)} values from there are no whole number"
                    " of frames; export the BVH again"
                )
            try:
                block = np.array([_number(*cell) for cell in cells]).reshape(-1, self.width)
            except ValueError as error:
                raise MotionFileError(f"{self.file.path}: {error}; export the BVH again") from None
            if len(block) < _ROWS and self._may_be_cut(cells):
                report.warn(
                    "the file ends without a line break, perhaps within a number; the last frame is"
                    " not used"
                )
                block = block[:-1]
            yield block[:, columns]
            frames += len(block)

    def _may_be_cut(self, cells: list[tuple[str, int]]) -> bool:
        """Return whether the last number may lack digits: all have as many decimals, or it may."""
        decimals = {len(word.replace(",", ".").partition(".")[2]) for word, _ in cells}
        return not self.file.ends_whole and (len(decimals) > 1 or decimals == {0})


def _placed(joint: Joint, places: Array) -> Array:
    """Return a joint's places, shape (T, 3); 0, 0, 0 below the root stands for the offset."""
    if joint.parent is None:
        return places
    return np.where(places.any(axis=1, keepdims=True), places, joint.offset)


def _load(
    path: Path,
    rows: _Rows | None,
    skeleton: _Skeleton,
    names: Sequence[str],
    report: ImportReport,
) -> Tracks:
    """Compute where joints are, each shape (T, 3)."""
    if rows is None:
        raise MotionFileError(f"{path}: has a hierarchy but no frames; export the motion too")
    chain = ancestry(skeleton.joints, names)
    offsets = {name: joint.offset for name, joint in skeleton.joints.items()}
    compare_sides("offset", offsets, chain, report)
    compare_orders(skeleton.joints, report)
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
    check = AngleCheck(path, report)

    def positions(block: Array) -> Array:
        check.begin(len(block))

        def turn(name: str) -> Array | None:
            joint = skeleton.joints[name]
            if name not in turning:
                return None
            return euler_turn(joint, check.check(joint, np.radians(block[:, turning[name]])))

        translations = {
            name: _placed(skeleton.joints[name], block[:, where]) for name, where in moving.items()
        }
        translations.setdefault(chain[0], np.zeros((len(block), 3)))
        return joint_positions(skeleton.joints, names, turn, translations)

    return tracks_of(map(positions, rows(columns, report)), names)
