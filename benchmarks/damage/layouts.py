"""One dancer in each layout of recordings, written by the writers of the tests."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mpma_mj.motions.readers.joint_orders import known_orders
from tests.motions.readers import writers
from tests.motions.readers.tables.test_joint_angles import ANGLES
from tests.motions.readers.tables.test_joint_angles import write as write_joint_angles
from tests.motions.readers.test_c3d import write_segments
from tests.motions.readers.test_mvnx import text as mvnx_text

__all__ = ["LAYOUTS", "Layout"]

Array = NDArray[np.float64]
Make = Callable[[Path], Path]

_FRAMES = 150
_NOISE = 0.3  # mm, of markers
_NAMES = [f"{s}_{p}" for s in ("left", "right") for p in ("shoulder", "elbow", "wrist")]
_TORSO = ("pelvis", "neck")


class Layout(NamedTuple):
    """A kind of file.

    Attributes:
        make: Writes the file into a folder, and returns its path.
        rate: Frames per second, Hz.
        declared: Whether the file says so.
    """

    make: Make
    rate: float = 100.0
    declared: bool = True


def _dancer(names: dict[str, str] | None = None) -> writers.Points:
    """Return points, mm, z up, of arms that move differently, beside a torso that turns and leans.

    Args:
        names: Other names of points by the usual ones.
    """
    time, rng = np.arange(_FRAMES) / 100.0, np.random.default_rng(0)
    points = {"pelvis": np.stack([30 * np.sin(time), 40 * np.sin(1.7 * time), 900 + 0 * time], 1)}
    points["neck"] = points["pelvis"] + _direction(0.1 * np.sin(2 * time), 0.1, 1.0) * 500
    for side, sign in (("left", 1.0), ("right", -1.0)):
        turn = 0.2 * np.sin(1.3 * time)
        across = np.stack([-np.sin(turn), np.cos(turn), 0 * time], 1) * sign
        points[f"{side}_shoulder"] = points["neck"] + 180 * across - [0, 0, 40]
        upper = _direction(0.3 + 0.5 * np.sin((5 + sign) * time), 0.4 * sign, -1.0)
        fore = _direction(0.7 + 0.5 * np.sin(6 * time + sign), 0.2 * sign * np.cos(4 * time), -0.6)
        points[f"{side}_elbow"] = points[f"{side}_shoulder"] + 300 * upper
        points[f"{side}_wrist"] = points[f"{side}_elbow"] + 250 * fore
    noisy = {n: np.round(p + rng.normal(0, _NOISE, p.shape), 3) for n, p in points.items()}
    ordered = {name: noisy[name] for name in (*_NAMES, *_TORSO)}
    return {(names or {}).get(name, name): track for name, track in ordered.items()}


def _direction(*way: Array | float) -> Array:
    vectors = np.stack(np.broadcast_arrays(*way), axis=1)
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def _angles(widths: dict[str, int]) -> dict[str, Array]:
    """Return joint angles, degrees, that swing, each shape (T, width)."""
    time, rng = np.arange(_FRAMES)[:, None] / 100.0, np.random.default_rng(0)
    angles = {}
    for name, width in widths.items():
        phase, size = rng.uniform(0, 6, width), rng.uniform(5, 25, width)
        swing = size * np.sin(rng.uniform(2, 6) * time + phase)
        angles[name] = swing + rng.normal(0, 0.05, swing.shape)
    return angles


def _text(name: str, write: Callable[[writers.Points], str]) -> Make:
    def make(folder: Path) -> Path:
        path = folder / name
        path.write_text(write(_dancer()))
        return path

    return make


def _bvh(folder: Path) -> Path:
    angles = _angles({name: 3 for name, _, _ in writers.BVH_JOINTS})
    path = folder / "dance.bvh"
    places = {"Hips": np.full((_FRAMES, 3), 90.0)}
    path.write_text(writers.bvh_text(angles, places, frame_time="0.01"))
    return path


def _acclaim(folder: Path) -> Path:
    angles = _angles({bone[0]: len(bone[5].split()) for bone in writers.AMC_BONES})
    return writers.write_acclaim(folder, angles, np.zeros((_FRAMES, 6)))


def _c3d(folder: Path, *, whole_numbers: bool) -> Path:
    path = folder / "dance.c3d"
    return writers.write_c3d_of(path, _dancer(), "intel", whole_numbers=whole_numbers)


def _theia(folder: Path) -> Path:
    segments = [f"{side}_{part}" for side in "lr" for part in ("uarm", "larm", "hand")]
    names = dict(zip(_NAMES, segments, strict=True))
    write_segments(folder / "dance.c3d", _dancer(names))
    return folder / "dance.c3d"


def _mvnx(folder: Path) -> Path:
    segments = [f"{s}{p}" for s in ("Left", "Right") for p in ("UpperArm", "ForeArm", "Hand")]
    names = dict(zip((*_NAMES, *_TORSO), (*segments, "Pelvis", "Neck"), strict=True))
    path = folder / "dance.mvnx"
    path.write_text(mvnx_text(_dancer(names)))
    return path


def _body(joints: int) -> Array:
    """Return joints in a known order, shape (T, joints, 3), mm."""
    names = known_orders(joints)[0].names(joints)
    body, dancer = writers.body_joints(names, _FRAMES), _dancer()
    for i, name in enumerate(names):
        if name in _NAMES:
            body[:, i] = dancer[name]
    return body


def _npy(folder: Path) -> Path:
    np.save(folder / "dance.npy", _body(24))
    return folder / "dance.npy"


def _json(folder: Path) -> Path:
    frames = [
        json.dumps([dict(zip("xyz", place, strict=True)) for place in frame])
        for frame in np.round(_body(33) / 1000.0, 4).tolist()
    ]
    path = folder / "dance.json"
    path.write_text('{"fps": 100, "frames": [\n' + ",\n".join(frames) + "\n]}\n")
    return path


def _joint_angles(folder: Path) -> Path:
    return write_joint_angles(folder / "robot.csv", ANGLES)


LAYOUTS: dict[str, Layout] = {
    "C3D of integers": Layout(lambda folder: _c3d(folder, whole_numbers=True)),
    "C3D of floats": Layout(lambda folder: _c3d(folder, whole_numbers=False)),
    "Theia C3D": Layout(_theia, rate=50.0),
    "BVH": Layout(_bvh),
    "ASF/AMC": Layout(_acclaim, rate=120.0),
    "TRC": Layout(_text("dance.trc", writers.trc_text)),
    "Qualisys TSV": Layout(_text("dance.tsv", writers.qualisys_text)),
    "Motive CSV": Layout(
        _text("dance.csv", lambda points: writers.optitrack_text(writers.y_up(points))), rate=120.0
    ),
    "Vicon CSV": Layout(_text("dance.csv", writers.vicon_text)),
    "Captury CSV": Layout(_text("dance.csv", writers.captury_text), declared=False),
    "header row": Layout(_text("dance.csv", writers.header_row_text)),
    "long table": Layout(_text("dance.csv", writers.long_text)),
    "joint angles": Layout(_joint_angles, rate=50.0),
    "MVNX": Layout(_mvnx),
    "JSON": Layout(_json),
    "npz": Layout(lambda folder: writers.write_npz(folder / "dance.npz", _dancer())),
    "npy": Layout(_npy, declared=False),
}
"""Kinds of files by name."""
