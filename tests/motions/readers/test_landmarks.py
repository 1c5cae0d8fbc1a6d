"""Landmarks in JSON, in each form that estimators write them, and other JSON."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mpma_mj.errors import MotionFileError
from mpma_mj.motions import loader
from mpma_mj.motions.options import ReadingOptions
from mpma_mj.motions.readers import landmarks
from mpma_mj.motions.readers.joint_orders import known_orders
from tests.motions.readers import writers

NAMES = known_orders(33)[0].names(33)
BODY = np.round(writers.body_joints(NAMES) / 1000.0, 6)
POINTS = [
    [{"x": x, "y": y, "z": z, "visibility": 0.9} for x, y, z in frame] for frame in BODY.tolist()
]
NAMED = [
    [{"name": name} | point for name, point in zip(NAMES, frame, strict=True)] for frame in POINTS
]


def read(folder: Path, document: Any, **options: Any) -> Any:
    path = folder / "pose.json"
    path.write_text(document if isinstance(document, str) else json.dumps(document))
    return loader.import_motion(path, ReadingOptions(**options), rate=60.0)


@pytest.fixture
def known(tmp_path: Path) -> Any:
    path = tmp_path / "known.npz"
    tracks = {name: BODY[:, i] for i, name in enumerate(NAMES)}
    np.savez(path, rate=60.0, **tracks)  # type: ignore[arg-type]
    return loader.import_motion(path, ReadingOptions(), rate=60.0).motion.posture


FORMS: dict[str, Any] = {
    "points": POINTS,
    "lists": BODY.tolist(),
    "lists with a confidence": np.concatenate([BODY, 0.0 * BODY[..., :1] + 0.9], axis=2).tolist(),
    "named points": [frame[::-1] for frame in NAMED],
    "objects by name": [dict(zip(NAMES, f, strict=True)) for f in BODY.tolist()],
    "places": [
        {
            name: {"position": place, "rotation": [0, 0, 0, 1]}
            for name, place in zip(NAMES, f, strict=True)
        }
        for f in BODY.tolist()
    ],
    "one person": [[frame] for frame in POINTS],
    "frames": {"frames": [{"landmarks": frame} for frame in POINTS], "version": 1},
    "world before picture": [
        {"poseLandmarks": frame[:2], "poseWorldLandmarks": frame} for frame in POINTS
    ],
    "world in a list": [{"pose_world_landmarks": [{"landmark": frame}]} for frame in POINTS],
    "names apart": {"joint_names": NAMES[::-1], "data": BODY[:, ::-1].tolist()},
    "bodies of Azure Kinect": {
        "joint_names": NAMES,
        "frames": [
            {"num_bodies": 1, "bodies": [{"body_id": 1, "joint_positions": f}]}
            for f in BODY.tolist()
        ],
    },
    "instances of MMPose": {
        "instance_info": [{"instances": [{"keypoints": f, "scores": [1]}]} for f in BODY.tolist()]
    },
    "OpenPose, with confidences": {
        "fps": 60.0,
        "frames": [
            {"people": [{"pose_keypoints_3d": [n for x, y, z in f for n in (x, y, z, 0.9)]}]}
            for f in BODY.tolist()
        ],
    },
    "flat lists": [{"keypoints": frame} for frame in (1000.0 * BODY).reshape(60, -1).tolist()],
    "tracks": {name: BODY[:, i].tolist() for i, name in enumerate(NAMES)},
    "a line a frame": "\n".join(map(json.dumps, POINTS)),
}


@pytest.mark.parametrize("form", FORMS)
def test_every_form_is_the_same(tmp_path: Path, known: Any, form: str) -> None:
    imported = read(tmp_path, FORMS[form], rate_in=60.0)
    assert imported.report.format == "JSON"
    np.testing.assert_allclose(imported.motion.posture, known, atol=1e-9)


@pytest.mark.parametrize(
    ("unit", "key", "top"),
    [(1.0, "time", {}), (1e3, "timestamp_ms", {}), (1e6, "t", {}), (0.0, "frame", {"fps": 50})],
)
def test_the_rate_is_declared_or_by_the_times(
    tmp_path: Path, unit: float, key: str, top: dict[str, Any]
) -> None:
    frames = [{key: 5.0 + unit * i / 50.0, "landmarks": f} for i, f in enumerate(POINTS)]
    assert read(tmp_path, top | {"frames": frames}).report.rate == pytest.approx(50.0)


def test_numbers_of_frames_are_no_times(tmp_path: Path) -> None:
    frames = [{"t": i, "landmarks": frame} for i, frame in enumerate(POINTS)]
    with pytest.raises(MotionFileError, match="does not declare its frame rate"):
        read(tmp_path, frames)


def test_a_frame_without_points_is_a_gap(tmp_path: Path, known: Any) -> None:
    frames: list[Any] = [*POINTS]
    frames[20:24] = [[], None, {}, {"landmarks": []}]
    imported = read(tmp_path, frames, rate_in=60.0)
    np.testing.assert_allclose(imported.motion.posture, known, atol=0.02)


@pytest.mark.parametrize(
    ("document", "message"),
    [
        ({"version": 1.3, "people": [{"pose_keypoints_2d": [1, 2, 3]}]}, "one frame of OpenPose"),
        ({"asset": {"version": "2.0"}, "nodes": []}, "is a glTF scene; export it as BVH"),
        ({"name": "dance"}, "JSON without a list of frames; expected a list"),
        ([{"type": "Feature"}], "JSON without points of a body"),
        (BODY[..., :2].tolist(), "frame 1 has several people, or points without x, y, z"),
        ([[frame, frame] for frame in POINTS], "frame 1 has several people"),
        ([{"keypoints": [300.5, 200.5, 2] * 17}] * 9, "frame 1: point 0 has no x, y, z"),
        ([[{"x": 1, "y": 2}, *POINTS[0][1:]]], "frame 1: point 0 has no x, y, z"),
        (
            [dict(zip(NAMES, NAMED[0], strict=True)) | {"nose": {"x": 1}}],
            "point nose has no x, y, z",
        ),
        ([[[1, 2], *BODY[0, 1:].tolist()]], "frame 1: point 0 has no x, y, z"),
        ([{"landmark": f} for f in POINTS[:2]] + [{"landmarc": POINTS[0]}], "frame 3 has several"),
        ([f[:3] for f in POINTS], "JSON without points of a body"),
        (json.dumps(POINTS)[:-9], r"line 1: is damaged or cut short JSON"),
        ("[" * 100_000, "JSON of another kind"),
        ("[1, 2]", "frame 1 is '1'"),
    ],
)
def test_other_json_is_refused(tmp_path: Path, document: Any, message: str) -> None:
    with pytest.raises(MotionFileError, match=message):
        read(tmp_path, document, rate_in=60.0)


def test_frames_that_their_times_leave_out_are_gaps(tmp_path: Path, known: Any) -> None:
    frames = [{"timestamp": i / 60.0, "landmarks": frame} for i, frame in enumerate(POINTS)]
    imported = read(tmp_path, frames[:20] + frames[24:])
    assert "4 frames are missing, the first after frame 20" in imported.report.warnings[0]
    np.testing.assert_allclose(imported.motion.posture, known, atol=0.02)


@pytest.mark.filterwarnings("error")
def test_a_number_that_is_no_coordinate_is_a_gap(tmp_path: Path, known: Any) -> None:
    frames = json.loads(json.dumps(POINTS))
    frames[20][NAMES.index("left_elbow")]["x"] = 1e300
    imported = read(tmp_path, frames, rate_in=60.0)
    assert "left_elbow: 1 missing sample bridged" in "\n".join(imported.report.steps)
    np.testing.assert_allclose(imported.motion.posture, known, atol=0.02)


def test_a_large_file_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(landmarks, "_LARGEST", 1000)
    with pytest.raises(MotionFileError, match="is 0 MB of JSON; save the points as npz"):
        read(tmp_path, POINTS, rate_in=60.0)


def test_a_frame_may_be_long(tmp_path: Path) -> None:
    path = tmp_path / "pose.json"
    path.write_text("\n" + json.dumps(POINTS).replace("0.9", "0.9" + 40 * "0"))
    assert path.stat().st_size > 100_000
    assert len(loader.import_motion(path, ReadingOptions(rate_in=60.0)).motion) > 2
