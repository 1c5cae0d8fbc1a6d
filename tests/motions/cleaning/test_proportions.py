"""Proportions that no body has are told."""

import numpy as np
import pytest
from numpy.typing import NDArray

from mpma_mj.motions import ymca
from mpma_mj.motions.loader import import_motion
from mpma_mj.motions.options import ReadingOptions
from tests.conftest import WriteTsv, dancer

Array = NDArray[np.float64]


def body() -> dict[str, Array]:
    """Return points, mm, of a dancer with a torso."""
    points = dancer(ymca(rate=60.0).posture)
    frames = len(points["left_wrist"])
    sway = 30.0 * np.sin(np.arange(frames)[:, None] / 20.0) * [1.0, 1.0, 0.0]
    points |= {"pelvis": np.full((frames, 3), [0.0, 0.0, 900.0])}
    points |= {"neck": np.full((frames, 3), [0.0, 0.0, 1440.0])}
    return {name: track + sway for name, track in points.items()}


def warnings(write_tsv: WriteTsv, points: dict[str, Array]) -> list[str]:
    return import_motion(write_tsv(points), ReadingOptions()).report.warnings


def longer(share: float) -> dict[str, Array]:
    """Return a body whose left forearm is longer than the right one."""
    points = body()
    points["left_wrist"] += share * (points["left_wrist"] - points["left_elbow"])
    return points


@pytest.mark.parametrize("share", [0.0, 0.2, -0.18])
def test_a_body_is_not_doubted(write_tsv: WriteTsv, share: float) -> None:
    assert not warnings(write_tsv, longer(share))


@pytest.mark.parametrize(
    ("share", "far", "near"), [(0.5, "left", "right"), (-0.4, "right", "left")]
)
def test_unlike_arms_are_told(write_tsv: WriteTsv, share: float, far: str, near: str) -> None:
    (warning,) = warnings(write_tsv, longer(share))
    assert warning.startswith("elbow and wrist are 1.")
    assert f"times as far apart on the {far} as on the {near}" in warning


def test_a_shoulder_in_the_wrong_place_is_told(write_tsv: WriteTsv) -> None:
    points = body()
    for point in ("shoulder", "elbow", "wrist"):
        points[f"left_{point}"] += [0.0, 90.0, 0.0]
    (warning,) = warnings(write_tsv, points)
    assert warning.startswith("neck and shoulder are 1.4")


def test_columns_that_changed_places_are_told(write_tsv: WriteTsv) -> None:
    points = body()
    for one, other, axis, words in (
        ("left_wrist", "right_wrist", 1, "length varies by"),
        ("pelvis", "neck", 2, "the shoulders lie at"),
        ("pelvis", "left_wrist", 1, "make an angle of"),
    ):
        exchanged = {name: track.copy() for name, track in points.items()}
        exchanged[one][:, axis], exchanged[other][:, axis] = (
            points[other][:, axis],
            points[one][:, axis],
        )
        assert any(words in warning for warning in warnings(write_tsv, exchanged)), words
