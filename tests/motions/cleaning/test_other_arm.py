"""A recording of one arm becomes a motion of two: the other arm hangs, or is its mirror image."""

import re
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from mpma_mj import kinematics
from mpma_mj.errors import MotionFileError
from mpma_mj.kinematics import SIDES
from mpma_mj.motions import read_motion, ymca
from mpma_mj.motions.loader import ImportedMotion, import_motion
from mpma_mj.motions.options import OtherArm, ReadingOptions
from tests.conftest import dancer, doubts

Array = NDArray[np.float64]
Points = dict[str, Array]

MIRROR = np.tile([1.0, -1.0, 1.0], 2)
POSTURE = ymca(rate=60.0).posture
FORWARD = kinematics.posture_from_angles(
    np.tile([0.2, 0.6, 0.0, 0.8], 2) + 0.1 * np.sin(np.arange(240)[:, None] / 20 + np.arange(8))
)
MIDDLE = {"neck": [0.0, 0.0, 1450.0], "pelvis": [0.0, 0.0, 950.0]}


def points_of(posture: Array, side: str, *others: str, turn: float = 0.0) -> Points:
    """Return the points of one arm, and some of the torso, of a dancer who is turned."""
    points = {n: track for n, track in dancer(posture).items() if n.startswith(side)}
    points |= {n: np.tile(MIDDLE[n], (len(posture), 1)) for n in others if n in MIDDLE}
    points |= {n: track for n, track in dancer(posture).items() if n in others}
    rotation = Rotation.from_euler("z", turn)
    return {name: rotation.apply(track) for name, track in points.items()}


def read(path: Path, points: Points, other_arm: OtherArm | None, **more: object) -> ImportedMotion:
    np.savez(path, rate=60.0, up="z", unit="mm", **points)  # type: ignore[arg-type]
    options = ReadingOptions(other_arm=other_arm, cutoff=20.0, **more)  # type: ignore[arg-type]
    return import_motion(path, options, rate=60.0)


def arm_of(posture: Array, side: str) -> Array:
    return posture[:, :6] if side == "left" else posture[:, 6:]


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize(
    "others", [("neck", "pelvis"), ("neck",), ("pelvis",), ("other shoulder",)]
)
@pytest.mark.parametrize("turn", [0.0, 2.0])
def test_the_known_arm_stays_and_the_other_is_its_mirror_image(
    tmp_path: Path, side: str, others: tuple[str, ...], turn: float
) -> None:
    other = SIDES[1 - SIDES.index(side)]
    others = tuple(f"{other}_shoulder" if name == "other shoulder" else name for name in others)
    points = points_of(POSTURE, side, *others, turn=turn)
    imported = read(tmp_path / "a.npz", points, "mirror")
    found = imported.motion.posture
    np.testing.assert_allclose(arm_of(found, side), arm_of(POSTURE, side), atol=0.03)
    np.testing.assert_allclose(arm_of(found, other), arm_of(found, side) * MIRROR, atol=1e-9)
    assert not doubts(imported.report)
    step = f"the {other} arm is not recorded and is the mirror image of the {side} one"
    assert f"{step}, as requested" in imported.report.steps
    assert set(imported.report.groups) == set(points)


@pytest.mark.parametrize("side", SIDES)
def test_the_other_arm_hangs(tmp_path: Path, side: str) -> None:
    other = SIDES[1 - SIDES.index(side)]
    points = points_of(POSTURE, side, "neck", "pelvis")
    leaning = {n: Rotation.from_euler("y", 0.5).apply(track) for n, track in points.items()}
    for one in (points, leaning):
        found = read(tmp_path / "a.npz", one, "hang").motion.posture
        np.testing.assert_allclose(arm_of(found, side), arm_of(POSTURE, side), atol=0.03)
        hanging = np.tile([0.0, 0.0, -1.0], (len(found), 2))
        np.testing.assert_allclose(arm_of(found, other), hanging, atol=1e-9)


@pytest.mark.parametrize("side", SIDES)
def test_without_a_torso_the_front_is_where_the_wrist_points(tmp_path: Path, side: str) -> None:
    imported = read(tmp_path / "a.npz", points_of(FORWARD, side, turn=1.0), "mirror")
    (warning,) = doubts(imported.report)
    assert warning.startswith("no point between the shoulders is recognised; the torso is assumed")
    reach = np.sum(arm_of(imported.motion.posture, side).reshape(-1, 2, 3), axis=1).mean(axis=0)
    assert reach[0] > 0.0
    assert abs(reach[1]) < 0.03
    np.testing.assert_allclose(  # what does not depend on the front
        imported.motion.posture[:, 2::3],
        FORWARD[:, 2::3][:, [0, 1, 0, 1]] if side == "left" else FORWARD[:, 2::3][:, [2, 3, 2, 3]],
        atol=0.03,
    )


@pytest.mark.parametrize("side", SIDES)
def test_without_the_option_both_ways_are_offered(tmp_path: Path, side: str) -> None:
    other = SIDES[1 - SIDES.index(side)]
    with pytest.raises(MotionFileError, match=f"has no {other} arm, and both") as caught:
        read(tmp_path / "a.npz", points_of(POSTURE, side), None)
    assert re.findall("other_arm=([a-z]+)", str(caught.value)) == ["hang", "mirror"]


def test_an_arm_that_is_named_neither_left_nor_right_is_the_right_one(tmp_path: Path) -> None:
    points = points_of(POSTURE, "right", "neck", "pelvis")
    unnamed = {name.removeprefix("right_"): track for name, track in points.items()}
    with pytest.raises(MotionFileError, match="a single arm, named neither left nor right"):
        read(tmp_path / "a.npz", unnamed, None)
    imported = read(tmp_path / "a.npz", unnamed, "mirror")
    (warning,) = doubts(imported.report)
    assert warning.startswith("the arm is named neither left nor right and taken as the right one")
    same = read(tmp_path / "b.npz", points, "mirror").motion.posture
    np.testing.assert_allclose(imported.motion.posture, same, atol=1e-9)
    mapping = re.findall(r'map="(.*?)" makes it the left one', warning)[0]
    left = read(tmp_path / "a.npz", unnamed, "mirror", map=mapping)
    assert {"left_shoulder", "left_elbow", "left_wrist"} <= set(left.report.groups)
    assert not any("neither left" in warning for warning in doubts(left.report))


def test_a_recording_of_both_arms_does_not_need_it(tmp_path: Path) -> None:
    points = dancer(POSTURE)
    plain = read(tmp_path / "a.npz", points, None)
    imported = read(tmp_path / "a.npz", points, "hang")
    np.testing.assert_array_equal(imported.motion.posture, plain.motion.posture)
    assert doubts(imported.report) == ["both arms are recorded; other_arm is of no use here"]


def test_an_arm_of_which_a_point_is_missing_can_be_done_without(tmp_path: Path) -> None:
    points = dancer(POSTURE)
    del points["left_wrist"]
    with pytest.raises(MotionFileError, match=r"the left wrist; it has .* do without that arm"):
        read(tmp_path / "a.npz", points, None)
    found = read(tmp_path / "a.npz", points, "mirror").motion.posture
    np.testing.assert_allclose(found[:, 6:], POSTURE[:, 6:], atol=0.03)


def test_the_other_arm_hangs_along_a_torso_with_half_a_pelvis(tmp_path: Path) -> None:
    points = points_of(POSTURE, "right", "neck")
    for name, side in (("LASI", 120.0), ("RASI", -120.0)):
        points[name] = np.tile([105.0, side, 950.0], (len(POSTURE), 1))
    found = read(tmp_path / "a.npz", points, "hang").motion.posture
    np.testing.assert_allclose(found[:, :6], np.tile([0.0, 0.0, -1.0], (len(found), 2)), atol=0.05)
    np.testing.assert_allclose(found[:, 6:], POSTURE[:, 6:], atol=0.06)


def test_the_torso_is_found_beside_an_arm_that_is_mapped(tmp_path: Path) -> None:
    points = points_of(POSTURE, "left", "neck", "pelvis")
    odd = {f"m{i}": track for i, track in enumerate(points.values())}
    names = dict(zip(odd, points, strict=True))
    odd = {n if names[n] not in MIDDLE else names[n]: track for n, track in odd.items()}
    mapping = ",".join(f"{names[n]}={n}" for n in odd if n in names)
    imported = read(tmp_path / "a.npz", odd, "mirror", map=mapping)
    np.testing.assert_allclose(imported.motion.posture[:, :6], POSTURE[:, :6], atol=0.03)
    assert not doubts(imported.report)


def test_a_shoulder_above_the_middle_of_the_torso_is_refused(tmp_path: Path) -> None:
    points = points_of(POSTURE, "right", "neck")
    points["neck"] = points["right_shoulder"] - [0.0, 0.0, 100.0]
    with pytest.raises(MotionFileError, match="the right shoulder lies straight above"):
        read(tmp_path / "a.npz", points, "hang")


def test_it_is_an_option_of_reading(tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    np.savez(path, rate=60.0, up="z", **points_of(POSTURE, "right", "neck"))  # type: ignore[arg-type]
    assert len(read_motion(path, other_arm="mirror")) > 70
