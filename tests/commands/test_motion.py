"""`mpma motion`: the report, the converted file, the video."""

from collections.abc import Callable
from pathlib import Path

import imageio.v2 as imageio
import numpy as np
import pytest

from mpma_mj import kinematics
from mpma_mj.cli import main
from mpma_mj.motions import read_motion, ymca
from mpma_mj.motions.feasibility import near_singularity
from tests.conftest import DISK_FULL, FAILED, NO_TRUNK, Encoder, Refused, dancer, markers_of

WriteTsv = Callable[..., Path]


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")


def test_it_tells_what_the_file_holds(
    write_tsv: WriteTsv, capsys: pytest.CaptureFixture[str]
) -> None:
    markers = markers_of(dancer(ymca(rate=60.0).posture))
    markers["Elbow_L"][30:36] = np.nan
    path = write_tsv(markers)
    assert main(["motion", str(path)]) == 0
    printed = capsys.readouterr().out
    frames = len(markers["Elbow_L"])
    for told in (
        f"dance: Qualisys TSV, {frames} frames at 60 Hz ({frames / 60:.2f} s), 8 points",
        "left_wrist      Radius_L + Ulna_L",
        "Elbow_L: 6 missing samples bridged in 1 gap, the longest frames 31 to 36 (0.10 s)",
        "left upper arm  0.300",
        "left forearm    0.250",
        "of 12",
        "near a singularity",
        "the arms can follow it",
    ):
        assert told in printed
    assert printed.splitlines()[-1] == "dance-motion.png"
    page = imageio.imread("dance-motion.png")
    assert page.shape[0] > 800
    assert len(np.unique(page.reshape(-1, page.shape[2]), axis=0)) > 20


def test_what_a_robot_can_do_is_reported(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["motion", "ymca", "--robot", "cmu_humanoid"]) == 0
    printed = capsys.readouterr()
    assert "cmu_humanoid has joints and speeds of its own" in printed.err
    for told in (
        "  lhumerusrz                 ",
        " of 20\n",
        " % of the postures, each alone: within 5° of one that the joints' ranges allow",
        " % of them in the whole motion: within 5° of the closest one at the joints' speeds",
        "a slower tempo hardly changes that",
    ):
        assert told in printed.out
    assert "near a singularity" not in printed.out
    assert imageio.imread("ymca-motion.png").shape[0] > 800


def test_what_is_changed_of_a_motion_is_reported(
    write_tsv: WriteTsv, capsys: pytest.CaptureFixture[str]
) -> None:
    path = write_tsv(markers_of(dancer(ymca(rate=60.0, tempo=6.0).posture)))
    assert main(["motion", str(path)]) == 0
    printed = capsys.readouterr()
    assert "the arms follow the closest motion that they can, with" in printed.out
    assert "its actuator reaches" in printed.err
    assert "% of the steps are changed by" in printed.err


def test_the_npz_that_it_writes_is_the_same_movement(write_tsv: WriteTsv) -> None:
    path = write_tsv()
    assert main(["motion", str(path), "--tempo", "0.5", "--out", "x.npz"]) == 0
    stored, read = read_motion("x.npz"), read_motion(path, tempo=0.5)
    np.testing.assert_array_equal(stored.posture, read.posture)
    np.testing.assert_array_equal(stored.context, read.context)
    assert (stored.labels, stored.rate, stored.tempo) == (read.labels, read.rate, read.tempo)
    for words in (["--out", "x.fbx"], ["--picture", "x.xyz"], ["--out", "x.npz"]):
        assert main(["motion", str(path), *words]) == 2
    assert main(["motion", "x.npz", "--out", "x.npz", "--overwrite"]) == 0


def test_the_last_line_is_the_file_that_is_asked_for(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["motion", "ymca", "--out", "x.csv"]) == 0
    assert capsys.readouterr().out.splitlines()[-2:] == ["ymca-motion.png", "x.csv"]
    assert main(["motion", "ymca"]) == 0  # the page with its own name is replaced


@pytest.mark.parametrize(
    ("there", "words"),
    [("x.png", []), ("x.mp4", ["--video"]), ("x.csv", ["--out", "x.csv"])],
)
def test_no_file_that_is_named_is_replaced_unless_that_is_asked_for(
    there: str, words: list[str], refused: Refused
) -> None:
    Path(there).write_text("old")
    command = ["motion", "ymca", "--picture", "x.png", *words]
    refused(command, f"{there}: already exists; --overwrite replaces it")
    assert Path(there).read_text() == "old"
    if not there.endswith(".mp4"):
        assert main([*command, "--overwrite"]) == 0
        assert Path(there).read_bytes() != b"old"


@pytest.mark.parametrize("ending", [".bvh", ".trc"])
def test_other_programs_get_the_motion_at_its_tempo(ending: str, write_tsv: WriteTsv) -> None:
    path, out = write_tsv(), f"x{ending}"
    assert main(["motion", str(path), "--tempo", "0.5", "--out", out]) == 0
    written, read = read_motion(out, cutoff=9.0), read_motion(path, tempo=0.5)
    assert written.posture.shape == read.posture.shape
    assert np.abs(written.posture - read.posture).max() < 0.01


def test_a_robot_gets_the_joint_angles() -> None:
    assert main(["motion", "ymca", "--from", "1", "--out", "x.csv"]) == 0
    table = np.genfromtxt("x.csv", delimiter=",", names=True)
    for joint, angle in zip(kinematics.JOINT_NAMES, ymca().joint_angles[20:].T, strict=True):
        np.testing.assert_allclose(np.sin(table[f"{joint}_rad"]), np.sin(angle), atol=1e-8)


def test_its_video_shows_the_movement_once(capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("imageio_ffmpeg")
    assert main(["motion", "ymca", "--to", "1", "--video", "--picture", "y/page.png"]) == 0
    with imageio.get_reader("y/page.mp4") as video:
        assert video.get_meta_data()["fps"] == pytest.approx(20.0)
        assert video.count_frames() == 19


def test_a_warning_is_one_line_and_says_what_is_used(
    write_tsv: WriteTsv, capsys: pytest.CaptureFixture[str]
) -> None:
    path = write_tsv(edit=lambda text: text.replace("NO_OF_FRAMES\t", "NO_OF_FRAMES\t9"))
    assert main(["motion", str(path)]) == 0
    upright, line = capsys.readouterr().err.splitlines()
    assert upright == f"mpma: warning: {path}: {NO_TRUNK}"
    assert line.startswith(f"mpma: warning: {path}: the file declares 9")
    assert line.endswith("are used")


def test_the_share_of_time_near_a_singularity() -> None:
    angles = np.zeros((10, 8))
    angles[:, [3, 7]] = 1.0
    angles[:3, 1] = np.pi / 2 - 0.1
    angles[5:7, 7] = 0.1
    assert near_singularity(angles) == (0.3, 0.2)
    assert near_singularity(np.tile(angles[4], (5, 1))) == (0.0, 0.0)


def test_the_joints_of_the_report_are_those_of_the_arms(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["motion", "ymca"]) == 0
    printed = capsys.readouterr().out
    assert all(name in printed for name in kinematics.JOINT_NAMES)


@pytest.mark.usefixtures("opengl")
def test_a_video_that_fails_leaves_the_old_one(
    tmp_path: Path, encoder: Encoder, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "page.mp4").write_text("old")
    encoder(DISK_FULL)
    assert (
        main(["motion", "ymca", "--video", "--overwrite", "--picture", str(tmp_path / "page.png")])
        == 1
    )
    line = capsys.readouterr().err.splitlines()[-1]
    assert line.startswith(f"mpma: {tmp_path / 'page.mp4'}: {FAILED}")
    assert (tmp_path / "page.mp4").read_text() == "old"
    assert {path.name for path in tmp_path.iterdir()} == {"here", "page.mp4", "page.png"}
