"""Several movements that are learned together."""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mpma_mj.context import one_hot
from mpma_mj.motions.motion import Motion
from mpma_mj.motions.repeat import way_between

__all__ = ["join"]

Array = NDArray[np.float64]


def join(motions: Sequence[Motion], max_joint_speed: Array) -> Motion:
    """Join movements into one, in which each has one label: its name.

    From the end of each the arms go to the start of the next by a minimum-jerk move, which has
    the label of where it leads.

    Args:
        motions: The movements, of one rate.
        max_joint_speed: Fastest that each joint can turn, shape (8,), rad/s.

    Returns:
        The repertoire.
    """
    names = _distinct([motion.name for motion in motions])
    postures, labels = [motions[0].posture], [0] * len(motions[0])
    for number, (before, motion) in enumerate(itertools.pairwise(motions), start=1):
        way = way_between(before, motion.posture[0], max_joint_speed)
        postures += [way, motion.posture] if len(way) else [motion.posture]
        labels += [number] * (len(way) + len(motion))
    return Motion(
        np.concatenate(postures),
        one_hot(np.array(labels), len(motions)),
        names,
        motions[0].rate,
        "repertoire",
        "; ".join(motion.source for motion in motions),
        motions[0].tempo,
    )


def _distinct(names: Sequence[str]) -> tuple[str, ...]:
    """Number the names that stand more than once."""
    counts, distinct = Counter(names), list[str]()
    for name in names:
        numbered = (f"{name} {i}" for i in itertools.count(1))
        taken = {*names, *distinct}
        distinct.append(next(n for n in numbered if n not in taken) if counts[name] > 1 else name)
    return tuple(distinct)
