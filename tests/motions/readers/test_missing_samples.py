"""What stands for a place that was not seen, and what is one although it looks like that."""

import numpy as np
import pytest

from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.readers.missing_samples import mark_missing
from mpma_mj.motions.readers.recording import Tracks
from tests.motions.readers import writers

LOST = slice(20, 28)


def seen(tracks: Tracks) -> dict[str, list[int]]:
    """Return the frames of each point in which it is not seen."""
    found = {n: np.flatnonzero(np.isnan(t).all(axis=1)).tolist() for n, t in tracks.items()}
    return {name: frames for name, frames in found.items() if frames}


def test_zeros_are_gaps_unless_they_are_the_origin() -> None:
    points = writers.arm_points()
    points["LELB"][5] = 0.0
    mark_missing(points, ImportReport())
    assert seen(points) == {"LELB": [5]}

    pelvis = np.array([0.0, 0.0, 950.0])
    relative = {name: track - pelvis for name, track in writers.arm_points().items()}
    relative["pelvis"] = np.zeros((60, 3))
    report = ImportReport()
    mark_missing(relative, report)
    assert not seen(relative)
    assert report.steps == ["pelvis is 0, 0, 0 throughout: the origin"]


@pytest.mark.parametrize("place", [(0.0, 0.0, 0.0), (2000.0, 0.0, 0.0)])
def test_a_point_of_zeros_far_from_the_body_is_never_seen(place: tuple[float, ...]) -> None:
    tracks = {name: track + np.array(place) for name, track in writers.arm_points().items()}
    tracks["LWRI"][:] = 0.0
    mark_missing(tracks, ImportReport())
    assert seen(tracks) == {"LWRI": list(range(60))}
