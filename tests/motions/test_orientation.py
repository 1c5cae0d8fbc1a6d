import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from mpma_mj import kinematics
from mpma_mj.errors import MotionFileError
from mpma_mj.motions import ymca
from mpma_mj.motions.body import posture_from_points
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.loader import ImportedMotion, import_motion
from mpma_mj.motions.marker_sets import half_pelvis
from mpma_mj.motions.options import ReadingOptions
from mpma_mj.motions.orientation import arm_length, check_sides, find_unit, find_up, turn_z_up
from mpma_mj.motions.readers.recording import UNITS, UPS, Up
from tests.conftest import WriteTsv, dancer, doubts, markers_of

Array = NDArray[np.float64]


Points = dict[str, Array]


POSTURE = ymca(rate=60.0).posture


HANGING = kinematics.posture_from_angles(
    np.tile([0.2, 0.1, 0.0, 0.5], 2) + 0.1 * np.sin(np.arange(240)[:, None] / 20 + np.arange(8))
)


def turned_to(points: Points, up: Up) -> Points:
    """Return points of a z-up dancer as a file stores them in which another axis is up."""
    axis = "xyz".index(up[-1])
    order = [(axis + 1) % 3, (axis + 2) % 3, axis]
    signs = [1.0, -1.0, -1.0] if up.startswith("-") else [1.0, 1.0, 1.0]
    found = {}
    for name, track in points.items():
        found[name] = np.empty_like(track)
        found[name][:, order] = track * signs
    return found


def standing(posture: Array, *, torso: bool) -> Points:
    points = dancer(posture)
    if torso:
        points |= {
            name: np.tile([0.0, 0.0, z], (len(posture), 1))
            for name, z in (("pelvis", 950.0), ("neck", 1450.0))
        }
    return points


def read(
    path: Path, points: Points, stored: dict[str, object], **options: object
) -> ImportedMotion:
    np.savez(path, **({"rate": 60.0} | stored), **points)  # type: ignore[arg-type]
    return import_motion(path, ReadingOptions(**options))  # type: ignore[arg-type]


@pytest.mark.parametrize("up", UPS)
@given(seed=st.integers(0, 999))
def test_turning_keeps_shape_and_handedness(up: Up, seed: int) -> None:
    track = np.random.default_rng(seed).normal(size=(4, 3))
    turned = turn_z_up(track, up)
    np.testing.assert_allclose(turned @ turned.T, track @ track.T)
    assert np.linalg.det(turned[:3]) == pytest.approx(np.linalg.det(track[:3]))
    np.testing.assert_array_equal(turn_z_up(np.eye(3)[["xyz".index(up[-1])]], up)[0, :2], 0.0)


@pytest.mark.parametrize("up", UPS)
def test_the_axis_that_is_up_becomes_z(up: Up) -> None:
    axis = np.zeros((1, 3))
    axis[0, "xyz".index(up[-1])] = -1.0 if up.startswith("-") else 1.0
    np.testing.assert_array_equal(turn_z_up(axis, up), [[0.0, 0.0, 1.0]])


@pytest.mark.parametrize("up", UPS)
@pytest.mark.parametrize(
    ("torso", "how"), [(True, "by the trunk"), (False, "by the hanging upper arms")]
)
def test_the_axis_that_is_up_is_found(tmp_path: Path, up: Up, torso: bool, how: str) -> None:
    points = standing(HANGING, torso=torso)
    plain = read(tmp_path / "plain.npz", points, {"up": "z"})
    if not torso and up not in ("y", "z"):  # rather than that, the arms do not hang
        with pytest.raises(MotionFileError, match="the up axis is unknown"):
            read(tmp_path / "turned.npz", turned_to(points, up), {})
        return
    found = read(tmp_path / "turned.npz", turned_to(points, up), {})
    np.testing.assert_allclose(found.motion.posture, plain.motion.posture, atol=1e-9)
    assert f"{up} is up, {how}" in found.report.steps
    assert not doubts(found.report)


@pytest.mark.parametrize("up", UPS)
def test_what_is_declared_or_given_is_used(tmp_path: Path, up: Up) -> None:
    points = standing(POSTURE, torso=False)  # arms are above the shoulders, which tells nothing
    plain = read(tmp_path / "plain.npz", points, {"up": "z"})
    turned = turned_to(points, up)
    declared = read(tmp_path / "a.npz", turned, {"up": up})
    given_ = read(tmp_path / "b.npz", turned, {"up": "x"}, up=up)
    for imported in (declared, given_):
        np.testing.assert_allclose(imported.motion.posture, plain.motion.posture, atol=1e-9)
    assert f"{up} is up, as the file or its format declares" in declared.report.steps
    assert f"{up} is up, as given" in given_.report.steps


def test_a_trunk_counts_for_more_than_a_declared_axis(tmp_path: Path) -> None:
    points = standing(POSTURE, torso=True)
    imported = read(tmp_path / "a.npz", turned_to(points, "y"), {"up": "z"})
    assert "y is up, by the trunk; the file or its format declares z" in imported.report.steps


def test_where_nothing_tells_what_is_up_it_is_asked_for(tmp_path: Path) -> None:
    t_pose = np.tile([[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]], 2).ravel()
    points = standing(np.tile(t_pose.reshape(2, 2, 3).ravel(), (60, 1)), torso=False)
    with pytest.raises(MotionFileError, match=r"the up axis is unknown: [^\n]* such as up=z$"):
        read(tmp_path / "a.npz", points, {})
    assert len(read(tmp_path / "a.npz", points, {}, up="z").motion) == 20
    more = {name: np.tile([0.0, 0.0, z], (60, 1)) for name, z in (("Bauch", 900), ("Kinn", 1400))}
    with pytest.raises(MotionFileError, match=r"is recognised among Bauch, Kinn, and the up axis"):
        read(tmp_path / "a.npz", points | more, {})
    named = read(tmp_path / "a.npz", points | more, {}, map="pelvis=Bauch,neck=Kinn")
    assert not named.report.warnings


def test_with_a_trunk_that_turns_everywhere_no_axis_needs_to_be_up(tmp_path: Path) -> None:
    points = standing(POSTURE, torso=True)
    plain = read(tmp_path / "plain.npz", points, {})
    angle = np.linspace(0.0, 2 * np.pi, len(POSTURE), endpoint=False)
    turn = np.zeros((len(angle), 3, 3))
    turn[:, 0, 0] = turn[:, 2, 2] = np.cos(angle)
    turn[:, 0, 2], turn[:, 2, 0], turn[:, 1, 1] = np.sin(angle), -np.sin(angle), 1.0
    rolling = {name: np.einsum("tij,tj->ti", turn, track) for name, track in points.items()}
    imported = read(tmp_path / "a.npz", rolling, {})
    assert not doubts(imported.report)
    assert np.abs(imported.motion.posture - plain.motion.posture).mean() < 0.01  # filtered


@pytest.mark.parametrize("frame", [0, 30])
def test_a_fault_in_one_frame_does_not_hide_what_is_up(frame: int) -> None:
    points = dancer(HANGING)
    points["left_elbow"][frame] = points["left_shoulder"][frame]
    assert find_up(points, None, None, "dance.x", ImportReport()) == "z"


@pytest.mark.parametrize("unit", UNITS)
@pytest.mark.parametrize("arm_m", [0.45, 0.55, 0.65])
def test_the_unit_is_found_by_the_arms(unit: str, arm_m: float) -> None:
    report = ImportReport()
    length = UNITS[unit]
    assert find_unit(arm_m / length, None, None, report) == length
    assert report.steps == [f"unit {unit}, by the length of the arms"]


@given(arm_m=st.floats(0.25, 0.9), unit=st.sampled_from([*UNITS]))
def test_a_declared_unit_that_fits_any_body_is_used(arm_m: float, unit: str) -> None:
    report = ImportReport()
    length = UNITS[unit]
    fits = 0.25 <= arm_m / length * length <= 0.9  # but for rounding
    if fits:
        assert find_unit(arm_m / length, length, None, report) == length
        assert report.steps == [f"unit {unit}, as the file declares"]
        assert not report.warnings


def test_a_declared_unit_that_fits_no_body_is_warned_about() -> None:
    report = ImportReport()
    assert find_unit(550.0, UNITS["m"], None, report) == UNITS["mm"]
    assert report.warnings == [
        "the file declares m, which makes arms of 550 m; mm is used; unit overrides it"
    ]


def test_arms_that_fit_no_unit_are_warned_about() -> None:
    for declared in (None, 1.0):
        report = ImportReport()
        assert find_unit(1e6, declared, None, report) is None
        assert len(report.warnings) == 1
        assert "no usual unit" in report.warnings[0]


def test_a_unit_that_is_given_is_used_and_told_if_it_fits_nobody() -> None:
    report = ImportReport()
    assert find_unit(0.55, UNITS["mm"], UNITS["m"], report) == 1.0
    assert report.steps == ["unit m, as given"]
    assert not report.warnings
    assert find_unit(550.0, UNITS["mm"], UNITS["m"], report) == 1.0
    assert len(report.warnings) == 1
    assert "arms of 550 m" in report.warnings[0]


@settings(max_examples=20)
@given(scale=st.floats(1e-4, 1e4), seed=st.integers(0, 9))
def test_arms_are_as_long_as_upper_arm_and_forearm(scale: float, seed: int) -> None:
    points = {name: scale * track for name, track in dancer(POSTURE).items()}
    gone = np.random.default_rng(seed).integers(0, len(POSTURE), 20)
    points["left_elbow"][gone] = np.nan
    assert arm_length(points) == pytest.approx(550.0 * scale)


@pytest.mark.parametrize("scale", [1e-3, 0.1, 1 / 25.4, 1e3])
@pytest.mark.parametrize("unit", [None, "m"])
def test_postures_do_not_depend_on_the_unit(tmp_path: Path, scale: float, unit: str | None) -> None:
    points = dancer(POSTURE)
    plain = read(tmp_path / "plain.npz", points, {"up": "z"})
    scaled = {name: scale * track for name, track in points.items()}
    found = read(tmp_path / "scaled.npz", scaled, {"up": "z"}, unit=unit)
    np.testing.assert_allclose(found.motion.posture, plain.motion.posture, atol=1e-9)


@pytest.mark.parametrize("unit", UNITS)
def test_lengths_are_told_in_metres(tmp_path: Path, unit: str) -> None:
    points = {n: t * 1e-3 / UNITS[unit] for n, t in dancer(POSTURE).items()}
    for stored, options in (({"unit": unit}, {}), ({}, {}), ({}, {"unit": unit})):
        imported = read(tmp_path / "a.npz", points, {"up": "z"} | stored, **options)
        assert imported.report.metric
        for name, length in (("upper arm", 0.3), ("forearm", 0.25)):
            for side in kinematics.SIDES:
                mean, deviation = imported.report.lengths[f"{side} {name}"]
                assert mean == pytest.approx(length)
                assert deviation == pytest.approx(0.0, abs=1e-9)


def test_the_rate_is_declared_given_or_asked_for(write_tsv: WriteTsv) -> None:
    assert import_motion(write_tsv(), ReadingOptions()).report.rate == 60.0
    imported = import_motion(write_tsv(), ReadingOptions(rate_in=120.0))
    assert imported.report.rate == 120.0
    assert imported.motion.duration == pytest.approx(1.9)
    assert "120 Hz, as given (the file declares 60 Hz)" in imported.report.steps
    path = write_tsv(edit=lambda text: text.replace("FREQUENCY\t60\n", ""))
    with pytest.raises(MotionFileError, match=r"does not declare its frame rate; .* rate_in=50$"):
        import_motion(path, ReadingOptions())
    imported = import_motion(path, ReadingOptions(rate_in=60.0))
    assert "60 Hz, as given (the file declares no rate)" in imported.report.steps


def test_the_same_dance_at_another_rate_is_the_same(tmp_path: Path) -> None:
    found = []
    for rate in (60.0, 100.0, 240.0):
        time = np.arange(round(8 * rate))[:, None] / rate
        angles = np.tile([0.5, 0.2, 0.0, 0.8], 2) + 0.3 * np.sin(3 * time + np.arange(8))
        points = dancer(kinematics.posture_from_angles(angles))
        path = tmp_path / f"{rate:g}.npz"
        found.append(read(path, points, {"rate": rate, "up": "z"}, cutoff=6.0).motion.posture)
    for posture in found[1:]:
        np.testing.assert_allclose(posture[10:150], found[0][10:150], atol=1e-3)


def moving(seed: int, elbow: float = 1.0) -> Points:
    """Return a dancer whose elbows bend forearms forward, about as far as is asked."""
    rng = np.random.default_rng(seed)
    rest = np.tile([0.5, 0.3, 0.0, elbow], 2)
    phase = np.arange(200)[:, None] / rng.uniform(8.0, 20.0, 8) + rng.uniform(0, 6, 8)
    return dancer(kinematics.posture_from_angles(rest + 0.3 * elbow * np.sin(phase)))


def swapped(points: Points, *parts: str) -> Points:
    other = {"left": "right", "right": "left"}
    found = dict(points)
    for name in points:
        side, _, part = name.partition("_")
        if part in parts:
            found[name] = points[f"{other[side]}_{part}"]
    return found


def side_warnings(points: Points) -> list[str]:
    report = ImportReport()
    groups = {name: (name.upper(),) for name in points}
    check_sides(points, posture_from_points(points), groups, report)
    return report.warnings


@given(seed=st.integers(0, 999))
def test_a_dancer_whose_sides_are_right_is_not_warned_about(seed: int) -> None:
    assert not side_warnings(moving(seed))


@given(seed=st.integers(0, 999))
def test_elbows_and_wrists_of_the_other_side_are_warned_about(seed: int) -> None:
    (warning,) = side_warnings(swapped(moving(seed), "elbow", "wrist"))
    assert warning.startswith("both elbows are beyond the body's midline in 100 % of the frames")


@given(seed=st.integers(0, 999))
def test_a_dancer_whose_every_name_is_of_the_other_side_is_warned_about(seed: int) -> None:
    (warning,) = side_warnings(swapped(moving(seed), "shoulder", "elbow", "wrist"))
    assert warning.startswith("forearms point backwards in 100 % of the frames in which they are")


@given(seed=st.integers(0, 999))
def test_stretched_arms_tell_nothing(seed: int) -> None:
    for parts in ((), ("shoulder", "elbow", "wrist")):
        assert not side_warnings(swapped(moving(seed, elbow=0.05), *parts))


@pytest.mark.parametrize("tempo", [0.5, 1.0])
def test_the_built_in_dance_is_not_warned_about(tempo: float) -> None:
    assert not side_warnings(dancer(ymca(rate=60.0, tempo=tempo).posture))


def test_arms_that_cross_now_and_then_are_not_warned_about() -> None:
    points = moving(0)
    crossed = swapped(points, "elbow", "wrist")
    for name, track in points.items():
        crossed[name] = np.where(np.arange(200)[:, None] < 80, crossed[name], track)
    assert not side_warnings(crossed)


def test_sides_of_a_file_are_checked(write_tsv: WriteTsv) -> None:
    points = moving(1)
    assert not doubts(
        import_motion(write_tsv(markers_of(points), name="right.tsv"), ReadingOptions()).report
    )
    wrong = swapped(points, "shoulder", "elbow", "wrist")
    imported = import_motion(write_tsv(markers_of(wrong)), ReadingOptions())
    assert len(doubts(imported.report)) == 1
    mapping = re.findall(r'map="(.*?)" the second', doubts(imported.report)[0])
    mended = import_motion(write_tsv(markers_of(wrong)), ReadingOptions(map=mapping[0]))
    assert not doubts(mended.report)
    right = import_motion(write_tsv(markers_of(points)), ReadingOptions())
    np.testing.assert_allclose(mended.motion.posture, right.motion.posture, atol=1e-9)


def picture(points: Points, width: float, height: float) -> Points:
    """Return points as a picture, of a size in pixels, shows them: x to the right, y down, z."""
    scale = 500.0  # pixels a metre
    shown = {}
    for name, track in points.items():
        left, up, forward = track[:, 1] / 1e3, track[:, 2] / 1e3, track[:, 0] / 1e3
        x, y = 960.0 + scale * left, 1300.0 - scale * up
        shown[name] = np.stack([x / width, y / height, -scale * forward / width], axis=1)
    return shown


@pytest.mark.parametrize("torso", [False, True])
def test_shares_of_a_picture_are_refused(tmp_path: Path, torso: bool) -> None:
    points = picture(standing(HANGING, torso=torso), 1920.0, 1300.0)
    with pytest.raises(MotionFileError, match="shares of a picture's width and height") as caught:
        read(tmp_path / "a.npz", points, {})
    assert "world landmarks" in str(caught.value)
    assert len(read(tmp_path / "a.npz", points, {}, unit="m", up="-y").motion) > 70


@pytest.mark.parametrize("scales", [(1.0, 16 / 9, 1.0), (0.5, 0.5, 5.0)])
@pytest.mark.parametrize("shift", [0.0, 0.9, -3.0])
def test_axes_of_different_scales_are_refused(
    tmp_path: Path, scales: tuple[float, float, float], shift: float
) -> None:
    points = {n: t / 1e3 + shift for n, t in standing(POSTURE, torso=True).items()}
    assert not read(tmp_path / "a.npz", points, {}).report.warnings
    uneven = {name: track * scales for name, track in points.items()}
    with pytest.raises(MotionFileError, match="which keep no angles; export places in space"):
        read(tmp_path / "a.npz", uneven, {})
    assert len(read(tmp_path / "a.npz", uneven, {}, unit="m").motion) > 70


@pytest.mark.parametrize("seed", range(3))
def test_noisy_places_are_no_picture(tmp_path: Path, seed: int) -> None:
    noise = np.random.default_rng(seed).normal(size=(6, len(POSTURE), 3)) * [10.0, 10.0, 60.0]
    points = standing(POSTURE, torso=False)
    noisy = {name: track + noise[i] for i, (name, track) in enumerate(points.items())}
    assert len(read(tmp_path / "a.npz", noisy, {"up": "z"}).motion) > 70


@pytest.mark.parametrize("depth", ["zero", "constant", "confidence"])
def test_pixels_without_depth_are_refused(tmp_path: Path, depth: str) -> None:
    rng = np.random.default_rng(0)
    points = picture(standing(HANGING, torso=True), 1.0, 1.0)
    for track in points.values():
        confidence = rng.uniform(0.5, 1.0, len(track))
        track[:, 2] = {"zero": 0.0, "constant": 7.0, "confidence": confidence}[depth]
    with pytest.raises(MotionFileError, match=r"these are places in a picture, without depth"):
        read(tmp_path / "a.npz", points, {})


@pytest.mark.parametrize("up", UPS)
@pytest.mark.parametrize("way", [0.0, 300.0])  # mm
def test_places_in_space_are_no_picture(tmp_path: Path, up: Up, way: float) -> None:
    shift = np.array([way, way, 0.0])
    points = {n: (t + shift) / 1e3 for n, t in standing(HANGING, torso=True).items()}
    assert len(read(tmp_path / "a.npz", turned_to(points, up), {}).motion) > 70


def test_places_before_a_camera_are_no_picture(tmp_path: Path) -> None:
    points = turned_to({n: t / 1e3 for n, t in standing(HANGING, torso=True).items()}, "-y")
    lowest = np.min([track.min(axis=0) for track in points.values()], axis=0)
    seen = {name: track - lowest + [0.05, 0.05, 2.0] for name, track in points.items()}
    assert max(track[:, :2].max() for track in seen.values()) < 1.0
    assert len(read(tmp_path / "a.npz", seen, {}).motion) > 70


@pytest.mark.parametrize("up", UPS)
@pytest.mark.parametrize("axis", range(3))
def test_left_handed_axes_are_mirrored(tmp_path: Path, up: Up, axis: int) -> None:
    points = standing(HANGING, torso=True)
    plain = read(tmp_path / "plain.npz", points, {})
    mirror = np.where(np.arange(3) == axis, -1.0, 1.0)
    mirrored = {name: track * mirror for name, track in turned_to(points, up).items()}
    imported = read(tmp_path / "a.npz", mirrored, {}, left_handed=True)
    np.testing.assert_allclose(imported.motion.posture, plain.motion.posture, atol=1e-9)
    assert "left-handed axes, as given: mirrored" in imported.report.steps
    assert not doubts(imported.report)


def test_left_handed_axes_are_warned_about_with_the_option_that_mirrors(tmp_path: Path) -> None:
    points = {name: track * [1.0, -1.0, 1.0] for name, track in moving(0).items()}
    (warning,) = doubts(read(tmp_path / "a.npz", points, {"up": "z"}).report)
    assert warning.endswith("up the third")
    assert "; left_handed corrects the first, map=" in warning
    assert not doubts(read(tmp_path / "a.npz", points, {"up": "z"}, left_handed=True).report)


PELVIS = {
    "front": [["LASI", "RASI"], ["L_IAS", "R_IAS"], ["LFWT", "RFWT"], ["Hip_FL", "Hip_FR"]],
    "back": [
        ["LPSI", "RPSI"],
        ["L_IPS", "R_IPS"],
        ["LBWT", "RBWT"],
        ["Hip_BL", "Hip_BR"],
        ["SACR"],
    ],
}


@pytest.mark.parametrize("end", PELVIS)
@pytest.mark.parametrize("lean", [0.0, 0.6])
@pytest.mark.parametrize("given", [False, True])
def test_a_torso_with_half_a_pelvis_leans_as_with_a_whole_one(
    tmp_path: Path, end: str, lean: float, given: bool
) -> None:
    plain = read(tmp_path / "plain.npz", standing(HANGING, torso=True), {})
    turn = Rotation.from_euler("y", lean)
    for names in PELVIS[end]:
        points = standing(HANGING, torso=True)
        del points["pelvis"]
        for name in names:
            side = {"L": 110.0, "R": -110.0}.get(name[0] if "Hip" not in name else name[-1], 0.0)
            x = 105.0 if end == "front" else -105.0
            points[name] = np.tile([x, side, 950.0], (len(HANGING), 1))
        turned = {name: turn.apply(track) for name, track in points.items()}
        mapping = f"pelvis={'+'.join(names)}" if given else None
        imported = read(tmp_path / "a.npz", turned, {}, map=mapping)
        angle = np.sum((imported.motion.posture * plain.motion.posture).reshape(-1, 4, 3), axis=2)
        assert np.degrees(np.arccos(angle.min())) < 1.0
        assert any(f"only the {end} of the pelvis" in w for w in doubts(imported.report))


def test_hips_and_whole_pelvises_are_no_halves() -> None:
    for group in ("Hips", "pelvis", "LHip RHip", "LASI RASI LPSI RPSI", "LASI RASI SACR SACR"):
        assert half_pelvis(group.split()) is None


FRONTS = {
    "toes": {"LeftToes": 180.0, "RightToes": 180.0, "LeftFoot": 20.0, "RightFoot": 20.0},
    "nose": {"NOSE": 90.0, "LEFT_EAR": 0.0, "RIGHT_EAR": 0.0},
    "chest": {"CLAV": 70.0, "C7": -70.0},
}


@pytest.mark.parametrize("front", FRONTS)
@pytest.mark.parametrize("turn", [0.0, 2.0])
def test_points_in_front_show_left_handed_axes(tmp_path: Path, front: str, turn: float) -> None:
    points = standing(dancer_facing_with_straight_arms(), torso=True)
    for name, forward in FRONTS[front].items():
        points[name] = np.tile([forward, 0.0, 1500.0], (240, 1))
    points = {n: Rotation.from_euler("z", turn).apply(track) for n, track in points.items()}
    mirrored = {name: track * [-1.0, 1.0, 1.0] for name, track in points.items()}
    assert not doubts(read(tmp_path / "a.npz", points, {}).report)
    (warning,) = doubts(read(tmp_path / "a.npz", mirrored, {}).report)
    assert "the file's axes look left-handed, as in Unity, or left and right are swapped" in warning
    assert "; left_handed corrects the first, map=" in warning
    assert not doubts(read(tmp_path / "a.npz", mirrored, {}, left_handed=True).report)
    (warning,) = doubts(read(tmp_path / "a.npz", points, {}, left_handed=True).report)
    assert warning.endswith("the file's axes are right-handed; leave out left_handed")


def dancer_facing_with_straight_arms() -> Array:
    """Return postures in which elbows show nothing."""
    phase = np.arange(240)[:, None] / 20 + np.arange(8)
    return kinematics.posture_from_angles(np.tile([0.3, 0.2, 0.0, 0.02], 2) + 0.05 * np.sin(phase))
