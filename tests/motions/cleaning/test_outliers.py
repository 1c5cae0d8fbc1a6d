"""Places far outside the body are gaps, whatever stands for a marker that was not seen."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from mpma_mj.errors import MotionFileError
from mpma_mj.motions import ymca
from mpma_mj.motions.cleaning.outliers import far_from_body, overstretched
from mpma_mj.motions.loader import ImportedMotion, import_motion
from mpma_mj.motions.options import ReadingOptions
from tests.conftest import WriteTsv, dancer, doubts, markers_of

Array = NDArray[np.float64]

POSTURE = ymca(rate=60.0).posture
LOST = slice(20, 28)
TAKEN = "places far outside the body are taken as missing: "


def read(write_tsv: WriteTsv, markers: dict[str, Array], **options: object) -> ImportedMotion:
    path: Path = write_tsv(markers)
    return import_motion(path, ReadingOptions(**options), rate=60.0)  # type: ignore[arg-type]


@pytest.mark.parametrize("axes", [[0, 1, 2], [0], [2]])
@pytest.mark.parametrize("value", [9999.0, -9999.0, 8888.0, 1e6, 9.9e8, 32767.0, -3.7e28])
def test_a_number_for_missing_is_a_gap(write_tsv: WriteTsv, value: float, axes: list[int]) -> None:
    markers = markers_of(dancer(POSTURE))
    markers["Elbow_L"][LOST] = np.nan
    gap = read(write_tsv, markers)
    markers = markers_of(dancer(POSTURE))
    markers["Elbow_L"][LOST, axes] = value
    imported = read(write_tsv, markers)
    np.testing.assert_allclose(imported.motion.posture, gap.motion.posture, atol=1e-9)
    (warning,) = doubts(imported.report)
    assert warning == TAKEN + "Elbow_L (8 frames from 21 on)"


@pytest.mark.parametrize("lost", [2, 4, 7, 8])
def test_many_markers_may_be_lost_at_once(write_tsv: WriteTsv, lost: int) -> None:
    markers = markers_of(dancer(POSTURE))
    names = list(markers)[:lost]
    for name in names:
        markers[name][LOST] = -9999.0
    imported = read(write_tsv, markers)
    (warning,) = doubts(imported.report)
    listed, _, more = warning.removeprefix(TAKEN).partition(" and ")
    expected = [f"{name} (8 frames from 21 on)" for name in names[:5]]
    assert listed.split(", ")[: len(expected)] == expected
    assert more in ("", "1 more", "2 more", "3 more")  # and what is left
    whole = read(write_tsv, markers_of(dancer(POSTURE)))
    kept = np.r_[0:15, 33 : len(POSTURE)]  # but for the filter
    np.testing.assert_allclose(imported.motion.posture[kept], whole.motion.posture[kept], atol=0.02)


def test_a_marker_that_is_far_away_for_long_is_refused(write_tsv: WriteTsv) -> None:
    markers = markers_of(dancer(POSTURE))
    markers["Elbow_L"][20:60] = 9999.0
    with pytest.raises(MotionFileError, match="Elbow_L is missing or far outside the body in fr"):
        read(write_tsv, markers)


def test_frames_count_as_in_the_file(write_tsv: WriteTsv) -> None:
    markers = markers_of(dancer(POSTURE))
    markers["Elbow_L"][90] = 9999.0
    (warning,) = doubts(read(write_tsv, markers, start=1.0).report)
    assert warning == TAKEN + "Elbow_L (1 frame from 91 on)"


def test_bodies_are_left_whole() -> None:
    reach = np.tile([[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]], 2).reshape(2, 2, 3).ravel()
    hang = np.tile([0.0, 0.0, -1.0], 4)
    for posture in (POSTURE, np.stack([hang] * 50 + [reach] * 5), np.stack([hang] * 50)):
        for way in (0.0, 9000.0):  # also one who walks far
            tracks = list(markers_of(dancer(posture)).values())
            walk = np.linspace(0.0, way, len(posture))[:, None]
            assert not np.any(far_from_body([track + walk for track in tracks]))


def test_a_frame_with_one_marker_shows_no_body() -> None:
    tracks = list(markers_of(dancer(POSTURE)).values())
    for track in tracks[1:]:
        track[5] = np.nan
    assert not np.any(far_from_body(tracks))


@pytest.mark.parametrize("value", [-3.7e28, 1e200])
def test_no_number_is_too_large(value: float) -> None:
    tracks = list(markers_of(dancer(POSTURE)).values())
    tracks[2][LOST] = value
    found = far_from_body(tracks)
    np.testing.assert_array_equal(np.flatnonzero(found[2]), np.arange(LOST.start, LOST.stop))
    assert not np.any(found[:2] + found[3:])


@pytest.mark.parametrize(
    "moved", ["wrist", "elbow", "shoulder", "elbow wrist", "shoulder elbow wrist"]
)
@pytest.mark.parametrize("side", ["left", "right"])
def test_a_place_that_stretches_an_arm_is_a_gap(moved: str, side: str) -> None:
    points = dancer(POSTURE)
    assert not overstretched(points)
    expected = {f"{side}_{point}" for point in moved.split()}
    for point in expected:
        points[point][LOST] += [1500.0, 0.0, 0.0]
    found = overstretched(points)
    if len(expected) == 3:  # no segment is long
        expected = set()
    assert found.keys() == expected
    for mask in found.values():
        np.testing.assert_array_equal(np.flatnonzero(mask), np.arange(LOST.start, LOST.stop))


def test_a_place_on_the_floor_is_a_gap(write_tsv: WriteTsv) -> None:
    markers = markers_of(dancer(POSTURE))
    for name in ("Radius_L", "Ulna_L"):
        markers[name][LOST] = np.nan
    gap = read(write_tsv, markers)
    for name in ("Radius_L", "Ulna_L"):
        markers[name][LOST] = -1.0
    imported = read(write_tsv, markers)
    np.testing.assert_allclose(imported.motion.posture, gap.motion.posture, atol=1e-9)


def test_a_marker_that_is_always_far_away_is_refused(write_tsv: WriteTsv) -> None:
    markers = markers_of(dancer(POSTURE))
    markers["Elbow_L"][:] = 9999.0
    with pytest.raises(MotionFileError, match=r"Elbow_L lies far outside .* \(9999, 9999, 9999\)"):
        read(write_tsv, markers)
