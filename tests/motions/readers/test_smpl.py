"""Poses of SMPL, SMPL-H and SMPL-X against laws of rotations, in each form that they are saved."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from mpma_mj.errors import BadOptionError, MotionFileError
from mpma_mj.motions import loader
from mpma_mj.motions.options import ReadingOptions
from mpma_mj.motions.readers.joint_orders import known_orders
from tests.motions.readers import writers

JOINTS = known_orders(22)[0].joints
FRAMES = 60


def bent(seed: int = 0) -> NDArray[np.float64]:
    """Return a pose in which all joints of trunk and arms turn, shape (T, 22, 3), rad."""
    rng = np.random.default_rng(seed)
    phase = np.linspace(0.0, 2.0 * np.pi, FRAMES)[:, None, None]
    return rng.uniform(-0.3, 0.3, (22, 3)) * (1.0 + np.sin(phase))


def read(folder: Path, options: dict[str, Any] | None = None, **arrays: Any) -> Any:
    path = folder / "pose.npz"
    np.savez(path, **({"mocap_framerate": 60.0} | arrays))
    return loader.import_motion(path, ReadingOptions(**(options or {})), rate=60.0)


def posture(folder: Path, options: dict[str, Any] | None = None, **arrays: Any) -> Any:
    return read(folder, options, **arrays).motion.posture


def test_without_rotations_arms_are_spread(tmp_path: Path) -> None:
    imported = read(tmp_path, poses=np.zeros((FRAMES, 156)), trans=np.ones((FRAMES, 3)))
    assert (imported.report.format, imported.report.rate) == ("SMPL pose", 60.0)
    spread = [0.0, 1.0, 0.0] * 2 + [0.0, -1.0, 0.0] * 2
    cosines = np.sum(imported.motion.posture.reshape(-1, 4, 3) * np.reshape(spread, (4, 3)), axis=2)
    assert cosines.min() > np.cos(np.radians(12.0))
    assert [w for w in imported.report.warnings if "a few degrees" in w]


def test_an_elbow_turns_its_forearm_alone(tmp_path: Path) -> None:
    still = np.zeros((FRAMES, 22, 3))
    turned = still.copy()
    turned[:, JOINTS.index("left_elbow"), 1] = -np.pi / 2  # about the axis that points up
    before, after = (posture(tmp_path, poses=p.reshape(FRAMES, -1)) for p in (still, turned))
    np.testing.assert_allclose(
        after[:, [0, 1, 2, *range(6, 12)]], before[:, [0, 1, 2, *range(6, 12)]]
    )
    assert np.degrees(np.arccos(np.sum(after[0, 3:6] * before[0, 3:6]))) == pytest.approx(90, abs=1)
    assert after[0, 3] > 0.95  # forward


def test_turning_the_whole_body_changes_nothing(tmp_path: Path) -> None:
    pose = bent()
    turned = pose.copy()
    spin = Rotation.from_euler("y", np.linspace(0.0, 3.0, FRAMES)[:, None])
    turned[:, 0] = (spin * Rotation.from_rotvec(pose[:, 0])).as_rotvec()
    np.testing.assert_allclose(
        posture(tmp_path, poses=turned.reshape(FRAMES, -1)),
        posture(tmp_path, poses=pose.reshape(FRAMES, -1)),
        atol=0.01,
    )


def test_every_form_of_a_pose_is_the_same(tmp_path: Path) -> None:
    pose = bent()
    flat = pose.reshape(FRAMES, -1)
    known = posture(tmp_path, poses=flat)
    matrices = Rotation.from_rotvec(pose.reshape(-1, 3)).as_matrix().reshape(FRAMES, 22, 3, 3)
    hands = np.zeros((FRAMES, 90))
    for form in (
        {"pose_body": flat[:, 3:], "root_orient": flat[:, :3], "pose_hand": hands},
        {"body_pose": pose[:, 1:], "global_orient": pose[:, :1]},
        {"body_pose": matrices[:, 1:], "global_orient": matrices[:, :1]},
        {
            "smpl_params_global.body_pose": flat[:, 3:],
            "smpl_params_global.global_orient": flat[:, :3],
        },
        {"fullpose": np.concatenate([flat, hands, np.zeros((FRAMES, 9))], axis=1)},
        {"poses": np.concatenate([flat, np.zeros((FRAMES, 6))], axis=1)},
        {"poses": pose},
        {"poses": flat[:, 3:], "global_orient": flat[:, :3]},
        {"body_pose": flat},
    ):
        found = posture(tmp_path, **form)  # type: ignore[arg-type]
        np.testing.assert_allclose(found, known, atol=1e-9, err_msg=str(list(form)))


def test_joints_follow_their_parents(tmp_path: Path) -> None:
    """Direction of the left forearm, by the product of the rotations before it."""
    pose = bent(3)
    found = posture(tmp_path, poses=pose.reshape(FRAMES, -1), options={"cutoff": 29.9})
    chain = ("pelvis", "spine1", "spine2", "spine3", "left_collar", "left_shoulder", "left_elbow")
    rotations = [Rotation.from_rotvec(pose[:, JOINTS.index(name)]) for name in chain]
    product = rotations[0]
    for rotation in rotations[1:]:
        product = product * rotation
    upper = (product * rotations[-1].inv()).apply([0.255, -0.01, -0.025])
    fore = product.apply([0.255, 0.005, -0.005])
    cosine = (
        np.sum(upper * fore, axis=1) / np.linalg.norm(upper, axis=1) / np.linalg.norm(fore, axis=1)
    )
    np.testing.assert_allclose(np.sum(found[:, :3] * found[:, 3:6], axis=1), cosine, atol=1e-3)


@pytest.mark.parametrize("stored", ["J", "regressor"])
def test_a_body_model_replaces_the_mean_body(tmp_path: Path, stored: str) -> None:
    rest = np.zeros((24, 3))
    body = writers.body_joints(known_orders(24)[0].names(24))[0] / 1000.0
    rest[:, :] = body[:, [1, 2, 0]]
    rest[JOINTS.index("left_wrist")] = rest[JOINTS.index("left_elbow")] + [0.0, -0.25, 0.0]
    model = tmp_path / "model.npz"
    if stored == "J":
        np.savez(model, J=rest)
    else:
        np.savez(model, v_template=rest, J_regressor=np.eye(24), names=np.array([object()]))
    options = {"skeleton": str(model)}
    imported = read(tmp_path, options, poses=np.zeros((FRAMES, 72)))
    np.testing.assert_allclose(
        imported.motion.posture[:, 3:6], [[0.0, 0.0, -1.0]] * FRAMES, atol=1e-9
    )
    assert not imported.report.warnings


def test_a_model_without_joints_is_refused(tmp_path: Path) -> None:
    np.savez(tmp_path / "model.npz", betas=np.zeros(10))
    with pytest.raises(MotionFileError, match=r"model\.npz: is no SMPL model: expected J"):
        read(tmp_path, {"skeleton": str(tmp_path / "model.npz")}, poses=np.zeros((FRAMES, 72)))


def test_a_frame_without_rotations_is_bridged(tmp_path: Path) -> None:
    pose = bent().reshape(FRAMES, -1)
    lost = pose.copy()
    lost[20:24] = np.nan
    np.testing.assert_allclose(
        posture(tmp_path, poses=lost), posture(tmp_path, poses=pose), atol=0.01
    )


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        ({"poses": np.zeros((60, 132))}, "convert those of six numbers and quaternions"),
        ({"poses": np.zeros((60, 24, 6))}, "convert those of six numbers and quaternions"),
        ({"poses": np.zeros((60, 24, 4))}, "convert those of six numbers and quaternions"),
        ({"poses": np.zeros((60, 30))}, "rotations of 10 joints; expected SMPL's, at least 21"),
        ({"poses": np.full((60, 72), 90.0)}, "pelvis in frame 1 is no axis times angle in rad"),
        ({"poses": np.ones((60, 24, 3, 3))}, "pelvis in frame 1 is no rotation matrix"),
    ],
)
def test_what_is_no_pose_is_refused(tmp_path: Path, arrays: dict[str, Any], message: str) -> None:
    with pytest.raises(MotionFileError, match=message):
        read(tmp_path, **arrays)


def test_a_skeleton_for_points_is_refused(tmp_path: Path) -> None:
    points = writers.arm_points()
    with pytest.raises(BadOptionError, match="is npz; leave out skeleton"):
        read(tmp_path, {"skeleton": "model.npz"}, **points)
