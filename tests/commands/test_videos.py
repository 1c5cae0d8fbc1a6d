"""Commands whose video cannot be written, as a user meets them."""

import resource
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from mpma_mj.cli import main
from mpma_mj.trace import OBSERVED, Trace
from mpma_mj.training.run_folder import RunFolder
from mpma_mj.visualization.video import write_video
from tests.conftest import Encoder, Refused

pytestmark = pytest.mark.usefixtures("opengl")

FULL = "No space left on device"
DISK_FULL = f'cat > /dev/null; echo half > "$video"; echo "[mp4 @ 0x1] {FULL}" >&2; exit 228'
SAID = f"dance.mp4: no new video, ffmpeg failed: exit code 228 ({FULL}); mend that"
TITLE = "drawing 227 frames"


@pytest.fixture
def run(small_run: Path, tmp_path: Path) -> Path:
    """Return a copy of a run, with a video of its first second."""
    folder = tmp_path / "run"
    shutil.copytree(small_run, folder)
    arrays = RunFolder(folder).read_trace().to_arrays()
    trace = Trace.from_arrays(
        {name: signal[: 21 if name in OBSERVED else 20] for name, signal in arrays.items()}
    )
    write_video(folder / "dance.mp4", trace, RunFolder(folder).read_motion())
    return folder


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


def test_render_leaves_the_old_video_if_the_disk_is_full(
    run: Path, encoder: Encoder, refused: Refused
) -> None:
    old, there = (run / "dance.mp4").read_bytes(), names(run)
    encoder(DISK_FULL)
    refused(["render", str(run)], f"{run}/{SAID}", code=1, title=TITLE)
    assert (run / "dance.mp4").read_bytes() == old
    assert names(run) == there


def test_render_leaves_the_old_video_if_its_encoder_is_stopped(run: Path) -> None:
    """By the limit of a file's size, as by a quota; Python itself gets an error there instead."""
    old, there = (run / "dance.mp4").read_bytes(), names(run)
    result = subprocess.run(
        [sys.executable, "-m", "mpma_mj.cli", "render", str(run)],
        capture_output=True,
        text=True,
        check=False,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (10_000, 10_000)),
    )
    assert result.returncode == 1
    title, line = result.stderr.splitlines()
    assert title == TITLE
    assert line.startswith(
        f"mpma: {run / 'dance.mp4'}: no new video, ffmpeg was stopped: File size"
    )
    assert (run / "dance.mp4").read_bytes() == old
    assert names(run) == there


def test_imitate_keeps_its_run_if_the_video_fails(
    tmp_path: Path, encoder: Encoder, capsys: pytest.CaptureFixture[str]
) -> None:
    encoder(DISK_FULL)
    out = tmp_path / "run"
    assert main(["imitate", "ymca", "--nodes", "20", "--epochs", "1", "--out", str(out)]) == 1
    printed = capsys.readouterr()
    line = f"mpma: {out}/{SAID}, perhaps by freeing disk space, and try again"
    assert printed.err.splitlines()[-2:] == [TITLE, line]
    assert "best epoch 1" in printed.out
    assert (out / "summary.json").exists()
    assert not [name for name in names(out) if name.endswith(".mp4")]


def test_a_motions_video_that_fails_leaves_the_old_one(
    tmp_path: Path, encoder: Encoder, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "page.mp4").write_text("old")
    encoder(DISK_FULL)
    assert main(["motion", "ymca", "--video", "--picture", str(tmp_path / "page.png")]) == 1
    line = capsys.readouterr().err.splitlines()[-1]
    assert line.startswith(f"mpma: {tmp_path / 'page.mp4'}: no new video, ffmpeg failed")
    assert (tmp_path / "page.mp4").read_text() == "old"
    assert names(tmp_path) == {"page.mp4", "page.png"}


def test_without_an_encoder_render_says_so(
    run: Path, monkeypatch: pytest.MonkeyPatch, refused: Refused
) -> None:
    monkeypatch.setenv("IMAGEIO_FFMPEG_EXE", "/nowhere")
    said = "/nowhere cannot be started (No such file or directory); let IMAGEIO_FFMPEG_EXE name"
    refused(["render", str(run)], said, code=1, title=TITLE)
