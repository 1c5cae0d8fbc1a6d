"""Names that OptiTrack Motive gives to several objects, distinguished by rows of its tables."""

from __future__ import annotations

import re

from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.readers.tables.header import Header

__all__ = ["rename_bones"]

# Of what has one name the first of these is meant: a bone begins in the joint, and a marker that
# is named like it is somewhere on the segment.
_TYPES = ("bone", "rigid body", "marker")
_PELVIS = re.compile(r"(hips?|pelvis)$", re.IGNORECASE)


def rename_bones(titled: dict[int, tuple[str, str]], header: Header, report: ImportReport) -> None:
    """Rename, in place, markers that are named like bones, and the root bone of each skeleton.

    The root is the pelvis. Its parent is Root, or it is named like its skeleton.

    Args:
        titled: For each column of a coordinate the point's name and the axis.
        header: The rows above, of which some begin with Type and Parent.
        report: Gets which bone is the pelvis.
    """
    labels = {header.cell(i, 1).lower(): i for i in range(header.axes)}
    if (row := labels.get("type")) is not None:
        kinds = {column: header.cell(row, column) for column in titled}
        ranks = {name: set[int]() for name, _ in titled.values()}
        for column, (name, _) in titled.items():
            ranks[name].add(_rank(kinds[column]))
        for column, (name, axis) in titled.items():
            if _rank(kinds[column]) > min(ranks[name]):
                titled[column] = f"{name} {kinds[column]}", axis
    parents = labels.get("parent")
    names = {name for name, _ in titled.values()}
    pelves = {name for name in names if _PELVIS.search(name)}
    for column, (name, axis) in titled.items():
        subject, _, bone = name.rpartition(":")
        is_root = parents is not None and header.cell(parents, column).lower() == "root"
        start = _start(name, names)
        if (is_root or subject == bone) and not any(n.startswith(start) for n in pelves):
            titled[column] = f"{start}Hips", axis
            if axis == "x":
                report.note(f"{name}, the root of its skeleton, is called {start}Hips")


def _rank(kind: str) -> int:
    """Return the place of a type of Motive's in `_TYPES`."""
    return next((i for i, t in enumerate(_TYPES) if kind.lower() == t), len(_TYPES))


def _start(root: str, names: set[str]) -> str:
    """Return what the names of a skeleton begin with, from that of its root."""
    if ":" in root:
        return root.rpartition(":")[0] + ":"
    return f"{root}_" if any(name.startswith(f"{root}_") for name in names) else ""
