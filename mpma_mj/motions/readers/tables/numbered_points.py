"""Points that a table only numbers, named by the order of a known skeleton."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.readers.joint_orders import find_order_of
from mpma_mj.motions.readers.recording import Recording, Tracks

__all__ = ["name_numbered"]

_FEWEST = 6  # points that two arms have
# 11, landmark_11, lm11, "joint 11"
_NUMBERED = re.compile(r"(?P<word>[a-z_ ]*?)[_\- ]*(?P<number>\d+)", re.IGNORECASE)


def name_numbered(recording: Recording, report: ImportReport) -> Recording:
    """Name the points of a recording if they all are numbered and make a known skeleton.

    Args:
        recording: A recording whose trajectories are in a table.
        report: Gets which skeleton is found, or a warning if none is.
    """
    found = [_NUMBERED.fullmatch(name) for name in recording.names]
    matches = [match for match in found if match]
    if len(matches) < max(_FEWEST, len(found)) or len({match["word"] for match in matches}) > 1:
        return recording
    numbers = [int(match["number"]) for match in matches]
    tracks = recording.load(recording.names)
    by_number = dict(zip(numbers, tracks.values(), strict=True))
    order = find_order_of(by_number)
    listed = f"points {min(numbers)} to {max(numbers)} have numbers instead of names"
    if order is None:
        report.warn(
            f"its {listed}, of no known skeleton",
            remedy="name them with {map}, such as {map=left_wrist=15,…}",
        )
        names = recording.names
    else:
        report.warn(
            f"its {listed}, which are read in the order of {order.name}",
            remedy="if that is wrong, name them in the header",
        )
        joints = order.names(max(numbers) + 1)
        names = tuple(joints[number] for number in numbers)
    by_name = dict(zip(names, tracks.values(), strict=True))

    def load(chosen: Sequence[str]) -> Tracks:
        return {name: by_name[name].copy() for name in chosen}

    return replace(recording, names=names, load=load)
