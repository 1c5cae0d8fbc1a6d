"""Damaged files: either a one-line message, or what is left with a warning; never a crash."""

import json
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from mpma_mj.errors import MotionFileError, MpmaError
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.loader import ImportedMotion, import_motion
from mpma_mj.motions.options import ReadingOptions
from mpma_mj.motions.readers.joint_orders import known_orders
from mpma_mj.motions.readers.recognise import open_recording
from tests.motions.readers import writers
from tests.motions.readers.test_mvnx import NAMES as MVNX_NAMES
from tests.motions.readers.test_mvnx import text as mvnx_text

CUTS, FLIPS = 20, 24
FRAMES = 40


def short_numbers(text: str) -> str:
    """Return a text whose numbers have no zeros at their ends, as %g writes them."""
    return re.sub(r"(\.\d*?)0+(?=[\t,;\s])", r"\1", text)


def bvh(folder: Path) -> Path:
    rng = np.random.default_rng(0)
    angles = {n: rng.normal(0, 1, (FRAMES, 3)).cumsum(axis=0) for n, _, _ in writers.BVH_JOINTS}
    path = folder / "dance.bvh"
    path.write_text(writers.bvh_text(angles, {"Hips": np.full((FRAMES, 3), 90.0)}))
    return path


def amc(folder: Path) -> Path:
    rng = np.random.default_rng(0)
    angles = {
        bone[0]: rng.normal(0, 1, (FRAMES, len(bone[5].split()))).cumsum(axis=0)
        for bone in writers.AMC_BONES
    }
    return writers.write_acclaim(folder, angles, np.zeros((FRAMES, 6)))


def text(name: str, write: Callable[[writers.Points], str]) -> Callable[[Path], Path]:
    def make(folder: Path) -> Path:
        path = folder / name
        path.write_text(write(writers.arm_points(FRAMES)))
        return path

    return make


def c3d(processor: str, *, whole_numbers: bool) -> Callable[[Path], Path]:
    return lambda folder: writers.write_c3d_of(
        folder / "dance.c3d",
        writers.arm_points(FRAMES),
        processor,
        whole_numbers=whole_numbers,
    )


def bvh_line(folder: Path) -> Path:
    path = bvh(folder)
    header, time_line, frames = re.split("(Frame Time.*\n)", path.read_text())
    path.write_text(header + time_line + " ".join(frames.split()) + "\n")
    return path


def npy(folder: Path) -> Path:
    np.save(folder / "dance.npy", writers.body_joints(known_orders(24)[0].names(24), FRAMES))
    return folder / "dance.npy"


def smpl(folder: Path) -> Path:
    poses = np.random.default_rng(0).normal(0.0, 0.02, (FRAMES, 72)).cumsum(axis=0)
    np.savez(folder / "pose.npz", poses=poses, mocap_framerate=50.0)
    return folder / "pose.npz"


def landmarks(folder: Path) -> Path:
    joints = writers.body_joints(known_orders(33)[0].names(33), FRAMES)
    points = [
        [dict(zip("xyz", place, strict=True)) for place in frame] for frame in joints.tolist()
    ]
    path = folder / "dance.json"
    path.write_text(json.dumps({"fps": 50, "frames": points}, indent=0))
    return path


FORMATS: dict[str, Callable[[Path], Path]] = {
    "Qualisys": text("dance.tsv", writers.qualisys_text),
    "Qualisys with frames": text(
        "dance.tsv", lambda p: short_numbers(writers.qualisys_text(p, lead=["Frame", "Time"]))
    ),
    "TRC": text("dance.trc", writers.trc_text),
    "header row": text("dance.csv", writers.header_row_text),
    "header row of short numbers": text(
        "dance.csv", lambda p: short_numbers(writers.header_row_text(p))
    ),
    "grouped axes": text("dance.csv", writers.grouped_text),
    "long table": text("dance.csv", writers.long_text),
    "Vicon": text("dance.csv", lambda p: short_numbers(writers.vicon_text(p))),
    "Captury": text("dance.csv", lambda p: writers.captury_text(p, decimal=",")),
    "OptiTrack": text("dance.csv", lambda p: writers.optitrack_text(writers.y_up(p))),
    "BVH": bvh,
    "AMC": amc,
    "npz": lambda folder: writers.write_npz(folder / "dance.npz", writers.arm_points(FRAMES)),
    "C3D": lambda folder: writers.write_c3d(
        folder / "dance.c3d", writers.arm_points(FRAMES), events=[("a", 0.1), ("b", 0.2)]
    ),
    "BVH on one line": bvh_line,
    "npy": npy,
    "SMPL": smpl,
    "JSON": landmarks,
    "MVNX": text("dance.mvnx", lambda p: mvnx_text(dict(zip(MVNX_NAMES, p.values(), strict=True)))),
    "C3D of integers": c3d("mips", whole_numbers=True),
    "C3D of DEC": c3d("dec", whole_numbers=False),
}


# Formats that do not say how many frames they have: a cut between two lines does not show.
AT_LINES = (
    *("header row", "header row of short numbers", "grouped axes", "long table", "Vicon", "AMC"),
)


def read(path: Path, kind: str) -> ImportedMotion | None:
    """Read a file; None where it is refused, which takes one line."""
    options = ReadingOptions(rate_in=50.0 if kind in ("Captury", "npy") else None, cutoff=4.0)
    imported, message = None, "none"
    try:
        imported = import_motion(path, options)
    except MpmaError as error:
        message = str(error)
    assert len(message.splitlines()) == 1, message
    return imported


@pytest.mark.parametrize("kind", FORMATS)
def test_what_is_cut_off_is_reported(tmp_path: Path, kind: str) -> None:
    path = FORMATS[kind](tmp_path)
    whole, data = read(path, kind), path.read_bytes()
    assert whole is not None
    assert whole.report.frames == FRAMES
    ends = {m.end() for m in re.finditer(rb"\n", data)}
    rng = np.random.default_rng(0)
    for cut in rng.integers(0, len(data), CUTS):
        path.write_bytes(data[:cut])
        part = read(path, kind)
        if part is None or set(part.report.warnings) > set(whole.report.warnings):
            continue
        at_an_end = bool({cut, cut + 1} & ends) and kind in AT_LINES
        assert at_an_end or (
            part.report.frames == whole.report.frames
            and np.array_equal(part.motion.posture, whole.motion.posture)
        ), f"cut at {cut} of {len(data)}"


@pytest.mark.parametrize(
    "kind",
    ["Qualisys", "header row", "header row of short numbers", "Vicon", "Captury", "BVH", "AMC"],
)
def test_a_number_that_is_cut_is_not_used(tmp_path: Path, kind: str) -> None:
    path = FORMATS[kind](tmp_path)
    data = path.read_bytes()
    whole = open_recording(path, ImportReport())
    arms = whole.names[-6:]
    known = whole.load(arms)
    for cut in range(1 + data.rindex(b"\n", 0, -1), len(data) - 1):  # all of the last line
        path.write_bytes(data[:cut])
        try:
            tracks = open_recording(path, ImportReport()).load(arms)
        except MotionFileError:
            continue
        for name, track in tracks.items():
            np.testing.assert_array_equal(track, known[name][: len(track)])


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize("kind", FORMATS)
def test_changed_bytes_are_no_crash(tmp_path: Path, kind: str) -> None:
    path = FORMATS[kind](tmp_path)
    data = np.frombuffer(path.read_bytes(), np.uint8)
    rng = np.random.default_rng(1)
    for i in range(FLIPS):
        changed = data.copy()
        among = min(len(data), 700 if i % 2 else len(data))  # headers are where it hurts
        places = rng.integers(0, among, rng.choice([1, 1, 4]))
        changed[places] = rng.integers(0, 256, len(places))
        path.write_bytes(changed.tobytes())
        read(path, kind)


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_a_changed_skeleton_is_no_crash(tmp_path: Path) -> None:
    path = amc(tmp_path)
    skeleton = path.with_suffix(".asf")
    data = np.frombuffer(skeleton.read_bytes(), np.uint8)
    rng = np.random.default_rng(2)
    for _ in range(FLIPS):
        changed = data.copy()
        changed[rng.integers(0, len(data), 2)] = rng.integers(0, 256, 2)
        skeleton.write_bytes(changed.tobytes())
        read(path, "AMC")


@pytest.mark.parametrize("head", [b"", b"\x02P", b"PK\x03\x04", b"HIERARCHY\n", b"\xff\xfe"])
def test_rubbish_is_refused_whatever_its_name(tmp_path: Path, head: bytes) -> None:
    for extension in ("c3d", "bvh", "amc", "asf", "trc", "tsv", "csv", "npz"):
        path = tmp_path / f"dance.{extension}"
        path.write_bytes(head + np.random.default_rng(3).bytes(5000))
        with pytest.raises(MotionFileError) as caught:
            import_motion(path, ReadingOptions())
        assert len(str(caught.value).splitlines()) == 1
