"""From poses in pictures to a motion, and what is refused, without a detector of people."""

import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from mpma_mj.errors import BadOptionError, MotionFileError
from mpma_mj.motions.loader import ImportedMotion, import_motion
from mpma_mj.motions.options import ReadingOptions
from mpma_mj.motions.readers.video import reader
from mpma_mj.motions.readers.video.detector import LANDMARKS, Pose
from tests.motions.readers import writers
from tests.motions.readers.video.clips import FRAMES, GivenPoses, pose_of, write_colours
from tests.motions.video_figure import posture_of

Array = NDArray[np.float64]
Poses = Sequence[Pose | None]
SHOWS = [90.0, 170.0, 45.0, 20.0]


def nobody(frame: int) -> bool:
    return False


class Reader:
    """Reads a video in whose frames given poses are found."""

    def __init__(self, path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        self.path, self._patch = path, monkeypatch
        self.detector = GivenPoses((), nobody)

    def __call__(
        self, poses: Poses, others: Callable[[int], bool] = nobody, **options: object
    ) -> ImportedMotion:
        reader._find_people.cache_clear()
        self.detector = GivenPoses(poses, others)
        self._patch.setattr(reader, "pose_detector", self.detector.open)
        return import_motion(self.path, ReadingOptions(**options))  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def clip(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_colours(tmp_path_factory.mktemp("video") / "dance.mp4")


@pytest.fixture
def read(clip: Path, monkeypatch: pytest.MonkeyPatch) -> Reader:
    return Reader(clip, monkeypatch)


def changed(pose: Pose, point: str, **parts: object) -> Pose:
    """Return a pose with another place or visibility of a point."""
    copies = {name: getattr(pose, name).copy() for name in parts}
    for name, value in parts.items():
        copies[name][LANDMARKS[point] if len(copies[name]) > 8 else [*LANDMARKS].index(point)] = (
            value
        )
    return pose._replace(**copies)


def test_the_left_hand_is_at_the_right_of_the_picture(read: Reader) -> None:
    pose = pose_of([90.0, 90.0, 0.0, 0.0])
    assert pose.places[2, 0] > pose.places[6, 0]
    left, _, right, _ = read([pose]).motion.posture[0].reshape(4, 3)
    np.testing.assert_allclose(left, [0.0, 1.0, 0.0], atol=1e-6)
    np.testing.assert_allclose(right, [0.0, 0.0, -1.0], atol=1e-6)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=6)
@given(
    angles=st.lists(st.floats(0.0, 180.0), min_size=4, max_size=4),
    middle=st.tuples(st.floats(200.0, 440.0), st.floats(200.0, 280.0)),
    scale=st.floats(80.0, 190.0),
)
def test_frontal_directions_do_not_depend_on_place_and_size(
    read: Reader, angles: list[float], middle: tuple[float, float], scale: float
) -> None:
    pose = pose_of(angles, middle=middle, scale=scale)
    posture = read([pose]).motion.posture
    assert len(posture) == FRAMES
    np.testing.assert_allclose(posture, np.tile(posture_of(angles), (FRAMES, 1)), atol=1e-6)


def test_flat_leaves_depth_out_and_estimated_takes_it(read: Reader) -> None:
    forward = [30.0, 40.0, 0.0, 20.0]
    pose = pose_of(SHOWS, forward)
    flat = read([pose]).motion.posture
    np.testing.assert_allclose(flat[0], posture_of(SHOWS), atol=1e-6)
    estimated = read([pose], depth="estimated").motion.posture
    np.testing.assert_allclose(estimated[0], posture_of(SHOWS, forward), atol=1e-6)


def test_a_moving_arm_is_followed_at_its_times(read: Reader) -> None:
    angles = np.linspace(20.0, 160.0, FRAMES)
    motion = read([pose_of([a, a, 10.0, 10.0]) for a in angles]).motion
    found = np.degrees(np.arctan2(motion.posture[:, 1], -motion.posture[:, 2]))
    np.testing.assert_allclose(found, angles, atol=1.0)
    assert motion.rate == 20.0


def test_it_is_said_to_be_experimental(read: Reader) -> None:
    report = read([pose_of(SHOWS)]).report
    assert report.format == "video"
    assert len(report.warnings) == 1
    assert "experimental" in report.warnings[0]
    assert "dance frontally" in report.warnings[0]


def test_frames_outside_of_the_chosen_time_are_not_looked_at(read: Reader) -> None:
    motion = read([pose_of(SHOWS)], start=0.5, end=1.5).motion
    assert len(motion) == 20
    assert motion.start == 0.5
    assert read.detector.looked == 21


def test_a_tempo_that_is_looked_for_looks_at_the_video_once(
    read: Reader, monkeypatch: pytest.MonkeyPatch
) -> None:
    read([pose_of(SHOWS)])
    import_motion(read.path, ReadingOptions(tempo=0.5))
    import_motion(read.path, ReadingOptions(depth="estimated"))
    assert read.detector.looked == FRAMES


def test_another_file_of_the_same_name_is_looked_at(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    read = Reader(write_colours(tmp_path / "dance.mp4"), monkeypatch)
    read([pose_of(SHOWS)])
    write_colours(read.path, 4.0)
    assert len(import_motion(read.path, ReadingOptions()).motion) == 80


def test_an_arm_towards_the_camera_is_warned_of_with_its_time(read: Reader) -> None:
    towards = pose_of(SHOWS, [0.0, 70.0, 0.0, 0.0])
    poses = [pose_of(SHOWS)] * 20 + [towards] * 10 + [pose_of(SHOWS)] * 10
    warning = next(w for w in read(poses).report.warnings if "points to the camera" in w)
    assert "the left arm points to the camera, or away from it, at 1.0-1.5 s" in warning
    assert "135°" in warning


def test_where_no_direction_is_left_it_is_bridged(read: Reader) -> None:
    towards = pose_of(SHOWS, [0.0, 89.0, 0.0, 0.0])
    poses = [pose_of(SHOWS)] * 20 + [towards] * 10 + [pose_of(SHOWS)] * 10
    posture = read(poses).motion.posture
    np.testing.assert_allclose(posture, np.tile(posture_of(SHOWS), (FRAMES, 1)), atol=1e-6)


def test_a_person_who_turns_is_warned_of(read: Reader) -> None:
    turned = pose_of(SHOWS)
    turned = turned._replace(places=turned.places * [0.3, 1.0] + [224.0, 0.0])
    poses = [pose_of(SHOWS)] * 20 + [turned] * 20
    assert any("turned from the camera at 1.0-2.0 s" in w for w in read(poses).report.warnings)


def test_frames_without_the_person_are_gaps(read: Reader) -> None:
    poses: list[Pose | None] = [pose_of(SHOWS)] * FRAMES
    poses[10:13] = [None] * 3
    assert len(read(poses).motion) == FRAMES
    poses[10:20] = [None] * 10
    with pytest.raises(MotionFileError, match=r"longer than 0\.25 s"):
        read(poses)
    assert len(read(poses, longest=True).motion) == 20


@pytest.mark.parametrize("seen", [0, 1])
def test_nobody_is_refused(read: Reader, seen: int) -> None:
    poses = [pose_of(SHOWS)] * seen + [None]
    where = "in any of 40 frames" if seen == 0 else "in 1 of 40 frames"
    with pytest.raises(MotionFileError, match=f"no person is found {where}; film one person"):
        read(poses)


def test_two_people_are_refused(read: Reader) -> None:
    with pytest.raises(MotionFileError, match=r"shows two people or more, as at 0\.0 s; cut the"):
        read([pose_of(SHOWS)], lambda frame: True)


def test_a_passer_by_is_warned_of(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    read = Reader(write_colours(tmp_path / "dance.mp4", 6.0), monkeypatch)
    warnings = read([pose_of(SHOWS)], lambda frame: frame == 100).report.warnings
    assert any("another person is in the picture at 5.0 s" in warning for warning in warnings)


def test_a_jump_to_another_person_is_warned_of(read: Reader) -> None:
    poses = [pose_of(SHOWS)] * 15 + [pose_of(SHOWS, middle=(450.0, 240.0))] * 25
    warnings = read(poses).report.warnings
    assert any("jumps within the picture at 0.75 s" in warning for warning in warnings)


@pytest.mark.parametrize("how", ["hidden", "outside"])
def test_an_arm_that_is_not_seen_is_refused_or_replaced(read: Reader, how: str) -> None:
    part = {"visibility": 0.2} if how == "hidden" else {"places": [700.0, 240.0]}
    pose = changed(pose_of(SHOWS), "left_wrist", **part)
    with pytest.raises(MotionFileError, match="the person's left wrist cannot be seen in most"):
        read([pose])
    left, _, right, _ = read([pose], other_arm="mirror").motion.posture[0].reshape(4, 3)
    np.testing.assert_allclose(left, right * [1.0, -1.0, 1.0], atol=1e-6)


def test_no_arms_are_refused_whatever_the_other_arm_does(read: Reader) -> None:
    pose = pose_of(SHOWS)
    for name in ("left_elbow", "right_wrist"):
        pose = changed(pose, name, visibility=0.1)
    for options in ({}, {"other_arm": "hang"}):
        with pytest.raises(MotionFileError, match="most frames; film the whole body") as error:
            read([pose], **options)
        assert "other_arm" not in str(error.value)


def test_a_point_that_may_be_guessed_is_warned_of(read: Reader) -> None:
    warnings = read([changed(pose_of(SHOWS), "right_wrist", visibility=0.6)]).report.warnings
    assert any("the right wrist may be hidden or guessed" in warning for warning in warnings)


def test_without_hips_the_torso_is_upright(read: Reader) -> None:
    pose = changed(changed(pose_of(SHOWS), "left_hip", visibility=0.1), "right_hip", visibility=0.1)
    imported = read([pose])
    np.testing.assert_allclose(imported.motion.posture[0], posture_of(SHOWS), atol=1e-6)
    assert any("torso is assumed to be upright" in w for w in imported.report.warnings)


def test_a_bent_torso_turns_the_arms_with_it(read: Reader) -> None:
    pose, turn = pose_of(SHOWS, middle=(0.0, 0.0)), np.radians(20.0)
    turned = pose.places @ [[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]]
    motion = read([pose._replace(places=turned + np.array([320.0, 240.0]))]).motion
    np.testing.assert_allclose(motion.posture[0], posture_of(SHOWS), atol=1e-6)


def test_a_clip_of_few_frames_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    read = Reader(write_colours(tmp_path / "dance.gif", 0.2), monkeypatch)
    with pytest.raises(MotionFileError, match="has 4 frames; a motion needs at least 8"):
        read([pose_of(SHOWS)])


def test_a_file_that_is_cut_short_is_warned_of(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write_colours(tmp_path / "dance.mkv", 4.0)
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    warnings = Reader(path, monkeypatch)([pose_of(SHOWS)]).report.warnings
    assert any("of 80 frames can be decoded: the file is damaged" in w for w in warnings)


USELESS = {
    "map": "left_wrist=a",
    "skeleton": "a.asf",
    "unit": "mm",
    "up": "z",
    "left_handed": True,
    "rate_in": 30.0,
}


@pytest.mark.parametrize("option", USELESS)
def test_options_of_points_are_refused(read: Reader, option: str) -> None:
    with pytest.raises(BadOptionError, match=f"is a video; leave out {option}, which is for rec"):
        read([pose_of(SHOWS)], **{option: USELESS[option]})


def test_depth_of_other_recordings_is_refused(tmp_path: Path, points: writers.Points) -> None:
    path = writers.write_npz(tmp_path / "dance.npz", points)
    with pytest.raises(BadOptionError, match="is npz; leave out depth, which is for videos"):
        import_motion(path, ReadingOptions(depth="estimated"))
    with pytest.raises(BadOptionError, match="leave out depth, which is for recordings"):
        import_motion("ymca", ReadingOptions(depth="estimated"))


class NoMediapipe:
    """Finder of modules where mediapipe is not installed."""

    def find_spec(self, name: str, *_: object) -> None:
        if name.split(".")[0] == "mediapipe":
            raise ModuleNotFoundError(f"No module named '{name}'", name=name)


def test_without_mediapipe_the_line_that_installs_it_is_given(
    clip: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    reader._find_people.cache_clear()
    for name in [name for name in sys.modules if name.split(".")[0] == "mediapipe"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setattr(sys, "meta_path", [NoMediapipe(), *sys.meta_path])
    with pytest.raises(BadOptionError, match=r"not installed; .* pip install -e '\.\[video\]'"):
        import_motion(clip, ReadingOptions())
