from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from mpma_mj import kinematics
from mpma_mj.errors import MotionFileError
from mpma_mj.motions import ymca
from mpma_mj.motions.body import check_segments, posture_from_points
from mpma_mj.motions.loader import import_motion
from mpma_mj.motions.options import ReadingOptions
from mpma_mj.motions.orientation import turn_z_up
from mpma_mj.motions.readers.recording import UPS, Up
from tests.conftest import dancer, markers_of

Array = NDArray[np.float64]
Points = dict[str, Array]

POSTURE = ymca(rate=60.0).posture.copy()
FACING = {  # how a dancer who stands along z has to be turned to stand along another axis
    "z": Rotation.identity(),
    "-z": Rotation.from_euler("x", np.pi),
    "y": Rotation.from_euler("x", -np.pi / 2),
    "-y": Rotation.from_euler("x", np.pi / 2),
    "x": Rotation.from_euler("y", np.pi / 2),
    "-x": Rotation.from_euler("y", -np.pi / 2),
}
vectors = st.tuples(*3 * [st.floats(-3.0, 3.0)]).map(np.array)


def with_torso(points: Points) -> Points:
    frames = len(points["left_wrist"])
    torso = {"pelvis": [0.0, 0.0, 950.0], "neck": [0.0, 0.0, 1450.0]}
    return points | {name: np.tile(place, (frames, 1)) for name, place in torso.items()}


def moved(points: Points, rotation: Rotation, way: Array) -> Points:
    return {name: rotation.apply(track) + way for name, track in points.items()}


def torso_markers(frames: int) -> Points:
    places = {
        **{"Hip_FL": [90.0, 120.0, 960.0], "Hip_FR": [90.0, -120.0, 960.0]},
        **{"Hip_BL": [-90.0, 120.0, 940.0], "Hip_BR": [-90.0, -120.0, 940.0]},
        **{"C7": [-60.0, 0.0, 1480.0], "CLAV": [60.0, 0.0, 1400.0]},
    }
    return {name: np.tile(place, (frames, 1)) for name, place in places.items()}


def save(path: Path, points: Points, **more: object) -> Path:
    np.savez(path, rate=60.0, **points, **more)  # type: ignore[arg-type]
    return path


def test_postures_of_a_dancer_are_found_again() -> None:
    for points in (dancer(POSTURE), with_torso(dancer(POSTURE))):
        np.testing.assert_allclose(posture_from_points(points), POSTURE, atol=1e-12)


@given(start=st.floats(-3.1, 3.1), speed=st.floats(-3.0, 3.0), walk=vectors)
def test_a_dancer_who_turns_and_walks_gives_the_same_arms(
    start: float, speed: float, walk: Array
) -> None:
    time = np.arange(len(POSTURE)) / 60.0
    turn = Rotation.from_euler("z", (start + speed * time + 0.5 * np.sin(3 * time))[:, None])
    points = moved(dancer(POSTURE), turn, 1000.0 * np.outer(np.sin(time), walk))
    np.testing.assert_allclose(posture_from_points(points), POSTURE, atol=1e-9)


@given(start=vectors, speed=vectors, walk=vectors, up=st.sampled_from(UPS))
def test_a_dancer_who_bends_gives_the_same_arms_if_the_trunk_is_known(
    start: Array, speed: Array, walk: Array, up: Up
) -> None:
    time = np.arange(len(POSTURE))[:, None] / 60.0
    bend = FACING[up] * Rotation.from_rotvec(start + speed * time)
    points = moved(with_torso(dancer(POSTURE)), bend, 1000.0 * time * walk)
    points = {name: turn_z_up(track, up) for name, track in points.items()}
    np.testing.assert_allclose(posture_from_points(points), POSTURE, atol=1e-9)


def test_a_bend_moves_the_arms_if_the_trunk_is_not_known() -> None:
    bent = moved(dancer(POSTURE), Rotation.from_euler("y", 0.5), np.zeros(3))
    found = posture_from_points(bent).reshape(-1, 4, 3)
    # Bending forward by 0.5 rad turns every segment by that about the axis of the shoulders.
    expected = Rotation.from_euler("y", 0.5).apply(POSTURE.reshape(-1, 3)).reshape(-1, 4, 3)
    np.testing.assert_allclose(found, expected, atol=1e-9)
    assert np.abs(found.reshape(-1, 12) - POSTURE).max() > 0.4


@given(scale=st.lists(st.floats(0.01, 100.0), min_size=4, max_size=4))
def test_a_dancers_proportions_do_not_matter(scale: list[float]) -> None:
    points = dancer(POSTURE)
    for i, side in enumerate(kinematics.SIDES):
        shoulder, elbow, wrist = (points[f"{side}_{p}"] for p in ("shoulder", "elbow", "wrist"))
        points[f"{side}_elbow"] = shoulder + scale[2 * i] * (elbow - shoulder)
        points[f"{side}_wrist"] = points[f"{side}_elbow"] + scale[2 * i + 1] * (wrist - elbow)
    np.testing.assert_allclose(posture_from_points(points), POSTURE, atol=1e-9)


@pytest.mark.parametrize("up", UPS)
@pytest.mark.parametrize("bend", [[0.0, 0.0, 2.0], [0.0, 1.2, 0.0], [1.0, -2.0, 0.5]])
def test_recordings_with_torso_markers_are_read_the_same_however_the_dancer_lies(
    tmp_path: Path, up: Up, bend: list[float]
) -> None:
    points = markers_of(dancer(POSTURE)) | torso_markers(len(POSTURE))
    upright = import_motion(save(tmp_path / "upright.npz", points), ReadingOptions())
    lying = moved(points, FACING[up] * Rotation.from_rotvec(bend), np.array([5e3, -2e3, 1e3]))
    read = import_motion(save(tmp_path / "lying.npz", lying), ReadingOptions())
    np.testing.assert_allclose(read.motion.posture, upright.motion.posture, atol=1e-9)
    assert np.abs(read.motion.posture - POSTURE[::3]).mean() < 0.01


def test_a_dancer_who_faces_anywhere_is_read_whatever_axis_is_up(tmp_path: Path) -> None:
    # Shoulders along the file's z are not above each other where y is up.
    turn = FACING["y"] * Rotation.from_euler("z", np.linspace(0.0, 7.0, len(POSTURE))[:, None])
    points = moved(dancer(POSTURE), turn, np.zeros(3))
    path = save(tmp_path / "dance.npz", points, up="y")
    found = import_motion(path, ReadingOptions()).motion.posture
    assert np.abs(found - POSTURE[::3]).mean() < 0.02


@settings(max_examples=20)
@given(frame=st.integers(0, len(POSTURE) - 1), first=st.integers(0, 1000))
def test_a_frame_in_which_markers_lie_in_one_place_is_named(frame: int, first: int) -> None:
    points = dancer(POSTURE)
    points["left_wrist"][frame] = points["left_elbow"][frame]
    message = rf"^dance\.x: the left forearm has length 0 at frame {first + frame + 1} \(median 250"
    with pytest.raises(MotionFileError, match=message):
        check_segments(points, "dance.x", first)


def test_shoulders_above_each_other_are_named_as_that() -> None:
    points = dancer(POSTURE)
    points["left_shoulder"][7] = points["right_shoulder"][7] + [0.0, 0.0, 300.0]
    with pytest.raises(MotionFileError, match=r"shoulders, seen.* frame 8 .*lie above each other"):
        check_segments(points, "dance.x")


def test_a_trunk_whose_length_varies_is_warned_about(tmp_path: Path) -> None:
    points = with_torso(dancer(POSTURE))
    whole = import_motion(save(tmp_path / "a.npz", points), ReadingOptions())
    assert not whole.report.warnings
    points["neck"][20:30] = [1.0, 1.0, 1.0]  # on the floor, below the pelvis
    (warning,) = import_motion(save(tmp_path / "a.npz", points), ReadingOptions()).report.warnings
    assert warning.startswith("the trunk's length varies by ")
