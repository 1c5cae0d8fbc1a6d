import builtins
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from numpy.typing import NDArray

from mpma_mj.context import Span
from mpma_mj.errors import BadOptionError, MotionFileError
from mpma_mj.motions.audio_segments import bars, sections

pytest.importorskip("librosa")
soundfile = pytest.importorskip("soundfile")

Array = NDArray[np.float64]
Find = Callable[[Path], tuple[Span, ...]]

RATE = 22050
CHORDS = {  # MIDI notes
    "A": ((57, 60, 64), (53, 57, 60), (60, 64, 67), (55, 59, 62)),
    "B": ((56, 59, 63), (61, 64, 68), (63, 66, 70), (58, 61, 65)),
}
OVERTONES = {"A": 1, "B": 6}


def click_track(tempo: float, count: int, first: float = 0.0) -> tuple[Array, Array]:
    """Return bars of four clicks with the first one accented, and when each bar begins, s."""
    beat = 60.0 / tempo
    time = np.arange(1500) / RATE
    samples = np.zeros(round((first + 4 * count * beat) * RATE) + len(time))
    for i in range(4 * count):
        pitch, loudness = (1000.0, 0.4) if i % 4 else (1500.0, 1.0)
        start = round((first + i * beat) * RATE)
        click = loudness * np.sin(2 * np.pi * pitch * time) * np.exp(-60.0 * time)
        samples[start : start + len(time)] += click
    return samples, first + 4 * beat * np.arange(count)


def song(form: str, bars_each: int, chords: int = 2) -> Array:
    """Return sections of chords in turn, bars of 2 s, each with its timbre, over a click track."""
    rng = np.random.default_rng(0)
    samples, starts = click_track(120.0, len(form) * bars_each)
    time = np.arange(2 * RATE) / RATE
    for i, start in enumerate(starts):
        name = form[i // bars_each]
        for note in CHORDS[name][i % chords]:
            for k in range(1, OVERTONES[name] + 1):
                tone = np.sin(2 * np.pi * 440.0 * 2 ** ((note - 69) / 12) * k * time)
                begin = round(start * RATE)
                samples[begin : begin + len(time)] += 0.1 / k * tone
    return samples + rng.normal(0.0, 1e-3, len(samples))


@pytest.fixture
def write(tmp_path: Path) -> Callable[..., Path]:
    def write(samples: Array, name: str = "song.wav", rate: int = RATE) -> Path:
        soundfile.write(tmp_path / name, samples, rate)
        return tmp_path / name

    return write


@pytest.mark.parametrize(("tempo", "first"), [(80.0, 0.0), (127.0, 1.1), (150.0, 2.5)])
def test_bars_begin_on_the_accented_beats(
    write: Callable[..., Path], tempo: float, first: float
) -> None:
    samples, starts = click_track(tempo, 8, first)
    found = bars(write(samples))
    np.testing.assert_allclose([span.start for span in found[1:]], starts[1:], atol=0.05)
    assert [span.label for span in found] == [f"bar {i}" for i in range(1, 9)]


@pytest.mark.parametrize("beats", [1, 2, 3])
def test_a_pickup_belongs_to_the_first_bar(write: Callable[..., Path], beats: int) -> None:
    samples, starts = click_track(120.0, 8)
    cut = starts[1] - 0.5 * beats
    found = bars(write(samples[round(cut * RATE) :]))
    np.testing.assert_allclose([span.start for span in found[1:]], starts[2:] - cut, atol=0.05)


def test_a_song_may_have_a_name_that_is_not_utf8(write: Callable[..., Path]) -> None:
    path = write(click_track(120.0, 4)[0])
    assert bars(path.rename(path.with_name("song\udcff.wav"))) == bars(
        write(click_track(120.0, 4)[0])
    )


@pytest.mark.parametrize("find", [bars, sections])
def test_spans_cover_the_file_without_gaps(write: Callable[..., Path], find: Find) -> None:
    samples = np.concatenate([np.zeros(RATE), song("ABA", 4), np.zeros(3 * RATE)])
    found = find(write(samples))
    assert found[0].start == 0.0
    assert found[-1].end == pytest.approx(len(samples) / RATE, abs=1e-3)
    assert all(a.end == b.start for a, b in pairwise(found))
    assert all(span.start < span.end for span in found)


@pytest.mark.parametrize("name", ["song.flac", "song.ogg", "song.mp3"])
def test_other_formats_rates_and_channels_have_the_same_bars(
    write: Callable[..., Path], name: str
) -> None:
    samples, starts = click_track(120.0, 6, 0.3)
    stereo = np.repeat(np.repeat(samples, 2)[:, None], 2, axis=1)
    found = bars(write(stereo, name, 2 * RATE))
    np.testing.assert_allclose([span.start for span in found[1:]], starts[1:], atol=0.05)


@pytest.mark.parametrize(("bars_each", "chords"), [(4, 1), (8, 4)])
def test_a_section_that_returns_has_its_label_again(
    write: Callable[..., Path], bars_each: int, chords: int
) -> None:
    bar = 2.0  # s
    found = sections(write(song("ABA", bars_each, chords)))
    assert [span.label for span in found] == ["A", "B", "A"]
    edges = [span.start for span in found[1:]]
    np.testing.assert_allclose(edges, [bars_each * bar, 2 * bars_each * bar], atol=0.5 * bar)


def test_sections_are_told_apart_by_harmony_alone(
    write: Callable[..., Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(OVERTONES, "B", OVERTONES["A"])
    found = sections(write(song("ABA", 6, chords=4)))
    assert [span.label for span in found] == ["A", "B", "A"]
    np.testing.assert_allclose([span.start for span in found[1:]], [12.0, 24.0], atol=2.0)


@pytest.mark.parametrize("chords", [1, 4])
def test_music_that_stays_the_same_is_one_section(write: Callable[..., Path], chords: int) -> None:
    assert [span.label for span in sections(write(song("A", 16, chords)))] == ["A"]


def test_too_few_bars_to_compare_are_one_section(write: Callable[..., Path]) -> None:
    assert [span.label for span in sections(write(song("AB", 2)))] == ["A"]


@pytest.mark.parametrize("find", [bars, sections])
def test_equal_files_give_equal_spans(write: Callable[..., Path], find: Find) -> None:
    samples = song("ABA", 4)
    assert find(write(samples)) == find(write(samples, "copy.wav"))


def test_good_music_is_read_without_a_word(
    write: Callable[..., Path], capfd: pytest.CaptureFixture[str], recwarn: pytest.WarningsRecorder
) -> None:
    sections(write(song("AB", 3), "song.mp3"))
    assert capfd.readouterr() == ("", "")
    assert not recwarn.list


def test_bad_files_are_one_line_that_names_them(
    write: Callable[..., Path], tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    samples, _ = click_track(120.0, 4)
    bad = {
        "missing.wav": "no such file",
        ".": "is a folder",
        "text.wav": "cannot be read as audio",
        "text.mp3": "cannot be read as audio",
        "text.raw": "cannot be read as audio",
        "empty.wav": "cannot be read as audio",
        "cut.flac": "cannot be read as audio",
        "cut.wav": "ends earlier than its header declares",
        "cut.aiff": "ends earlier than its header declares",
        "cut.mp3": "ends earlier than its header declares",
        "silent.wav": "is silent",
        "offset.wav": "is silent",
        "short.wav": "too short for a bar",
        "nan.wav": "not finite",
        "x" * 300 + ".wav": "cannot be read",
    }
    for name in ("text.wav", "text.mp3", "text.raw"):
        (tmp_path / name).write_text("no music\n" * 1000)
    (tmp_path / "empty.wav").touch()
    for name in ("cut.flac", "cut.wav", "cut.aiff", "cut.mp3"):
        path = write(samples, name)
        path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    write(np.zeros(3 * RATE), "silent.wav")
    write(np.full(3 * RATE, 0.5), "offset.wav")
    write(samples[: RATE // 2], "short.wav")
    soundfile.write(tmp_path / "nan.wav", np.append(samples, np.nan), RATE, subtype="FLOAT")
    for name, problem in bad.items():
        with pytest.raises(MotionFileError, match=problem) as caught:
            bars(tmp_path / name)
        assert str(caught.value).startswith(f"{tmp_path / name}: ")
        assert "\n" not in str(caught.value)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("find", [bars, sections])
def test_music_without_four_beats_is_refused(write: Callable[..., Path], find: Find) -> None:
    one_click = click_track(60.0, 1, 1.0)[0][: round(1.5 * RATE)]
    with pytest.raises(MotionFileError, match=r"has \d beat\(s\), and a bar needs 4; give"):
        find(write(np.concatenate([one_click, np.zeros(3 * RATE)])))


def test_a_steady_tone_has_no_beat(write: Callable[..., Path]) -> None:
    tone = 0.5 * np.sin(2 * np.pi * 440.0 * np.arange(8 * RATE) / RATE)
    with pytest.raises(MotionFileError, match="give music with a clear beat"):
        bars(write(tone))


@pytest.mark.parametrize("missing", ["librosa", "soundfile"])
def test_a_missing_library_is_one_line_that_says_how_to_install_it(
    write: Callable[..., Path], monkeypatch: pytest.MonkeyPatch, missing: str
) -> None:
    path = write(click_track(120.0, 2)[0])
    whole = builtins.__import__

    def without(name: str, *args: object, **kwargs: object) -> ModuleType:
        if name == missing:
            raise ImportError(name)
        return whole(name, *args, **kwargs)  # type: ignore[arg-type]

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(BadOptionError, match=r"^[^\n]*pip install -e '\.\[audio\]'$"):
        bars(path)
