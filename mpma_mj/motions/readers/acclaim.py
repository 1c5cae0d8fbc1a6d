"""Reader for ASF/AMC, Acclaim's pair of a skeleton and its motion, as CMU and HDM05 use it."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator, Sequence, Set
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpma_mj.errors import MotionFileError, one_line
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.readers.cells import is_number
from mpma_mj.motions.readers.recording import Recording, Tracks
from mpma_mj.motions.readers.skeleton import (
    AngleCheck,
    Joint,
    ancestry,
    compare_sides,
    euler_turn,
    joint_positions,
    tracks_of,
)
from mpma_mj.motions.readers.text import FARTHEST, TextFile
from mpma_mj.utils.input_files import SMALL_FILE, file_problem

__all__ = ["is_amc", "is_asf", "read_acclaim"]

Array = NDArray[np.float64]

_USUAL_RATE = 120.0  # Hz: of CMU's and HDM05's recordings; the format has no place for it
_CHANNELS = {"tx", "ty", "tz", "rx", "ry", "rz", "l"}
_ROUNDED = 3e-3  # of a direction's length, for three decimals
_BLOCK = 2048  # frames that are turned into places at once
_MENDED = "export it again, or give the right {skeleton}"


@dataclass(frozen=True)
class _Skeleton:
    """The joints of an ASF. A bone's joint is where it begins; NAME_end is where it ends."""

    joints: dict[str, Joint]
    channels: dict[str, tuple[str, ...]]  # for each bone what a row of it holds: tx, rx, …
    frames: dict[str, Array]  # for each bone the angles of its axes, degrees
    degrees: bool


def is_asf(head: list[str]) -> bool:
    """Return whether the first lines are those of an ASF."""
    return any(line.split()[:1] in ([":bonedata"], [":units"], [":root"]) for line in head)


def is_amc(head: list[str]) -> bool:
    """Return whether the first lines are those of an AMC."""
    return any(line.strip().upper() in (":FULLY-SPECIFIED", ":DEGREES") for line in head)


def read_acclaim(file: TextFile, skeleton: Path | None, report: ImportReport) -> Recording:
    """Read the skeleton of an AMC.

    Args:
        file: The AMC.
        skeleton: Its ASF; looked for in its folder if not given.
        report: Gets which skeleton is taken, and what is odd.

    Raises:
        MotionFileError: There is no skeleton, or it is damaged.
    """
    path = skeleton or _skeleton_in_folder(file.path, report)
    if problem := file_problem(path, largest=SMALL_FILE):
        raise MotionFileError(f"{path}: {problem}")
    asf = TextFile.open(path)
    if asf is None or not is_asf(asf.head(60)):
        raise MotionFileError(
            f"{path}: is not an ASF skeleton", remedy="give another one with {skeleton}"
        )
    try:
        bones = _read_skeleton(asf, report)
    except (ValueError, IndexError, KeyError) as error:
        raise MotionFileError(
            f"{path}: is damaged or cut short ({one_line(error)})",
            remedy="give another one with {skeleton}",
        ) from None
    report.note(f"skeleton {path.name}")
    report.warn(
        f"AMC files carry no rate; {_USUAL_RATE:g} Hz is used", remedy="{rate_in} overrides it"
    )
    return Recording(
        file.path,
        "ASF/AMC",
        tuple(bones.joints),
        lambda names: _load(file, bones, names, report),
        rate=_USUAL_RATE,
        up="y",
        root="root",
    )


def _skeleton_in_folder(path: Path, report: ImportReport) -> Path:
    """Return the ASF in the same folder whose name begins the AMC's, or the only one."""
    there = sorted(p for p in path.parent.iterdir() if p.suffix.lower() == ".asf")
    fitting = [p for p in there if re.match(rf"{re.escape(p.stem)}(?![^\W_])", path.stem)]
    if fitting:
        return max(fitting, key=lambda p: len(p.stem))
    if len(there) == 1:
        report.warn(
            f"{there[0].name}, the only skeleton in its folder, is used; check that it is of the"
            " same person"
        )
        return there[0]
    names = f" ({', '.join(p.name for p in there)} are there)" if there else ""
    raise MotionFileError(
        f"{path}: needs its skeleton, an .asf file, which is not in its folder{names}",
        remedy="give it with {skeleton}",
    )


def _read_skeleton(file: TextFile, report: ImportReport) -> _Skeleton:
    sections: dict[str, list[list[str]]] = {}
    section: list[list[str]] = []
    for line in file.lines():
        words = line.split("#")[0].split()
        if words and words[0].startswith(":"):
            section = sections.setdefault(words[0].lower(), [])
        elif words:
            section.append(words)
    units = {words[0].lower(): words[1].lower() for words in sections[":units"]}
    degrees = units.get("angle", "deg").startswith("deg")
    root = {words[0].lower(): words[1:] for words in sections[":root"]}
    bones = dict(_read_bones(sections[":bonedata"]))
    parents = {}
    if sections[":hierarchy"][-1] != ["end"]:
        raise ValueError("no end of the hierarchy")
    for words in sections[":hierarchy"][1:-1]:
        parents.update(dict.fromkeys(words[1:], words[0]))
    turn = 180.0 / np.pi if not degrees else 1.0
    frame = _frame(turn * _numbers(root["orientation"]), root["axis"][0])
    order = tuple(word.lower() for word in root["order"])
    _check_channels("root", order, needed={"tx", "ty", "tz"})
    joints = {"root": Joint("root", None, np.zeros(3), _axes(order), frame)}
    channels, frames = {"root": order}, {}
    for name, parent in _parents_first(parents):
        bone = bones[name]
        dof = tuple(word.lower() for word in bone.get("dof", []))
        _check_channels(name, dof)
        frames[name] = turn * _numbers(bone["axis"][:3])
        direction = _numbers(bone["direction"])
        if direction.shape != (3,):
            raise ValueError(f"{name} has the direction {' '.join(bone['direction'])}")
        if abs(np.linalg.norm(direction) - 1.0) > _ROUNDED:
            report.warn(
                f"the direction of {name} has the length {np.linalg.norm(direction):.4g} instead of"
                " 1; check it in the skeleton"
            )
        way = direction * _numbers(bone["length"])
        begins = joints.get(f"{parent}_end", joints["root"])
        joints[name] = Joint(
            name, parent, begins.offset, _axes(dof), _frame(frames[name], bone["axis"][3])
        )
        joints[f"{name}_end"] = Joint(f"{name}_end", name, way, "", np.eye(3))
        channels[name] = dof
    return _Skeleton(joints, channels, frames, degrees)


def _parents_first(parents: dict[str, str]) -> list[tuple[str, str]]:
    """Return bones and their parents, level by level from the root, in the file's order."""
    children: dict[str, list[tuple[int, str]]] = {}
    for number, (name, parent) in enumerate(parents.items()):
        children.setdefault(parent, []).append((number, name))
    found: list[tuple[str, str]] = []
    level = children.pop("root", [])
    while level:
        found += [(name, parents[name]) for _, name in level]
        level = sorted(child for _, name in level for child in children.pop(name, []))
    if children:
        raise ValueError(f"bone {next(iter(children.values()))[0][1]} has no parent")
    return found


def _check_channels(bone: str, channels: Sequence[str], needed: Set[str] = frozenset()) -> None:
    """Check a bone's degrees of freedom, each of which is given once."""
    if not needed <= set(channels) <= _CHANNELS or len(set(channels)) < len(channels):
        raise ValueError(f"{bone} has the channels {' '.join(channels)}")


def _read_bones(section: list[list[str]]) -> Iterator[tuple[str, dict[str, list[str]]]]:
    """Iterate over the bones' names and entries."""
    bone: dict[str, list[str]] | None = None
    for words in section:
        key = words[0].lower()
        if words == ["begin"] and bone is None:
            bone = {}
        elif bone is None or key in ("begin", *bone):
            raise ValueError(f"'{' '.join(words)[:40]}' is not where bones have it")
        elif words == ["end"]:
            yield bone["name"][0], bone
            bone = None
        elif key[0].isalpha():  # limits go on with lines of numbers
            bone[key] = words[1:]


def _axes(channels: Sequence[str]) -> str:
    """Return the axes of a bone's rotation channels, the one that turns last first."""
    return "".join(c[1].upper() for c in reversed(channels) if c.startswith("r"))


def _numbers(words: Sequence[str]) -> Array:
    numbers = np.array(words, float)
    if not (np.abs(numbers) < FARTHEST).all():
        raise ValueError(f"{' '.join(words)} are not lengths or angles")
    return numbers


def _frame(angles: Array, order: str) -> Array:
    """Return the rotation of a bone's axes from angles in degrees, about fixed axes in order."""
    from scipy.spatial.transform import Rotation  # slow to import, needed by few runs

    return Rotation.from_euler(order.lower(), angles, degrees=True).as_matrix()


def _load(
    file: TextFile, skeleton: _Skeleton, names: Sequence[str], report: ImportReport
) -> Tracks:
    """Compute where joints are, each shape (T, 3)."""
    chain = ancestry(skeleton.joints, names)
    offsets = {name: joint.offset for name, joint in skeleton.joints.items()}
    compare_sides("offset", offsets, chain, report)
    compare_sides("axis", skeleton.frames, chain, report)
    channels = {name: skeleton.channels[name] for name in chain if name in skeleton.channels}
    bones = {name: given for name, given in channels.items() if given}
    places = {}
    column = 0
    for name, given in bones.items():
        places[name] = {channel: column + i for i, channel in enumerate(given)}
        column += len(given)
    unit = np.pi / 180.0 if skeleton.degrees else 1.0

    turning = {
        name: [place[c] for c in reversed(place) if c.startswith("r")]
        for name, place in places.items()
    }
    shift = [places["root"][axis] for axis in ("tx", "ty", "tz")]
    check = AngleCheck(file.path, report)

    def positions(rows: list[list[float]]) -> Array:
        block = np.array(rows)
        check.begin(len(block))

        def turn(name: str) -> Array | None:
            joint = skeleton.joints[name]
            if not turning.get(name):
                return None
            return euler_turn(joint, check.check(joint, unit * block[:, turning[name]]))

        return joint_positions(skeleton.joints, names, turn, {"root": block[:, shift]})

    frames = _frames(file, channels, report)
    blocks = iter(lambda: list(itertools.islice(frames, _BLOCK)), [])
    tracks = tracks_of(map(positions, blocks), names)
    if not len(tracks[names[0]]):
        raise MotionFileError(f"{file.path}: has no frames; export the motion again")
    return tracks


def _frames(
    file: TextFile, channels: dict[str, tuple[str, ...]], report: ImportReport
) -> Iterator[list[float]]:
    """Iterate over the frames' values of some bones, of which some do not turn."""
    bones = [name for name, given in channels.items() if given]
    values: dict[str, list[float]] = {}
    rows = bones_a_frame = 0
    number = ""
    for index, line in enumerate(file.lines(), 1):
        words = line.split()
        if len(words) == 1 and words[0].isdigit():
            if number:
                yield _frame_values(file.path, number, bones, values)
                bones_a_frame = bones_a_frame or rows
                if int(words[0]) != int(number) + 1:
                    report.warn(
                        f"line {index}: after frame {number} comes frame {words[0]}; frames are"
                        " treated as consecutive"
                    )
            number, values, rows = words[0], {}, 0
        elif words and words[0] in channels and not number:
            raise MotionFileError(
                f"{file.path}: line {index}: {words[0]} before the number of a frame",
                remedy=_MENDED,
            )
        elif number and words:
            rows += 1
            if words[0] in channels:
                values[words[0]] = _row(file.path, index, words, channels[words[0]])
    if number and rows < bones_a_frame:
        raise MotionFileError(
            f"{file.path}: frame {number}, where the file ends, has {rows} of {bones_a_frame}"
            " bones; export it again, or delete that frame"
        )
    if number and file.ends_whole:
        yield _frame_values(file.path, number, bones, values)
    elif number:
        report.warn(
            f"the file ends in frame {number} without a line break, perhaps within a number; that"
            " frame is not used"
        )


def _row(path: Path, index: int, words: list[str], channels: Sequence[str]) -> list[float]:
    if len(words) != 1 + len(channels) or not all(map(is_number, words[1:])):
        raise MotionFileError(
            f"{path}: line {index}: expected {words[0]} and {len(channels)} numbers, found"
            f" '{' '.join(words)[:60]}'",
            remedy=_MENDED,
        )
    return [float(word) for word in words[1:]]


def _frame_values(
    path: Path, number: str, bones: Sequence[str], values: dict[str, list[float]]
) -> list[float]:
    missing = [name for name in bones if name not in values]
    if missing:
        raise MotionFileError(
            f"{path}: frame {number} lacks {missing[0]}",
            remedy=_MENDED,
        )
    return [value for name in bones for value in values[name]]
