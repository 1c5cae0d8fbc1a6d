"""Reader for pose parameters of SMPL, SMPL-H and SMPL-X, as in AMASS: rotations of a body's joints.

A frame is a rotation for every joint, an axis times an angle in rad or a matrix, relative to the
joint's parent (M. Loper et al., SMPL: A skinned multi-person linear model, ACM Trans. Graphics
34(6), 2015). The first 22 joints are those of `joint_orders.toml`; hands and face follow.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpma_mj.errors import MotionFileError
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.readers.joint_orders import find_order, known_orders
from mpma_mj.motions.readers.recording import Recording, Tracks
from mpma_mj.motions.readers.skeleton import Joint, ancestry, joint_positions

__all__ = ["FORMAT", "MODEL_ARRAYS", "find_pose", "read_pose"]

Array = NDArray[np.float64]

FORMAT = "SMPL pose"
"""Name of the format."""
MODEL_ARRAYS = ("J", "v_template", "J_regressor")
"""Arrays of a body model from which its joints follow."""

# Joints that arms and trunk need: the parent, and where the joint is in the T-pose, m, x to the
# left, y up, z forward. Rounded to 5 mm and made symmetrical from the mean neutral SMPL body,
# whose shape a recording's body may differ from: this is what approximate means in the warning.
_BODY: dict[str, tuple[str | None, tuple[float, float, float]]] = {
    "pelvis": (None, (0.0, -0.225, 0.03)),
    "spine1": ("pelvis", (0.0, -0.115, 0.0)),
    "spine2": ("spine1", (0.0, 0.02, 0.005)),
    "spine3": ("spine2", (0.0, 0.075, 0.03)),
    "neck": ("spine3", (0.0, 0.29, -0.015)),
}
_ARM: dict[str, tuple[str, tuple[float, float, float]]] = {
    "collar": ("spine3", (0.08, 0.195, -0.01)),
    "shoulder": ("collar", (0.175, 0.225, -0.015)),
    "elbow": ("shoulder", (0.43, 0.215, -0.04)),
    "wrist": ("elbow", (0.685, 0.22, -0.045)),
}
_JOINTS = known_orders(22)[0].joints
# What holds all rotations, all but the root's, and the root's alone. Names may have a prefix. How
# many there are shows whether the root is among them: SMPL-X and SMPL have 21 and 23 others.
_WHOLE = r"poses?|full_?pose|smpl_poses?|pose_world|pose_aa|thetas?|rotmats?"
_BODY_ONLY = r"pose_body|body_pose|poses_body"
_ROOT = r"root_orient|global_orient|poses_root(_world)?"
_WITHOUT_ROOT = (21, 23)
_MOST = 3.0 * np.pi  # rad; a turn is given by less than 2π, and half of one would do


@dataclass(frozen=True)
class Pose:
    """Rotations of the joints.

    Attributes:
        title: Name of the array.
        rotations: The root first, shape (T, J, 3) or (T, J, 3, 3).
    """

    title: str
    rotations: NDArray[Any]


def find_pose(path: Path, arrays: Mapping[str, NDArray[Any]]) -> Pose | None:
    """Return the pose among the arrays of an archive, if there is one.

    Raises:
        MotionFileError: There is one, in a form that is not known.
    """
    for title, array in _named(arrays, f"{_WHOLE}|{_BODY_ONLY}"):
        if array.ndim == 3 and array.shape[2] == 3 and find_order(array.astype(float)):
            return None  # places, which somebody calls a pose
        found = _rotations(path, title, array)
        if found.shape[1] in _WITHOUT_ROOT:
            root = np.broadcast_to(np.eye(3) if found.ndim == 4 else 0.0, found[:, :1].shape)
            for other, turned in _named(arrays, _ROOT):
                given = _rotations(path, other, turned)
                root = given if given.shape == root.shape else root
            found = np.concatenate([root, found], axis=1)
        return Pose(title, found)
    return None


def read_pose(
    path: Path,
    pose: Pose,
    model: Mapping[str, NDArray[Any]] | None,
    rate: float | None,
    report: ImportReport,
    skeleton: Path | None,
) -> Recording:
    """Read where a pose puts the joints of arms and trunk.

    Args:
        path: The archive.
        pose: Its pose.
        model: Arrays of the body model, if the user has it.
        rate: Declared frames per second, Hz.
        report: Gets a warning where there is no model.
        skeleton: File of the model, for messages.

    Raises:
        MotionFileError: Rotations are impossible or too few, or the model has no joints.
    """
    rotations = pose.rotations
    if rotations.shape[1] < len(_JOINTS) - 1:
        raise MotionFileError(
            f"{path}: {pose.title} has shape {rotations.shape}, which is rotations of"
            f" {rotations.shape[1]} joints; expected SMPL's, at least 21"
        )
    _check_angles(path, pose)
    joints = _skeleton(None if model is None else _rest_joints(skeleton or path, model))
    if model is None:
        report.warn(
            "it holds a pose and no body, so that a mean body is used; directions of the arms may"
            " be off by a few degrees",
            remedy="{skeleton=MODEL.npz} uses that body model",
        )

    def load(names: Sequence[str]) -> Tracks:
        from scipy.spatial.transform import Rotation  # slow to import, needed by few runs

        turns = {}
        seen = np.full(len(rotations), True)
        for name in ancestry(joints, names):
            index = _JOINTS.index(name)
            if index >= rotations.shape[1]:  # the right wrist, which moves no point here
                continue
            turned = np.asarray(rotations[:, index], float)
            there = np.isfinite(turned.reshape(len(turned), -1)).all(axis=1)
            seen &= there
            if turned.ndim == 2:
                turns[name] = Rotation.from_rotvec(np.where(there[:, None], turned, 0)).as_matrix()
            else:
                turns[name] = np.where(there[:, None, None], turned, np.eye(3))
        still = {"pelvis": np.zeros((len(rotations), 3))}
        places = joint_positions(joints, names, turns.get, still)
        places[~seen] = np.nan
        return {name: places[:, 3 * i : 3 * i + 3] for i, name in enumerate(names)}

    return Recording(path, FORMAT, tuple(joints), load, rate=rate, unit=1.0)


def _named(arrays: Mapping[str, NDArray[Any]], rule: str) -> Iterator[tuple[str, NDArray[Any]]]:
    """Iterate over arrays of numbers whose names, without what is before / or a dot, fit."""
    for name, array in arrays.items():
        last = re.split(r"[/.]", name)[-1].lower()
        if re.fullmatch(rule, last) and array.dtype.kind in "fiu" and array.ndim > 1:
            yield name, array


def _rotations(path: Path, title: str, array: NDArray[Any]) -> NDArray[Any]:
    """Return rotations, shape (T, J, 3) or (T, J, 3, 3), of an array with them."""
    shape = array.shape
    if array.ndim in (3, 4) and shape[0] == 1 and shape[1] > 1 and shape[-1] != 3:
        array = array[0]  # one person
    if array.ndim == 4 and array.shape[2:] == (3, 3):
        return array
    if array.ndim == 3 and array.shape[2] == 3:
        return array if array.shape[1:] != (3, 3) else array[:, None]
    if array.ndim == 2 and array.shape[1] % 3 == 0 and array.shape[1] not in (126, 132, 138, 144):
        return array.reshape(len(array), -1, 3)
    raise MotionFileError(
        f"{path}: {title} has shape {shape}; expected rotations as axis times angle, (T, 3 J), or"
        " as matrices, (T, J, 3, 3); convert those of six numbers and quaternions"
    )


def _check_angles(path: Path, pose: Pose) -> None:
    """Refuse arrays that are not rotations."""
    rotations = pose.rotations[:, : len(_JOINTS)].astype(float)
    if rotations.ndim == 4:
        product = np.einsum("tjik,tjil->tjkl", rotations, rotations)
        off = np.abs(product - np.eye(3)).max(axis=(2, 3)) > 0.01
        what = "is no rotation matrix"
    else:
        off = np.linalg.norm(rotations, axis=2) > _MOST
        what = "is no axis times angle in rad"
    if off.any():
        frame, joint = np.argwhere(off)[0]
        raise MotionFileError(
            f"{path}: {pose.title}: the rotation of {_JOINTS[joint]} in frame {frame + 1} {what};"
            " export it again"
        )


def _skeleton(rest: Array | None) -> dict[str, Joint]:
    """Return the joints of arms and trunk, with a model's rest positions, shape (J, 3), m."""
    body = {name: (parent, np.array(place)) for name, (parent, place) in _BODY.items()}
    for side, sign in (("left", 1.0), ("right", -1.0)):
        for part, (parent, place) in _ARM.items():
            parent = parent if parent in body else f"{side}_{parent}"
            body[f"{side}_{part}"] = (parent, np.array(place) * [sign, 1.0, 1.0])
    if rest is not None:
        body = {name: (parent, rest[_JOINTS.index(name)]) for name, (parent, _) in body.items()}
    return {
        name: Joint(name, parent, place - (body[parent][1] if parent else 0.0), "", np.eye(3))
        for name, (parent, place) in body.items()
    }


def _rest_joints(path: Path, model: Mapping[str, NDArray[Any]]) -> Array:
    """Return where a body model's joints are at rest, shape (J, 3), m."""
    template, regressor = model.get("v_template"), model.get("J_regressor")
    joints = model.get("J")
    if joints is None and template is not None and regressor is not None:
        fit = regressor.ndim == template.ndim == 2 and regressor.shape[1] == len(template)
        joints = regressor @ template if fit else None
    if joints is None or joints.ndim != 2 or joints.shape[1] != 3 or len(joints) < len(_JOINTS):
        raise MotionFileError(
            f"{path}: is no SMPL model: expected J of shape (24, 3), or v_template and J_regressor"
        )
    return np.asarray(joints, float)
