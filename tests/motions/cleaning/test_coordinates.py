"""Warnings of coordinates that changed places, or are something else."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from mpma_mj.motions import ymca
from mpma_mj.motions.cleaning.coordinates import exchanged_coordinates
from mpma_mj.motions.loader import import_motion
from mpma_mj.motions.options import ReadingOptions
from tests.conftest import WriteTsv, dancer, doubts
from tests.motions.known_motions import singular

Array = NDArray[np.float64]

ARMS = np.array(
    np.kron(np.eye(2), [[-1, 1, 0], [0, -1, 1]]), np.float64
)  # upper arm and forearm of both sides


def body(noise: float = 0.3) -> dict[str, Array]:
    """Return points, mm, of a dancer who sways."""
    points = dancer(ymca(rate=60.0).posture)
    frames = len(points["left_wrist"])
    points |= {"pelvis": np.full((frames, 3), [0.0, 0.0, 900.0])}
    points |= {"neck": np.full((frames, 3), [0.0, 0.0, 1440.0])}
    rng, sway = np.random.default_rng(0), 30.0 * np.sin(np.arange(frames)[:, None] / [20, 31, 43])
    return {
        name: track + sway + rng.normal(0, noise, (frames, 3)) for name, track in points.items()
    }


def warnings(write_tsv: WriteTsv, points: dict[str, Array]) -> list[str]:
    return doubts(import_motion(write_tsv(points), ReadingOptions()).report)


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (("left_elbow", 2), ("right_elbow", 2)),
        (("left_wrist", 0), ("left_wrist", 1)),
        (("left_elbow", 1), ("right_wrist", 0)),
        (("left_shoulder", 2), ("neck", 2)),
    ],
)
def test_exchanged_columns_are_warned_of(
    write_tsv: WriteTsv, one: tuple[str, int], other: tuple[str, int]
) -> None:
    points = body()
    assert not warnings(write_tsv, points)
    (a, x), (b, y) = one, other
    points[a][:, x], points[b][:, y] = points[b][:, y].copy(), points[a][:, x].copy()
    expected = f"{'xyz'[x]} of {a} and {'xyz'[y]} of {b} seem to be exchanged"
    assert any(warning.startswith(expected) for warning in warnings(write_tsv, points))


def test_the_only_coordinate_that_never_changes_is_warned_of(write_tsv: WriteTsv) -> None:
    points = body()
    points["pelvis"][:, 0] = 45.0
    expected = "x of pelvis is 45 in all frames, while all other coordinates change"
    assert any(warning.startswith(expected) for warning in warnings(write_tsv, points))
    points["neck"][:, 2] = 1440.0  # with more of them it is no recording of a body, but right
    assert not any("in all frames" in warning for warning in warnings(write_tsv, points))


@given(seed=st.integers(0, 999), noise=st.floats(0.0, 20.0))
def test_no_movement_looks_exchanged(seed: int, noise: float) -> None:
    points = np.stack([*dancer(singular(seed).posture).values()])
    points += np.random.default_rng(seed).normal(0.0, noise, points.shape)
    assert exchanged_coordinates(points, ARMS) is None
