"""Reader for tables of joint angles, as robots log them and `mpma motion` exports them.

A header names the eight joints of `kinematics.JOINT_NAMES`, in any order and perhaps with a unit
(`left_elbow`, `left_elbow_deg`, `angle_left_elbow`, `joint_states/left_elbow/position`), with a
column of times or of frames. ROS's exports of JointState have the names in every row instead.
"""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpma_mj import kinematics
from mpma_mj.errors import MotionFileError
from mpma_mj.motions.cleaning.jumps import off_at_end, single_frame_jumps, small_jumps
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.motion import Motion
from mpma_mj.motions.readers.cells import is_number
from mpma_mj.motions.readers.recording import unknown_rate
from mpma_mj.motions.readers.tables.header import Header, find_header
from mpma_mj.motions.readers.tables.times import arrangement, continuous, rate_of
from mpma_mj.motions.readers.tables.titles import time_unit
from mpma_mj.motions.readers.text import Grid, TextFile, stack

__all__ = ["read_joint_angles"]

Array = NDArray[np.float64]

_WORD = "abduction"  # in no other file: a quick look
_LONGEST_HEADER = 60  # lines
_UNITS = {"rad": 1.0, "radian": 1.0, "deg": np.pi / 180, "degree": np.pi / 180, "°": np.pi / 180}
_UNIT = re.compile(r"(?:^|[\W_])(rad|radian|deg|degree)s?[)\]]?$|(°)", re.IGNORECASE)
_JOINT = re.compile(
    r"(?!.*(vel|acc|effort|torque|current|command|target|desired|error))"  # of the same joints
    r"(.*[./])?((?:angle|position|pos|q|joint|measured|actual)_)*"
    rf"(?P<joint>{'|'.join(kinematics.JOINT_NAMES)})[_./]*(angle|position|pos|q)?"
)
_TURNS = 4 * np.pi  # rad: angles that are larger may as well be degrees
_ELBOW = 2 * np.pi  # rad: no elbow bends so far (choice)
_LONGEST_GAP = 0.25  # s
_JUMP = 0.005  # rad of a single angle in a row (choice)


def read_joint_angles(path: Path, rate: float | None, report: ImportReport) -> Motion | None:
    """Read a table of joint angles.

    Args:
        path: The file.
        rate: Rows per second, Hz, that the user gives.
        report: Gets what is odd.

    Returns:
        The motion; None if the file is something else.

    Raises:
        MotionFileError: A joint, the rate or the unit is missing, or a row cannot be read.
    """
    file = TextFile.open(path)
    if file is None or not any(_WORD in line.lower() for line in file.head(_LONGEST_HEADER)):
        return None
    header = find_header(file, _names_joints)
    if header is None:
        return None
    states = _state_columns(header)
    if states is not None:
        header = replace(header, first=header.axes)
    columns = _columns(path, header, report) if states is None else states
    grid = Grid.starting(file, header.start + header.first, columns=header.width)
    frame, time = header.counters
    counters = [column for column in (time, frame) if column is not None]
    needed = [*counters, *columns]
    header.check_width(grid, needed)
    rows = stack(grid.blocks(needed, report, counters=len(counters)), len(needed))
    angles = rows[:, len(counters) :]
    angles = angles * _scale(path, header, columns, angles, report)
    lacking = np.flatnonzero(~np.isfinite(angles).all(axis=1))
    if len(lacking):
        report.warn(
            f"rows without all angles: {len(lacking)}, the first in line"
            f" {grid.first + lacking[0] + 1}; they are bridged, or cut off at the ends"
        )
    times = None if time is None else continuous(rows[:, 0])
    declared = header.rate
    if rate is None and times is not None:
        declared = rate_of(times, declared, report, time_unit(header.titles[time or 0]))
    rate = rate or declared
    if rate is None:
        raise unknown_rate(path, report)
    numbers = None if frame is None else rows[:, len(counters) - 1]
    arrange = arrangement(times, numbers, lambda row: f"line {grid.first + row + 1}", report)
    angles = angles if arrange is None else arrange(angles)
    angles = _without_gaps(path, angles, rate)
    posture = kinematics.posture_from_angles(angles)
    _warn_of_jumps(angles, posture, report)
    source = f"joint angles of {path.name}"
    return Motion(posture, np.ones((len(posture), 1)), ("1",), rate, path.stem, source)


def _names_joints(cells: list[str]) -> bool:
    """Return whether a row names angles; an elbow alone may be a point."""
    return any("shoulder" in _joint(cell) for cell in cells)


def _joint(title: str) -> str:
    """Return the joint that a title names, or ""."""
    letters = re.sub(r"[\s_\-]+", "_", _UNIT.sub("", title).strip(" ()[]").lower())
    found = _JOINT.fullmatch(letters.strip("_"))
    return found["joint"] if found else ""


def _state_columns(header: Header) -> list[int] | None:
    """Return the columns of the joints in ROS's JointState, whose rows name them; else None.

    Its titles are field.name0, …, field.position0, …: the joints' names are cells of every row.
    """
    row = header.axes
    titles = header.rows[row - 1] if row else []
    places = {title: column for column, title in enumerate(titles)}
    found = {
        _joint(header.cell(row, column)): places.get(title.replace("name", "position"))
        for title, column in places.items()
        if "name" in title
    }
    columns = [found.get(joint) for joint in kinematics.JOINT_NAMES]
    known = [column for column in columns if column is not None]
    return known if len(known) == len(columns) else None


def _columns(path: Path, header: Header, report: ImportReport) -> list[int]:
    """Return the columns of the joints, in the order of `JOINT_NAMES`."""
    titles = [_joint(title) for title in header.rows[header.axes]]
    if any(is_number(cell) for cell in header.rows[header.axes]):
        raise MotionFileError(
            f"{path}: line {header.start + header.axes + 1} has joints' names amid numbers, as"
            " messages of ROS do; give one column to each joint, titled by its name"
        )
    for joint in kinematics.JOINT_NAMES:
        if titles.count(joint) != 1:
            how = "several columns" if joint in titles else "no column"
            raise MotionFileError(
                f"{path}: has joint angles, but {how} of {joint}; expected one column each of"
                f" {', '.join(kinematics.JOINT_NAMES)}"
            )
    columns = [titles.index(joint) for joint in kinematics.JOINT_NAMES]
    left, right = np.argsort(np.argsort(columns)).reshape(2, -1)
    if np.ptp(right - left):
        report.warn(
            f"line {header.start + header.axes + 1} names the joints of the right arm in another"
            " order than those of the left; check that no two titles are exchanged"
        )
    return columns


def _scale(
    path: Path, header: Header, columns: list[int], angles: Array, report: ImportReport
) -> Array:
    """Return what one of each joint's units is, shape (8,), rad, declared or by the elbows.

    Args:
        path: The file, for messages.
        header: Its header.
        columns: Columns of the joints.
        angles: Angles as they are in the file, shape (T, 8).
        report: Gets a warning where the unit is taken from the angles.
    """
    found = [
        next((u for row in range(header.axes, header.first) if (u := _unit(header, row, c))), "")
        for c in columns
    ]
    above = {_unit(header, r, c) for r in range(header.axes) for c in range(len(header.rows[r]))}
    declared = (set(found) | above) - {""}
    if declared and (all(found) or len(declared) == 1):
        return np.array([_UNITS[unit or next(iter(declared))] for unit in found])
    largest = np.nanmax(np.abs(angles), axis=0, initial=0.0)
    elbows = [i for i, joint in enumerate(kinematics.JOINT_NAMES) if joint.endswith("elbow")]
    if not declared and largest.max() <= _TURNS:
        # Logs of robots, as `mpma identify` reads them or of ROS, are in radians (its REP 103).
        titles = [re.sub(r"[\W_]+", "_", header.cell(header.axes, c)).lower() for c in columns]
        if set(titles) & set(kinematics.JOINT_NAMES):
            report.warn(
                f"its titles name no unit: the angles, up to {largest.max():.3g}, are read as"
                " radians; write the unit into the titles, such as left_elbow_rad or left_elbow_deg"
            )
        return np.ones(len(columns))
    if not declared and largest[elbows].max() > _ELBOW:
        report.warn(
            f"the angles are read as degrees, as an elbow has {largest[elbows].max():.4g}; write"
            " the unit into the titles, such as left_elbow_deg"
        )
        return np.full(len(columns), _UNITS["deg"])
    raise MotionFileError(
        f"{path}: does not say whether its angles, up to {largest.max():.4g}, are in radians or"
        " degrees; write the unit into the titles, such as left_elbow_deg or left_elbow_rad"
    )


def _unit(header: Header, row: int, column: int) -> str:
    """Return the unit of angles that a cell names, or ""."""
    found = _UNIT.search(header.cell(row, column))
    return next(filter(None, found.groups())).lower() if found else ""


def _without_gaps(path: Path, angles: Array, rate: float) -> Array:
    """Return angles, shape (T, 8), rad, with short gaps bridged by linear interpolation."""
    seen = np.isfinite(angles).all(axis=1)
    known = np.flatnonzero(seen)
    if len(known) < 2:
        raise MotionFileError(f"{path}: has {len(known)} row(s) with all angles; expected two")
    longest = int(np.argmax(np.diff(known)))
    if np.diff(known).max() - 1 > _LONGEST_GAP * rate:
        raise MotionFileError(
            f"{path}: has no angles from {(known[longest] + 1) / rate:.2f} to"
            f" {known[longest + 1] / rate:.2f} s; cut the file there"
        )
    frames = np.arange(known[0], known[-1] + 1)
    return np.stack([np.interp(frames, known, column[known]) for column in angles.T], axis=1)


def _warn_of_jumps(angles: Array, posture: Array, report: ImportReport) -> None:
    """Warn of rows in which a segment of postures, (T, 12), or an angle, (T, 8), jumps."""
    segments = zip(kinematics.SEGMENT_NAMES, np.split(posture, 4, axis=1), strict=True)
    found = {}
    for name, vectors in segments:
        rows = [int(row) + 1 for row in single_frame_jumps(vectors, 1.0)]
        ends = off_at_end(vectors, 1.0), off_at_end(vectors[::-1], 1.0)
        rows += [1 + ends[0]] if ends[0] is not None else []
        rows += [len(vectors) - ends[1]] if ends[1] is not None else []
        if rows:
            found[name] = rows
    known = {row for rows in found.values() for row in rows}
    for joint, column in zip(kinematics.JOINT_NAMES, angles.T, strict=True):
        rows = [int(row) + 1 for row in small_jumps(column[:, None], _JUMP, exact=True)]
        if not known.issuperset(rows):
            found[joint] = rows
    if found:
        count = sum(map(len, found.values()))
        listed = "; ".join(f"{name} in row {rows[0]}" for name, rows in found.items())
        report.warn(f"{count} single-frame jump{'s' * (count > 1)} ({listed}); correct those rows")
