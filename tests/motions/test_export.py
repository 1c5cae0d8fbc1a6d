"""Export of motions: our own readers find the postures again."""

import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from mpma_mj.envs.load import arm_limits
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.errors import BadOptionError, RunFolderError
from mpma_mj.kinematics import JOINT_NAMES, posture_from_angles
from mpma_mj.motions import Motion, read_motion, ymca
from mpma_mj.motions.body import posture_from_points
from mpma_mj.motions.export import (
    MOTION_FORMATS,
    export_motion,
    write_joint_angles,
)
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.marker_sets import choose_markers
from mpma_mj.motions.readers.recognise import open_recording
from tests.motions.known_motions import check_equal, moving, singular

Array = NDArray[np.float64]

TO_Z_UP = {".bvh": ([2, 0, 1], [1, 1, 1]), ".trc": ([0, 2, 1], [1, -1, 1])}


def points_of(path: Path) -> tuple[dict[str, Array], float | None]:
    """Return the points of the body, x forward and z up, m, and the rate, without any cleaning."""
    recording = open_recording(path, ImportReport())
    groups = choose_markers(path, recording.names, {})
    tracks = recording.load([name for group in groups.values() for name in group])
    axes, signs = TO_Z_UP[path.suffix]
    unit = recording.unit or 0.01
    points = {point: unit * tracks[group[0]][:, axes] * signs for point, group in groups.items()}
    return points, recording.rate


def posture_in(path: Path) -> Array:
    if path.suffix == ".csv":
        return posture_from_angles(table_of(path)[1][:, 1:])
    return posture_from_points(points_of(path)[0])


def table_of(path: Path) -> tuple[list[str], Array]:
    head, *rows = path.read_text().splitlines()
    return head.split(","), np.array([row.split(",") for row in rows], float)


@pytest.mark.parametrize("ending", [".bvh", ".csv", ".trc"])
@given(seed=st.integers(0, 2**32 - 1), rate=st.sampled_from([10.0, 30.0, 59.94, 120.0]))
def test_any_posture_comes_back(ending: str, seed: int, rate: float) -> None:
    angles = np.random.default_rng(seed).uniform(-np.pi, np.pi, (5, 8))
    angles[0, [3, 7]] = 0.0  # straight elbows
    angles[1, [1, 5]] = np.pi / 2  # upper arms straight forward
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"x{ending}"
        motion = moving(angles, rate)
        export_motion(path, motion)
        held = posture_from_angles(motion.joint_angles)  # rotation, where it cannot be seen
        expected = held if ending == ".csv" else motion.posture
        np.testing.assert_allclose(posture_in(path), expected, rtol=0.0, atol=1e-6)


def test_a_motion_file_is_the_same_motion(tmp_path: Path) -> None:
    export_motion(tmp_path / "x.npz", ymca(tempo=0.5))
    check_equal(read_motion(tmp_path / "x.npz"), ymca(tempo=0.5))


@pytest.mark.parametrize("ending", [".bvh", ".trc"])
@pytest.mark.parametrize("tempo", [1.0, 4.0])
def test_an_exported_motion_is_read_without_a_filter(
    ending: str, tempo: float, tmp_path: Path
) -> None:
    motion = ymca(tempo=tempo)
    export_motion(tmp_path / f"x{ending}", motion)
    again = read_motion(tmp_path / f"x{ending}")
    np.testing.assert_allclose(again.posture, motion.posture, rtol=0.0, atol=1e-5)


@pytest.mark.parametrize("ending", [".bvh", ".trc"])
@pytest.mark.filterwarnings("error")
def test_a_body_is_upright_and_as_large_as_the_arms(ending: str, tmp_path: Path) -> None:
    motion = ymca(rate=60.0, tempo=0.5)
    path = tmp_path / f"x{ending}"
    export_motion(path, motion)
    points, rate = points_of(path)
    assert rate == 60.0
    np.testing.assert_allclose(points["pelvis"], np.tile([0.0, 0.0, 0.66], (len(motion), 1)))
    np.testing.assert_allclose(points["neck"][0], [0.0, 0.0, 1.2], atol=1e-9)
    np.testing.assert_allclose(points["left_shoulder"][0], [0.0, 0.19, 1.15], atol=1e-9)
    np.testing.assert_allclose(points["right_shoulder"][0], [0.0, -0.19, 1.15], atol=1e-9)
    upper_arm = points["right_elbow"] - points["right_shoulder"]
    np.testing.assert_allclose(np.linalg.norm(upper_arm, axis=1), 0.2817, atol=1e-6)
    forearm = points["left_wrist"] - points["left_elbow"]
    np.testing.assert_allclose(np.linalg.norm(forearm, axis=1), 0.2689, atol=1e-6)
    again = read_motion(path, rate=60.0, cutoff=25.0)  # without a warning
    assert np.abs(again.posture - motion.posture).max() < 2e-3


def test_a_skeleton_turns_its_arms_by_the_joint_angles_alone(tmp_path: Path) -> None:
    angles = np.radians([[0.0, 0.0, 0.0, 90.0] * 2, [90.0, 20.0, 30.0, 40.0] * 2])
    export_motion(tmp_path / "x.bvh", moving(angles))
    text = (tmp_path / "x.bvh").read_text()
    names = [line.split()[1] for line in text.splitlines() if "JOINT" in line or "ROOT" in line]
    rows = np.array([line.split() for line in text.splitlines()[-2:]], float)
    turns = dict(zip(names, rows[:, 3:].reshape(2, -1, 3).swapaxes(0, 1), strict=True))
    expected = {
        "LeftArm": [[-90.0, 0.0, 0.0], [0.0, -20.0, -30.0]],
        "LeftForeArm": [[0.0, -90.0, 0.0], [0.0, -40.0, 0.0]],
        "RightArm": [[90.0, 0.0, 0.0], [0.0, 20.0, -30.0]],
        "RightForeArm": [[0.0, 90.0, 0.0], [0.0, 40.0, 0.0]],
    }
    for name, turned in turns.items():
        np.testing.assert_allclose(turned, expected.get(name, np.zeros((2, 3))), atol=1e-6)
    assert "-0.000000" not in text


def test_joint_angles_are_columns_by_name_and_unit(tmp_path: Path) -> None:
    motion = ymca(rate=30.0)
    export_motion(tmp_path / "x.csv", motion)
    titles, table = table_of(tmp_path / "x.csv")
    assert titles == ["time", *(f"{joint}_rad" for joint in JOINT_NAMES)]
    np.testing.assert_allclose(table[:, 0], np.arange(len(motion)) / 30.0, atol=1e-9)
    np.testing.assert_allclose(table[:, 1:], motion.joint_angles, atol=1e-9)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("ending", [".bvh", ".csv"])
@pytest.mark.filterwarnings("error:.* turns by ")
def test_arms_that_turn_many_times_are_within_few_turns(
    ending: str, seed: int, tmp_path: Path
) -> None:
    motion = singular(seed, frames=2000)
    assert np.abs(motion.joint_angles).max() > 4 * np.pi
    path = tmp_path / f"x{ending}"
    export_motion(path, motion)
    read_motion(path, rate=20.0)  # without a warning of turns
    if ending == ".csv":
        table = table_of(path)[1][:, 1:]
        middle = 0.5 * (table.min(axis=0) + table.max(axis=0))
        assert np.abs(middle).max() <= np.pi
        steps = np.diff(motion.joint_angles, axis=0)
        np.testing.assert_allclose(np.diff(table, axis=0), steps, atol=1e-8)
    else:
        np.testing.assert_allclose(posture_in(path), motion.posture, rtol=0.0, atol=1e-6)
        rows = [line.split() for line in path.read_text().splitlines()[-len(motion) :]]
        turns = np.array(rows, float)[:, 3:]
        assert np.abs(turns).max() <= 360.0
        assert np.abs(np.diff(turns, axis=0)).max() <= 360.0


def test_commands_have_their_unit_in_their_title(tmp_path: Path) -> None:
    angles, commands = np.random.default_rng(0).normal(size=(2, 4, 8))
    write_joint_angles(tmp_path / "x.csv", angles, 20.0, commands)
    titles, table = table_of(tmp_path / "x.csv")
    assert titles[1:9] == [f"{joint}_rad" for joint in JOINT_NAMES]
    assert titles[9:] == [f"{joint}_command_rad/s" for joint in JOINT_NAMES]
    np.testing.assert_allclose(table[:, 9:], commands, atol=1e-9)


@pytest.mark.filterwarnings("ignore:ymca")
def test_a_motion_of_a_robot_needs_the_limits_of_that_robot(tmp_path: Path) -> None:
    humanoid = arm_limits(EnvironmentOptions(robot="cmu_humanoid"))
    motion = read_motion("ymca", limits=humanoid)
    for limits, message in ((None, "not of two_arm"), (arm_limits(), "not of two_arm")):
        with pytest.raises(BadOptionError, match=message):
            export_motion(tmp_path / "x.csv", motion, limits)
    with pytest.raises(BadOptionError, match="joint angles of two_arm, not of cmu_humanoid"):
        export_motion(tmp_path / "x.csv", ymca(), humanoid)
    for ending, largest in ((".bvh", 1e-6), (".trc", 1e-6)):
        export_motion(tmp_path / f"x{ending}", motion, humanoid)
        shown = humanoid.kinematics.posture(motion.joint_angles)
        found = posture_in(tmp_path / f"x{ending}")
        np.testing.assert_allclose(found, shown, rtol=0.0, atol=largest)
    export_motion(tmp_path / "x.npz", motion, humanoid)
    again = read_motion(tmp_path / "x.npz", limits=humanoid)
    np.testing.assert_array_equal(again.posture, motion.posture)
    np.testing.assert_array_equal(again.joint_angles, motion.joint_angles)


@pytest.mark.parametrize("name", ["take$1_$2", "dance\udcff", "two\nlines", "tab\tin it", "踊り🕺"])
@pytest.mark.parametrize("ending", MOTION_FORMATS)
def test_a_file_may_have_any_name(name: str, ending: str, tmp_path: Path) -> None:
    path = tmp_path / f"{name}{ending}"
    export_motion(path, ymca())
    assert [file.name for file in tmp_path.iterdir()] == [path.name]
    if ending in TO_Z_UP:
        np.testing.assert_allclose(posture_in(path), ymca().posture, rtol=0.0, atol=1e-6)


def test_another_ending_and_a_folder_that_cannot_be_are_refused(tmp_path: Path) -> None:
    motion: Motion = ymca()
    expected = r"path is '.*x\.fbx'; expected a file name that ends in \.bvh or \.csv or \.npz or"
    with pytest.raises(BadOptionError, match=expected):
        export_motion(tmp_path / "x.fbx", motion)
    (tmp_path / "file").write_text("")
    for ending in MOTION_FORMATS:
        with pytest.raises(RunFolderError, match="is a file, not a folder"):
            export_motion(tmp_path / "file" / f"x{ending}", motion)
