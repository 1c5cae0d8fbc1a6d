"""Known points, written as each file format that the readers read."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from itertools import chain
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "AMC_BONES",
    "BVH_JOINTS",
    "Points",
    "arm_points",
    "body_joints",
    "bvh_text",
    "captury_text",
    "grouped_text",
    "header_row_text",
    "long_text",
    "optitrack_text",
    "qualisys_text",
    "trc_text",
    "vicon_text",
    "write_acclaim",
    "write_c3d",
    "write_c3d_of",
    "write_npz",
    "y_up",
]

Array = NDArray[np.float64]
Points = dict[str, Array]

SHOULDERS = {"L": (0.0, 180.0, 1400.0), "R": (0.0, -180.0, 1400.0)}  # mm, z up


def arm_points(
    frames: int = 60, names: Sequence[str] = ("LSHO", "LELB", "LWRI", "RSHO", "RELB", "RWRI")
) -> Points:
    """Return points, mm, z up, of arms that swing beside a body, to three decimals.

    Args:
        frames: Number of frames.
        names: Of left shoulder, elbow and wrist, then of the right ones.
    """
    swing = 0.6 * np.sin(np.arange(frames) / 9.0)
    points = []
    for side, sign in (("L", 1.0), ("R", -1.0)):
        shoulder = np.tile(SHOULDERS[side], (frames, 1))
        upper, lower = sign * swing, sign * swing + 0.4
        down = [
            np.stack([length * np.sin(a), 0.1 * sign * length + 0 * a, -length * np.cos(a)], 1)
            for length, a in ((300.0, upper), (250.0, lower))
        ]
        points += [shoulder, shoulder + down[0], shoulder + down[0] + down[1]]
    return {name: np.round(track, 3) for name, track in zip(names, points, strict=True)}


def body_joints(names: Sequence[str], frames: int = 60) -> Array:
    """Return joints of a body whose arms swing, shape (T, J, 3), mm, z up.

    Args:
        names: Of the joints, such as left_knee; one that is not of a body is far from it.
        frames: Number of frames.
    """
    arms = arm_points(
        frames, [f"{s}_{p}" for s in ("left", "right") for p in ("shoulder", "elbow", "wrist")]
    )
    still = {
        **{
            "pelvis": (0, 0, 900),
            "spine": (0, 0, 1150),
            "neck": (0, 0, 1450),
            "head": (20, 0, 1650),
        },
        **{"thorax": (0, 0, 1400), "nose": (120, 0, 1600), "head_top": (0, 0, 1750)},
    }
    sides = {"hip": (100, 900), "knee": (100, 480), "ankle": (110, 80)}
    for side, sign in (("left", 1), ("right", -1)):
        still |= {f"{side}_{part}": (0, sign * y, z) for part, (y, z) in sides.items()}
    far = {name: (500.0 + 7 * i * i, 900.0, 11.0 * i) for i, name in enumerate(names)}
    tracks = {name: np.tile(place, (frames, 1)) for name, place in (far | still).items()} | arms
    return np.stack([tracks[name] for name in names], axis=1).astype(float)


def y_up(points: Points) -> Points:
    """Return points, z up, in axes of which y is up."""
    return {name: track[:, [1, 2, 0]] for name, track in points.items()}


def qualisys_text(points: Points, rate: float = 100.0, *, lead: Sequence[str] = ()) -> str:
    """Write as Qualisys Track Manager does.

    Args:
        points: Trajectories, mm.
        rate: Hz.
        lead: Columns before the first marker: "Frame", "Time" or both.
    """
    frames = _count(points)
    columns = {"Frame": range(1, frames + 1), "Time": _times(frames, rate)}
    header = [
        f"NO_OF_FRAMES\t{frames}",
        f"NO_OF_MARKERS\t{len(points)}",
        f"FREQUENCY\t{rate:g}",
        "DATA_INCLUDED\t3D",
        "\t".join(["MARKER_NAMES", *points]),
    ]
    if lead:
        header.append("\t".join([*lead, *(f"{n} {axis}" for n in points for axis in "XYZ")]))
    return _joined(header, _rows(points, [columns[title] for title in lead], "\t"))


def trc_text(points: Points, rate: float = 100.0, *, separator: str = "\t") -> str:
    """Write as Motion Analysis and OpenSim do."""
    frames = _count(points)
    lines = [
        ["PathFileType", "4", "(X/Y/Z)", "dance.trc"],
        ["DataRate", "CameraRate", "NumFrames", "NumMarkers", "Units", "OrigDataRate"],
        [f"{rate:g}", f"{rate:g}", str(frames), str(len(points)), "mm", f"{rate:g}"],
        ["Frame#", "Time", *chain.from_iterable([name, "", ""] for name in points)],
        ["", "", *(f"{axis}{i}" for i in range(1, len(points) + 1) for axis in "XYZ")],
        [""],
    ]
    rows = _rows(points, [range(1, frames + 1), _times(frames, rate)], separator)
    return _joined([separator.join(cells) for cells in lines], rows)


def header_row_text(
    points: Points, rate: float = 100.0, *, separator: str = ",", title: str = "{}_{}"
) -> str:
    """Write a table with one header row: time, then name and axis of every column."""
    titles = ["time", *(title.format(name, axis) for name in points for axis in "xyz")]
    rows = _rows(points, [_times(_count(points), rate)], separator)
    return _joined([separator.join(titles)], rows)


def grouped_text(points: Points, rate: float = 100.0) -> str:
    """Write a table with one header row, of all x, then all y, then all z."""
    titles = ["time", *(f"{name}_{axis}" for axis in "xyz" for name in points)]
    by_axis = {f"{axis}{name}": points[name][:, [axis]] for axis in range(3) for name in points}
    return _joined([",".join(titles)], _rows(by_axis, [_times(_count(points), rate)], ","))


def long_text(points: Points, rate: float = 100.0) -> str:
    """Write a table of one point a row."""
    rows = [
        f"{i},{i / rate:.6f},{name},{','.join(f'{value:.3f}' for value in track[i])}"
        for i in range(_count(points))
        for name, track in points.items()
    ]
    return _joined(["frame,time,keypoint,x,y,z"], rows)


def vicon_text(points: Points, rate: float = 100.0, *, separator: str = ",") -> str:
    """Write as Vicon Nexus exports trajectories."""
    frames = _count(points)
    lines = [
        ["Trajectories"],
        [f"{rate:g}"],
        ["", "", *chain.from_iterable([name, "", ""] for name in points)],
        ["Frame", "Sub Frame", *("X", "Y", "Z") * len(points)],
        ["", "", *["mm"] * 3 * len(points)],
    ]
    rows = _rows(points, [range(1, frames + 1), [0] * frames], separator)
    return _joined([separator.join(cells) for cells in lines], rows)


def captury_text(points: Points, *, decimal: str = ".") -> str:
    """Write as Captury Live does: positions and angles, and no rate."""
    frames = _count(points)
    angles = {name: np.full((frames, 3), 45.0) for name in points}
    both = {
        f"{name}{kind}": of[name]
        for name in points
        for kind, of in (("Positions", points), ("Angles", angles))
    }
    lines = [
        ["Recorded at", "2020-02-02 20:20:02", "Recorded with", "", "Exported with", "Live 1.0"],
        ["Frames", str(frames)],
        ["", "", "", *chain.from_iterable([name, "", ""] for name in both)],
        ["Frame", "Sub Frame", "Annotations", *("X", "Y", "Z") * len(both)],
        ["", "", "", *(["mm"] * 3 + ["deg"] * 3) * len(points)],
    ]
    rows = _rows(both, [range(frames), [0] * frames, [""] * frames], ";")
    return _joined([";".join(cells) for cells in lines], [r.replace(".", decimal) for r in rows])


def optitrack_text(points: Points, rate: float = 120.0) -> str:
    """Write as OptiTrack Motive does: for every bone a quaternion, then a place."""
    frames = _count(points)
    unit = np.tile([0.0, 0.0, 0.0, 1.0], (frames, 1))
    lines = [
        [
            *("Format Version", "1.23", "Take Name", "dance", "Capture Frame Rate", "240.000000"),
            *("Export Frame Rate", f"{rate:.6f}", "Total Exported Frames", str(frames)),
            *("Rotation Type", "Quaternion", "Length Units", "Millimeters"),
            *("Coordinate Space", "Global"),
        ],
        [],
        ["", "Type", *["Bone"] * 7 * len(points)],
        ["", "Name", *chain.from_iterable([name] * 7 for name in points)],
        ["", "ID", *["7A"] * 7 * len(points)],
        ["", "", *(["Rotation"] * 4 + ["Position"] * 3) * len(points)],
        ["Frame", "Time (Seconds)", *("X", "Y", "Z", "W", "X", "Y", "Z") * len(points)],
    ]
    both = {name: np.concatenate([unit, track], axis=1) for name, track in points.items()}
    rows = _rows(both, [range(frames), _times(frames, rate)], ",")
    return _joined([",".join(cells) for cells in lines], rows)


def write_npz(path: Path, points: Points, rate: float = 100.0) -> Path:
    """Write an archive of points."""
    with path.open("wb") as file:
        np.savez_compressed(file, rate=rate, unit="mm", up="z", **points)  # type: ignore[arg-type]
    return path


def write_c3d(
    path: Path, points: Points, rate: float = 100.0, *, events: Sequence[tuple[str, float]] = ()
) -> Path:
    """Write a C3D by the usual library, with one analog channel."""
    import ezc3d

    frames = _count(points)
    file = ezc3d.c3d()
    parameters = file["parameters"]
    parameters["POINT"]["RATE"]["value"] = [rate]
    parameters["POINT"]["LABELS"]["value"] = list(points)
    parameters["POINT"]["UNITS"]["value"] = ["mm"]
    parameters["ANALOG"]["RATE"]["value"] = [2 * rate]
    parameters["ANALOG"]["LABELS"]["value"] = ["force"]
    if events:
        file.add_parameter("EVENT", "USED", [len(events)])
        file.add_parameter("EVENT", "CONTEXTS", ["Left"] * len(events))
        file.add_parameter("EVENT", "LABELS", [label for label, _ in events])
        file.add_parameter("EVENT", "TIMES", np.array([divmod(t, 60.0) for _, t in events]).T)
    places = np.stack([track.T for track in points.values()], axis=1)  # (3, points, T)
    file["data"]["points"] = np.concatenate([places, np.ones((1, *places.shape[1:]))])
    file["data"]["analogs"] = np.ones((1, 1, 2 * frames))
    file.write(str(path))
    return path


def write_c3d_of(
    path: Path, points: Points, processor: str, *, whole_numbers: bool, first: int = 1
) -> Path:
    """Write a C3D as another processor stores it, with whole numbers of 0.05 mm or floats.

    Args:
        path: The file.
        points: Trajectories, mm; NaN is not seen.
        processor: "intel", "dec" or "mips", the last with the first byte first.
        whole_numbers: Whether coordinates are 2-byte integers.
        first: Number of the first frame.
    """
    order, code = {"intel": ("<", 84), "dec": ("<", 85), "mips": (">", 86)}[processor]
    scale = 0.05

    def floats(values: Array) -> bytes:
        if processor != "dec":
            return values.astype(f"{order}f4").tobytes()
        halves = (values.astype("<f4") * np.float32(4.0)).view("<u2")  # exponent and halves
        return halves.reshape(-1, 2)[:, ::-1].tobytes()

    def number(value: float) -> bytes:
        return floats(np.array([value]))

    def parameter(name: str, kind: int, shape: Sequence[int], data: bytes) -> bytes:
        content = struct.pack("bB", kind, len(shape)) + bytes(shape) + data + b"\0"
        return entry(name, 1, content)

    def entry(name: str, group: int, content: bytes) -> bytes:
        begin = struct.pack("bb", len(name), group) + name.encode()
        return begin + struct.pack(f"{order}h", 2 + len(content)) + content

    width = max(map(len, points))
    labels = "".join(name.ljust(width) for name in points).encode()
    signed = scale if whole_numbers else -scale
    parameters = b"".join(
        [
            entry("POINT", -1, b"\0"),
            parameter("USED", 2, [], struct.pack(f"{order}h", len(points))),
            parameter("FRAMES", 2, [], struct.pack(f"{order}h", len(next(iter(points.values()))))),
            parameter("DATA_START", 2, [], struct.pack(f"{order}h", 3)),
            parameter("SCALE", 4, [], number(signed)),
            parameter("RATE", 4, [], number(100.0)),
            parameter("UNITS", -1, [2], b"mm"),
            parameter("Y_SCREEN", -1, [2], b"+Z"),
            parameter("LABELS", -1, [width, len(points)], labels),
        ]
    )
    blocks = -(-(4 + len(parameters) + 2) // 512)
    section = bytes([1, 80, blocks, code]) + parameters
    frames = _count(points)
    words = (len(points), 0, first, first + frames - 1, 0)
    header = struct.pack(f"{order}BB5H", 2, 80, *words) + number(signed)
    header += struct.pack(f"{order}2H", 2 + blocks, 0) + number(100.0)
    places = np.stack([*points.values()], axis=1)  # (T, points, 3)
    table = np.concatenate([places, np.zeros((*places.shape[:2], 1))], axis=2)
    table[np.isnan(places).any(axis=2)] = [0.0, 0.0, 0.0, -1.0]
    if whole_numbers:
        table[..., :3] /= scale
        data = np.round(table).astype(f"{order}i2").tobytes()
    else:
        data = floats(table.reshape(-1))
    path.write_bytes(header.ljust(512, b"\0") + section.ljust(512 * blocks, b"\0") + data)
    return path


# A spine with two arms, cm, y up: name, parent, offset.
BVH_JOINTS: tuple[tuple[str, str | None, tuple[float, float, float]], ...] = (
    ("Hips", None, (0.0, 0.0, 0.0)),
    ("Spine", "Hips", (0.0, 50.0, 1.0)),
    ("LeftArm", "Spine", (18.0, -2.0, 0.0)),
    ("LeftForeArm", "LeftArm", (2.0, -30.0, 0.5)),
    ("LeftHand", "LeftForeArm", (1.0, -25.0, 0.25)),
    ("RightArm", "Spine", (-18.0, -2.0, 0.0)),
    ("RightForeArm", "RightArm", (-2.0, -30.0, 0.5)),
    ("RightHand", "RightForeArm", (-1.0, -25.0, 0.25)),
)
HAND_END = (0.0, -8.0, 0.0)


def bvh_text(
    angles: dict[str, Array],
    places: dict[str, Array],
    *,
    frame_time: str = "0.0083333",
    order: str = "ZXY",
) -> str:
    """Write the skeleton of `BVH_JOINTS` with joint angles.

    Args:
        angles: For every joint its angles about the axes of `order`, shape (T, 3), degrees.
        places: For the root, and any joint with six channels, its places, shape (T, 3), cm.
        frame_time: As the file says it, s.
        order: Axes, the outermost rotation first.
    """
    lines = ["HIERARCHY"]
    lines += _bvh_joint("Hips", 0, set(places), order)
    frames = len(angles["Hips"])
    lines += ["MOTION", f"Frames: {frames}", f"Frame Time: {frame_time}"]
    columns = []
    for name, _, _ in BVH_JOINTS:
        columns += [places[name]] if name in places else []
        columns.append(angles[name])
    table = np.concatenate(columns, axis=1)
    return _joined(lines, [" ".join(f"{value:.6f}" for value in row) for row in table])


def _bvh_joint(name: str, depth: int, moving: set[str], order: str) -> list[str]:
    indent = "  " * depth
    offset = next(o for n, _, o in BVH_JOINTS if n == name)
    turns = " ".join(f"{axis}rotation" for axis in order)
    channels = f"6 Xposition Yposition Zposition {turns}" if name in moving else f"3 {turns}"
    children = [child for child, parent, _ in BVH_JOINTS if parent == name]
    inside = [f"OFFSET {offset[0]} {offset[1]} {offset[2]}", f"CHANNELS {channels}"]
    for child in children:
        inside += _bvh_joint(child, 1, moving, order)
    if not children:
        end = " ".join(map(str, HAND_END))
        inside += ["End Site", "{", f"  OFFSET {end}", "}"]
    kind = "JOINT" if depth else "ROOT"
    return [f"{indent}{line}" for line in [f"{kind} {name}", "{", *inside, "}"]]


# Bones of two arms: name, parent, direction, length, axes in degrees, degrees of freedom.
AMC_BONES: tuple[tuple[str, str, tuple[float, ...], float, tuple[float, ...], str], ...] = (
    ("lowerback", "root", (0.0, 1.0, 0.0), 4.0, (0.0, 0.0, 0.0), "rx ry rz"),
    ("thorax", "lowerback", (0.0, 1.0, 0.0), 5.0, (0.0, 0.0, 0.0), "rx ry rz"),
    *(
        bone
        for side, sign in (("l", 1.0), ("r", -1.0))
        for bone in (
            (f"{side}clavicle", "thorax", (sign, 0.0, 0.0), 4.0, (0.0, 0.0, 0.0), "ry rz"),
            (
                f"{side}humerus",
                f"{side}clavicle",
                (0.0, -1.0, 0.0),
                5.0,
                (20.0, 30.0, -40.0 * sign),
                "rx ry rz",
            ),
            (f"{side}radius", f"{side}humerus", (0.0, -0.8, 0.6), 3.0, (10.0, 0.0, 90.0), "rx"),
            (f"{side}wrist", f"{side}radius", (0.0, -1.0, 0.0), 1.5, (0.0, 0.0, 0.0), "ry"),
        )
    ),
)


def write_acclaim(folder: Path, angles: dict[str, Array], root: Array) -> Path:
    """Write the skeleton of `AMC_BONES` and its motion; return the AMC.

    Args:
        folder: Where to; dance.asf and dance.amc.
        angles: For every bone the angles of its degrees of freedom, shape (T, dof), degrees.
        root: The root's tx, ty, tz, rx, ry, rz, shape (T, 6).
    """
    asf = [":version 1.10", ":name dancer", ":units", "  mass 1.0", "  length 0.45", "  angle deg"]
    asf += [":root", "  order TX TY TZ RX RY RZ", "  axis XYZ", "  position 0 0 0"]
    asf += ["  orientation 0 0 0", ":bonedata"]
    for i, (name, _, direction, length, axis, dof) in enumerate(AMC_BONES, 1):
        asf += ["  begin", f"    id {i}", f"    name {name}"]
        asf += [f"    direction {' '.join(map(str, direction))}", f"    length {length}"]
        asf += [f"    axis {' '.join(map(str, axis))}  XYZ", f"    dof {dof}", "  end"]
    asf += [":hierarchy", "  begin"]
    for parent in dict.fromkeys(bone[1] for bone in AMC_BONES):
        children = [bone[0] for bone in AMC_BONES if bone[1] == parent]
        asf.append(f"    {parent} {' '.join(children)}")
    asf.append("  end")
    (folder / "dance.asf").write_text("\n".join(asf) + "\n")
    amc = ["#!OML:ASF", ":FULLY-SPECIFIED", ":DEGREES"]
    for frame in range(len(root)):
        amc.append(str(frame + 1))
        for name, values in ({"root": root} | angles).items():
            amc.append(f"{name} {' '.join(f'{value:.6f}' for value in values[frame])}")
    path = folder / "dance.amc"
    path.write_text("\n".join(amc) + "\n")
    return path


def _count(points: Points) -> int:
    return len(next(iter(points.values())))


def _times(frames: int, rate: float) -> list[str]:
    return [f"{frame / rate:.5f}" for frame in range(frames)]


def _rows(points: Points, lead: Sequence[Sequence[object]], separator: str) -> list[str]:
    table = np.concatenate([*points.values()], axis=1)
    rows = []
    for i, row in enumerate(table):
        cells = [str(column[i]) for column in lead]
        cells += ["" if np.isnan(value) else f"{value:.3f}" for value in row]
        rows.append(separator.join(cells))
    return rows


def _joined(header: Sequence[str], rows: Sequence[str]) -> str:
    return "\n".join([*header, *rows]) + "\n"
