"""Foreshortened arms and shoulders are warned of, with their times."""

import numpy as np
import pytest

from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.readers.recording import Tracks
from mpma_mj.motions.readers.video.detector import LANDMARKS
from mpma_mj.motions.readers.video.view import check_view, drop_end_on
from tests.motions.readers.video.clips import pose_of

FRAMES, RATE = 40, 20.0


def seen(forward: float, first: int = 0) -> Tracks:
    """Return places of arms in the frontal plane, forearms by degrees forward from a frame on."""
    frontal, towards = (pose_of([90.0, 150.0] * 2, [0.0, f] * 2) for f in (0.0, forward))
    places = np.array([frontal.space] * first + [towards.space] * (FRAMES - first))
    return {name: places[:, i] * [1.0, 1.0, 0.0] for i, name in enumerate(LANDMARKS)}


def warnings(tracks: Tracks) -> list[str]:
    report = ImportReport()
    check_view(tracks, 3.0, RATE, report)
    return report.warnings


@pytest.mark.parametrize("forward", [0.0, 25.0, 45.0])
def test_arms_at_the_sides_are_no_warning(forward: float) -> None:
    assert not warnings(seen(forward, 10))


@pytest.mark.parametrize("forward", [52.0, 80.0])
def test_an_arm_towards_the_camera_is_a_warning_with_its_time(forward: float) -> None:
    left, right = warnings(seen(forward, 10))
    assert "the left arm points to the camera, or away from it, at 3.5-5.0 s" in left
    assert "the right arm" in right


def test_one_that_never_is_at_the_sides_is_a_warning() -> None:
    assert len(warnings(seen(70.0))) == 2


def test_single_frames_are_no_warning() -> None:
    assert not warnings(seen(70.0, FRAMES - 1))


def test_shoulders_that_turn_are_a_warning() -> None:
    tracks = seen(0.0)
    for track in tracks.values():
        track[20:, 0] *= 0.4
    assert any("turned from the camera at 4.0-5.0 s" in warning for warning in warnings(tracks))


def test_a_segment_without_a_direction_has_no_end() -> None:
    tracks = seen(85.0, 30)
    drop_end_on(tracks)
    missing = np.isnan(tracks["left_wrist"]).any(axis=1)
    assert missing.tolist() == [False] * 30 + [True] * 10
    assert np.isfinite(tracks["left_elbow"]).all()
