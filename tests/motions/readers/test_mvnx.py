"""MVNX of Xsens: places of segments, and what is no MVNX."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mpma_mj.errors import MotionFileError
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.marker_sets import choose_markers
from mpma_mj.motions.readers.recognise import open_recording
from tests.motions.readers import writers

NAMES = [f"{s}{p}" for s in ("Left", "Right") for p in ("UpperArm", "ForeArm", "Hand")]


def text(points: writers.Points, *, prefix: str = "", frames: str = "") -> str:
    """Write places in m as Xsens MVN does, after a calibration pose."""
    segments = "".join(f'<{prefix}segment label="{name}" id="1"/>' for name in points)
    rows = np.concatenate([*points.values()], axis=1) / 1000.0
    still = (
        f'<{prefix}frame type="tpose"><{prefix}position>1 2 3</{prefix}position></{prefix}frame>'
    )
    moving = "".join(
        f'<{prefix}frame time="{10 * i}" index="{i}" type="normal">\n'
        f"<{prefix}orientation>1 0 0 0</{prefix}orientation>"
        f"<{prefix}position>{' '.join(f'{v:.6f}' for v in row)}</{prefix}position>"
        f"</{prefix}frame>\n"
        for i, row in enumerate(rows)
    )
    space = f' xmlns:{prefix[:-1]}="http://www.xsens.com/mvn/mvnx"' if prefix else ""
    return (
        f'<?xml version="1.0"?>\n<{prefix}mvnx version="4"{space}>'
        f'<{prefix}subject label="S" frameRate="100"><{prefix}segments>{segments}'
        f"</{prefix}segments><{prefix}frames>{still}{frames or moving}</{prefix}frames>"
        f"</{prefix}subject></{prefix}mvnx>\n"
    )


def read(path: Path, content: str) -> Any:
    path.write_text(content)
    report = ImportReport()
    recording = open_recording(path, report)
    return recording, recording.load(recording.names), report


@pytest.mark.parametrize("prefix", ["", "x:"])
def test_segments_are_points(tmp_path: Path, prefix: str) -> None:
    points = writers.arm_points(names=NAMES)
    recording, tracks, report = read(tmp_path / "dance.mvnx", text(points, prefix=prefix))
    assert (recording.format, recording.rate, recording.unit, recording.up) == ("MVNX", 100, 1, "z")
    for name, track in tracks.items():
        np.testing.assert_allclose(track, points[name] / 1000.0, atol=1e-6)
    assert not report.warnings
    assert choose_markers(recording.path, recording.names, {})["left_wrist"] == ("LeftHand",)


def test_frames_that_are_left_out_are_gaps(tmp_path: Path) -> None:
    content = text(writers.arm_points(names=NAMES))
    start, end = content.index('<frame time="100"'), content.index('<frame time="120"')
    _, tracks, report = read(tmp_path / "dance.mvnx", content[:start] + content[end:])
    lost = np.flatnonzero(np.isnan(tracks["LeftHand"]).any(axis=1))
    assert (len(tracks["LeftHand"]), lost.tolist()) == (60, [10, 11])
    assert report.warnings == [
        "2 frames are missing, the first after frame 10; they are treated as gaps"
    ]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("</mvnx>", "", r"line 1\d\d: is damaged or cut short \(no element found\)"),
        ("<mvnx", "<!DOCTYPE a [<!ENTITY b 'c'>]><mvnx", "line 2: declares a document type"),
        ("</position></frame>", " 7</position></frame>", "19 numbers; expected x, y, z of 6"),
        ("0.180000", "wide", "'wide' is not a coordinate"),
        ("</subject>", '</subject><subject label="T"/>', "has a second subject"),
        ("position>", "velocity>", "has no positions of segments; export the MVNX with them"),
        ("mvnx", "COLLADA", "is a COLLADA scene; export it as BVH"),
        ("mvnx", "gpx", "is XML, of a kind that is not known"),
    ],
)
def test_what_is_no_motion_is_refused(tmp_path: Path, old: str, new: str, message: str) -> None:
    content = text(writers.arm_points(names=NAMES))
    assert old in content
    with pytest.raises(MotionFileError, match=message):
        read(tmp_path / "dance.mvnx", content.replace(old, new))
