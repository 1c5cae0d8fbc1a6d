"""Points that are only numbered are named by a known skeleton, or not at all."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.readers.recording import Recording
from mpma_mj.motions.readers.tables.numbered_points import name_numbered
from tests.motions.readers import writers

# Of MediaPipe's 33 landmarks those of arms and hips.
NUMBERS = {"LSHO": 11, "RSHO": 12, "LELB": 13, "RELB": 14, "LWRI": 15, "RWRI": 16}
SIDES = {"L": "left", "R": "right"}


def body() -> dict[int, np.ndarray]:
    points = writers.arm_points()
    hips = {23: np.array([0.0, 100.0, 950.0]), 24: np.array([0.0, -100.0, 950.0])}
    arms = {NUMBERS[name]: track for name, track in points.items()}
    return arms | {number: np.tile(place, (60, 1)) for number, place in hips.items()}


def named(tracks: Mapping[str, np.ndarray]) -> tuple[Recording, ImportReport]:
    recording = Recording(
        Path("dance.csv"), "table", tuple(tracks), lambda names: {n: tracks[n] for n in names}
    )
    report = ImportReport()
    return name_numbered(recording, report), report


@pytest.mark.parametrize("title", ["{}", "landmark_{}", "lm{}", "Joint {}"])
def test_landmarks_are_named_with_a_warning(title: str) -> None:
    tracks = {title.format(number): track for number, track in body().items()}
    recording, report = named(tracks)
    assert set(recording.names) == {
        f"{side}_{part}"
        for side in SIDES.values()
        for part in ("shoulder", "elbow", "wrist", "hip")
    }
    (warning,) = report.warnings
    assert "points 11 to 24 have numbers" in warning
    assert "in the order of MediaPipe Pose" in warning
    loaded = recording.load(["left_wrist"])
    np.testing.assert_array_equal(loaded["left_wrist"], body()[15])


def test_numbers_of_no_known_skeleton_stay() -> None:
    rng = np.random.default_rng(0)
    tracks = {str(number): rng.normal(size=(60, 3)) for number in range(12)}
    recording, report = named(tracks)
    assert recording.names == tuple(tracks)
    assert "of no known skeleton" in report.warnings[0]


def test_names_stay() -> None:
    recording, report = named(writers.arm_points())
    assert recording.names == tuple(writers.arm_points())
    mixed = {str(number): track for number, track in body().items()} | {"head": body()[11]}
    assert named(mixed)[0].names == tuple(mixed)
    assert not report.warnings
