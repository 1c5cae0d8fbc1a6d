"""Sound of videos: clicks at the beats of the dance."""

import os
import subprocess
import wave
from pathlib import Path

import imageio_ffmpeg
import numpy as np
import pytest
from numpy.typing import NDArray

from mpma_mj.envs.frame_writer import frame_writer
from mpma_mj.envs.soundtrack import Soundtrack
from mpma_mj.errors import VideoError
from mpma_mj.motions import ymca

RATE = 44_100
BEATS = np.arange(0.25, 8.0, 0.5)
FRAME = np.zeros((64, 64, 3), np.uint8)


@pytest.fixture(scope="module")
def clicks(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a sound file of eight seconds with a click at each beat."""
    path = tmp_path_factory.mktemp("sound") / "a: 'b'.wav"
    time = np.arange(int(0.03 * RATE)) / RATE
    samples = np.zeros(int(8.0 * RATE))
    for beat in BEATS:
        start = int(beat * RATE)
        samples[start : start + len(time)] = np.sin(6283.0 * time) * np.exp(-100.0 * time)
    with wave.open(str(path), "wb") as file:
        file.setparams((1, 2, RATE, 0, "NONE", ""))
        file.writeframes((30_000 * samples).astype("<i2").tobytes())
    return path


def clicks_of(path: Path) -> tuple[float, NDArray[np.float64]]:
    """Return the duration of a video's sound, s, and the times of its clicks, s."""
    words = ["-v", "error", "-i", str(path), "-f", "f32le", "-ac", "1", "-ar", "48000", "-"]
    found = subprocess.run(
        [imageio_ffmpeg.get_ffmpeg_exe(), *words], capture_output=True, check=True
    )
    loud = np.abs(np.frombuffer(found.stdout, "<f4"))
    times = np.flatnonzero(loud > 0.15) / 48_000
    return len(loud) / 48_000, times[np.diff(times, prepend=-1.0) > 0.1]


def write(path: Path, sound: Soundtrack) -> None:
    with frame_writer(path, FRAME.shape[:2], 20.0, sound) as write_frame:
        for _ in range(round(20.0 * sound.duration)):
            write_frame(FRAME)


@pytest.mark.parametrize("tempo", [0.5, 0.8, 1.0, 1.5])
def test_clicks_are_at_the_beats_of_every_repetition(
    tempo: float, clicks: Path, tmp_path: Path
) -> None:
    start, part = 0.6, 5.0 / tempo
    period = part + 0.5
    sound = Soundtrack(clicks, start, tempo, part, period, duration=3.0 * period - 0.5)
    write(tmp_path / "a.mp4", sound)
    duration, times = clicks_of(tmp_path / "a.mp4")
    once = (BEATS[(start <= BEATS) & (start + 5.0 > BEATS)] - start) / tempo
    expected = np.concatenate([once + k * period for k in range(3)])
    assert duration == pytest.approx(sound.duration, abs=0.05)
    assert len(times) == len(expected)
    np.testing.assert_allclose(times, expected, atol=0.05)


@pytest.mark.parametrize(("ending", "begin"), [(".mp4", 1.3), (".webm", 6.1), (".webm", 0.0)])
def test_clicks_of_a_part_are_at_its_beats(
    ending: str, begin: float, clicks: Path, tmp_path: Path
) -> None:
    whole = Soundtrack(clicks, 0.0, 0.8, 5.0, 5.5, duration=16.0)
    write(tmp_path / f"a{ending}", whole.cut(begin, 6.0))
    duration, times = clicks_of(tmp_path / f"a{ending}")
    once = BEATS[BEATS < 5.0 * 0.8] / 0.8
    beats = np.concatenate([once + k * 5.5 for k in range(3)]) - begin
    expected = beats[(beats >= 0.0) & (beats < 6.0)]
    assert duration == pytest.approx(6.0, abs=0.05)
    assert len(times) == len(expected)
    np.testing.assert_allclose(times, expected, atol=0.05)


@pytest.mark.parametrize(("start", "number"), [(6.0, 4), (9.0, 0)])
def test_music_that_ends_early_is_followed_by_silence(
    start: float, number: int, clicks: Path, tmp_path: Path
) -> None:
    write(tmp_path / "a.mp4", Soundtrack(clicks, start, 1.0, 10.0, 10.0, 10.0))
    duration, times = clicks_of(tmp_path / "a.mp4")
    assert duration == pytest.approx(10.0, abs=0.05)
    assert len(times) == number


def test_other_formats_are_silent(clicks: Path, tmp_path: Path) -> None:
    write(tmp_path / "a.gif", Soundtrack(clicks, 0.0, 1.0, 1.0, 1.0, 1.0))
    assert (tmp_path / "a.gif").exists()


def test_what_is_no_sound_is_one_line(tmp_path: Path) -> None:
    (tmp_path / "a.wav").write_text("no sound")
    os.mkfifo(tmp_path / "pipe")
    with frame_writer(tmp_path / "silent.mp4", FRAME.shape[:2], 20.0) as write_frame:
        write_frame(FRAME)
    problems = {"a.wav": "has no sound", "silent.mp4": "has no sound", "pipe": "is a pipe"}
    for name, message in (problems | {"b": "no such"}).items():
        with pytest.raises(VideoError, match=message) as refused:
            write(tmp_path / "a.mp4", Soundtrack(tmp_path / name, 0.0, 1.0, 1.0, 1.0, 1.0))
        assert name in str(refused.value)
        assert len(str(refused.value).splitlines()) == 1


def test_the_music_is_repeated_as_the_motion_is() -> None:
    motion = ymca()
    sound = Soundtrack.of(Path("a.wav"), motion, 3 * len(motion) + 2 * 7 - 1, 3)
    part = len(motion) / motion.rate
    assert (sound.start, sound.tempo, sound.motion_duration) == (0.0, 1.0, part)
    assert sound.period == pytest.approx(part + 7 / motion.rate)
    once = Soundtrack.of(Path("a.wav"), motion, len(motion) - 1, 1)
    assert once.period == part
    assert Soundtrack.of(None, motion, 10, 1) is None
