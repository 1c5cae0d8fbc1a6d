"""Skeletons known by the number of their joints (`joint_orders.toml`), for files without names."""

from __future__ import annotations

import functools
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpma_mj.kinematics import SIDES

__all__ = ["JointOrder", "find_order", "find_order_of", "known_orders"]

Array = NDArray[np.float64]

# What arms and trunks are like, wide enough for children, bent backs and noise (choice).
_ALIKE = 1.3  # left to right
_STEADY = 0.25  # median deviation of a segment's length over its median
_OBLIQUE = 0.6  # cosine between the line of the shoulders and the trunk
_PROPORTIONS = {  # over the upper arm
    "forearm": (0.55, 1.5),
    "shoulders": (0.6, 2.6),
    "trunk": (1.0, 3.2),
}


@dataclass(frozen=True)
class JointOrder:
    """A known skeleton.

    Attributes:
        name: What it is called, such as SMPL.
        counts: Numbers of joints of files in this order.
        joints: Names of the first joints, from number 0.
    """

    name: str
    counts: tuple[int, ...]
    joints: tuple[str, ...]

    def names(self, count: int) -> tuple[str, ...]:
        """Return names for a number of joints; one without a name is its number."""
        return self.joints[:count] + tuple(map(str, range(len(self.joints), count)))


@functools.cache
def _all_orders() -> tuple[JointOrder, ...]:
    content = tomllib.loads(Path(__file__).with_suffix(".toml").read_text("utf-8"))
    return tuple(
        JointOrder(o["name"], tuple(o["counts"]), tuple(o["joints"])) for o in content["order"]
    )


def known_orders(count: int) -> tuple[JointOrder, ...]:
    """Return the known skeletons with a number of joints."""
    return tuple(order for order in _all_orders() if count in order.counts)


def find_order(points: Array) -> JointOrder | None:
    """Return the known skeleton whose arms and trunk the points make, if one alone does.

    Left and right segments have to be alike and steady, and to have the proportions of a body.

    Args:
        points: Joints by their number, shape (T, J, 3), any unit; one that is not seen is NaN.
    """
    fitting = [order for order in known_orders(points.shape[1]) if _fits(order, points)]
    return fitting[0] if len(fitting) == 1 else None


def find_order_of(tracks: Mapping[int, Array]) -> JointOrder | None:
    """Return the known skeleton whose arms and trunk some joints make, if one alone does.

    Args:
        tracks: Trajectories by number, each shape (T, 3), any unit, NaN where not seen: of all
            joints, or of some.
    """
    count = max(tracks) + 1
    points = np.full((len(next(iter(tracks.values()))), count, 3), np.nan)
    for number, track in tracks.items():
        points[:, number] = track
    if len(tracks) == count and known_orders(count):
        return find_order(points)
    fitting = [o for o in _all_orders() if count <= max(o.counts) and _fits(o, points)]
    meant = {tuple(order.names(count)[number] for number in tracks) for order in fitting}
    return fitting[0] if len(meant) == 1 else None


def _fits(order: JointOrder, points: Array) -> bool:
    """Return whether points in an order make two arms and a trunk."""
    number = {name: i for i, name in enumerate(order.joints)}
    needed = [f"{side}_{part}" for part in ("shoulder", "elbow", "wrist", "hip") for side in SIDES]
    if max(number[joint] for joint in needed) >= points.shape[1]:
        return False
    shoulder, elbow, wrist, hip = (
        points[:, [number[f"{side}_{part}"] for side in SIDES]]
        for part in ("shoulder", "elbow", "wrist", "hip")
    )  # each (T, 2, 3)
    trunk = shoulder.mean(axis=1) - hip.mean(axis=1)
    across = shoulder[:, 0] - shoulder[:, 1]
    lengths = {
        "upper arm": np.linalg.norm(elbow - shoulder, axis=2),  # (T, 2)
        "forearm": np.linalg.norm(wrist - elbow, axis=2),
        "flank": np.linalg.norm(shoulder - hip, axis=2),
        "shoulders": np.linalg.norm(across, axis=1, keepdims=True),  # (T, 1)
        "trunk": np.linalg.norm(trunk, axis=1, keepdims=True),
    }
    usual = {name: _median(length) for name, length in lengths.items()}
    if not all((length > 0).all() for length in usual.values()):  # NaN, too
        return False
    oblique = np.abs(np.sum(across * trunk, axis=1, keepdims=True))
    if _median(oblique)[0] > _OBLIQUE * usual["shoulders"][0] * usual["trunk"][0]:
        return False
    upper = usual["upper arm"].mean()
    return all(
        length.max() <= _ALIKE * length.min()
        and (_median(np.abs(lengths[name] - length)) <= _STEADY * length).all()
        for name, length in usual.items()
    ) and all(
        low <= usual[name].mean() / upper <= high for name, (low, high) in _PROPORTIONS.items()
    )


def _median(values: Array) -> Array:
    """Return the medians of columns, shape (T, n), without what is not seen."""
    seen = values[np.isfinite(values).all(axis=1)]
    return np.median(seen, axis=0) if len(seen) else np.zeros(values.shape[1])
