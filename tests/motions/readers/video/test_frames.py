"""Frames of videos: formats, sizes and rates; damaged and foreign files in one line."""

import logging
from pathlib import Path

import numpy as np
import pytest

from mpma_mj.errors import BadOptionError, MotionFileError
from mpma_mj.motions.readers.video import frames
from mpma_mj.motions.readers.video.frames import Clip, is_video, open_clip
from tests.motions.readers.video.clips import FRAMES, RATE, ffmpeg, write_colours


def count(clip: Clip) -> int:
    return sum(1 for _ in clip.frames())


@pytest.mark.parametrize("ending", ["mp4", "mov", "mkv", "webm", "gif", "avi", "ogv", "flv", "mpg"])
def test_every_frame_of_a_format_is_read(tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"dance.{ending}"
    if ending in ("mpg", "ogv"):  # which has the rates of television, or pads the first frame
        codec = ["-r", "25"] if ending == "mpg" else []
        ffmpeg("-f", "lavfi", "-i", "testsrc=size=64x48:rate=25:duration=2", *codec, str(path))
    else:
        write_colours(path)
    assert is_video(path.read_bytes()[:64])
    clip = open_clip(path, None, None)
    pictures = list(clip.frames())
    assert {picture.shape for picture in pictures} == {(480, 640, 3)}
    assert len(pictures) / clip.rate == pytest.approx(FRAMES / RATE, abs=2.1 / clip.rate)
    assert not clip.is_cut_short(len(pictures))


def test_the_library_logs_nothing(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    path = write_colours(tmp_path / "dance.mp4")
    with caplog.at_level(logging.DEBUG):
        count(open_clip(path, None, None))
    assert not caplog.records


def test_colours_are_those_of_the_file(tmp_path: Path) -> None:
    path = tmp_path / "red.gif"
    ffmpeg("-f", "lavfi", "-i", "color=red:size=64x48:rate=20:duration=1", str(path))
    picture = next(open_clip(path, None, None).frames())
    np.testing.assert_allclose(picture.mean(axis=(0, 1)), [255.0, 0.0, 0.0], atol=8.0)


def test_pixels_that_are_not_square_become_so(tmp_path: Path) -> None:
    path = tmp_path / "wide.mp4"
    source = "testsrc=size=64x48:rate=20:duration=1,setsar=2"
    ffmpeg("-f", "lavfi", "-i", source, "-pix_fmt", "yuv420p", str(path))
    assert next(open_clip(path, None, None).frames()).shape == (240, 640, 3)


def test_a_high_rate_is_lowered(tmp_path: Path) -> None:
    path = tmp_path / "fast.mp4"
    ffmpeg("-f", "lavfi", "-i", "testsrc=size=64x48:rate=120:duration=1", str(path))
    clip = open_clip(path, None, None)
    assert clip.rate == 30.0
    assert count(clip) == pytest.approx(30, abs=1)


def test_a_part_is_read_alone(tmp_path: Path) -> None:
    path = write_colours(tmp_path / "dance.mp4")
    whole = list(open_clip(path, None, None).frames())
    clip = open_clip(path, 0.5, 1.0)
    part = list(clip.frames())
    assert clip.frames_before == 10
    assert len(part) == 11
    np.testing.assert_allclose(part[0].mean(), whole[10].mean(), atol=0.5)


def test_a_colon_or_a_dash_in_a_name_is_no_address(tmp_path: Path) -> None:
    for name in ("http:dance.mp4", "-i.mp4", "50% ü.mp4"):
        path = write_colours(tmp_path / "dance.mp4").rename(tmp_path / name)
        assert count(open_clip(path, None, None)) == FRAMES


def test_a_start_after_the_end_is_refused(tmp_path: Path) -> None:
    path = write_colours(tmp_path / "dance.mp4")
    with pytest.raises(BadOptionError, match=r"expected less, as .* lasts 2\.00 s"):
        open_clip(path, 2.5, None)


def test_a_long_video_is_refused_unless_a_part_is_chosen(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write_colours(tmp_path / "dance.mp4", 3.0)
    monkeypatch.setattr(frames, "_LONGEST", 2.0)
    with pytest.raises(MotionFileError, match="has 3 s of video; at most 2 s are read; choose"):
        open_clip(path, None, None)
    assert count(open_clip(path, 1.0, None)) == FRAMES
    undeclared = Clip(path, RATE, 0.0, np.inf, 0.0)
    with pytest.raises(MotionFileError, match="more than 2 s of video"):
        count(undeclared)


def test_a_file_that_is_cut_short_is_known_by_its_length(tmp_path: Path) -> None:
    path = write_colours(tmp_path / "dance.mkv", 4.0)
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    clip = open_clip(path, None, None)
    assert clip.is_cut_short(count(clip))


@pytest.mark.parametrize("ending", ["mp4", "webm", "ogg"])
def test_sound_alone_is_no_video(tmp_path: Path, ending: str) -> None:
    path = tmp_path / "song"
    kind = ["-f", ending]
    ffmpeg("-f", "lavfi", "-i", "sine=duration=1", *kind, str(path))
    path = path.rename(tmp_path / "dance.mp4")
    with pytest.raises(MotionFileError, match="has sound, but no pictures; give a video") as caught:
        open_clip(path, None, None)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "head", [b"\0\0\0\x20ftypisom", b"\x1a\x45\xdf\xa3", b"GIF89a", b"RIFF\0\0\0\0AVI "]
)
def test_rubbish_with_the_sign_of_a_video_is_refused_in_one_line(
    tmp_path: Path, head: bytes
) -> None:
    path = tmp_path / "dance.mp4"
    path.write_bytes(head + np.random.default_rng(0).bytes(4000))
    with pytest.raises(MotionFileError, match="cannot be decoded as a video") as caught:
        count(open_clip(path, None, None))
    assert len(str(caught.value).splitlines()) == 1


def test_no_ffmpeg_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write_colours(tmp_path / "dance.mp4")
    monkeypatch.setenv("IMAGEIO_FFMPEG_EXE", str(tmp_path / "none"))
    with pytest.raises(MotionFileError, match=r"ffmpeg, .* cannot be started \(No such file"):
        open_clip(path, None, None)
