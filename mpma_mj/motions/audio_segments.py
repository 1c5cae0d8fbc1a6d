"""Bars and sections of the music in an audio file."""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import groupby, pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpma_mj.context import Span
from mpma_mj.errors import BadOptionError, MotionFileError
from mpma_mj.utils.input_files import file_problem
from mpma_mj.utils.silence import silenced

__all__ = ["bars", "sections"]

Array = NDArray[np.float64]
Samples = NDArray[np.float32]

_RATE = 22050.0  # Hz, at which librosa's defaults are meant to work
_HOP = 256  # samples between two spectra: 12 ms
_LEAD = 1.0  # s of silence in front, without which the first beat is found too early
_BEATS = 4  # of a bar (choice)
_SHORTEST = 1.0  # s: a bar at 240 beats a minute (choice)
_WHOLE = 0.99  # share of the samples that a header promises; that of an MP3 is rough (choice)
_LARGEST = 1_000_000_000  # bytes: an hour of sound, all of which is held in memory (choice)
_SILENCE = 1e-4  # loudest sample, of 1 (choice)
_FEWEST_BARS = 3  # of a section (choice)
_MOST_PARTS = 24  # that the music is cut into (choice)
_MOST_SECTIONS = 8  # that sound different (choice)
_SAME = (0.1, 8.0)  # spread of chroma and MFCC below which bars sound the same (choice)
_CLEAR = 0.25  # silhouette below which there are no groups (Kaufman & Rousseeuw 1990)


def bars(path: Path) -> tuple[Span, ...]:
    """Find the bars of the music.

    Beats are found by dynamic programming (Ellis 2007, J. New Music Research 36(1)). Four of
    them are a bar (choice), which begins with the beat that has the strongest onsets. Music before
    the first bar belongs to the first bar, music after the last one to the last.

    Args:
        path: Audio file.

    Returns:
        "bar 1", "bar 2" and so on, without gaps from 0 s to the end of the file.

    Raises:
        MotionFileError: The file cannot be read as music with a beat.
        BadOptionError: The libraries for audio are not installed.
    """
    samples = _read(path)
    starts = _bar_starts(samples, path)
    return _spans(starts, [f"bar {i + 1}" for i in range(len(starts))], samples)


def sections(path: Path) -> tuple[Span, ...]:
    """Find the sections of the music, such as verse and chorus.

    Bars are compared by harmony and timbre: the music is cut into parts where these change, and
    parts that sound alike share a label. Of all numbers of parts and labels those are taken
    that separate the bars most clearly, measured by their silhouette (Rousseeuw 1987, J.
    Comp. Appl. Math. 20). A section has three bars or more (choice).

    Args:
        path: Audio file.

    Returns:
        "A", "B" and so on, at most eight labels in the order in which they first occur,
        without gaps from 0 s to the end of the file. A section that returns has its label again.

    Raises:
        MotionFileError: The file cannot be read as music with a beat.
        BadOptionError: The libraries for audio are not installed.
    """
    samples = _read(path)
    starts = _bar_starts(samples, path)
    groups = _groups(*_sound(samples, starts)).tolist()
    names = {group: chr(ord("A") + i) for i, group in enumerate(dict.fromkeys(groups))}
    runs = [[*run] for _, run in groupby(range(len(starts)), key=groups.__getitem__)]
    return _spans(
        starts[[run[0] for run in runs]], [names[groups[run[0]]] for run in runs], samples
    )


def _read(path: Path) -> Samples:
    """Read an audio file as mono samples at `_RATE`, shape (S,)."""
    if problem := file_problem(path, largest=_LARGEST):
        raise MotionFileError(f"{path}: {problem}")
    try:
        import librosa
        import soundfile
    except ImportError:
        raise BadOptionError(
            f"{path}: audio needs libraries that are not installed; in the checkout, pip install"
            " -e '.[audio]'"
        ) from None
    try:
        # Opened here: libsndfile takes no name but UTF-8. Its MP3 decoder writes of bad files.
        with path.open("rb") as opened, silenced(), soundfile.SoundFile(opened) as file:
            promised, rate, notes = file.frames, float(file.samplerate), file.extra_info
            channels = file.read(dtype="float32", always_2d=True)
    except (soundfile.SoundFileError, TypeError):  # TypeError: a name that ends in .raw
        raise MotionFileError(
            f"{path}: cannot be read as audio; give a complete WAV, FLAC, OGG or MP3 file"
        ) from None
    if len(channels) < _WHOLE * promised or _is_truncated(notes):
        raise MotionFileError(
            f"{path}: ends earlier than its header declares; copy or export it again"
        )
    samples: Samples = channels.mean(axis=1)
    if len(samples) < _SHORTEST * rate:
        raise MotionFileError(
            f"{path}: lasts {len(samples) / rate:.2f} s, too short for a bar; expected at least"
            f" {_SHORTEST:g} s of music"
        )
    if not np.isfinite(samples).all():
        raise MotionFileError(f"{path}: contains a sample that is not finite; export it again")
    if np.ptp(samples) < _SILENCE:
        raise MotionFileError(f"{path}: is silent; give a file with music")
    return librosa.resample(samples, orig_sr=rate, target_sr=_RATE)


def _is_truncated(notes: str) -> bool:
    """Return whether libsndfile's log of a WAV or AIFF file reports missing samples."""
    sizes = re.findall(r"(?:data|SSND) : (\d+) \(should be (\d+)\)", notes)
    return any(int(stated) > int(actual) for stated, actual in sizes)


def _bar_starts(samples: Samples, path: Path) -> Array:
    """Return when bars begin, shape (B,), s; samples have shape (S,)."""
    import librosa

    lead = np.zeros(round(_LEAD * _RATE), np.float32)
    onsets = librosa.onset.onset_strength(
        y=np.concatenate([lead, samples]), sr=_RATE, hop_length=_HOP
    )
    frames = librosa.beat.beat_track(onset_envelope=onsets, sr=_RATE, hop_length=_HOP, trim=False)[
        1
    ]
    times = librosa.frames_to_time(frames, sr=_RATE, hop_length=_HOP) - _LEAD
    audible = times >= 0  # the first beat may be detected in the silence before the music
    frames, times = frames[audible], times[audible]
    phases = min(_BEATS, len(times) - _BEATS + 1)  # that leave a whole bar
    if phases < 1:
        raise MotionFileError(
            f"{path}: has {len(times)} beat(s), and a bar needs {_BEATS};"
            " give music with a clear beat"
        )
    if np.median(onsets[frames]) <= onsets.mean():
        raise MotionFileError(
            f"{path}: its beats are not clear, as onsets are as strong between them; give music"
            " with a clear beat"
        )
    phase = max(range(phases), key=lambda k: float(onsets[frames[k::_BEATS]].mean()))
    return times[phase : len(times) - _BEATS + 1 : _BEATS]


def _spans(starts: Array, labels: Sequence[str], samples: Samples) -> tuple[Span, ...]:
    """Return spans that cover samples, shape (S,), and begin at times, shape (N,), s."""
    edges = [0.0, *starts[1:].tolist(), len(samples) / _RATE]
    return tuple(map(Span, edges[:-1], edges[1:], labels))


def _sound(samples: Samples, starts: Array) -> tuple[Array, Array]:
    """Return chroma (B, 12) and MFCC (B, 20) of each bar."""
    import librosa

    chroma = librosa.feature.chroma_stft(y=samples, sr=_RATE, hop_length=_HOP)
    # The first coefficient, loudness, is left out: a chorus stays the same when it is louder.
    mfcc = librosa.feature.mfcc(y=samples, sr=_RATE, hop_length=_HOP, n_mfcc=21)[1:]
    first = librosa.time_to_frames(starts, sr=_RATE, hop_length=_HOP).tolist()
    edges = [0, *first[1:], chroma.shape[1]]
    chroma, mfcc = (librosa.util.sync(x, edges, pad=False).T for x in (chroma, mfcc))
    return chroma.astype(np.float64), mfcc.astype(np.float64)


def _groups(chroma: Array, mfcc: Array) -> NDArray[np.int_]:
    """Return which bars belong together, shape (B,), by chroma (B, 12) and MFCC (B, 20)."""
    from ruptures import KernelCPD
    from scipy.spatial.distance import pdist, squareform
    from sklearn.cluster import AgglomerativeClustering
    from sklearn.metrics import silhouette_score

    alike = np.zeros(len(chroma), np.int_)
    most = min(len(chroma) // _FEWEST_BARS, _MOST_PARTS)
    # Neighbours blur the chords of a section into what they have in common, and its edges too:
    # they help to group bars, but not where to cut.
    around = _scaled(_with_neighbours(chroma), _with_neighbours(mfcc))
    if most < 2 or not around.any():
        return alike
    distances = squareform(pdist(around))
    bars_alone = _scaled(chroma, mfcc)
    cutter = KernelCPD(kernel="linear", min_size=_FEWEST_BARS).fit(bars_alone)
    cutter.predict(n_bkps=most - 1)  # finds those of fewer parts as well, and keeps them
    clearest = _CLEAR
    for count in range(2, most + 1):
        cuts = [0, *cutter.predict(n_bkps=count - 1)]
        parts = [bars_alone[i:j].mean(axis=0) for i, j in pairwise(cuts)]
        for labels in range(2, min(_MOST_SECTIONS, count) + 1):
            of_parts = AgglomerativeClustering(labels).fit_predict(parts)
            of_bars = np.repeat(of_parts, np.diff(cuts))
            clearness = silhouette_score(distances, of_bars, metric="precomputed")
            if clearness > clearest:
                alike, clearest = of_bars, clearness
    return alike


def _with_neighbours(feature: Array) -> Array:
    """Return the means of each bar and its two neighbours, shape (B, F)."""
    padded = np.pad(feature, ((1, 1), (0, 0)), mode="edge")
    return (padded[:-2] + padded[1:-1] + padded[2:]) / 3.0


def _scaled(chroma: Array, mfcc: Array) -> Array:
    """Return both features with the same spread, shape (B, 32), or 0 where all is the same."""
    scaled = []
    for feature, same in zip((chroma, mfcc), _SAME, strict=True):
        spread = np.sqrt(np.var(feature, axis=0).sum())
        centred = feature - feature.mean(axis=0)
        scaled.append(centred / spread if spread > same else np.zeros_like(feature))
    return np.concatenate(scaled, axis=1)
