"""Forward kinematics of skeletons, which BVH, ASF/AMC and SMPL describe by joint angles."""

from __future__ import annotations

import itertools
import re
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpma_mj.errors import MotionFileError
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.readers.recording import Tracks
from mpma_mj.motions.readers.text import stack

__all__ = [
    "AngleCheck",
    "Joint",
    "ancestry",
    "compare_orders",
    "compare_sides",
    "euler_turn",
    "joint_positions",
    "root_of_legs",
    "tracks_of",
]

Array = NDArray[np.float64]

_ODD, _IMPOSSIBLE = 4.0 * np.pi, 20.0 * np.pi  # rad that a joint below the root turns (choice)

_SIDES = ((r"left", "right"), (r"Left", "Right"), (r"LEFT", "RIGHT"))
_LETTERS = ((r"^l|(?<=[\W_])l$", "r"), (r"^L|(?<=[\W_])L$|(?<=[a-z])L$", "R"))
_ALIKE = 0.01  # of its length, by which an offset or an axis may differ from the other side's
_FEWEST_PAIRS = 3  # of which all but one are alike


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


def compare_sides(
    what: str, values: Mapping[str, Array], needed: Sequence[str], report: ImportReport
) -> None:
    """Warn of the only value that is not, but for signs, that of the other side.

    Args:
        what: What the values are, such as "offset".
        values: Those of the skeleton's joints, by name, each shape (3,).
        needed: Joints on whose values the motion depends.
        report: Gets the warning.
    """
    pairs = {}
    for left, word in itertools.product(values, (*_SIDES, *_LETTERS)):
        right = re.sub(*word, left)
        if right != left and right in values:
            pairs[left] = right
    both = {(tuple(values[a]), tuple(values[b])): (a, b) for a, b in pairs.items()}
    unlike = [names for pair, names in both.items() if not _alike(*map(np.array, pair))]
    if len(unlike) == 1 and len(both) >= _FEWEST_PAIRS and not {*unlike[0]}.isdisjoint(needed):
        a, b = unlike[0]
        first, second = (" ".join(f"{x:g}" for x in values[name]) for name in (a, b))
        report.warn(
            f"the {what} of {a} is {first}, and that of {b} {second}, while the other"
            f" {len(both) - 1} on the left are those on the right; check both"
        )


def _alike(one: Array, other: Array) -> bool:
    """Return whether two values are the same but for signs."""
    return bool(np.abs(np.abs(one) - np.abs(other)).max() <= _ALIKE * np.linalg.norm(other))


def root_of_legs(joints: dict[str, Joint]) -> str | None:
    """Return the first joint that branches if one of its branches, the spine, branches again.

    A root before it may stand on the floor; of an upper body the first such joint is the chest.
    """
    children: dict[str, list[str]] = {name: [] for name in joints}
    for name, joint in joints.items():
        if joint.parent is not None:
            children[joint.parent].append(name)

    def first_branching(name: str) -> str | None:
        while len(children[name]) == 1:
            (name,) = children[name]
        return name if children[name] else None

    pelvis = first_branching(next(iter(joints))) if joints else None
    branches = children[pelvis] if pelvis is not None else []
    return pelvis if len([b for b in branches if first_branching(b)]) == 1 else None


def ancestry(joints: Mapping[str, Joint], names: Sequence[str]) -> list[str]:
    """Return the joints on the way from the root to some joints, parents first."""
    found: dict[str, None] = {}
    for name in names:
        chain = [name]
        while (parent := joints[chain[-1]].parent) is not None:
            chain.append(parent)
        found.update(dict.fromkeys(reversed(chain)))
    return list(found)


@dataclass
class AngleCheck:
    """Check of joint angles, block after block: one of many turns is damaged, or no angle.

    Attributes:
        path: The file, for messages.
        report: Gets a warning of what is odd.
    """

    path: Path
    report: ImportReport
    _first: int = 0  # frames before the block
    _frames: int = 0  # frames of the block
    _warned: bool = False

    def begin(self, frames: int) -> None:
        """Begin a block of frames."""
        self._first += self._frames
        self._frames = frames

    def check(self, joint: Joint, angles: Array) -> Array:
        """Return a joint's angles, shape (T, axes), rad; NaN is a gap.

        Raises:
            MotionFileError: One is of more turns than a body can make.
        """
        missing = ~np.isfinite(angles).all(axis=1)
        if missing.any():
            self._warn(int(np.argmax(missing)), joint, "has no angle; such frames are gaps")
        if joint.parent is None:  # a dancer may spin, and only the root counts the turns
            return angles
        largest = np.where(missing, 0.0, np.abs(angles).max(axis=1))
        frame = int(np.argmax(largest))
        turns = f"turns by {np.degrees(largest[frame]):.0f} degrees"
        if largest[frame] > _IMPOSSIBLE:
            raise MotionFileError(
                f"{self.path}: frame {self._first + frame + 1}: {joint.name} {turns}, which no"
                " joint does; correct that frame, or export again"
            )
        if largest[frame] > _ODD:
            self._warn(frame, joint, f"{turns}; check that frame")
        return angles

    def _warn(self, frame: int, joint: Joint, what: str) -> None:
        """Warn of a frame of the block, once for a file: more of them have the same reason."""
        if not self._warned:
            self.report.warn(f"frame {self._first + frame + 1}: {joint.name} {what}")
        self._warned = True


def joint_positions(
    joints: Mapping[str, Joint],
    names: Sequence[str],
    turn: Callable[[str], Array | None],
    translations: Mapping[str, Array],
) -> Array:
    """Compute where joints are.

        R_j = R_parent turn_j        x_j = x_parent + R_parent offset_j

    Args:
        joints: The skeleton, by name.
        names: Requested joints.
        turn: Returns the rotations of a joint, shape (T, 3, 3), or None if it does not turn.
        translations: For each joint that moves its place in the parent's frame, shape (T, 3),
            which stands instead of the offset.

    Returns:
        Positions, shape (T, 3 · number of `names`), in the file's unit.
    """
    frames = len(next(iter(translations.values())))
    chain = ancestry(joints, names)
    children = Counter(joints[name].parent for name in chain)
    turned: dict[str, Array] = {}  # of joints that have children left: a chain may be long
    places: dict[str, Array] = {}
    for name in chain:
        joint = joints[name]
        way = translations.get(name, joint.offset)
        rotation = turn(name)
        if joint.parent is None:
            places[name] = np.broadcast_to(way, (frames, 3))
            before = np.broadcast_to(np.eye(3), (frames, 3, 3))
        else:
            before = turned[joint.parent]
            step = np.matmul(before, np.broadcast_to(way, (frames, 3))[:, :, None])[:, :, 0]
            places[name] = places[joint.parent] + step
            children[joint.parent] -= 1
            if not children[joint.parent]:
                del turned[joint.parent]
                if joint.parent not in names:
                    del places[joint.parent]
        if children[name]:
            turned[name] = before if rotation is None else before @ rotation
    return np.concatenate([places[name] for name in names], axis=1)


def tracks_of(blocks: Iterator[Array], names: Sequence[str]) -> Tracks:
    """Return the trajectories in blocks of positions, each shape (rows, 3 · number of `names`)."""
    rows = stack(blocks, 3 * len(names))
    return {name: rows[:, 3 * i : 3 * i + 3] for i, name in enumerate(names)}


def euler_turn(joint: Joint, angles: Array) -> Array | None:
    """Return how a joint turns, C R(angles) Cᵀ, shape (T, 3, 3); None if it has no axes.

    Args:
        joint: The joint.
        angles: Angles about its axes, shape (T, axes), rad.
    """
    if not joint.axes:
        return None
    from scipy.spatial.transform import Rotation  # slow to import, needed by few runs

    return joint.frame @ Rotation.from_euler(joint.axes, angles).as_matrix() @ joint.frame.T


def compare_orders(joints: Mapping[str, Joint], report: ImportReport) -> None:
    """Warn of the only joint whose axes come in another order than those of all others.

    The root is left out: CMU's recordings give it an order of its own.
    """
    below = {name: joint for name, joint in joints.items() if joint.parent is not None}
    orders = {name: joint.axes for name, joint in below.items() if len(joint.axes) == 3}
    counts = Counter(orders.values()).most_common()
    if len(counts) == 2 and counts[0][1] > 2 and counts[1][1] == 1:
        odd = next(name for name, order in orders.items() if order == counts[1][0])
        report.warn(
            f"{odd} turns about {orders[odd]}, all other joints about {counts[0][0]}; check the"
            f" CHANNELS of {odd}"
        )
