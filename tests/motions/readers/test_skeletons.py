"""BVH and ASF/AMC against closed forms, and against each other."""

from itertools import pairwise, permutations
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from mpma_mj.errors import BadOptionError, MotionFileError
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.loader import import_motion
from mpma_mj.motions.options import ReadingOptions
from mpma_mj.motions.readers.recognise import open_recording
from mpma_mj.motions.readers.recording import Recording, Tracks
from tests.motions.readers import writers

Array = NDArray[np.float64]

ORDERS = ["".join(order) for order in permutations("XYZ")]
FRAMES = 4


def read(path: Path, skeleton: Path | None = None) -> tuple[Recording, Tracks, ImportReport]:
    report = ImportReport()
    recording = open_recording(path, report, ReadingOptions(skeleton=skeleton and str(skeleton)))
    return recording, recording.load(recording.names), report


def about(axis: str, degrees: float) -> Array:
    """Return the rotation about one axis, shape (3, 3)."""
    vector = np.radians(degrees) * np.eye(3)["XYZ".index(axis.upper())]
    return Rotation.from_rotvec(vector).as_matrix()


def bvh_places(angles: dict[str, Array], places: dict[str, Array], order: str) -> Tracks:
    """Return where the joints of `writers.BVH_JOINTS` are, frame by frame, by their definition."""
    found: Tracks = {}
    turned: dict[str, list[Array]] = {}
    for name, parent, offset in writers.BVH_JOINTS:
        way = places.get(name, np.tile(offset, (FRAMES, 1)))
        found[name], turned[name] = np.empty((FRAMES, 3)), []
        for t in range(FRAMES):
            before = np.eye(3) if parent is None else turned[parent][t]
            start = np.zeros(3) if parent is None else found[parent][t]
            first, second, third = (
                about(a, d) for a, d in zip(order, angles[name][t], strict=True)
            )
            found[name][t] = start + before @ way[t]
            turned[name].append(before @ first @ second @ third)
        if name.endswith("Hand"):
            ends = [turned[name][t] @ writers.HAND_END for t in range(FRAMES)]
            found[f"{name}_end"] = found[name] + ends
    return found


def random_angles(seed: int) -> tuple[dict[str, Array], dict[str, Array]]:
    """Return angles of all joints, degrees, and places of the root and of one joint, cm."""
    rng = np.random.default_rng(seed)
    angles = {n: rng.uniform(-180, 180, (FRAMES, 3)).round(6) for n, _, _ in writers.BVH_JOINTS}
    names = ("Hips", "LeftForeArm")
    return angles, {name: rng.uniform(-90, 90, (FRAMES, 3)).round(6) for name in names}


@settings(max_examples=25)
@given(order=st.sampled_from(ORDERS), seed=st.integers(0, 1000))
def test_joints_are_where_any_order_of_rotations_puts_them(
    tmp_path_factory: pytest.TempPathFactory, order: str, seed: int
) -> None:
    angles, places = random_angles(seed)
    path = tmp_path_factory.mktemp("bvh") / "dance"
    path.write_text(writers.bvh_text(angles, places, order=order))
    recording, tracks, report = read(path)
    assert (recording.format, recording.up, recording.frames) == ("BVH", "y", FRAMES)
    assert tuple(tracks) == recording.names
    for name, known in bvh_places(angles, places, order).items():
        np.testing.assert_allclose(tracks[name], known, atol=1e-9)
    assert not report.warnings


def test_without_rotations_joints_are_their_offsets_apart(tmp_path: Path) -> None:
    angles = {name: np.zeros((2, 3)) for name, _, _ in writers.BVH_JOINTS}
    path = tmp_path / "dance.bvh"
    path.write_text(writers.bvh_text(angles, {"Hips": np.array([[1.0, 90, 2], [3, 91, 4]])}))
    _, tracks, _ = read(path)
    for name, parent, offset in writers.BVH_JOINTS:
        if parent:
            np.testing.assert_allclose(tracks[name] - tracks[parent], [offset] * 2)
    np.testing.assert_allclose(tracks["LeftHand_end"] - tracks["LeftHand"], [(0, -8, 0)] * 2)


def test_a_joint_at_0_0_0_is_at_its_offset(tmp_path: Path) -> None:
    angles, places = random_angles(0)
    path = tmp_path / "dance.bvh"
    path.write_text(writers.bvh_text(angles, {"Hips": places["Hips"]}))
    expected = read(path)[1]
    joints = [name for name, parent, _ in writers.BVH_JOINTS if parent]
    still = {name: np.zeros((FRAMES, 3)) for name in joints}
    path.write_text(writers.bvh_text(angles, {"Hips": places["Hips"]} | still))
    for name, track in read(path)[1].items():
        np.testing.assert_allclose(track, expected[name], atol=1e-9)


@pytest.mark.parametrize(
    ("frame_time", "rate"),
    [
        ("0.0083333", 120.0),
        ("0.00833", 120.0),
        (".033333", 30.0),
        ("0.0166833", 59.94),
        ("0.0417083", 23.976),
        ("0.01", 100.0),
        ("8.3333e-03", 120.0),
    ],
)
def test_the_frame_time_gives_the_rate(tmp_path: Path, frame_time: str, rate: float) -> None:
    angles, places = random_angles(0)
    path = tmp_path / "dance.bvh"
    path.write_text(writers.bvh_text(angles, places, frame_time=frame_time))
    assert read(path)[0].rate == pytest.approx(rate, rel=1e-5)


@pytest.mark.parametrize("frame_time", ["0", "1e-320", "-0.01"])
def test_a_frame_time_that_cannot_be_gives_no_rate(tmp_path: Path, frame_time: str) -> None:
    angles, places = random_angles(0)
    path = tmp_path / "dance.bvh"
    path.write_text(writers.bvh_text(angles, places, frame_time=frame_time))
    assert read(path)[0].rate is None


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("\n", "\r\n"),
        ("HIERARCHY", "\n  Hierarchy"),
        ("{", " {\n"),
        ("\n{", " {"),
        ("Xrotation", "XROTATION"),
        ("ROOT Hips", "ROOT  Hips "),
        ("Frames: ", "Frames:\t"),
        ("Frame Time: ", "Frame time:"),
        ("OFFSET ", "OFFSET\t"),
    ],
)
def test_spelling_and_spaces_do_not_matter(tmp_path: Path, old: str, new: str) -> None:
    angles, places = random_angles(3)
    text = writers.bvh_text(angles, places)
    assert old in text
    path = tmp_path / "dance.bvh"
    path.write_bytes(text.replace(old, new).encode())
    for name, known in bvh_places(angles, places, "ZXY").items():
        np.testing.assert_allclose(read(path)[1][name], known, atol=1e-9)


def skeleton_text(chains: str) -> str:
    """Return a BVH without frames of chains such as "a b c; b d", each joint after its parent."""
    children: dict[str, list[str]] = {}
    for chain in chains.split(";"):
        for parent, child in pairwise(chain.split()):
            children.setdefault(parent, []).append(child)

    def inside(name: str) -> str:
        below = "".join(f"JOINT {child} {inside(child)}" for child in children.get(name, ()))
        end = "End Site { OFFSET 0 1 0 } " if not below else ""
        return f"{{ OFFSET 0 1 0 CHANNELS 0 {below}{end}}} "

    root = chains.split()[0]
    return f"HIERARCHY\nROOT {root} {inside(root)}\nMOTION\nFrames: 0\nFrame Time: 0.01\n"


@pytest.mark.parametrize(
    ("chains", "root"),
    [
        ("body spine chest head; chest arm_l; chest arm_r; body leg_l; body leg_r", "body"),
        ("ground body spine chest head; chest arm_l; chest arm_r; body leg_l; body leg_r", "body"),
        ("ground chest head; chest arm_l; chest arm_r", None),
        ("ground chest head; chest arm_l hand a; hand b; chest arm_r palm c; palm d", None),
        ("chain link end", None),
    ],
)
def test_the_root_is_where_legs_branch_from_the_spine(
    tmp_path: Path, chains: str, root: str | None
) -> None:
    path = tmp_path / "dance.bvh"
    path.write_text(skeleton_text(chains))
    assert open_recording(path, ImportReport()).root == root


def test_the_root_is_taken_for_a_pelvis_of_unknown_name(tmp_path: Path) -> None:
    angles, _ = random_angles(0)
    angles = {name: np.tile(angle[:1] / 6.0, (60, 1)) for name, angle in angles.items()}
    places = {"Hips": np.full((60, 3), 100.0)}
    known, unknown = tmp_path / "known.bvh", tmp_path / "unknown.bvh"
    known.write_text(writers.bvh_text(angles, places))
    leg = "JOINT Leg{} {{ OFFSET 9 -5 0 CHANNELS 0 End Site {{ OFFSET 0 -90 0 }} }}\n"
    text = known.read_text().replace("ROOT Hips", "ROOT Kreuz")
    unknown.write_text(
        text.replace("JOINT Spine", leg.format("A") + leg.format("B") + "JOINT Spine")
    )
    expected = import_motion(known, ReadingOptions(), rate=60.0)
    found = import_motion(unknown, ReadingOptions(), rate=60.0)
    assert found.report.groups["pelvis"] == ("Kreuz",)
    np.testing.assert_array_equal(found.motion.posture, expected.motion.posture)


def test_a_joint_below_another_of_its_name_is_no_endless_loop(tmp_path: Path) -> None:
    angles, places = random_angles(4)
    path = tmp_path / "dance.bvh"
    path.write_text(writers.bvh_text(angles, places).replace("JOINT Spine", "JOINT Hips"))
    recording, tracks, _ = read(path)
    assert recording.names.count("Hips") == 2
    np.testing.assert_allclose(
        tracks["LeftHand"], bvh_places(angles, places, "ZXY")["LeftHand"], atol=1e-9
    )


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("OFFSET 0.0 50.0 1.0", "", "Spine has no OFFSET"),
        ("OFFSET 0.0 50.0 1.0", "OFFSET 0.0 50.0", "line 8: expected a joint's OFFSET"),
        ("OFFSET 0.0 50.0 1.0", "OFFSET 0.0 50.0 x", "line 8: 'x' is not a number"),
        ("OFFSET 0.0 50.0 1.0", "OFFSET 0.0 1e300 0", "line 8: '1e300' is not a number"),
        ("3 Zrotation", "4 Zrotation", "is not a list of channels"),
        ("3 Zrotation", "3 Xrotation", "a channel is given twice"),
        ("ROOT Hips\n", "", "line .*"),
        ("Frames: 4", "Frames: many", "' many'|'many' is not a number"),
        ("Frames: 4\n", "", "expected 'Frames:', found 'Frame Time"),
        ("MOTION\n", "", "line 50: 'Frames:' is no part of a hierarchy"),
        ("MOTION\n", "CHANNELS 0\n", "line 50: 'CHANNELS' outside a joint"),
        ("    OFFSET 2.0 -30.0", "    OFFSET 0 0 0\n OFFSET 2.0 -30.0", "a second OFFSET of LeftF"),
        ("3 Zrotation", "6 Xrot6d", "'6 XROT6D.* is not a list of channels"),
        ("MOTION", "}\nMOTION", "line 50: '}' outside a joint"),
        ("}\nMOTION", "MOTION", "line 49: 1 joints lack their '}'"),
        ("JOINT Spine\n  {", "JOINT Spine", "line 7: expected '{', found 'OFFSET'"),
    ],
)
def test_damaged_hierarchies_say_where(tmp_path: Path, old: str, new: str, message: str) -> None:
    angles, places = random_angles(0)
    path = tmp_path / "dance.bvh"
    path.write_text(writers.bvh_text(angles, places).replace(old, new))
    with pytest.raises(MotionFileError, match=message):
        read(path)


def test_a_row_with_another_number_of_channels_is_refused(tmp_path: Path) -> None:
    angles, places = random_angles(0)
    lines = writers.bvh_text(angles, places).splitlines()
    path = tmp_path / "dance.bvh"
    for row, message in ((-4, "has not the 30 values of a frame"), (-2, "has 31 ")):
        changed = [*lines]
        changed[row] += " 1.0"
        path.write_text("\n".join(changed) + "\n")
        with pytest.raises(MotionFileError, match=f"line {len(lines) + row + 1} {message}"):
            read(path)


def test_frames_need_not_be_lines(tmp_path: Path) -> None:
    angles, places = random_angles(5)
    known = bvh_places(angles, places, "ZXY")
    text = writers.bvh_text(angles, places)
    start = text.index("\n", text.index("Frame Time")) + 1
    words = text[start:].split()
    path = tmp_path / "dance.bvh"
    for frames in (
        " ".join(words),
        "\n".join(words) + "\n",
        " ".join(words[:50]) + "\n\n " + " ".join(words[50:]),
    ):
        for header in (text[:start], " ".join(text[:start].split()) + " "):
            path.write_text(header + frames)
            recording, tracks, report = read(path)
            assert recording.rate == pytest.approx(120)
            assert not report.warnings
            for name, track in known.items():
                np.testing.assert_allclose(tracks[name], track, atol=1e-9)
    path.write_text(text[:start] + " ".join(words[:-1]))
    with pytest.raises(MotionFileError, match="119 values from there are no whole number"):
        read(path)
    words[-1] = words[-1][:-2]
    path.write_text(text[:start] + " ".join(words))
    _, tracks, report = read(path)
    assert len(tracks["Hips"]) == FRAMES - 1
    assert "perhaps within a number; the last frame is not used" in report.warnings[0]


def test_numbers_may_have_decimal_commas(tmp_path: Path) -> None:
    angles, places = random_angles(5)
    path = tmp_path / "dance.bvh"
    text = writers.bvh_text(angles, places).replace(".", ",")
    for content in (text, " ".join(text.split())):
        path.write_text(content)
        recording, tracks, report = read(path)
        assert recording.rate == pytest.approx(120)
        assert not report.warnings
        for name, known in bvh_places(angles, places, "ZXY").items():
            np.testing.assert_allclose(tracks[name], known, atol=1e-9)


def test_angles_of_many_turns_are_no_angles(tmp_path: Path) -> None:
    angles, places = random_angles(5)
    path = tmp_path / "dance.bvh"
    angles["Hips"][2] += 36000.0  # a spin, which only the root has
    angles["LeftArm"][1, 2] = 1084.5
    path.write_text(writers.bvh_text(angles, places))
    warnings = read(path)[2].warnings
    assert warnings == ["frame 2: LeftArm turns by 1084 degrees; check that frame"]
    angles["LeftArm"][3, 0] = -51234.0
    path.write_text(writers.bvh_text(angles, places))
    with pytest.raises(MotionFileError, match="frame 4: LeftArm turns by 51234 degrees, w"):
        read(path)


@pytest.mark.parametrize(
    ("ending", "old", "new", "message"),
    [
        ("asf", "  begin\n    id 5", "    id 5", "'id 5' is not where bones have it"),
        ("asf", "  end\n  begin\n    id 5", "  begin\n    id 5", "'begin' is not where bones"),
        (
            "asf",
            "    length 4.0\n",
            "    length 4.0\n    length 9.0\n",
            "'length 9.0' is not where",
        ),
        ("asf", "    dof rx\n", "    dog rx\n", "dance.amc: line .*: expected lradius and 0 num"),
        ("amc", "\n1\n", "\n", "dance.amc: line .*: root before the number of a frame"),
    ],
)
def test_bones_that_are_not_whole_are_refused(
    tmp_path: Path, ending: str, old: str, new: str, message: str
) -> None:
    path, _ = random_acclaim(tmp_path, 0)
    changed = path.with_suffix(f".{ending}")
    assert old in changed.read_text()
    changed.write_text(changed.read_text().replace(old, new, 1))
    with pytest.raises(MotionFileError, match=message):
        read(path)


def test_an_angle_that_is_missing_is_reported(tmp_path: Path) -> None:
    angles, places = random_angles(5)
    angles["LeftArm"][2, 1] = np.nan
    path = tmp_path / "dance.bvh"
    path.write_text(writers.bvh_text(angles, places))
    _, tracks, report = read(path)
    assert report.warnings == ["frame 3: LeftArm has no angle; such frames are gaps"]
    assert np.flatnonzero(np.isnan(tracks["LeftHand"]).any(axis=1)).tolist() == [2]


def test_angles_of_many_turns_are_no_angles_of_bones(tmp_path: Path) -> None:
    path, _ = random_acclaim(tmp_path, 0)
    lines = path.read_text().splitlines()
    row = next(i for i, line in enumerate(lines) if line.startswith("lradius"))
    for degrees, message in ((900, "turns by 900 degrees; check"), (9000, "which no joint does")):
        lines[row] = f"lradius {degrees}"
        path.write_text("\n".join(lines) + "\n")
        try:
            found = read(path)[2].warnings[-1]
        except MotionFileError as error:
            found = str(error)
        assert f"frame 1: lradius turns by {degrees} degrees" in found
        assert message in found


def test_a_long_chain_of_bones_is_read(tmp_path: Path) -> None:
    path, _ = random_acclaim(tmp_path, 0)
    asf = tmp_path / "dance.asf"
    bone = "  begin\n    name b{}\n    direction 0 1 0\n    length 1\n    axis 0 0 0 XYZ\n  end\n"
    count = 3000  # more than Python calls within each other
    chain = "".join(f"    b{i} b{i + 1}\n" for i in range(count - 1))
    bones = "".join(map(bone.format, range(count)))
    text = asf.read_text().replace(":hierarchy\n", f"{bones}:hierarchy\n")
    asf.write_text(text.replace("  begin\n    root", f"  begin\n    root b0\n{chain}    root"))
    _, tracks, _ = read(path)
    rise = tracks[f"b{count - 1}_end"] - tracks["root"]
    np.testing.assert_allclose(np.linalg.norm(rise, axis=1), count)


def amc_places(angles: dict[str, Array], root: Array) -> Tracks:
    """Return where the bones of `writers.AMC_BONES` begin and end, by their definition.

    A bone turns by C M C⁻¹ in its parent's frame, where C = Rz Ry Rx of its axes and M that of
    its angles; its end is a length along its direction away.
    """
    found: Tracks = {"root": root[:, :3]}
    turned = {"root": [about("z", r[5]) @ about("y", r[4]) @ about("x", r[3]) for r in root]}
    ends = {"root": root[:, :3]}
    for name, parent, direction, length, axis, dof in writers.AMC_BONES:
        x, y, z = axis
        frame = about("z", z) @ about("y", y) @ about("x", x)
        turned[name], ways = [], []
        for t in range(len(root)):
            turn = np.eye(3)
            for channel, degrees in zip(dof.split(), angles[name][t], strict=True):
                turn = about(channel[1], degrees) @ turn
            turned[name].append(turned[parent][t] @ frame @ turn @ frame.T)
            ways.append(turned[name][t] @ np.array(direction) * length)
        found[name] = ends[parent]
        found[f"{name}_end"] = ends[name] = ends[parent] + ways
    return found


def random_acclaim(folder: Path, seed: int) -> tuple[Path, Tracks]:
    rng = np.random.default_rng(seed)
    angles = {
        bone[0]: rng.uniform(-90, 90, (FRAMES, len(bone[5].split()))).round(6)
        for bone in writers.AMC_BONES
    }
    root = rng.uniform(-90, 90, (FRAMES, 6)).round(6)
    return writers.write_acclaim(folder, angles, root), amc_places(angles, root)


@pytest.mark.parametrize("seed", range(5))
def test_bones_are_where_their_angles_put_them(tmp_path: Path, seed: int) -> None:
    path, known = random_acclaim(tmp_path, seed)
    recording, tracks, report = read(path)
    assert (recording.format, recording.up, recording.rate) == ("ASF/AMC", "y", 120.0)
    for name, track in known.items():
        np.testing.assert_allclose(tracks[name], track, atol=1e-9)
    assert report.warnings == ["AMC files carry no rate; 120 Hz is used; rate_in overrides it"]


def test_angles_may_be_in_radians(tmp_path: Path) -> None:
    path, known = random_acclaim(tmp_path, 0)
    asf = tmp_path / "dance.asf"
    text = asf.read_text().replace("angle deg", "angle rad")
    for _, _, _, _, axis, _ in writers.AMC_BONES:
        degrees = " ".join(map(str, axis))
        text = text.replace(f"axis {degrees} ", f"axis {' '.join(map(str, np.radians(axis)))} ")
    asf.write_text(text)
    lines = []
    for line in path.read_text().splitlines():
        name, *values = line.split()
        kept = 3 if name == "root" else 0
        turned = [str(np.radians(float(v))) if i >= kept else v for i, v in enumerate(values)]
        lines.append(" ".join([name, *turned]))
    path.write_text("\n".join(lines).replace(":DEGREES", ":RADIANS") + "\n")
    tracks = read(path)[1]
    for name, track in known.items():
        np.testing.assert_allclose(tracks[name], track, atol=1e-9)


@pytest.mark.parametrize("newline", ["\r\n", "\n"])
def test_comments_in_latin_letters_do_not_matter(tmp_path: Path, newline: str) -> None:
    path, known = random_acclaim(tmp_path, 1)
    for file in (path, path.with_suffix(".asf")):
        text = "# geändert für Übung\n" + file.read_text()
        file.write_bytes(text.replace("\n", newline).encode("latin-1"))
    np.testing.assert_allclose(read(path)[1]["lwrist_end"], known["lwrist_end"], atol=1e-9)


def test_the_skeleton_is_looked_for_beside_the_motion(tmp_path: Path) -> None:
    path, _ = random_acclaim(tmp_path, 0)
    asf = path.with_suffix(".asf").rename(tmp_path / "d.asf")
    assert "skeleton d.asf" in read(path)[2].steps
    (tmp_path / "elsewhere").mkdir()
    moved = asf.rename(tmp_path / "elsewhere" / "d.asf")
    with pytest.raises(MotionFileError, match=r"needs its skeleton.*give it with skeleton"):
        read(path)
    assert "skeleton d.asf" in read(path, moved)[2].steps


def test_of_several_skeletons_the_one_of_that_name_is_taken(tmp_path: Path) -> None:
    path, _ = random_acclaim(tmp_path, 0)
    for name in ("other.asf", "dan.asf"):
        (tmp_path / name).write_text((tmp_path / "dance.asf").read_text())
    assert "skeleton dance.asf" in read(path)[2].steps
    (tmp_path / "dance.asf").unlink()
    (tmp_path / "dan.asf").rename(tmp_path / "third.asf")
    with pytest.raises(MotionFileError, match=r"\(other.asf, third.asf are there\)"):
        read(path)


@pytest.mark.parametrize(("skeleton", "doubted"), [("07", True), ("1", True), ("10", False)])
def test_the_only_skeleton_is_taken_but_doubted_if_its_name_is_another(
    tmp_path: Path, skeleton: str, doubted: bool
) -> None:
    path, _ = random_acclaim(tmp_path, 0)
    path.with_suffix(".asf").rename(tmp_path / f"{skeleton}.asf")
    _, _, report = read(path.rename(tmp_path / "10_01.amc"))
    assert any("the only skeleton" in warning for warning in report.warnings) == doubted


def test_frame_numbers_that_jump_are_reported(tmp_path: Path) -> None:
    path, tracks = random_acclaim(tmp_path, 0)
    path.write_text(path.read_text().replace("\n3\n", "\n30\n"))
    _, read_tracks, report = read(path)
    assert any("after frame 2 comes frame 30" in warning for warning in report.warnings)
    assert len(read_tracks["root"]) == len(tracks["root"])


def test_a_skeleton_for_a_file_that_has_its_own_is_refused(tmp_path: Path) -> None:
    angles, places = random_angles(0)
    path = tmp_path / "dance.bvh"
    path.write_text(writers.bvh_text(angles, places))
    with pytest.raises(BadOptionError, match="leave out skeleton, which is for AMC"):
        open_recording(path, ImportReport(), ReadingOptions(skeleton=str(path)))


def test_a_skeleton_in_place_of_the_motion_is_refused(tmp_path: Path) -> None:
    path, _ = random_acclaim(tmp_path, 0)
    with pytest.raises(MotionFileError, match=r"is a skeleton; give the \.amc"):
        read(path.with_suffix(".asf"))


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("order TX TY TZ", "order TX TY"),
        ("dof ry rz", "dof ry ry"),
        ("dof ry rz", "dof ry rq"),
        ("length 5.0", "length inf"),
        ("length 5.0", ""),
        ("axis 20.0", "axis nan"),
        ("lclavicle rclavicle", "lclavicle knee"),
        ("    lclavicle lhumerus", "    nobody lhumerus"),
        ("  end\n", ""),
    ],
)
def test_damaged_skeletons_are_named(tmp_path: Path, old: str, new: str) -> None:
    path, _ = random_acclaim(tmp_path, 0)
    asf = path.with_suffix(".asf")
    assert old in asf.read_text()
    asf.write_text(asf.read_text().replace(old, new))
    with pytest.raises(MotionFileError, match=r"dance\.asf: is damaged or cut short"):
        read(path)


def test_a_skeleton_that_is_cut_in_its_hierarchy_is_named(tmp_path: Path) -> None:
    path, _ = random_acclaim(tmp_path, 0)
    asf = path.with_suffix(".asf")
    asf.write_text(asf.read_text().rpartition("  end")[0])
    with pytest.raises(MotionFileError, match=r"dance\.asf: is damaged or cut short \(no end of"):
        read(path)


def test_a_frame_that_lacks_a_bone_is_named(tmp_path: Path) -> None:
    path, _ = random_acclaim(tmp_path, 0)
    lines = path.read_text().splitlines()
    lines.remove(next(line for line in reversed(lines) if line.startswith("lhumerus")))
    path.write_text("\n".join(lines) + "\n")
    with pytest.raises(MotionFileError, match="frame 4, where the file ends, has 10 of 11 bones"):
        read(path)


def test_an_axis_unlike_that_of_the_other_side_is_warned_of(tmp_path: Path) -> None:
    path, _ = random_acclaim(tmp_path, 0)
    skeleton = path.with_suffix(".asf")
    assert not any("the axis of" in warning for warning in read(path)[2].warnings)
    left, _, right = skeleton.read_text().rpartition("axis 10.0 0.0 90.0")
    skeleton.write_text(f"{left}axis 10.0 0.0 20.0{right}")
    expected = "the axis of lradius is 10 0 90, and that of rradius 10 0 20"
    assert any(warning.startswith(expected) for warning in read(path)[2].warnings)


def test_a_motion_and_its_bvh_show_the_same_arms(mocap: Path) -> None:
    amc = read(mocap / "cmu_amc" / "01_01.amc")[1]
    bvh = read(mocap / "cmu_amc" / "01_01.bvh")[1]
    # What CMU's BVH calls LeftArm begins where the bone lhumerus does.
    for side in ("l", "r"):
        word = {"l": "Left", "r": "Right"}[side]
        for bone, start, end in (("humerus", "Arm", "ForeArm"), ("radius", "ForeArm", "Hand")):
            ends = f"{side}{bone}_end" if bone == "humerus" else f"{side}wrist_end"
            mine = amc[ends] - amc[f"{side}{bone}"]
            theirs = (bvh[f"{word}{end}"] - bvh[f"{word}{start}"])[1:]  # one frame more
            unit = [v / np.linalg.norm(v, axis=1, keepdims=True) for v in (mine, theirs)]
            angle = 2 * np.arcsin(np.linalg.norm(unit[0] - unit[1], axis=1) / 2)
            assert np.median(angle) < 1e-3, (side, bone)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("OFFSET 2.0 -30.0", "OFFSET 2.0 -80.0", "the offset of LeftForeArm is 2 -80 0.5"),
        ("OFFSET -1.0 -25.0", "OFFSET -9.0 -25.0", "and that of RightHand -9 -25 0.25"),
        ("OFFSET 0.0 50.0", "OFFSET 9.0 50.0", ""),  # the only one of its kind
    ],
)
def test_an_offset_unlike_the_other_sides_is_told(
    tmp_path: Path, old: str, new: str, told: str
) -> None:
    path = tmp_path / "dance.bvh"
    angles, places = random_angles(0)
    text = writers.bvh_text(angles, {"Hips": places["Hips"]})
    path.write_text(text)
    assert not read(path)[2].warnings
    path.write_text(text.replace(old, new))
    found = [warning for warning in read(path)[2].warnings if told in warning]
    assert len(found) == bool(told)


def test_an_order_of_axes_unlike_all_others_is_warned_of(tmp_path: Path) -> None:
    path = tmp_path / "dance.bvh"
    angles, places = random_angles(0)
    text = writers.bvh_text(angles, {"Hips": places["Hips"]})
    left, usual, right = text.rpartition("Zrotation Xrotation Yrotation")
    assert usual
    path.write_text(f"{left}Yrotation Xrotation Zrotation{right}")
    assert any("all other joints about ZXY" in warning for warning in read(path)[2].warnings)


def test_an_asymmetric_skeleton_is_not_doubted(tmp_path: Path) -> None:
    path = tmp_path / "dance.bvh"
    angles, places = random_angles(0)
    text = writers.bvh_text(angles, {"Hips": places["Hips"]})
    path.write_text(
        text.replace("OFFSET 2.0 -30.0", "OFFSET 2.0 -31.0").replace("-1.0 -25", "-2 -25")
    )
    assert not read(path)[2].warnings


def test_a_direction_that_is_no_unit_vector_is_told(tmp_path: Path) -> None:
    path, skeleton = random_acclaim(tmp_path, 0)[0], tmp_path / "dance.asf"
    text = skeleton.read_text()
    skeleton.write_text(text.replace("direction 0.0 1.0 0.0", "direction 0.6 1.0 0.0", 1))
    told = [warning for warning in read(path)[2].warnings if "direction" in warning]
    assert told == [
        "the direction of lowerback has the length 1.166 instead of 1; check it in the skeleton"
    ]
