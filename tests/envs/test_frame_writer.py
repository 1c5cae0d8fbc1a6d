"""Videos: whole ones, and none where the encoder failed."""

import signal
from pathlib import Path

import imageio.v2 as imageio
import imageio_ffmpeg
import numpy as np
import pytest
from PIL import Image

from mpma_mj.envs.frame_writer import frame_writer
from mpma_mj.errors import RunFolderError, VideoError
from tests.conftest import Encoder

SIZE = (98, 130)  # even, but no multiple of what codecs like best
FRAME = np.full((*SIZE, 3), (200, 100, 50), np.uint8)
DISK_FULL = "[out#0/mp4 @ 0x5f] Error closing file: No space left on device"


def write(path: Path, frames: int = 30, rate: float = 20.0) -> None:
    with frame_writer(path, SIZE, rate) as write_frame:
        for _ in range(frames):
            write_frame(FRAME)


@pytest.mark.parametrize(
    ("ending", "rate"), [(".mp4", 20.0), (".mp4", 30000 / 1001), (".webm", 60.0)]
)
def test_a_video_has_the_frames_size_and_rate_that_were_given(
    tmp_path: Path, ending: str, rate: float
) -> None:
    path = tmp_path / "new" / f"a{ending}"
    write(path, rate=rate)
    assert list(path.parent.iterdir()) == [path]
    with imageio.get_reader(path) as reader:
        assert reader.get_meta_data()["fps"] == pytest.approx(rate, abs=0.01)
        frames = [np.asarray(frame, float) for frame in reader]
    assert len(frames) == 30
    assert frames[-1].shape == FRAME.shape
    assert np.abs(frames[-1] - FRAME).max() < 10


def test_a_frame_need_not_lie_in_one_piece(tmp_path: Path) -> None:
    with frame_writer(tmp_path / "a.mp4", SIZE, 20.0) as write_frame:
        write_frame(np.concatenate([FRAME, FRAME], axis=1)[:, : SIZE[1]])
    assert (tmp_path / "a.mp4").exists()


@pytest.mark.parametrize(
    ("script", "message"),
    [
        (
            f"cat > /dev/null; echo half > $video; echo '{DISK_FULL}' >&2; echo more >&2; exit 228",
            r"ffmpeg failed: exit code 228 \(Error closing file: No space left on device\); fix",
        ),
        ("cat > /dev/null; echo half > $video; exit 1", "ffmpeg failed: exit code 1; fix"),
        ("echo half > $video; exit 1", "ffmpeg failed: exit code 1; fix"),
        ("echo half > $video; exit 0", "ffmpeg failed: exit code 0; fix"),
        ("cat > /dev/null; echo half > $video; kill -9 $$", "ffmpeg was stopped: Killed; fix"),
        ("echo half > $video; kill -9 $$", "ffmpeg was stopped: Killed; fix"),
        # More than a pipe holds, before it takes a frame.
        ("yes no | head -n 100000 >&2; cat > /dev/null; exit 1", r"failed: exit code 1 \(no\)"),
    ],
)
def test_a_failed_encoder_leaves_the_old_video_and_nothing_else(
    script: str, message: str, tmp_path: Path, encoder: Encoder
) -> None:
    path = tmp_path / "a.mp4"
    write(path)
    old = path.read_bytes()
    encoder(script)
    with pytest.raises(VideoError, match=message) as raised:
        write(path)
    assert str(raised.value).startswith(f"{path}: the video was not written: ")
    assert len(str(raised.value).splitlines()) == 1
    assert path.read_bytes() == old
    assert list(tmp_path.iterdir()) == [path]


def test_an_encoder_that_writes_nothing_leaves_the_old_video(
    tmp_path: Path, encoder: Encoder
) -> None:
    path = tmp_path / "a.mp4"
    path.write_text("old")
    encoder("cat > /dev/null")
    with pytest.raises(RunFolderError, match="cannot be written"):
        write(path)
    assert path.read_text() == "old"


def test_an_encoder_that_cannot_be_started_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("IMAGEIO_FFMPEG_EXE", str(tmp_path / "nowhere"))
    with pytest.raises(VideoError, match=r"nowhere cannot be started \(No such file") as raised:
        write(tmp_path / "a.mp4")
    assert "set IMAGEIO_FFMPEG_EXE to an ffmpeg that works" in str(raised.value)
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(RunFolderError, match=r"file: is a file, not a folder"):
        write(tmp_path / "file" / "a.mp4")


def test_without_any_encoder_it_is_said_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def none() -> str:
        raise RuntimeError("No ffmpeg exe could be found.")

    monkeypatch.setattr(imageio_ffmpeg, "get_ffmpeg_exe", none)
    with pytest.raises(VideoError, match="ffmpeg was not found; install it"):
        write(tmp_path / "a.mp4")


def test_a_video_that_is_broken_off_leaves_the_old_one_and_does_not_wait(
    tmp_path: Path, encoder: Encoder
) -> None:
    path = tmp_path / "a.mp4"
    path.write_text("old")
    encoder("exec sleep 100")
    with pytest.raises(KeyboardInterrupt), frame_writer(path, SIZE, 20.0) as write_frame:
        raise KeyboardInterrupt
    assert write_frame.__self__._process.returncode == -signal.SIGKILL
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("ending", [".gif", ".webp"])
def test_an_animated_picture_has_all_frames_and_repeats_for_ever(
    ending: str, tmp_path: Path
) -> None:
    with frame_writer(tmp_path / f"a{ending}", SIZE, 20.0) as write_frame:
        for shade in range(0, 250, 50):
            write_frame(np.full((*SIZE, 3), shade, np.uint8))
    with Image.open(tmp_path / f"a{ending}") as image:
        assert (image.n_frames, image.info["loop"]) == (5, 0)
        assert image.size == SIZE[::-1]
        for number, shade in enumerate(range(0, 250, 50)):
            image.seek(number)
            assert np.abs(np.asarray(image.convert("RGB"), float) - shade).max() < 10
