"""Recordings of a synthetic dancer whose postures are known."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from mpma_mj.errors import (
    BadOptionError,
    MotionFileError,
    RecordingWarning,
    UnknownMotionError,
)
from mpma_mj.motions import read_motion, ymca
from mpma_mj.motions.loader import import_motion
from mpma_mj.motions.options import ReadingOptions
from tests.conftest import NO_TRUNK, dancer, doubts, markers_of, with_trunk
from tests.motions.readers import writers

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


def test_half_the_tempo_gives_twice_the_postures(write_tsv: WriteTsv) -> None:
    path = write_tsv()
    original, slowed = (read_motion(path, tempo=tempo, cutoff=6.0) for tempo in (1.0, 0.5))
    assert abs(len(slowed) - 2 * len(original)) <= 1
    np.testing.assert_allclose(
        slowed.posture[::2], original.posture[: len(slowed) // 2 + 1], atol=1e-3
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
        rows = [
            "\t".join([*[str(i), f"{i / 60:.4f}"][:extra], row])
            for i, row in enumerate(lines[4:], 1)
        ]
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
    assert 0 < np.abs(bridged.posture - complete.posture).max() < 0.03


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


def test_a_single_wrist_marker_will_do(write_tsv: WriteTsv) -> None:
    points = markers()
    points["Wrist_L"] = (points.pop("Radius_L") + points.pop("Ulna_L")) / 2  # one side only
    single, double = read_motion(write_tsv(points, name="1.tsv")), read_motion(write_tsv())
    np.testing.assert_allclose(single.posture, double.posture, atol=1e-6)


def test_a_body_without_pelvis_is_a_warning(write_tsv: WriteTsv) -> None:
    assert import_motion(write_tsv(), ReadingOptions()).report.warnings == [NO_TRUNK]
    more = {n: np.tile([0.0, 0.0, z], (228, 1)) for n, z in (("Bauchmitte", 900), ("Kinn", 1400))}
    path = write_tsv(markers() | more)
    (warning,) = import_motion(path, ReadingOptions()).report.warnings
    assert warning.startswith("no point is recognised as the pelvis, so that the torso is assumed")
    assert "not recognised are Bauchmitte, Kinn; name pelvis and neck with map=" in warning
    mapping = ReadingOptions(map="pelvis=Bauchmitte,neck=Kinn")
    assert not import_motion(path, mapping).report.warnings


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
        (
            lambda t: t.replace("Elbow_L", "Ellbow"),
            "recognised as the left elbow; it has Shoulder_L, Ell",
        ),
        (lambda t: t.replace("Ulna_R", "Una"), "recognised as the right wrist; it has Shou"),
        (
            edit_row(12, lambda c: [*c[:4], "1e308", *c[5:]]),
            "line 12, column 5: 1e.308 is not a coord",
        ),
        (edit_row(12, lambda c: [*c[:4], "inf", *c[5:]]), "line 12, column 5: inf is not a coord"),
        (edit_row(9, lambda c: c[:-1]), "line 9 has 23 columns, expected 24"),
        (edit_row(7, lambda c: [*c, "1.0"]), "line 7 has 25 columns, expected 24"),
        (edit_row(5, lambda c: [*c, "1.0"]), "line 6 has 24 columns, expected 25"),
        (edit_row(12, lambda c: [*c[:4], "x7", *c[5:]]), "line 12, column 5: 'x7' is not a number"),
        (lambda t: "", "is empty"),
        (lambda t: "\n\n", "is empty"),
        (lambda t: "time,x,y\n0,1,2\n", "no recording of a known format"),
        (lambda t: t.replace("\t60", "\t0"), "FREQUENCY is '0'"),
        (lambda t: t.replace("\t60", "\tfast"), "FREQUENCY is 'fast'"),
        (lambda t: t.replace("FREQUENCY\t60\n", ""), "not declare its frame rate; .* rate_in=50$"),
        (lambda t: "\n".join(t.splitlines()[:5]) + "\n", "at least two"),
        (lambda t: "\n".join(t.splitlines()[:4]), "no frames"),
        (lambda t: t.replace("Ulna_L", "Radius_L"), "Radius_L appears twice"),
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
        MotionFileError, match=r"Shoulder_R is missing in frames 101 to 120 \(0\.33 s\).*max_gap="
    ):
        read_motion(path)
    assert len(read_motion(path, max_gap=0.4)) > 0


def test_a_gap_of_exactly_the_limit_is_bridged(write_tsv: WriteTsv) -> None:
    holed = markers()
    holed["Shoulder_R"][100:115] = np.nan  # 15 frames at 60 Hz: 0.25 s
    assert len(read_motion(write_tsv(holed))) > 0


@pytest.mark.parametrize("frames", [slice(0, 3), slice(-3, None)])
def test_gaps_at_the_ends_are_cut_off(write_tsv: WriteTsv, frames: slice) -> None:
    holed = markers()
    holed["Elbow_L"][frames] = np.nan
    imported = import_motion(write_tsv(holed), ReadingOptions())
    assert len(imported.motion) == len(ymca()) - 1
    (first, last) = (3, 0) if frames.start == 0 else (0, 3)
    assert (
        f"cut {first} frames at the start and {last} at the end, where markers of the arms are"
        " missing"
    ) in imported.report.steps
    np.testing.assert_allclose(imported.report.times, first / 60 + np.arange(75) / 20)


def test_rows_after_an_empty_one_are_left_out_and_told(write_tsv: WriteTsv) -> None:
    path = write_tsv(edit=edit_row(105, lambda cells: []))
    imported = import_motion(path, ReadingOptions())
    assert imported.report.frames == 100
    assert "line 105 is empty; the 127 lines after it are not read" in doubts(imported.report)


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
        ({"max_gap": -0.1}, "max_gap is -0.1"),
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
    with pytest.raises(UnknownMotionError, match="no motion 'macarena'; expected ymca"):
        read_motion("macarena")
    with pytest.raises(UnknownMotionError, match="no such file"):
        read_motion(tmp_path / "gone.tsv")
    with pytest.raises(MotionFileError, match="is a folder"):
        read_motion(tmp_path)
    with pytest.raises(BadOptionError, match="source is 5; expected the name of a motion, or a"):
        read_motion(5)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("start", "end", "first", "count"),
    [
        (None, None, 0, 228),
        (0.0, None, 0, 228),
        (1.0, None, 60, 168),
        (None, 2.0, 0, 120),
        (1.0, 2.0, 60, 60),
        (1.0, 99.0, 60, 168),
        (3.7, None, 222, 6),
    ],
)
def test_from_and_to_count_in_seconds_of_the_recording(
    write_tsv: WriteTsv, start: float | None, end: float | None, first: int, count: int
) -> None:
    options = ReadingOptions(start=start, end=end, segments=2, cutoff=30.0)
    cut = import_motion(write_tsv(), options, rate=60.0)
    # Filtered up to what 60 Hz show: close to the truth.
    truth = ymca(rate=60.0).posture[first : first + count]
    assert cut.motion.posture.shape == truth.shape
    assert np.abs(cut.motion.posture - truth).max() < 0.02
    np.testing.assert_allclose(cut.report.times, np.arange(first, first + count) / 60.0)
    asked = bool(start) or end is not None
    assert any("as requested" in step for step in cut.report.steps) == asked
    beyond = end is not None and end > 3.8
    warning = "the recording ends at 3.80 s; end=99 is later than that"
    assert doubts(cut.report) == beyond * [warning]


@pytest.mark.parametrize(
    ("start", "end", "message"),
    [
        (5.0, None, r"start is 5\.0; expected less, as .*dance\.tsv lasts 3\.80 s"),
        (3.8, None, r"start is 3\.8; expected less, as .*dance\.tsv lasts 3\.80 s"),
        (3.795, None, r"from 3\.795 to 3\.80 s .* has 0 frame\(s\) at 60 Hz; give a longer"),
        (1.0, 1.01, r"from 1 to 1\.02 s .* has 1 frame\(s\) at 60 Hz; give a longer time"),
        (2.0, 1.0, r"end is 1\.0; expected more than 2 s, where the motion begins"),
        (1.0, 1.0, r"end is 1\.0; expected more than 1 s, where the motion begins"),
        (-1.0, None, r"start is -1\.0; expected 0 to 1e\+06, s"),
        (float("nan"), None, r"start is nan; expected 0 to 1e\+06, s"),
        (0.0, float("nan"), r"end is nan; expected 0 to 1e\+06, s"),
    ],
)
def test_times_outside_are_refused(
    write_tsv: WriteTsv, start: float, end: float | None, message: str
) -> None:
    with pytest.raises(BadOptionError, match=f"^{message}[^\n]*$"):
        read_motion(write_tsv(), start=start, end=end)


def test_an_option_that_there_is_not_is_named() -> None:
    with pytest.raises(BadOptionError, match=r"^no option maxgap; expected map, skeleton, unit"):
        read_motion("ymca", maxgap=0.3)


def test_what_may_be_wrong_is_a_warning_that_names_the_file(write_tsv: WriteTsv) -> None:
    with pytest.warns(
        RecordingWarning, match=r"dance\.tsv: the file declares 9 frames but contains 228"
    ):
        read_motion(write_tsv(edit=lambda t: t.replace("NO_OF_FRAMES\t228", "NO_OF_FRAMES\t9")))


@pytest.mark.filterwarnings("error")
def test_a_good_recording_is_read_without_a_warning(write_tsv: WriteTsv) -> None:
    assert len(read_motion(write_tsv(with_trunk(markers())))) == 76


def test_the_report_has_what_the_file_has(write_tsv: WriteTsv) -> None:
    report = import_motion(write_tsv(), ReadingOptions()).report
    assert report.format == "Qualisys TSV"
    assert report.names == tuple(markers())
    assert report.groups["left_wrist"] == ("Radius_L", "Ulna_L")
    assert (report.frames, report.rate, report.metric) == (228, 60.0, True)
    np.testing.assert_allclose(report.times, np.arange(76) / 20)
    assert report.gaps == {}


def test_a_torso_without_pelvis_is_told(tmp_path: Path) -> None:
    path = tmp_path / "dance.csv"
    points = writers.arm_points() | {"pelwis": np.full((60, 3), [0.0, 0.0, 900.0])}
    path.write_text(writers.header_row_text(points))
    (warning,) = import_motion(path, ReadingOptions()).report.warnings
    assert "not recognised are pelwis;" in warning
    path.write_text(writers.header_row_text(points | {"neck": np.full((60, 3), 1400.0)}))
    (warning,) = import_motion(path, ReadingOptions()).report.warnings
    assert "not recognised are pelwis, neck;" in warning
