"""Reader for MVNX, the XML export of Xsens MVN: places of a body's segments, frame by frame.

A subject has a list of segments, then frames whose `position` holds x, y, z of the beginning of
each segment, in metres, z up. Frames of a calibration pose (identity, tpose) come first.
"""

from __future__ import annotations

from array import array
from collections.abc import Sequence
from pathlib import Path
from xml.parsers import expat

import numpy as np

from mpma_mj.errors import MotionFileError
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.readers.cells import is_number, positive
from mpma_mj.motions.readers.recording import UNITS, Recording, Tracks
from mpma_mj.motions.readers.tables.times import arrangement
from mpma_mj.motions.readers.text import FARTHEST, TextFile

__all__ = ["is_xml", "read_mvnx"]

_SCENES = {"COLLADA": "a COLLADA scene", "X3D": "an X3D scene"}


def is_xml(head: list[str]) -> bool:
    """Return whether the first lines are those of an XML document."""
    first = next((line.strip() for line in head if line.strip()), "").lower()
    return first.startswith(("<?xml", "<mvnx", "<collada"))


def read_mvnx(file: TextFile, report: ImportReport) -> Recording:
    """Read an MVNX.

    Raises:
        MotionFileError: It is another XML document, is damaged, or has no places.
    """
    content = _Content(file.path)
    try:
        content.parse()
    except expat.ExpatError as error:
        raise MotionFileError(
            f"{file.path}: line {error.lineno}: is damaged or cut short"
            f" ({expat.errors.messages.get(error.code, error)}); export the MVNX again"
        ) from None
    if not content.names or not content.places:
        raise MotionFileError(
            f"{file.path}: has no positions of segments; export the MVNX with them"
        )
    places = np.array(content.places).reshape(-1, len(content.names), 3)
    arrange = arrangement(
        None, np.array(content.numbers), lambda frame: f"frame {frame + 1}", report
    )
    places = places if arrange is None else arrange(places)
    number = {name: i for i, name in reversed([*enumerate(content.names)])}

    def load(names: Sequence[str]) -> Tracks:
        return {name: places[:, number[name]] for name in names}

    return Recording(
        file.path, "MVNX", tuple(content.names), load, content.rate, UNITS["m"], up="z"
    )


class _Content:
    """Content of an MVNX, found by a parser of XML that expands no entities."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.names: list[str] = []
        self.rate: float | None = None
        self.places = array("d")  # of all segments, frame after frame
        self.numbers = array("d")  # of the frames
        self._root: str | None = None
        self._subjects = 0
        self._kept = False  # whether the frame is of a motion
        self._number = np.nan  # of the frame
        self._text: list[str] | None = None  # of a position
        self._parser = expat.ParserCreate()
        self._parser.buffer_text = True
        self._parser.StartDoctypeDeclHandler = self._refuse_doctype
        self._parser.StartElementHandler = self._start
        self._parser.EndElementHandler = self._end
        self._parser.CharacterDataHandler = self._characters

    def parse(self) -> None:
        with self.path.open("rb") as file:
            self._parser.ParseFile(file)

    def _refuse(self, problem: str) -> MotionFileError:
        line = self._parser.CurrentLineNumber
        return MotionFileError(f"{self.path}: line {line}: {problem}; export the MVNX again")

    def _refuse_doctype(self, *_: object) -> None:
        raise self._refuse("declares a document type, which no MVNX does")

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        tag = tag.rpartition(":")[2]
        if self._root is None:
            self._root = tag
            self._check_root()
        if tag == "subject":
            self._subjects += 1
            if self._subjects > 1:
                raise self._refuse("has a second subject; export one person a file")
            self.rate = positive(attributes.get("frameRate", ""))
        elif tag == "segment" and "label" in attributes:
            self.names.append(attributes["label"])
        elif tag == "frame":
            self._kept = attributes.get("type", "normal") == "normal"
            index = attributes.get("index", "")
            self._number = float(index) if is_number(index) else np.nan
        elif tag == "position" and self._kept:
            self._text = []

    def _check_root(self) -> None:
        if self._root in _SCENES:
            what = _SCENES[self._root]
            raise MotionFileError(f"{self.path}: is {what}", remedy="export it as BVH")
        if self._root != "mvnx":
            what = f"XML, of a kind that is not known (<{str(self._root)[:40]}>)"
            raise MotionFileError(f"{self.path}: is {what}; export as C3D, BVH or CSV")

    def _characters(self, text: str) -> None:
        if self._text is not None:
            self._text.append(text)

    def _end(self, tag: str) -> None:
        if tag.rpartition(":")[2] != "position" or self._text is None:
            return
        cells = "".join(self._text).split()
        self._text = None
        if len(cells) != 3 * len(self.names):
            raise self._refuse(
                f"a position of {len(cells)} numbers; expected x, y, z of {len(self.names)}"
                " segments"
            )
        wrong = next((c for c in cells if not is_number(c) or not abs(float(c)) < FARTHEST), None)
        if wrong is not None:
            raise self._refuse(f"'{wrong[:40]}' is not a coordinate")
        self.places.extend(map(float, cells))
        self.numbers.append(self._number)
