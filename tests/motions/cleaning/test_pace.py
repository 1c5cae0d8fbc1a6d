"""Frames that repeat, are lost or are exchanged are told, a movement at any pace is not."""

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from mpma_mj.motions.cleaning.pace import exchanged_at_end, odd_steps
from mpma_mj.motions.loader import import_motion
from mpma_mj.motions.options import ReadingOptions
from tests.conftest import WriteTsv, dancer, doubts
from tests.motions.known_motions import singular
from tests.motions.readers import writers

Array = NDArray[np.float64]

FRAME = 84
REPEATED, MISSING, EXCHANGED = 0, 2, -1


def moving(noise: float = 0.2, frames: int = 180) -> Array:
    """Return places of three markers, mm, of arms that swing, shape (T, 9)."""
    phase = np.arange(frames)[:, None] / 20.0 + np.arange(9)
    return 200.0 * np.sin(phase) + np.random.default_rng(0).normal(0.0, noise, phase.shape)


def exchange(places: Array) -> Array:
    order = np.arange(len(places))
    order[[FRAME, FRAME + 1]] = FRAME + 1, FRAME
    return places[order]


DAMAGE: dict[int, Callable[[Array], Array]] = {
    REPEATED: lambda places: np.insert(places, FRAME, places[FRAME], axis=0),
    MISSING: lambda places: np.delete(places, FRAME, axis=0),
    EXCHANGED: exchange,
}


@pytest.mark.parametrize("kind", DAMAGE)
def test_the_odd_step_is_found(kind: int) -> None:
    step = FRAME - (kind == MISSING)
    found = odd_steps(np.diff(DAMAGE[kind](moving()), axis=0))
    assert {k: steps.tolist() for k, steps in found.items()} == {kind: [step]}


@given(seed=st.integers(0, 999), seconds=st.floats(0.1, 1.0), noise=st.floats(0.0, 5.0))
def test_no_movement_is_odd(seed: int, seconds: float, noise: float) -> None:
    points = dancer(singular(seed, seconds=seconds).posture)
    rng = np.random.default_rng(seed)
    places = np.concatenate([*points.values()], axis=1)
    places += rng.normal(0.0, noise, places.shape)
    assert not odd_steps(np.diff(places, axis=0))
    assert not exchanged_at_end(places)
    assert not exchanged_at_end(places[::-1])


@given(frame=st.integers(20, 160))
def test_a_lost_frame_is_found_at_any_pace(frame: int) -> None:
    phase = np.arange(180)[:, None] / 20.0 + np.array([0.0, 0.2, 0.4])  # that turn together
    places = 200.0 * np.sin(phase) + np.random.default_rng(0).normal(0.0, 0.02, phase.shape)
    found = odd_steps(np.diff(np.delete(places, frame, axis=0), axis=0))
    assert {k: steps.tolist() for k, steps in found.items()} == {MISSING: [frame - 1]}


@pytest.mark.parametrize("later", [1, 2])
def test_frames_exchanged_at_an_end_are_found(write_tsv: WriteTsv, later: int) -> None:
    places = moving()
    places[[later - 1, later]] = places[[later, later - 1]]
    assert exchanged_at_end(places) == later
    for end, number in ((1, later + 1), (-1, 181 - later)):
        markers = {
            name: CubicSpline(np.arange(60), track)(np.arange(0.0, 59.9, 1.0 / 3.0))[::end]
            for name, track in writers.arm_points().items()
        }
        for track in markers.values():
            track[[later - 1, later]] = track[[later, later - 1]]
        path = write_tsv({name: track[::end] for name, track in markers.items()})
        warnings = doubts(import_motion(path, ReadingOptions()).report)
        assert any(w.startswith(f"frame {number} and the one before") for w in warnings), warnings


@pytest.mark.parametrize("frames", [1, 2, 4, 5, 6])
def test_few_frames_and_no_movement_are_not_odd(frames: int) -> None:
    assert not odd_steps(np.diff(moving()[:frames], axis=0))
    assert not odd_steps(np.zeros((frames, 9)))


@pytest.mark.parametrize(
    ("kind", "message"),
    [
        (REPEATED, "frame 86 repeats the one before"),
        (MISSING, "frame 85 comes a frame too late: one seems to be missing before it"),
        (EXCHANGED, "frame 86 and the one before seem to be exchanged"),
    ],
)
def test_the_frame_is_told(write_tsv: WriteTsv, kind: int, message: str) -> None:
    markers = {
        name: CubicSpline(np.arange(60), track)(np.arange(0.0, 59.0, 1.0 / 3.0))
        for name, track in writers.arm_points().items()
    }
    assert not doubts(import_motion(write_tsv(markers), ReadingOptions()).report)
    damaged = {name: DAMAGE[kind](track) for name, track in markers.items()}
    assert doubts(import_motion(write_tsv(damaged), ReadingOptions()).report)[0].startswith(message)
