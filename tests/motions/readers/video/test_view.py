"""Foreshortened arms and shoulders are warned of, with their times."""

import numpy as np
import pytest

from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.readers.recording import Tracks
from mpma_mj.motions.readers.video.detector import LANDMARKS
from mpma_mj.motions.readers.video.view import bridge_end_on, check_view
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


def test_a_segment_without_a_direction_turns_from_the_one_before_to_the_one_after() -> None:
    angles = [90.0] * 10 + [0.0] * 3 + [30.0] * 10
    forward = [0.0] * 10 + [89.0] * 3 + [0.0] * 10
    poses = [pose_of([60.0, a] * 2, [0.0, f] * 2) for a, f in zip(angles, forward, strict=True)]
    places = np.array([pose.space for pose in poses]) * [1.0, 1.0, 0.0]
    tracks = {name: places[:, i].copy() for i, name in enumerate(LANDMARKS)}
    tracks["left_wrist"][2] = np.nan
    bridge_end_on(tracks)
    for side, outwards in (("left", 1.0), ("right", -1.0)):
        way = tracks[f"{side}_wrist"] - tracks[f"{side}_elbow"]
        found = np.degrees(np.arctan2(outwards * way[:, 0], way[:, 1]))
        np.testing.assert_allclose(found[10:13], [75.0, 60.0, 45.0])
        np.testing.assert_allclose(found[13:], 30.0)
    assert np.flatnonzero(np.isnan(tracks["left_wrist"]).any(axis=1)).tolist() == [2]
    np.testing.assert_array_equal(tracks["left_elbow"], places[:, 1])


def test_a_forearm_keeps_its_direction_where_the_upper_arm_has_none() -> None:
    poses = [pose_of([60.0, 120.0] * 2, [f, 0.0] * 2) for f in (0.0, 0.0, 88.0, 0.0)]
    places = np.array([pose.space for pose in poses]) * [1.0, 1.0, 0.0]
    tracks = {name: places[:, i].copy() for i, name in enumerate(LANDMARKS)}
    bridge_end_on(tracks)
    forearm = tracks["left_wrist"] - tracks["left_elbow"]
    np.testing.assert_allclose(forearm, np.tile(forearm[0], (4, 1)), atol=1e-12)
    assert not np.allclose(tracks["left_elbow"][2], places[2, 1])
