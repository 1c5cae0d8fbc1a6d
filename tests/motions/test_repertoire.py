import dataclasses
from itertools import groupby

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from mpma_mj import kinematics
from mpma_mj.context import equal_segments
from mpma_mj.motions import Motion, ymca
from mpma_mj.motions.feasibility import check_feasibility
from mpma_mj.motions.transforms import join

Array = NDArray[np.float64]

SPEED = np.array([12.0, 12.0, 20.0, 15.0] * 2)  # rad/s


def wander(seed: int, frames: int, name: str) -> Motion:
    rng = np.random.default_rng(seed)
    rest = np.tile([0.6, 0.2, 0.0, 1.0], 2) + rng.uniform(-0.3, 0.3, 8)
    phase = np.arange(frames)[:, None] / rng.uniform(5.0, 15.0, 8)
    posture = kinematics.posture_from_angles(rest + 0.3 * np.sin(phase + rng.uniform(0, 6, 8)))
    return Motion(posture, *equal_segments(frames, 2), 20.0, name, f"source of {name}")


def parts(motion: Motion) -> list[slice]:
    """Return the stretch of each label in turn."""
    found, first = [], 0
    for _, same in groupby(motion.context.argmax(axis=1)):
        length = len(list(same))
        found.append(slice(first, first + length))
        first += length
    return found


@settings(max_examples=30)
@given(lengths=st.lists(st.integers(2, 60), min_size=1, max_size=5), seed=st.integers(0, 99))
def test_every_movement_is_there_untouched_with_its_one_label(
    lengths: list[int], seed: int
) -> None:
    motions = [wander(seed + i, length, f"dance{i}") for i, length in enumerate(lengths)]
    joined = join(motions, SPEED)
    np.testing.assert_array_equal(joined.context.sum(axis=1), 1.0)
    assert joined.labels == tuple(motion.name for motion in motions)
    assert (np.diff(joined.context.argmax(axis=1)) >= 0).all()
    found = parts(joined)
    assert len(found) == len(motions)
    for motion, part in zip(motions, found, strict=True):
        np.testing.assert_array_equal(joined.posture[part][-len(motion) :], motion.posture)
    assert found[0] == slice(0, lengths[0])  # nothing is before the first


@settings(max_examples=30)
@given(lengths=st.lists(st.integers(2, 40), min_size=2, max_size=4), seed=st.integers(0, 99))
def test_the_ways_between_are_within_the_joints_speed(lengths: list[int], seed: int) -> None:
    motions = [wander(seed + i, length, f"dance{i}") for i, length in enumerate(lengths)]
    joined = join(motions, SPEED)
    speed = np.abs(np.diff(kinematics.continuous_angles(joined.posture), axis=0)) * 20.0
    for motion, part in zip(motions[1:], parts(joined)[1:], strict=True):
        way = speed[part.start - 1 : part.stop - len(motion)]
        assert (way <= 0.55 * SPEED).all()
    check_feasibility(joined, SPEED, 2.8)


def test_movements_that_lead_into_each_other_are_joined_as_they_are() -> None:
    joined = join([ymca(), dataclasses.replace(ymca(), name="again")], SPEED)
    np.testing.assert_array_equal(joined.posture, np.tile(ymca().posture, (2, 1)))
    assert joined.labels == ("ymca", "again")


@pytest.mark.parametrize(
    ("names", "labels"),
    [
        ("abc", ("a", "b", "c")),
        ("aba", ("a 1", "b", "a 2")),
        ("aaa", ("a 1", "a 2", "a 3")),
        (("a", "a", "a 1"), ("a 2", "a 3", "a 1")),
        (("a 1", "a", "a"), ("a 1", "a 2", "a 3")),
        (("a 1", "a 1", "a", "a"), ("a 1 1", "a 1 2", "a 2", "a 3")),
    ],
)
def test_names_that_stand_twice_are_numbered(names: str, labels: tuple[str, ...]) -> None:
    motions = [wander(i, 5, name) for i, name in enumerate(names)]
    assert join(motions, SPEED).labels == labels


def test_the_sources_of_all_are_told() -> None:
    joined = join([wander(0, 5, "a"), wander(1, 5, "b")], SPEED)
    assert joined.source == "source of a; source of b"
    assert joined.rate == 20.0
