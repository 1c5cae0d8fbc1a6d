"""Forward kinematics of skeletons, which BVH, ASF/AMC and SMPL describe by joint angles."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpma_mj.motions.readers.recording import Tracks
from mpma_mj.motions.readers.text import stack

__all__ = ["Joint", "ancestry", "euler_turns", "joint_positions", "tracks_of"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Joint:
    """A joint, or the end of a bone.

    Attributes:
        name: Its name.
        parent: Name of the joint before it; None for the root.
        offset: From the parent, in the parent's frame, shape (3,), in the file's unit.
        axes: Axes that it turns about, such as "ZXY": R = Rz Rx Ry.
        frame: Rotation C of the axes themselves, shape (3, 3): the joint turns by C R Cᵀ.
    """

    name: str
    parent: str | None
    offset: Array
    axes: str
    frame: Array


def ancestry(joints: Mapping[str, Joint], names: Sequence[str]) -> list[str]:
    """Return the joints on the way from the root to some joints, parents first."""
    found: dict[str, None] = {}
    for name in names:
        chain = [name]
        while (parent := joints[chain[-1]].parent) is not None:
            chain.append(parent)
        found.update(dict.fromkeys(reversed(chain)))
    return list(found)


def joint_positions(
    joints: Mapping[str, Joint],
    names: Sequence[str],
    turns: Mapping[str, Array],
    translations: Mapping[str, Array],
) -> Array:
    """Compute where joints are.

        R_j = R_parent turn_j        x_j = x_parent + R_parent offset_j

    Args:
        joints: The skeleton, by name.
        names: Requested joints.
        turns: For each joint that turns its rotations, each shape (T, 3, 3).
        translations: For each joint that moves its place in the parent's frame, shape (T, 3),
            which stands instead of the offset.

    Returns:
        Positions, shape (T, 3 · number of `names`), in the file's unit.
    """
    frames = len(next(iter(translations.values())))
    turned: dict[str, Array] = {}
    places: dict[str, Array] = {}
    for name in ancestry(joints, names):
        joint = joints[name]
        way = translations.get(name, joint.offset)
        turn = turns.get(name, np.eye(3))
        if joint.parent is None:
            places[name] = np.broadcast_to(way, (frames, 3))
            turned[name] = np.broadcast_to(turn, (frames, 3, 3))
        else:
            before = turned[joint.parent]
            step = np.matmul(before, np.broadcast_to(way, (frames, 3))[:, :, None])[:, :, 0]
            places[name] = places[joint.parent] + step
            turned[name] = before @ turn
    return np.concatenate([places[name] for name in names], axis=1)


def tracks_of(blocks: Iterator[Array], names: Sequence[str]) -> Tracks:
    """Return the trajectories in blocks of positions, each shape (rows, 3 · number of `names`)."""
    rows = stack(blocks, 3 * len(names))
    return {name: rows[:, 3 * i : 3 * i + 3] for i, name in enumerate(names)}


def euler_turns(joints: Mapping[str, Joint], angles: Mapping[str, Array]) -> dict[str, Array]:
    """Return how joints turn, C R(angles) Cᵀ, each shape (T, 3, 3).

    Args:
        joints: The skeleton, by name.
        angles: For some joints the angles about their axes, each shape (T, axes), rad.
    """
    from scipy.spatial.transform import Rotation  # slow to import, needed by few runs

    return {
        name: joints[name].frame
        @ Rotation.from_euler(joints[name].axes, turned).as_matrix()
        @ joints[name].frame.T
        for name, turned in angles.items()
        if joints[name].axes
    }
