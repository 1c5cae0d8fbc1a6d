"""Real recordings, where MPMA_MOCAP names a folder that has them."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from mpma_mj.envs.load import load
from mpma_mj.errors import MotionFileError
from mpma_mj.motions import read_motion
from mpma_mj.motions.loader import ImportedMotion, import_motion
from mpma_mj.motions.options import ReadingOptions

Array = NDArray[np.float64]

WITHOUT_RATE = ("cmu_amc/01_01.amc", "hdm05/HDM_dg_06-03_03_120.amc")
PEOPLE = (
    *WITHOUT_RATE,
    *("cmu_amc/01_01.bvh", "cmu_bvh/indian_13.bvh", "hdm05/HDM_dg_06-03_03_120.c3d"),
    *("qualisys_c3d/Qualisys.c3d", "qualisys_tsv/dance.tsv", "qualisys_tsv/walk.tsv"),
)


def read(path: Path) -> ImportedMotion:
    return import_motion(path, ReadingOptions(max_gap=0.3, cutoff=6.0))


@pytest.mark.parametrize("name", PEOPLE)
def test_people_have_arms_that_bend_forward_and_bodies_of_human_size(
    mocap: Path, name: str
) -> None:
    imported = read(mocap / name)
    segments = imported.motion.posture.reshape(-1, 4, 3)
    bent = segments[:, 1::2, 0] - segments[:, ::2, 0]
    assert bent.mean() > 0.1
    assert imported.report.metric
    for mean, deviation in imported.report.lengths.values():
        assert 0.18 < mean < 0.45
        assert deviation < 0.05 * mean
    duration = imported.report.frames / imported.report.rate
    assert imported.motion.duration == pytest.approx(duration, abs=0.2)  # without a ramp
    assert np.abs(np.diff(imported.motion.posture, axis=0)).max() < 0.75  # 15 rad/s
    load(imported.motion)


@pytest.mark.parametrize("name", PEOPLE)
def test_good_recordings_are_not_warned_about(mocap: Path, name: str) -> None:
    expected = ["AMC files carry no rate; 120 Hz is used; rate_in overrides it"]
    told = [w for w in read(mocap / name).report.warnings if "calibration" not in w]
    assert told == expected * (name in WITHOUT_RATE)


@pytest.mark.parametrize("name", PEOPLE)
def test_only_the_pose_that_export_puts_first_is_cut(mocap: Path, name: str) -> None:
    poses = {"cmu_amc/01_01.bvh": 1, "cmu_bvh/indian_13.bvh": 16}
    imported = read(mocap / name)
    cut = [step for step in imported.report.warnings if "calibration" in step]
    assert len(cut) == (name in poses)
    assert imported.report.times[0] == pytest.approx(poses.get(name, 0) / imported.report.rate)


def test_the_same_dance_as_skeleton_and_as_motion_capture_is_the_same(mocap: Path) -> None:
    bvh = read(mocap / "cmu_amc" / "01_01.bvh").motion.posture
    amc = read(mocap / "cmu_amc" / "01_01.amc").motion.posture
    # The BVH has a T-pose before the first frame; its forearms end elsewhere in the hand.
    angle = np.arccos(np.clip(np.sum((bvh * amc).reshape(-1, 4, 3), axis=2), -1, 1))
    assert np.median(angle[:, ::2]) < 0.05


def test_the_same_dance_as_markers_and_as_skeleton_is_similar(mocap: Path) -> None:
    c3d = read(mocap / "hdm05" / "HDM_dg_06-03_03_120.c3d").motion.posture
    amc = read(mocap / "hdm05" / "HDM_dg_06-03_03_120.amc").motion.posture
    angle = np.arccos(np.clip(np.sum((c3d * amc).reshape(-1, 4, 3), axis=2), -1, 1))
    assert np.median(angle) < 0.5


def test_the_qualisys_dance_is_read_whole(mocap: Path) -> None:
    motion = read_motion(mocap / "qualisys_tsv" / "dance.tsv")
    assert motion.posture.shape == (500, 12)
    assert motion.duration == pytest.approx(25.0)
    # A dancer's hands are mostly below the shoulders and in front.
    forearms = motion.posture.reshape(-1, 4, 3)[:, 1::2]
    assert forearms[..., 0].mean() > 0.2
    assert np.abs(np.diff(motion.posture, axis=0)).max() < 0.5


def test_the_gap_in_the_qualisys_walk_is_refused_by_name(mocap: Path) -> None:
    path = mocap / "qualisys_tsv" / "walk.tsv"
    with pytest.raises(
        MotionFileError,
        match=r"Shoulder_R is missing in frames 305 to 320 \(0\.27 s\).* max_gap=0\.27, or keep"
        r" the longest clean stretch \(frames 1 to 304, 5\.07 s\) with longest$",
    ):
        read_motion(path)
    motion = read_motion(path, max_gap=0.27)
    assert motion.posture.shape == (117, 12)
    # Walking: upper arms hang.
    assert (motion.posture.reshape(-1, 4, 3)[:, ::2, 2] < -0.6).all()
    assert len(read_motion(path, longest=True)) == 102


def test_a_recording_of_one_arm_is_refused_in_words(mocap: Path) -> None:
    for name in ("markers.csv", "markers.trc", "markers_analogs.c3d"):
        with pytest.raises(
            MotionFileError,
            match=r"^[^\n]*a single arm[^\n]*both arms are needed;[^\n]*other_arm=hang[^\n]*$",
        ):
            read_motion(mocap / "vicon_trc" / name)


def test_left_and_right_of_a_dancer_are_told_apart(mocap: Path) -> None:
    path = mocap / "qualisys_tsv" / "dance.tsv"
    other = {"L": "R", "R": "L"}
    names = {"shoulder": ("Shoulder",), "elbow": ("Elbow",), "wrist": ("Radius", "Ulna")}
    swapped = ",".join(
        f"{side}_{point}=" + "+".join(f"{name}_{other[side[0].upper()]}" for name in group)
        for side in ("left", "right")
        for point, group in names.items()
    )
    imported = import_motion(path, ReadingOptions(map=swapped))
    assert any("left and right are swapped" in line for line in imported.report.warnings)


@pytest.mark.parametrize("name", ["dance", "walk"])
def test_both_can_be_danced(mocap: Path, name: str) -> None:
    motion = read_motion(mocap / "qualisys_tsv" / f"{name}.tsv", max_gap=0.3)
    assert load(motion).reset().first()
