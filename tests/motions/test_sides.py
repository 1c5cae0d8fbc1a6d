import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from mpma_mj import kinematics
from mpma_mj.motions import ymca
from mpma_mj.motions.body import posture_from_points
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.loader import import_motion
from mpma_mj.motions.options import ReadingOptions
from mpma_mj.motions.orientation import check_sides
from tests.conftest import WriteTsv, dancer, markers_of

Array = NDArray[np.float64]
Points = dict[str, Array]


def moving(seed: int, elbow: float = 1.0) -> Points:
    """Return a dancer whose elbows bend forearms forward, about as far as is asked."""
    rng = np.random.default_rng(seed)
    rest = np.tile([0.5, 0.3, 0.0, elbow], 2)
    phase = np.arange(200)[:, None] / rng.uniform(8.0, 20.0, 8) + rng.uniform(0, 6, 8)
    return dancer(kinematics.posture_from_angles(rest + 0.3 * elbow * np.sin(phase)))


def swapped(points: Points, *parts: str) -> Points:
    other = {"left": "right", "right": "left"}
    found = dict(points)
    for name in points:
        side, _, part = name.partition("_")
        if part in parts:
            found[name] = points[f"{other[side]}_{part}"]
    return found


def warnings(points: Points) -> list[str]:
    report = ImportReport()
    groups = {name: (name.upper(),) for name in points}
    check_sides(points, posture_from_points(points), groups, report)
    return report.warnings


@given(seed=st.integers(0, 999))
def test_a_dancer_whose_sides_are_right_is_not_warned_about(seed: int) -> None:
    assert not warnings(moving(seed))


@given(seed=st.integers(0, 999))
def test_elbows_and_wrists_of_the_other_side_are_warned_about(seed: int) -> None:
    (warning,) = warnings(swapped(moving(seed), "elbow", "wrist"))
    assert warning.startswith("both elbows are beyond the body's midline in 100 % of the frames")


@given(seed=st.integers(0, 999))
def test_a_dancer_whose_every_name_is_of_the_other_side_is_warned_about(seed: int) -> None:
    (warning,) = warnings(swapped(moving(seed), "shoulder", "elbow", "wrist"))
    assert warning.startswith("forearms point backwards in 100 % of the frames in which they are")


@given(seed=st.integers(0, 999))
def test_stretched_arms_tell_nothing(seed: int) -> None:
    for parts in ((), ("shoulder", "elbow", "wrist")):
        assert not warnings(swapped(moving(seed, elbow=0.05), *parts))


@pytest.mark.parametrize("tempo", [0.5, 1.0])
def test_the_built_in_dance_is_not_warned_about(tempo: float) -> None:
    assert not warnings(dancer(ymca(rate=60.0, tempo=tempo).posture))


def test_arms_that_cross_now_and_then_are_not_warned_about() -> None:
    points = moving(0)
    crossed = swapped(points, "elbow", "wrist")
    for name, track in points.items():
        crossed[name] = np.where(np.arange(200)[:, None] < 80, crossed[name], track)
    assert not warnings(crossed)


def test_sides_of_a_file_are_checked(write_tsv: WriteTsv) -> None:
    points = moving(1)
    assert not import_motion(
        write_tsv(markers_of(points), name="right.tsv"), ReadingOptions()
    ).report.warnings
    wrong = swapped(points, "shoulder", "elbow", "wrist")
    imported = import_motion(write_tsv(markers_of(wrong)), ReadingOptions())
    assert len(imported.report.warnings) == 1
    mapping = re.findall(r'map="(.*?)" mends', imported.report.warnings[0])
    mended = import_motion(write_tsv(markers_of(wrong)), ReadingOptions(map=mapping[0]))
    assert not mended.report.warnings
    right = import_motion(write_tsv(markers_of(points)), ReadingOptions())
    np.testing.assert_allclose(mended.motion.posture, right.motion.posture, atol=1e-9)
