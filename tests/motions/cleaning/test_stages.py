import re
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from mpma_mj.errors import MotionFileError
from mpma_mj.motions import ymca
from mpma_mj.motions.cleaning import MARKER_STAGES
from mpma_mj.motions.cleaning.gaps import runs
from mpma_mj.motions.cleaning.trajectories import Trajectories, missing
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.loader import import_motion
from mpma_mj.motions.options import ReadingOptions
from mpma_mj.motions.readers.recording import Recording
from tests.conftest import WriteTsv, dancer, doubts, markers_of

Array = NDArray[np.float64]
Tracks = dict[str, Array]

RATE = 60.0
NAMES = tuple(dancer(ymca(rate=20.0).posture))
LONG = 0.25 * RATE  # frames that are bridged by default


def dance(seconds: float = 3.8) -> Tracks:
    """Return points, mm, of a dancer at 60 Hz."""
    once = ymca(rate=RATE).posture
    frames = round(seconds * RATE)
    return dancer(np.tile(once, (-(-frames // len(once)), 1))[:frames])


def cleaned(tracks: Tracks, **options: object) -> tuple[Trajectories, ImportReport]:
    """Return trajectories after the stages that see markers."""
    groups = {name: (name,) for name in tracks}
    copies = {name: track.copy() for name, track in tracks.items()}
    recording = Recording(Path("dance.x"), "points", tuple(tracks), lambda names: copies)
    trajectories, report = Trajectories(copies, groups, RATE, 20.0, recording), ImportReport()
    for stage in MARKER_STAGES:
        stage(trajectories, ReadingOptions(**options), report)  # type: ignore[arg-type]
    return trajectories, report


Gaps = list[tuple[str, int, int]]  # of which marker, from which frame, how many


def some_gaps(longest: int = 60) -> st.SearchStrategy[Gaps]:
    gap = st.tuples(st.sampled_from(NAMES), st.integers(-10, 227), st.integers(1, longest))
    return st.lists(gap, max_size=8)


def holed(gaps: Gaps) -> Tracks:
    tracks = dance()
    for name, first, length in gaps:
        tracks[name][max(0, first) : max(0, first + length)] = np.nan
    return tracks


def check_whole(cleaned: tuple[Trajectories, ImportReport], tracks: Tracks) -> None:
    """Check that what is kept is whole, as it was where it was seen, and told truly."""
    trajectories, report = cleaned
    begin = trajectories.first
    kept = slice(begin, begin + trajectories.frames)
    notes = "\n".join(report.steps)
    for name, track in trajectories.tracks.items():
        before = tracks[name][kept]
        gone = missing(before)
        assert not missing(track).any()
        np.testing.assert_array_equal(track[~gone], before[~gone])
        assert not gone[[0, -1]].any()
        bridged = [(first + begin, end + begin) for first, end in runs(gone)]
        assert report.gaps.get(name, []) == [(first / RATE, end / RATE) for first, end in bridged]
        told = re.search(
            rf"{name}: (\d+) missing samples? bridged in (\d+) gaps?, the longest frames (\d+) to"
            r" (\d+) \((\S+) s\)",
            notes,
        )
        assert (told is None) == (not bridged)
        if told is not None:
            count, number, first, end = map(int, told.groups()[:4])
            assert count == gone.sum()
            assert number == len(bridged)
            assert (first - 1, end) in bridged
            assert end - first + 1 == max(e - f for f, e in bridged)
            assert float(told[5]) == pytest.approx((end - first + 1) / RATE, abs=0.006)


@settings(max_examples=100)
@given(gaps=some_gaps())
def test_gaps_are_bridged_or_refused_with_ways_that_work(gaps: Gaps) -> None:
    tracks = holed(gaps)
    long = {
        (name, first + 1, end)
        for name in NAMES
        for first, end in runs(missing(tracks[name]))
        if end - first > LONG
    }
    if not long:
        check_whole(cleaned(tracks), tracks)
        return
    with pytest.raises(MotionFileError) as caught:
        cleaned(tracks)
    message = str(caught.value)
    told = re.match(
        r"dance\.x: marker (\w+) is missing in frames (\d+) to (\d+) \((\S+) s\)(?: and there"
        r" (?:is|are) (\d+) more such gaps?)?, longer than 0\.25 s; ",
        message,
    )
    assert told is not None
    name, first, end = told[1], int(told[2]), int(told[3])
    assert (name, first, end) in long
    assert first == min(first for _, first, _ in long)
    assert float(told[4]) == pytest.approx((end - first + 1) / RATE, abs=0.006)
    assert int(told[5] or 0) == len(long) - 1
    assert "\n" not in message
    wider = re.search(r"bridge them with max_gap=([\d.]+)", message)
    if wider:
        check_whole(cleaned(tracks, max_gap=float(wider[1])), tracks)
    kept = re.search(r"stretch \(frames (\d+) to (\d+), (\S+) s\) with longest", message)
    if kept:
        found = cleaned(tracks, longest=True)
        check_whole(found, tracks)
        begin, frames = found[0].first, found[0].frames
        assert (begin + 1, begin + frames) == (int(kept[1]), int(kept[2]))
        assert float(kept[3]) == pytest.approx(frames / RATE, abs=0.006)
    assert wider or kept or "record it again" in message


@settings(max_examples=50)
@given(gaps=some_gaps(longest=90))
def test_the_longest_clean_stretch_is_kept(gaps: Gaps) -> None:
    tracks = holed(gaps)
    # A stretch is clean if no long gap reaches into it and it begins and ends with all seen.
    clean, whole = np.ones((2, 228), bool)
    for track in tracks.values():
        whole &= ~missing(track)
        for first, end in runs(missing(track)):
            clean[first:end] &= end - first <= LONG
    seen = [np.flatnonzero(whole[first:end]) for first, end in runs(clean)]
    best = max((inside[-1] - inside[0] + 1 for inside in seen if len(inside)), default=0)
    if best < LONG:  # too little for a movement
        with pytest.raises(MotionFileError, match=r"^[^\n]*(record it again|max_gap=[\d.]+)$"):
            cleaned(tracks, longest=True)
    else:
        assert cleaned(tracks, longest=True)[0].frames == best


def test_nine_seconds_of_gaps_in_thirty_are_bridged_where_they_are_short() -> None:
    whole = dance(30.0)
    tracks = {name: track.copy() for name, track in whole.items()}
    for i in range(36):
        tracks["left_wrist"][20 + 49 * i : 35 + 49 * i] = np.nan
    trajectories, report = found = cleaned(tracks)
    check_whole(found, tracks)
    assert any(
        step.startswith("left_wrist: 540 missing samples bridged in 36 gaps")
        for step in report.steps
    )
    assert np.abs(trajectories.tracks["left_wrist"] - whole["left_wrist"]).max() < 150.0  # mm


def test_nine_seconds_without_a_marker_are_refused_with_their_frames() -> None:
    tracks = dance(30.0)
    tracks["left_wrist"][600:1140] = np.nan
    with pytest.raises(MotionFileError) as caught:
        cleaned(tracks)
    assert str(caught.value) == (
        "dance.x: marker left_wrist is missing in frames 601 to 1140 (9.00 s), longer than 0.25 s;"
        " keep the longest clean stretch (frames 1141 to 1800, 11.00 s) with longest, or bridge"
        " them with max_gap=9"
    )


@pytest.mark.parametrize("length", [15, 16])
def test_what_is_bridged_goes_by_the_limit_exactly(length: int) -> None:
    tracks = dance()
    tracks["left_wrist"][100 : 100 + length] = np.nan
    if length > LONG:
        with pytest.raises(MotionFileError, match=r"max_gap=0\.27, or"):
            cleaned(tracks)
    else:
        check_whole(cleaned(tracks), tracks)


def test_no_gap_is_bridged_if_none_may_be() -> None:
    tracks = dance()
    tracks["left_wrist"][100] = np.nan
    with pytest.raises(MotionFileError, match=r"frames 101 to 101 \(0\.02 s\), longer than 0 s"):
        cleaned(tracks, max_gap=0.0)
    check_whole(cleaned(tracks, max_gap=0.02), tracks)


def test_ends_are_cut_to_where_all_markers_are_seen() -> None:
    tracks = dance()
    tracks["left_wrist"][:6] = np.nan
    tracks["right_wrist"][3:9] = np.nan  # still missing where the other appears
    tracks["right_elbow"][-4:] = np.nan
    trajectories, report = found = cleaned(tracks)
    check_whole(found, tracks)
    assert trajectories.first == 9
    assert report.steps == [
        "cut 9 frames at the start and 4 at the end, where markers of the arms are missing"
    ]


def test_a_whole_recording_is_left_alone() -> None:
    trajectories, report = cleaned(dance())
    assert not report.steps + report.doubts
    assert not report.gaps
    assert trajectories.first == 0
    for name, track in dance().items():
        np.testing.assert_array_equal(trajectories.tracks[name], track)


@pytest.mark.parametrize("gap", [np.nan, 0.0], ids=["NaN", "exact zeros"])
def test_gaps_in_files_are_empty_cells_or_exact_zeros(write_tsv: WriteTsv, gap: float) -> None:
    tracks = markers_of(dance())
    tracks["Elbow_R"][100:110] = gap
    imported = import_motion(write_tsv(tracks), ReadingOptions())
    assert imported.report.gaps == {"Elbow_R": [(pytest.approx(100 / 60), pytest.approx(110 / 60))]}


def test_frames_of_gaps_count_from_the_files_first(write_tsv: WriteTsv) -> None:
    tracks = markers_of(dance())
    tracks["Elbow_R"][100:110] = np.nan
    imported = import_motion(write_tsv(tracks), ReadingOptions(start=1.0))
    assert any("the longest frames 101 to 110 (0.17 s)" in s for s in imported.report.steps)
    assert imported.report.gaps == {"Elbow_R": [(pytest.approx(100 / 60), pytest.approx(110 / 60))]}


def bent() -> Tracks:
    """Return a dance in which the dancer bends sideways, with pelvis and neck."""
    tracks = dance()
    frames = len(tracks[NAMES[0]])
    tracks |= {name: np.tile([0.0, 0.0, z], (frames, 1)) for name, z in TORSO.items()}
    angle = 0.5 * np.sin(np.arange(frames) / 30.0)
    cos, sin, zero, one = np.cos(angle), np.sin(angle), 0 * angle, 1 + 0 * angle
    turn = np.stack([one, zero, zero, zero, cos, -sin, zero, sin, cos], 1).reshape(-1, 3, 3)
    return {name: np.einsum("tij,tj->ti", turn, track) for name, track in tracks.items()}


TORSO = {"pelvis": 950.0, "neck": 1450.0}
Change = Callable[[Tracks], None]


def without(name: str, frames: slice) -> Change:
    def change(tracks: Tracks) -> None:
        tracks[name][frames] = np.nan

    return change


def read_bent(path: Path, change: Change = lambda tracks: None) -> tuple[Array, ImportReport]:
    tracks = bent()
    change(tracks)
    np.savez(path, rate=RATE, up="z", **tracks)  # type: ignore[arg-type]
    imported = import_motion(path, ReadingOptions(cutoff=6.0))
    return imported.motion.posture, imported.report


def test_a_torso_without_its_neck_is_taken_from_the_shoulders(tmp_path: Path) -> None:
    _, report = read_bent(tmp_path / "a.npz", without("neck", slice(100, 140)))
    (warning,) = report.warnings
    assert warning.endswith(
        "from other markers: pelvis pelvis; neck left_shoulder + right_shoulder"
    )


def test_of_a_pelvis_either_pair_will_do(write_tsv: WriteTsv) -> None:
    markers = markers_of(dancer(ymca(rate=60.0).posture))
    shoulders = 0.5 * (markers["Shoulder_L"] + markers["Shoulder_R"])
    for name, offset in {
        "LASI": [60.0, 120.0, -500.0],
        "RASI": [60.0, -120.0, -500.0],
        "LPSI": [-60.0, 50.0, -500.0],
        "RPSI": [-60.0, -50.0, -500.0],
    }.items():
        markers[name] = shoulders + offset
    markers["LASI"][:40] = np.nan
    imported = import_motion(write_tsv(markers), ReadingOptions())
    assert (
        "LASI is missing for up to 0.67 s; the torso is computed from other markers"
        in (doubts(imported.report)[0])
    )
    assert imported.report.groups["pelvis"] == ("LPSI", "RPSI")


@pytest.mark.parametrize("name", ["pelvis"])
@pytest.mark.parametrize("frames", [slice(100, 120), slice(None), slice(20), slice(-20, None)])
def test_a_torso_without_its_markers_is_taken_as_upright(
    tmp_path: Path, name: str, frames: slice
) -> None:
    posture, report = read_bent(tmp_path / "a.npz", without(name, frames))

    def drop(tracks: Tracks) -> None:
        del tracks["pelvis"], tracks["neck"]

    upright, _ = read_bent(tmp_path / "b.npz", drop)
    whole, _ = read_bent(tmp_path / "c.npz")
    np.testing.assert_array_equal(posture, upright)
    assert np.abs(posture - whole).max() > 0.3
    seconds = len(np.arange(228)[frames]) / RATE
    assert report.warnings == [
        f"torso marker {name} is missing for up to {seconds:.2f} s; the torso is assumed to be"
        " upright, so that bending moves the arms"
    ]


@pytest.mark.parametrize("name", ["pelvis", "neck"])
@pytest.mark.parametrize("frames", [slice(100, 110), slice(3), slice(-3, None)])
def test_a_torso_marker_may_be_missing_for_a_moment(
    tmp_path: Path, name: str, frames: slice
) -> None:
    posture, report = read_bent(tmp_path / "a.npz", without(name, frames))
    whole, _ = read_bent(tmp_path / "b.npz")
    assert not report.warnings
    if frames.start is None:
        whole = whole[1:]  # three frames, one posture
    assert np.abs(posture - whole[: len(posture)])[2:-2].max() < 0.02


def test_gaps_that_are_told_are_apart_and_in_order() -> None:
    tracks = dance()
    for first in (30, 60, 90):
        tracks["left_wrist"][first : first + 5] = np.nan
    found = cleaned(tracks)[1].gaps["left_wrist"]
    assert all(a[1] < b[0] for a, b in pairwise(found))
    assert len(found) == 3


def test_a_marker_that_is_never_seen_can_be_done_without_where_it_has_another(
    write_tsv: WriteTsv,
) -> None:
    markers = markers_of(dancer(ymca(rate=60.0).posture))
    markers["Ulna_R"][:] = np.nan
    path = write_tsv(markers)
    with pytest.raises(MotionFileError, match="Ulna_R is missing in all") as caught:
        import_motion(path, ReadingOptions())
    mapping = str(caught.value).partition('map="')[2].rstrip('"')
    assert import_motion(path, ReadingOptions(map=mapping)).report.groups["right_wrist"] == (
        "Radius_R",
    )


@pytest.mark.filterwarnings("error")
def test_markers_that_are_never_seen_together_are_refused(write_tsv: WriteTsv) -> None:
    markers = markers_of(dancer(ymca(rate=60.0).posture))
    markers["Ulna_R"][::2] = np.nan
    markers["Radius_R"][1::2] = np.nan
    with pytest.raises(MotionFileError, match="Radius_R and Ulna_R are never seen together"):
        import_motion(write_tsv(markers), ReadingOptions())


def test_what_a_long_bridge_invents_and_a_segment_that_varies_are_warned_about(
    write_tsv: WriteTsv,
) -> None:
    markers = markers_of(dancer(ymca(rate=60.0).posture))
    markers["Elbow_L"][60:120] = np.nan
    imported = import_motion(write_tsv(markers), ReadingOptions(max_gap=2.0))
    assert "Elbow_L is bridged over 1.00 s from frame 61 on" in doubts(imported.report)[0]
    markers = markers_of(dancer(ymca(rate=60.0).posture))
    markers["Elbow_L"][100:] *= [1.0, 0.5, 1.0]
    warnings = doubts(import_motion(write_tsv(markers), ReadingOptions()).report)
    assert any("the left upper arm's length varies by" in warning for warning in warnings)


@pytest.mark.filterwarnings("error")
def test_arms_that_are_never_seen_together_are_refused() -> None:
    tracks = dance()
    tracks["left_wrist"][:120] = np.nan
    tracks["right_wrist"][110:] = np.nan
    for options in ({}, {"longest": True}, {"max_gap": 100.0}):
        with pytest.raises(MotionFileError, match=r"^dance\.x: [^\n]*record it again$"):
            cleaned(tracks, **options)
