"""`mpma motion`, and repertoires, through the real command line."""

import json
from collections.abc import Callable
from pathlib import Path

import imageio.v2 as imageio
import numpy as np
import pytest

from mpma_mj import kinematics
from mpma_mj.cli import main
from mpma_mj.motions import read_motion, ymca
from mpma_mj.motions.feasibility import near_singularity
from tests.conftest import dancer, markers_of

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


def test_a_movement_that_is_too_fast_is_shown_all_the_same(
    write_tsv: WriteTsv, capsys: pytest.CaptureFixture[str]
) -> None:
    path = write_tsv(markers_of(dancer(ymca(rate=60.0, tempo=6.0).posture)))
    assert main(["motion", str(path)]) == 0
    printed = capsys.readouterr().out
    assert "too fast" in printed
    assert "the arms cannot follow it: dance: " in printed
    assert "--tempo" in printed


def test_the_npz_that_it_writes_is_the_same_movement(write_tsv: WriteTsv) -> None:
    path = write_tsv()
    assert main(["motion", str(path), "--tempo", "0.5", "--out", "x.npz"]) == 0
    stored, read = read_motion("x.npz"), read_motion(path, tempo=0.5)
    np.testing.assert_array_equal(stored.posture, read.posture)
    np.testing.assert_array_equal(stored.context, read.context)
    assert (stored.labels, stored.rate, stored.tempo) == (read.labels, read.rate, read.tempo)
    for words in (["--out", "x.csv"], ["--picture", "x.xyz"], ["--out", "x.npz"]):
        assert main(["motion", str(path), *words]) == 2
    assert main(["motion", "x.npz", "--out", "x.npz", "--overwrite"]) == 0


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
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"mpma: warning: {path}: the file says 9")
    assert line.endswith("are used")


def test_the_share_of_time_near_a_singularity() -> None:
    angles = np.zeros((10, 8))
    angles[:, [3, 7]] = 1.0
    angles[:3, 1] = np.pi / 2 - 0.1
    angles[5:7, 7] = 0.1
    assert near_singularity(angles) == (0.3, 0.2)
    assert near_singularity(np.tile(angles[4], (5, 1))) == (0.0, 0.0)


def test_several_movements_are_learned_together(write_tsv: WriteTsv) -> None:
    slow = write_tsv(markers_of(dancer(ymca(rate=60.0, tempo=0.8).posture[:200])))
    words = f"imitate ymca {slow} --nodes 30 --repeats 1 --epochs 3 --no-video --out run"
    assert main(words.split()) == 0
    summary = json.loads(Path("run/summary.json").read_text())
    assert [row["name"] for row in summary["motions"]] == ["ymca", "dance"]
    assert set(summary["active_modules"]) == {"ymca", "dance"}
    steps = [row["steps"] for row in summary["motions"]]
    mean = np.average([row["p_e_percent"] for row in summary["motions"]], weights=steps)
    assert mean == pytest.approx(summary["p_e_percent"])
    assert main(["imitate", "--resume", "run", "--epochs", "1", "--no-video"]) == 0
    assert main(["imitate", "ymca", "--resume", "run", "--epochs", "1", "--no-video"]) == 2


def test_a_folder_is_the_recordings_in_it(
    write_tsv: WriteTsv, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "dances"
    folder.mkdir()
    markers = markers_of(dancer(ymca(rate=60.0).posture[:200]))
    for name in ("b.tsv", "a.tsv"):
        write_tsv(markers).rename(folder / name)
    (folder / "notes.txt").write_text("not a recording")
    words = ["--nodes", "20", "--repeats", "1", "--epochs", "1", "--no-video", "--out", "run"]
    assert main(["imitate", str(folder), *words]) == 0
    summary = json.loads(Path("run/summary.json").read_text())
    assert [row["name"] for row in summary["motions"]] == ["a", "b"]
    empty = tmp_path / "empty"
    empty.mkdir()
    assert main(["imitate", str(empty), "--no-video"]) == 2
    assert "holds no recording" in capsys.readouterr().err


@pytest.mark.parametrize("words", [["--to", "3"], ["--labels", "x.csv"], ["--audio", "x.wav"]])
def test_what_is_for_one_recording_is_refused_for_several(
    words: list[str], write_tsv: WriteTsv, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("x.csv").write_text("0,2,a\n")
    assert main(["imitate", str(write_tsv()), "ymca", *words, "--no-video"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "is for one recording" in line


def test_the_joints_of_the_report_are_those_of_the_arms(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["motion", "ymca"]) == 0
    printed = capsys.readouterr().out
    assert all(name in printed for name in kinematics.JOINT_NAMES)
