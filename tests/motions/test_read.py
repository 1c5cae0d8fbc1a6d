"""Recordings of a synthetic dancer whose postures are known."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from mpma_mj.errors import BadOptionError, MotionFileError, UnknownMotionError
from mpma_mj.motions import read_motion, ymca
from mpma_mj.motions.body import posture_from_points
from mpma_mj.motions.filtering import low_pass
from tests.conftest import dancer, markers_of

WriteTsv = Callable[..., Path]


def markers() -> dict[str, np.ndarray]:
    return markers_of(dancer(ymca(rate=60.0).posture))


def test_a_recorded_posture_is_read_back(write_tsv: WriteTsv) -> None:
    motion = read_motion(write_tsv())
    truth = ymca(rate=60.0).posture[::3]
    assert motion.rate == 20.0
    assert motion.posture.shape == truth.shape
    # What is left is what the low-pass filter takes from the fastest moves.
    assert np.abs(motion.posture - truth).mean() < 0.01


def test_slow_movements_pass_the_filter_unchanged(write_tsv: WriteTsv) -> None:
    slow = ymca(rate=60.0, tempo=0.1).posture
    motion = read_motion(write_tsv(markers_of(dancer(slow))))
    assert np.abs(motion.posture - slow[::3]).max() < 2e-3


@settings(max_examples=10, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(angle=st.floats(-3.1, 3.1), speed=st.floats(-2.0, 2.0), walk=st.floats(-900.0, 900.0))
def test_a_dancer_who_turns_and_walks_gives_the_same_arms(
    write_tsv: WriteTsv, angle: float, speed: float, walk: float
) -> None:
    standing = dancer(ymca(rate=60.0).posture)
    time = np.arange(len(standing["left_wrist"])) / 60.0
    turn = angle + speed * time
    cos, sin, zero, one = np.cos(turn), np.sin(turn), 0 * turn, 0 * turn + 1
    matrix = np.stack([cos, -sin, zero, sin, cos, zero, zero, zero, one], 1).reshape(-1, 3, 3)
    path = np.stack([walk * time, 300 * np.sin(time), 0 * time], axis=1)
    moving = {n: np.einsum("tij,tj->ti", matrix, p) + path for n, p in standing.items()}
    np.testing.assert_allclose(
        posture_from_points(moving), posture_from_points(standing), atol=1e-9
    )


def test_half_the_tempo_gives_twice_the_postures(write_tsv: WriteTsv) -> None:
    path = write_tsv()
    original, slowed = read_motion(path), read_motion(path, tempo=0.5)
    assert abs(len(slowed) - 2 * len(original)) <= 1
    np.testing.assert_allclose(
        slowed.posture[::2], original.posture[: len(slowed) // 2 + 1], atol=1e-6
    )


def test_lines_between_names_and_numbers_are_skipped(write_tsv: WriteTsv) -> None:
    def add_line(text: str) -> str:
        return text.replace("\tUlna_R\n", "\tUlna_R\nTRAJECTORY_TYPES\tMeasured\tMixed\n")

    more, plain = write_tsv(name="more.tsv", edit=add_line), write_tsv()
    np.testing.assert_array_equal(read_motion(more).posture, read_motion(plain).posture)


@pytest.mark.parametrize("columns", ["Frame", "Frame\tTime"])
def test_frame_and_time_columns_are_skipped(write_tsv: WriteTsv, columns: str) -> None:
    def add_columns(text: str) -> str:
        lines = text.splitlines()
        extra = len(columns.split("\t"))
        rows = ["\t".join(["7"] * extra) + "\t" + row for row in lines[4:]]
        return "\n".join([*lines[:4], columns + "\tShoulder_L X", *rows])

    plain = read_motion(write_tsv(name="plain.tsv"))
    with_columns = read_motion(write_tsv(name="columns.tsv", edit=add_columns))
    np.testing.assert_array_equal(with_columns.posture, plain.posture)


@pytest.mark.parametrize(
    "edit",
    [
        lambda text: text.replace("\n", "\t\n"),
        lambda text: text.replace("\n", "\r\n"),
        lambda text: text + "\n\n",
    ],
    ids=["trailing tabs", "CRLF", "blank lines at the end"],
)
def test_harmless_variants_read_the_same(write_tsv: WriteTsv, edit: Callable[[str], str]) -> None:
    plain, variant = write_tsv(name="plain.tsv"), write_tsv(name="variant.tsv", edit=edit)
    np.testing.assert_array_equal(read_motion(variant).posture, read_motion(plain).posture)


@pytest.mark.parametrize("gap", [np.nan, 0.0], ids=["empty cells", "exact zeros"])
def test_short_gaps_are_bridged(write_tsv: WriteTsv, gap: float) -> None:
    complete = read_motion(write_tsv(name="complete.tsv"))
    holed = markers()
    holed["Elbow_R"][100:110] = gap
    bridged = read_motion(write_tsv(holed, name="holed.tsv"))
    assert np.abs(bridged.posture - complete.posture).max() < 0.03


def test_the_last_marker_may_be_missing_in_a_row(write_tsv: WriteTsv) -> None:
    holed = markers()
    holed["Ulna_R"][100:105] = np.nan
    assert len(read_motion(write_tsv(holed))) == len(read_motion(write_tsv(name="whole.tsv")))


def test_noise_is_filtered(write_tsv: WriteTsv) -> None:
    rng = np.random.default_rng(0)
    slow = ymca(rate=60.0, tempo=0.2).posture
    clean = markers_of(dancer(slow))
    noisy = {name: track + rng.normal(0, 5.0, track.shape) for name, track in clean.items()}
    error = read_motion(write_tsv(noisy)).posture - slow[::3]
    assert error.std() < 0.6 * 5.0 / 275  # unfiltered, 5 mm are this angle or more


@pytest.mark.parametrize(("frequency", "gain"), [(2.0, 0.988), (6.0, 0.5), (12.0, 0.038)])
def test_the_filter_is_butterworths_both_ways(frequency: float, gain: float) -> None:
    time = np.arange(1200) / 60.0
    wave = np.sin(2 * np.pi * frequency * time)
    middle = low_pass(wave, 60.0, 6.0)[300:-300]
    expected = 1 / (1 + (np.tan(np.pi * frequency / 60) / np.tan(np.pi * 0.1)) ** 4)
    assert expected == pytest.approx(gain, abs=0.02)
    assert np.sqrt(2) * middle.std() == pytest.approx(expected, rel=0.02)


def test_what_a_faster_tempo_would_alias_is_filtered(write_tsv: WriteTsv) -> None:
    shaking = markers_of(dancer(np.tile(ymca().posture[:1], (600, 1))))
    for name in ("Radius_L", "Ulna_L"):
        shaking[name][:, 0] += 30 * np.sin(2 * np.pi * 4.5 * np.arange(600) / 60)
    path = write_tsv(shaking)
    slow, fast = (read_motion(path, tempo=tempo).posture[:, 3].std() for tempo in (1.0, 2.0))
    # At 4.5 Hz: cut off at 6 Hz, and at the 4 Hz that become 8 of 20 Hz.
    assert fast / slow == pytest.approx((1 + (4.5 / 6) ** 4) / (1 + (4.5 / 4) ** 4), rel=0.1)


def test_a_single_wrist_marker_will_do(write_tsv: WriteTsv) -> None:
    points = markers()
    points["Wrist_L"] = (points.pop("Radius_L") + points.pop("Ulna_L")) / 2  # one side only
    single, double = read_motion(write_tsv(points, name="1.tsv")), read_motion(write_tsv())
    np.testing.assert_allclose(single.posture, double.posture, atol=1e-6)


def test_a_recording_has_equal_segments_as_context(write_tsv: WriteTsv) -> None:
    motion = read_motion(write_tsv(), segments=5)
    assert motion.labels == ("1", "2", "3", "4", "5")
    counts = motion.context.sum(axis=0)
    assert counts.max() - counts.min() <= 1
    assert (np.diff(motion.context.argmax(axis=1)) >= 0).all()


def edit_row(row: int, change: Callable[[list[str]], list[str]]) -> Callable[[str], str]:
    def edit(text: str) -> str:
        lines = text.splitlines()
        lines[row - 1] = "\t".join(change(lines[row - 1].split("\t")))
        return "\n".join(lines)

    return edit


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (lambda t: t.replace("Elbow_L", "Ellbow"), "no marker Elbow_L;.*has Shoulder_L, Ellbow"),
        (lambda t: t.replace("Ulna_R", "Una"), "no marker Radius_R and Ulna_R, or Wrist_R;"),
        (edit_row(12, lambda c: []), "line 12 has 0 columns, expected 24"),
        (
            edit_row(12, lambda c: [*c[:4], "1e308", *c[5:]]),
            "line 12, column 5: 1e.308 is no coord",
        ),
        (edit_row(12, lambda c: [*c[:4], "inf", *c[5:]]), "line 12, column 5: inf is no coord"),
        (edit_row(9, lambda c: c[:-1]), "line 9 has 23 columns, expected 24"),
        (edit_row(7, lambda c: [*c, "1.0"]), "line 7 has 25 columns, expected 24"),
        (edit_row(5, lambda c: [*c, "1.0"]), "line 5 has 25 columns, expected 24"),
        (edit_row(12, lambda c: [*c[:4], "x7", *c[5:]]), "line 12, column 5: 'x7' is not a number"),
        (lambda t: "", "is empty"),
        (lambda t: "\n\n", "is empty"),
        (lambda t: "time,x,y\n0,1,2\n", "not a Qualisys TSV"),
        (lambda t: t.replace("\t60", "\t0"), "FREQUENCY is '0'"),
        (lambda t: t.replace("\t60", "\tfast"), "FREQUENCY is 'fast'"),
        (lambda t: t.replace("FREQUENCY\t60\n", ""), "FREQUENCY is ''"),
        (lambda t: "\n".join(t.splitlines()[:5]), "at least two"),
        (lambda t: "\n".join(t.splitlines()[:4]), "no frames"),
        (lambda t: t.replace("Ulna_L", "Radius_L"), "Radius_L stands twice"),
        (lambda t: "MARKER_NAMES\n1\t2\n", "lacks a name"),
        (lambda t: t.replace("MARKER_NAMES", "MARKERS"), "no line MARKER_NAMES"),
    ],
)
def test_bad_files_say_what_is_wrong_where(
    write_tsv: WriteTsv, edit: Callable[[str], str], message: str
) -> None:
    with pytest.raises(MotionFileError, match=message) as caught:
        read_motion(write_tsv(edit=edit))
    assert "dance" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_marker_without_any_data_is_named(write_tsv: WriteTsv) -> None:
    holed = markers()
    holed["Ulna_R"][:] = np.nan
    with pytest.raises(MotionFileError, match="marker Ulna_R is missing in all 228 frames"):
        read_motion(write_tsv(holed))


def test_a_long_gap_is_refused_and_max_gap_allows_it(write_tsv: WriteTsv) -> None:
    holed = markers()
    holed["Shoulder_R"][100:120] = np.nan
    path = write_tsv(holed)
    with pytest.raises(
        MotionFileError, match=r"Shoulder_R is missing in frames 101 to 120 \(0\.33 s\).*--max-gap"
    ):
        read_motion(path)
    assert len(read_motion(path, max_gap=0.4)) > 0


def test_a_gap_of_exactly_the_limit_is_bridged(write_tsv: WriteTsv) -> None:
    holed = markers()
    holed["Shoulder_R"][100:115] = np.nan  # 15 frames at 60 Hz: 0.25 s
    assert len(read_motion(write_tsv(holed))) > 0


@pytest.mark.parametrize(("frames", "place"), [(slice(0, 3), "start"), (slice(-3, None), "end")])
def test_gaps_at_the_ends_are_refused(write_tsv: WriteTsv, frames: slice, place: str) -> None:
    holed = markers()
    holed["Elbow_L"][frames] = np.nan
    with pytest.raises(MotionFileError, match=f"Elbow_L is missing.*at the {place}"):
        read_motion(write_tsv(holed))


def test_markers_that_are_not_of_the_arms_may_have_gaps(write_tsv: WriteTsv) -> None:
    with_head = {"Head_FL": np.full((228, 3), np.nan)} | markers()
    np.testing.assert_array_equal(
        read_motion(write_tsv(with_head)).posture,
        read_motion(write_tsv(name="headless.tsv")).posture,
    )


def test_a_segment_without_length_is_refused(write_tsv: WriteTsv) -> None:
    merged = markers()
    for name in ("Radius_L", "Ulna_L"):
        merged[name][50:100] = merged["Elbow_L"][50:100]
    with pytest.raises(MotionFileError, match=r"the left forearm has length 0 at frame 51 "):
        read_motion(write_tsv(merged))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"rate": 0.0}, "rate is 0"),
        ({"rate": float("nan")}, "rate is nan"),
        ({"tempo": -1.0}, "tempo is -1"),
        ({"max_gap": -0.1}, "max-gap is -0.1"),
        ({"segments": 0}, "segments is 0"),
        ({"segments": 1000}, "segments is 1000"),
    ],
)
def test_bad_options_are_named(
    write_tsv: WriteTsv, options: dict[str, float], message: str
) -> None:
    with pytest.raises(BadOptionError, match=message):
        read_motion(write_tsv(), **options)  # type: ignore[arg-type]


def test_unknown_names_and_missing_files(tmp_path: Path) -> None:
    with pytest.raises(UnknownMotionError, match="no motion 'macarena'; built in: ymca"):
        read_motion("macarena")
    with pytest.raises(UnknownMotionError, match="no such file"):
        read_motion(tmp_path / "gone.tsv")
    with pytest.raises(MotionFileError, match="is a folder"):
        read_motion(tmp_path)
