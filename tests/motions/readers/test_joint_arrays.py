"""Joints in an array are named by the skeleton that they are of, or by their number."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from mpma_mj.errors import MotionFileError
from mpma_mj.motions import loader
from mpma_mj.motions.options import ReadingOptions
from mpma_mj.motions.readers import joint_arrays, npz
from mpma_mj.motions.readers.joint_orders import known_orders
from tests.motions.readers import writers

NAMES = known_orders(22)[0].names(22)
RATE = {"rate_in": 60.0}


def joints(names: tuple[str, ...] = NAMES) -> NDArray[np.float64]:
    """Return a body's joints, shape (T, J, 3), m, y up."""
    return writers.body_joints(names)[..., [1, 2, 0]] / 1000.0


def read(path: Path, array: NDArray[Any], **options: Any) -> Any:
    np.save(path, array)
    return loader.import_motion(path, ReadingOptions(**options), rate=60.0)


@pytest.fixture
def known(tmp_path: Path) -> NDArray[np.float64]:
    """Postures of the joints, read by their names."""
    path = tmp_path / "known.npz"
    tracks = {name: joints()[:, i] for i, name in enumerate(NAMES)}
    np.savez(path, rate=60.0, **tracks)  # type: ignore[arg-type]
    return loader.import_motion(path, ReadingOptions(), rate=60.0).motion.posture


@pytest.mark.parametrize("count", [17, 22, 24, 25, 33, 52])
def test_known_skeletons_are_named(tmp_path: Path, known: NDArray[np.float64], count: int) -> None:
    for order in known_orders(count):
        imported = read(tmp_path / "a.npy", joints(order.names(count)), **RATE)
        np.testing.assert_allclose(imported.motion.posture, known, atol=0.02)
        assert f"its {count} joints are in the order of {order.name}" in imported.report.steps


def test_humanml3d_has_its_rate(tmp_path: Path) -> None:
    imported = read(tmp_path / "a.npy", joints())
    assert imported.report.rate == 20.0
    assert "are taken for HumanML3D's, which have 20 Hz" in imported.report.warnings[0]
    with pytest.raises(MotionFileError, match="does not declare its frame rate"):
        read(tmp_path / "a.npy", joints()[..., [2, 0, 1]])  # z up


@pytest.mark.parametrize(
    "form",
    [
        lambda a: a[None],
        lambda a: a[:, None],
        lambda a: a.reshape(len(a), -1),
        lambda a: np.concatenate([a, np.full((*a.shape[:2], 1), 0.9)], axis=2),
        lambda a: (1000.0 * a).astype(np.float32),
    ],
)
def test_shapes_that_can_only_be_joints_are_read(
    tmp_path: Path, known: NDArray[np.float64], form: Any
) -> None:
    found = read(tmp_path / "a.npy", form(joints()), **RATE).motion.posture
    np.testing.assert_allclose(found, known, atol=1e-3)


def test_joints_relative_to_the_pelvis_are_read(tmp_path: Path, known: NDArray[np.float64]) -> None:
    centred = joints() - joints()[:, :1]
    found = read(tmp_path / "a.npy", centred, **RATE)
    np.testing.assert_allclose(found.motion.posture, known, atol=1e-6)
    assert not [w for w in found.report.warnings if "pelvis" in w]


def test_an_archive_of_joints_has_names_or_an_order(
    tmp_path: Path, known: NDArray[np.float64]
) -> None:
    turned = np.arange(22)[::-1]
    for arrays in (
        {"joints": joints(), "fps": 60},
        {"xyz": joints()[:, turned], "joint_names": np.array(NAMES)[turned], "frame_rate": [60.0]},
        {
            "body_positions": joints(),
            "body_names": np.array(NAMES),
            "body_linear_velocities": joints(),
            "body_rotations": np.ones((60, 22, 4)),
            "fps": 60,
        },
        {"poses": joints(), "FPS": 60, "root": np.zeros((60, 3))},
    ):
        path = tmp_path / "a.npz"
        np.savez(path, **arrays)  # type: ignore[arg-type]
        found = loader.import_motion(path, ReadingOptions(), rate=60.0)
        np.testing.assert_allclose(found.motion.posture, known, atol=1e-6)


def test_other_joints_are_named_by_number(tmp_path: Path, known: NDArray[np.float64]) -> None:
    array = np.concatenate([joints(), joints()[:, :7]], axis=1)[:, ::-1]  # 29 of them
    with pytest.raises(MotionFileError, match=r"it has 0, 1, 2, .*name the points with map="):
        read(tmp_path / "a.npy", array, **RATE)
    points = ["pelvis", "neck", *(n for n in NAMES if n.endswith(("shoulder", "elbow", "wrist")))]
    mapping = ",".join(f"{name}={28 - NAMES.index(name)}" for name in points)
    found = read(tmp_path / "a.npy", array, map=mapping, **RATE)
    np.testing.assert_allclose(found.motion.posture, known, atol=1e-6)


def test_a_known_number_in_another_order_is_not_guessed(tmp_path: Path) -> None:
    with pytest.raises(MotionFileError, match=r"it has 0, 1, 2, 3"):
        read(tmp_path / "a.npy", joints()[:, ::-1], **RATE)


@pytest.mark.parametrize(
    ("array", "message"),
    [
        (joints()[..., :2], "two coordinates are those of a picture"),
        (joints()[:, :3], r"expected joints of shape \(T, J, 3\)"),
        (np.zeros((60, 22, 6)), "six numbers are rotations"),
        (np.zeros((60, 22, 3, 3)), "those are rotations"),
        (np.zeros((60, 263)), "HumanML3D's features; give the joints"),
        (np.zeros((60, 322)), r"Motion-X's parameters of SMPL-X; save array\[:, :66\] as poses"),
        (np.zeros((2, 60, 22, 3)), "it shows 2 people; save one of them"),
        (np.full((60, 22, 4), 7.0), "four numbers a joint are no place"),
        (np.zeros(60), r"the array has shape \(60,\); expected joints"),
        (np.array(["a"]), "holds <U1; expected numbers"),
        (np.array([{}]), "holds Python objects, which can run code and are never opened"),
        (
            np.concatenate([1000.0 * joints()[..., :2], np.full((60, 22, 1), 0.8)], axis=2),
            "places in a picture with a confidence",
        ),
    ],
)
def test_other_arrays_are_refused(tmp_path: Path, array: NDArray[Any], message: str) -> None:
    with pytest.raises(MotionFileError, match=message):
        read(tmp_path / "a.npy", array, **RATE)


def test_what_is_too_large_is_refused_before_it_is_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(joint_arrays, "_LARGEST", 1000)
    monkeypatch.setattr(npz, "_LARGEST", 1000)
    with pytest.raises(MotionFileError, match=r"holds 0.0 GB; keep one recording"):
        read(tmp_path / "a.npy", joints(), **RATE)
    np.savez(tmp_path / "a.npz", joints=joints(), fps=60)
    with pytest.raises(MotionFileError, match=r"unpacks to 0.0 GB; keep the arrays of one"):
        loader.import_motion(tmp_path / "a.npz", ReadingOptions())


def test_a_rate_that_cannot_be_is_not_used(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", joints=joints(), fps=1e6)
    with pytest.raises(MotionFileError, match="does not declare its frame rate"):
        loader.import_motion(tmp_path / "a.npz", ReadingOptions())


def test_a_unit_that_is_not_known_is_refused(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", joints=joints(), fps=60, unit="foot")
    with pytest.raises(MotionFileError, match="unit is 'foot'; expected one of m, cm, mm, inch"):
        loader.import_motion(tmp_path / "a.npz", ReadingOptions())


def test_a_damaged_array_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.npy"
    np.save(path, joints())
    whole = path.read_bytes()
    for damaged in (*(whole[:cut] for cut in (7, 60, 200, -1)), whole.replace(b"60", b"(\n")):
        (tmp_path / "b.npy").write_bytes(damaged)
        with pytest.raises(MotionFileError, match=r"b\.npy: is a damaged NumPy array"):
            loader.import_motion(tmp_path / "b.npy", ReadingOptions(), rate=60.0)


def test_several_arrays_of_joints_are_refused(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", first=joints(), second=joints(), fps=60)
    with pytest.raises(MotionFileError, match=r"several arrays of joints, first \(60, 22, 3\)"):
        loader.import_motion(tmp_path / "a.npz", ReadingOptions())
