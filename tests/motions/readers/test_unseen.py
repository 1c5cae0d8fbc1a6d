"""What stands for a place that was not seen, and what is one although it looks like that."""

import numpy as np
import pytest

from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.readers.recording import Tracks
from mpma_mj.motions.readers.unseen import mark_unseen
from tests.motions.readers import writers

LOST = slice(20, 28)


def seen(tracks: Tracks) -> dict[str, list[int]]:
    """Return the frames of each point in which it is not seen."""
    found = {n: np.flatnonzero(np.isnan(t).all(axis=1)).tolist() for n, t in tracks.items()}
    return {name: frames for name, frames in found.items() if frames}


@pytest.mark.parametrize("axes", [[0, 1, 2], [0], [2]])
@pytest.mark.parametrize(
    "number", [9999.0, -9999.0, 99999.0, 9999.99, float(np.float32(9999.99)), 1e9 + 1, -3.7e28]
)
def test_numbers_that_no_place_has_are_gaps_with_a_warning(number: float, axes: list[int]) -> None:
    tracks = writers.arm_points()
    tracks["LWRI"][LOST, axes] = number
    report = ImportReport()
    mark_unseen(tracks, report)
    assert seen(tracks) == {"LWRI": list(range(20, 28))}
    (warning,) = report.warnings
    assert warning.startswith(f"{number:.6g} is no place: 8 samples of LWRI, the first in row 21")


@pytest.mark.parametrize("number", [999.0, 8888.0, -1.0, 32767.0])
def test_one_number_in_all_axes_far_from_the_others_is_a_gap(number: float) -> None:
    tracks = {name: track + 0.25 for name, track in writers.arm_points().items()}
    tracks["LWRI"] += [5000.0, 0.0, 0.0]
    tracks["LWRI"][LOST] = number
    mark_unseen(tracks, ImportReport())
    assert seen(tracks) == {"LWRI": list(range(20, 28))}


def test_numbers_of_nines_amid_other_places_are_places() -> None:
    tracks = writers.arm_points()
    tracks["LWRI"][:, 2] = np.linspace(900.0, 1100.0, 60)
    tracks["LWRI"][30, 2] = 999.0
    tracks["LELB"][:] = np.linspace(0.0, 118.0, 60)[:, None] + 40.0  # x = y = z throughout
    report = ImportReport()
    mark_unseen(tracks, report)
    assert not seen(tracks)
    assert not report.warnings


def test_a_point_that_is_a_placeholder_throughout_is_never_seen() -> None:
    tracks = writers.arm_points()
    tracks["LWRI"][:] = 9999.0
    mark_unseen(tracks, ImportReport())
    assert seen(tracks) == {"LWRI": list(range(60))}


def test_zeros_are_gaps_unless_they_are_the_origin() -> None:
    points = writers.arm_points()
    points["LELB"][5] = 0.0
    mark_unseen(points, ImportReport())
    assert seen(points) == {"LELB": [5]}

    pelvis = np.array([0.0, 0.0, 950.0])
    relative = {name: track - pelvis for name, track in writers.arm_points().items()}
    relative["pelvis"] = np.zeros((60, 3))
    report = ImportReport()
    mark_unseen(relative, report)
    assert not seen(relative)
    assert report.steps == ["pelvis is 0, 0, 0 throughout: the origin"]


@pytest.mark.parametrize("place", [(0.0, 0.0, 0.0), (2000.0, 0.0, 0.0)])
def test_a_point_of_zeros_far_from_the_body_is_never_seen(place: tuple[float, ...]) -> None:
    tracks = {name: track + np.array(place) for name, track in writers.arm_points().items()}
    tracks["LWRI"][:] = 0.0
    mark_unseen(tracks, ImportReport())
    assert seen(tracks) == {"LWRI": list(range(60))}


def test_a_place_far_from_the_body_is_no_place() -> None:
    walked = np.linspace(50_000.0, 250_000.0, 60)[:, None] * [1.0, 0.0, 0.0]
    tracks = {name: track + walked for name, track in writers.arm_points().items()}
    report = ImportReport()
    mark_unseen(tracks, report)
    assert not seen(tracks)
    tracks["LWRI"][7, 1] = 80_000.0
    mark_unseen(tracks, report)
    assert seen(tracks) == {"LWRI": [7]}
    assert report.warnings[0].startswith("80000 is no place: 1 sample of LWRI, the first in row 8")
