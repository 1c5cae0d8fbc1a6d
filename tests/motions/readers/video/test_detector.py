"""The detector of mediapipe on a drawn figure: found, with its sides, to 20°, always the same."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from mpma_mj.cli import main
from mpma_mj.errors import MotionFileError
from mpma_mj.motions.loader import import_motion
from mpma_mj.motions.options import ReadingOptions
from mpma_mj.motions.readers.video import reader
from mpma_mj.motions.readers.video.detector import pose_detector
from tests.conftest import Refused
from tests.motions.readers.video.clips import write_colours
from tests.motions.video_figure import Figure, posture_of, write_clip

pytest.importorskip("mediapipe")

Array = NDArray[np.float64]

# Angles of upper arm and forearm, left and right, in the frontal plane, degrees. The sleeves hide
# the figure's shoulders where its upper arms point further up than 150°.
FRONTAL = [
    *([10.0] * 4, [45.0] * 4, [90.0] * 4, [135.0] * 4, [150.0, 170.0] * 2),
    *([90.0, 180.0] * 2, [45.0, 90.0] * 2, [100.0, 220.0] * 2),
    *([150.0, 150.0, 90.0, 90.0], [90.0, 90.0, 10.0, 10.0]),
    [20.0, 40.0, 120.0, 160.0],
]
HELD = 8  # frames of a pose


def off(found: Array, true: Array) -> Array:
    """Return the angles, degrees, between the segments of two postures."""
    cosines = np.sum(found.reshape(-1, 4, 3) * true.reshape(-1, 4, 3), axis=2)
    return np.degrees(np.arccos(np.clip(cosines, -1.0, 1.0)))


@pytest.fixture(scope="module")
def figure(opengl: None) -> Figure:
    return Figure()


@pytest.fixture(scope="module")
def dance(figure: Figure, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Array]:
    """A clip that holds one pose after the other, and its postures."""
    pictures, postures = [], []
    for angles in FRONTAL:
        figure.pose(posture_of(angles))
        postures.append(figure.posture)
        pictures += [figure.draw()] * HELD
    path = write_clip(tmp_path_factory.mktemp("video") / "dance.mp4", pictures)
    return path, np.array(postures)


def test_frontal_arms_are_found_to_20_degrees(dance: tuple[Path, Array]) -> None:
    path, postures = dance
    motion, report = import_motion(path, ReadingOptions())
    found = motion.posture[HELD // 2 :: HELD]
    errors = off(found, postures)
    assert errors.max() < 20.0, errors.round()
    assert np.median(errors) < 8.0
    assert not any("camera" in warning or "hidden" in warning for warning in report.warnings)


def test_the_same_file_is_the_same_motion_to_the_bit(dance: tuple[Path, Array]) -> None:
    path, _ = dance
    motions = []
    for _ in range(2):
        reader._find_people.cache_clear()
        motions.append(import_motion(path, ReadingOptions(end=1.0, depth="estimated")).motion)
    np.testing.assert_array_equal(motions[0].posture, motions[1].posture)


def test_arms_towards_the_camera_are_warned_of(figure: Figure, tmp_path: Path) -> None:
    figure.pose(posture_of([90.0] * 4))
    pictures = [figure.draw()] * 10
    figure.pose(posture_of([60.0] * 4, [70.0] * 4))
    path = write_clip(tmp_path / "dance.mp4", pictures + [figure.draw()] * 10)
    report = import_motion(path, ReadingOptions()).report
    for side in ("left", "right"):
        expected = f"the {side} arm points to the camera, or away from it, at 0.5-1.0 s"
        assert any(expected in warning for warning in report.warnings)


def test_two_people_are_refused(opengl: None, tmp_path: Path) -> None:
    figure = Figure((-0.6, 0.6))
    figure.pose(posture_of([45.0] * 4))
    path = write_clip(tmp_path / "dance.mp4", [figure.draw()] * 25)
    with pytest.raises(MotionFileError, match="shows two people or more"):
        import_motion(path, ReadingOptions())


def test_missing_arms_are_refused(opengl: None, tmp_path: Path) -> None:
    figure = Figure(hidden="lr")
    figure.pose(posture_of([45.0] * 4))
    path = write_clip(tmp_path / "dance.mp4", [figure.draw()] * 10)
    with pytest.raises(MotionFileError, match="wrist cannot be seen in most frames"):
        import_motion(path, ReadingOptions())


def test_nobody_is_refused_in_one_line(tmp_path: Path, refused: Refused) -> None:
    path = write_colours(tmp_path / "dance.mp4")
    refused(["motion", str(path)], "no person is found in any of 40 frames")


def test_the_library_writes_nothing(
    figure: Figure, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    figure.pose(posture_of([45.0] * 4))
    with pose_detector(tmp_path) as detector:
        assert detector.find(figure.draw()) is not None
    assert capfd.readouterr() == ("", "")


def test_the_command_reports_and_draws(
    dance: tuple[Path, Array],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["motion", str(dance[0]), "--to", "1"]) == 0
    out, err = capfd.readouterr()
    assert "dance: video, 21 frames at 20 Hz" in out
    assert all(line.startswith("mpma: warning:") for line in err.splitlines())
    assert Path("dance-motion.png").exists()
