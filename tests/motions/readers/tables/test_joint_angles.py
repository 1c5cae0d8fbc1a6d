"""Tables of joint angles become motions of these angles, in radians or degrees."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from mpma_mj import kinematics
from mpma_mj.errors import MotionFileError
from mpma_mj.kinematics import JOINT_NAMES
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.loader import import_motion
from mpma_mj.motions.motion import Motion
from mpma_mj.motions.options import ReadingOptions
from mpma_mj.motions.readers.tables.joint_angles import read_joint_angles
from tests.motions.readers import writers

RATE = 50.0
IN_RADIANS = [f"{name}_rad" for name in JOINT_NAMES]
ANGLES = 0.4 + 0.9 * np.sin(np.arange(80)[:, None] / 12.0 + np.arange(8)) ** 2


def write(
    path: Path,
    angles: np.ndarray,
    titles: Sequence[str] = IN_RADIANS,
    *,
    above: Sequence[str] = (),
    separator: str = ",",
) -> Path:
    rows = np.column_stack([np.arange(len(angles)) / RATE, angles])
    lines = [separator.join(["time", *titles])]
    lines += [separator.join(f"{value:.9f}" for value in row) for row in rows]
    path.write_text("\n".join([*above, *lines]) + "\n")
    return path


def read(path: Path, rate: float | None = None) -> tuple[Motion, ImportReport]:
    report = ImportReport()
    motion = read_joint_angles(path, rate, report)
    assert motion is not None
    return motion, report


def assert_angles(motion: Motion, angles: np.ndarray = ANGLES) -> None:
    posture = kinematics.posture_from_angles(angles)
    np.testing.assert_allclose(motion.posture, posture, atol=1e-7)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "robot.csv"


@pytest.mark.parametrize(
    "title",
    [
        *("{}_rad", "{} (rad)", "joint_states.{}_position", "joint_states/{}/position"),
        *("angle_{}", "position_{}", "q_{}", "actual/{}", "position.{}"),
    ],
)
def test_radians_come_back(path: Path, title: str) -> None:
    titles = [title.format(name) for name in JOINT_NAMES]
    motion, report = read(write(path, ANGLES, titles, separator="\t"))
    assert_angles(motion)
    assert motion.rate == RATE
    assert not report.warnings


@pytest.mark.parametrize("title", ["{}_deg", "{} [degrees]", "{} (°)"])
def test_degrees_come_back(path: Path, title: str) -> None:
    titles = [title.format(name) for name in JOINT_NAMES]
    motion, report = read(write(path, np.degrees(ANGLES), titles))
    assert_angles(motion)
    assert not report.warnings
    assert_angles(read(write(path, np.degrees(ANGLES), JOINT_NAMES, above=["unit,deg"]))[0])


def test_columns_may_be_in_any_order_with_others_between(path: Path) -> None:
    others = [
        *("left_elbow_command_rad/s", "velocity_left_elbow", "command_left_elbow", "force"),
        *("desired/left_elbow/position", "joint_states/left_elbow/effort", "velocity.left_elbow"),
    ]
    rows = np.column_stack([ANGLES[:, ::-1], 7 * ANGLES[:, : len(others)]])
    motion, _ = read(write(path, rows, [*JOINT_NAMES[::-1], *others]))
    assert_angles(motion)


def test_radians_without_unit_are_told(path: Path) -> None:
    for titles in (JOINT_NAMES, [name.replace("_", " ").title() for name in JOINT_NAMES]):
        motion, report = read(write(path, ANGLES, titles))
        assert_angles(motion)
        assert "its titles name no unit: the angles, up to 1.3, are read as" in report.warnings[0]


def test_joint_states_of_ros_name_the_joints_in_every_row(path: Path) -> None:
    order = np.roll(np.arange(8), 3)
    titles = [f"field.{what}{i}" for what in ("name", "position", "velocity") for i in range(8)]
    lines = [",".join(["%time", *titles])]
    for i, angles in enumerate(ANGLES[:, order]):
        names = [JOINT_NAMES[joint] for joint in order]
        stamp = 1_700_000_000_000_000_000 + int(i * 1e9 / RATE)
        lines.append(",".join(map(str, [stamp, *names, *angles, *7 * angles])))
    path.write_text("\n".join(lines) + "\n")
    motion, _ = read(path)
    assert motion.rate == RATE
    assert_angles(motion)
    lists = [f'{i},"[{", ".join(JOINT_NAMES)}]","{list(row)}"' for i, row in enumerate(ANGLES)]
    path.write_text("\n".join(["%time,field.name,field.position", *lists]) + "\n")
    with pytest.raises(MotionFileError, match="line 2 has joints' names amid numbers"):
        read(path)


def test_equal_parts_are_the_labels_by_default(path: Path) -> None:
    imported = import_motion(write(path, ANGLES), ReadingOptions())
    assert imported.motion.labels == ("1", "2", "3", "4")
    halves = import_motion(path, ReadingOptions(segments=2)).motion
    assert len(halves.labels) == 2


def test_degrees_without_unit_are_told_by_the_elbows(path: Path) -> None:
    motion, report = read(write(path, np.degrees(ANGLES), JOINT_NAMES))
    assert_angles(motion)
    assert "the angles are read as degrees, as an elbow has" in report.warnings[0]


def test_a_unit_that_cannot_be_told_is_asked_for(path: Path) -> None:
    unwound = ANGLES + 20.0 * np.eye(8)[0]
    with pytest.raises(MotionFileError, match="does not say whether its angles, up to 21"):
        read(write(path, unwound, JOINT_NAMES))
    motion, _ = read(write(path, unwound))
    assert_angles(motion, unwound)


def test_a_joint_that_is_missing_or_twice_is_named(path: Path) -> None:
    with pytest.raises(MotionFileError, match="no column of right_elbow"):
        read(write(path, ANGLES, [*JOINT_NAMES[:7], "q8"]))
    with pytest.raises(MotionFileError, match="several columns of right_elbow"):
        read(write(path, ANGLES[:, [*range(8), 7]], [*JOINT_NAMES, "right_elbow"]))


def test_rows_of_another_width_than_the_header_are_refused(path: Path) -> None:
    header, *rows = write(path, ANGLES, separator="\t").read_text().splitlines()
    path.write_text("\n".join([header, *(f"{i}\t{row}" for i, row in enumerate(rows))]) + "\n")
    with pytest.raises(MotionFileError, match="line 2 has 10 columns, but the header names 9"):
        read(path)


def test_one_row_is_no_motion(path: Path) -> None:
    lacking = ANGLES.copy()
    lacking[1:] = np.nan
    with pytest.raises(MotionFileError, match=r"has 1 row\(s\) with all angles; expected two"):
        read(write(path, lacking))


def test_short_gaps_are_bridged_and_long_ones_refused(path: Path) -> None:
    lines = write(path, ANGLES).read_text().splitlines(keepends=True)
    path.write_text("".join(lines[:31] + lines[33:]))
    motion, report = read(path)
    bridged = ANGLES.copy()
    bridged[30:32] = [[2 / 3], [1 / 3]] * ANGLES[29] + [[1 / 3], [2 / 3]] * ANGLES[32]
    assert_angles(motion, bridged)
    assert "2 frames are missing" in report.warnings[0]
    path.write_text("".join(lines[:31] + lines[51:]))
    with pytest.raises(MotionFileError, match=r"has no angles from 0.60 to 1.00 s"):
        read(path)


@pytest.mark.parametrize("row", [0, 40, 79])
def test_a_cell_that_is_empty_is_reported(path: Path, row: int) -> None:
    lines = write(path, ANGLES).read_text().splitlines()
    lines[row + 1] = ",".join([*lines[row + 1].split(",")[:-1], ""])
    path.write_text("\n".join(lines) + "\n")
    motion, report = read(path)
    assert f"rows without all angles: 1, the first in line {row + 2}" in report.warnings[0]
    assert len(motion) == (80 if row == 40 else 79)


def test_the_rate_may_be_given(path: Path) -> None:
    rows = [line.partition(",")[2] for line in write(path, ANGLES).read_text().splitlines()]
    path.write_text("\n".join(rows) + "\n")
    with pytest.raises(MotionFileError, match="does not declare its frame rate"):
        read(path)
    motion, _ = import_motion(path, ReadingOptions(rate_in=RATE), rate=RATE)
    assert_angles(motion)


def test_points_are_no_angles(path: Path) -> None:
    names = [f"{s}_{p}" for s in ("left", "right") for p in ("shoulder", "elbow", "wrist")]
    path.write_text(writers.vicon_text(writers.arm_points(names=names)))
    assert read_joint_angles(path, None, ImportReport()) is None
    path.write_bytes(b"\0" * 100)
    assert read_joint_angles(path, None, ImportReport()) is None


def test_a_row_that_jumps_away_is_reported(path: Path) -> None:
    jumping = ANGLES.copy()
    jumping[40, 3] += 1.0
    _, report = read(write(path, jumping))
    (warning,) = report.warnings
    assert warning.startswith("1 single-frame jump (left_forearm in row 41)")


@pytest.mark.parametrize("row", [0, 79])
def test_a_first_or_last_row_that_is_off_is_told(path: Path, row: int) -> None:
    off = ANGLES.copy()
    off[row, 3] += 0.3
    _, report = read(write(path, off))
    (warning,) = report.warnings
    assert warning.startswith(f"1 single-frame jump (left_forearm in row {row + 1})")


@pytest.mark.parametrize("row", [3, 13, 40, 76])
@pytest.mark.parametrize("joint", range(8))
def test_a_small_error_of_an_angle_is_warned_of(path: Path, row: int, joint: int) -> None:
    angles = ANGLES.copy()
    angles[row, joint] += 0.02
    (warning,) = read(write(path, angles))[1].warnings
    assert f" in row {row + 1})" in warning


@pytest.mark.parametrize("speed", [0.5, 5.0])
def test_a_robot_that_starts_turns_and_stops_at_once_does_not_jump(
    path: Path, speed: float
) -> None:
    time = np.arange(80)[:, None] / RATE
    bends = np.interp(time, [0.0, 0.3, 0.7, 1.1, 2.0], [0.0, 0.0, 0.4, 0.0, 0.0])
    angles = 0.5 + 0.1 * speed * bends * np.ones(8)
    assert not read(write(path, angles))[1].warnings


@pytest.mark.parametrize(("one", "other"), [(0, 1), (1, 6), (2, 6), (3, 7)])
def test_exchanged_titles_are_warned_of(path: Path, one: int, other: int) -> None:
    titles = [*IN_RADIANS]
    titles[one], titles[other] = titles[other], titles[one]
    (warning,) = read(write(path, ANGLES, titles))[1].warnings
    assert warning.startswith("line 1 names the joints of the right arm in another order")


def test_sides_may_alternate(path: Path) -> None:
    order = np.arange(8).reshape(2, 4).T.reshape(-1)
    motion, report = read(write(path, ANGLES[:, order], [IN_RADIANS[i] for i in order]))
    assert_angles(motion)
    assert not report.warnings
