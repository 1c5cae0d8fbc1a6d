from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from mpma_mj import kinematics
from mpma_mj.envs.load import arm_limits
from mpma_mj.errors import BadOptionError
from mpma_mj.motions import Motion
from mpma_mj.motions.choreographies import BARS, BEAT, FIGURES, conductor, wave
from mpma_mj.motions.feasibility import beyond_limits

DANCES = pytest.mark.parametrize(
    ("make", "labels", "beats_per_minute"),
    [(wave, tuple(FIGURES), 108.0), (conductor, tuple(BARS), 96.0)],
)
Make = Callable[..., Motion]


def wrists(motion: Motion) -> NDArray[np.float64]:
    """Return the wrists as seen from their shoulders, outward being positive, (T, arm, xyz)."""
    sides = motion.posture.reshape(-1, 2, 2, 3).sum(axis=2)
    return np.asarray(sides * [[1.0, 1.0, 1.0], [1.0, -1.0, 1.0]])


def step(beat: float, bar: int = 0) -> int:
    """Return the step at a beat of the conductor at 80 Hz; the first beat of a bar is 1."""
    return round((4 * bar + beat - 1.0) * 50)


@DANCES
def test_a_bar_has_a_label_and_four_beats(
    make: Make, labels: tuple[str, ...], beats_per_minute: float
) -> None:
    motion = make()
    assert motion.labels == labels
    assert motion.duration == pytest.approx(4 * 4 * 60.0 / beats_per_minute, rel=0.01)
    assert (motion.context == np.repeat(np.eye(4), len(motion) // 4, axis=0)).all()


@DANCES
def test_arms_can_follow(make: Make, labels: tuple[str, ...], beats_per_minute: float) -> None:
    del labels, beats_per_minute
    assert not beyond_limits(make(), arm_limits("physics"))
    assert not beyond_limits(make(tempo=1.5), arm_limits("physics"))


@DANCES
def test_the_end_leads_into_the_start_without_a_jump(
    make: Make, labels: tuple[str, ...], beats_per_minute: float
) -> None:
    del labels, beats_per_minute
    posture = make(rate=100.0).posture
    steps = np.linalg.norm(np.roll(posture, -1, axis=0) - posture, axis=1)
    assert steps[-1] < 1.2 * steps[[-3, -2, 0, 1]].max()


@DANCES
def test_half_the_tempo_takes_twice_as_long(
    make: Make, labels: tuple[str, ...], beats_per_minute: float
) -> None:
    del labels, beats_per_minute
    slow, fast = make(tempo=0.5), make(rate=10.0)
    assert len(slow) == pytest.approx(4 * len(fast), abs=8)
    assert slow.duration == pytest.approx(2 * fast.duration, abs=0.5)


@DANCES
def test_too_fast_for_its_rate_is_refused(
    make: Make, labels: tuple[str, ...], beats_per_minute: float
) -> None:
    del labels, beats_per_minute
    with pytest.raises(BadOptionError, match=r"leave 0 sample\(s\) a bar"):
        make(tempo=200.0)


def test_a_crest_runs_through_the_arms_in_the_order_of_the_figure() -> None:
    motion = wave(rate=200.0)
    swing = motion.joint_angles[:, [0, 2, 4, 6]]  # both arms' abduction and rotation
    samples = len(motion) // 4
    for bar, (name, (mean, delays)) in enumerate(FIGURES.items()):
        second = swing[bar * samples + samples // 2 : (bar + 1) * samples]  # one swing
        np.testing.assert_allclose(second.mean(axis=0), [mean, 0.0, mean, 0.0], atol=1e-3)
        turns = np.argmax(second, axis=0) / len(second) - 0.25  # when a sine has its crest
        difference = (turns - np.array(delays) / 8.0 + 0.5) % 1.0 - 0.5
        assert np.abs(difference).max() < 0.01, name


def test_both_is_symmetrical() -> None:
    motion = wave()
    held = motion.joint_angles[len(motion) * 5 // 8 : len(motion) * 3 // 4]
    np.testing.assert_allclose(held[:, :4], held[:, 4:], atol=1e-9)


@pytest.mark.parametrize("bar", range(4))
def test_the_right_hand_beats_down_in_out_and_up(bar: int) -> None:
    hand = wrists(conductor(rate=80.0))[:, 1]
    way = hand[step(1, bar) : step(5, bar)]
    np.testing.assert_allclose(way[::25], BEAT, atol=1e-9)
    down, inward, out, up = way[[step(beat) for beat in (1, 2, 3, 4.5)]]
    assert down[2] == pytest.approx(way[:, 2].min(), abs=0.1)
    assert inward[1] == pytest.approx(way[:, 1].min(), abs=0.1)
    assert out[1] == pytest.approx(way[:, 1].max(), abs=0.1)
    assert up[2] == pytest.approx(way[:, 2].max(), abs=0.1)


def test_the_left_hand_mirrors_gives_a_cue_rises_and_sinks() -> None:
    left, right = np.moveaxis(wrists(conductor(rate=80.0)), 1, 0)
    mirror, cue, swell, fade = np.split(left, 4)
    np.testing.assert_allclose(mirror[: step(4.5)], right[: step(4.5)], atol=0.1)
    assert np.argmax(cue[:, 0]) == pytest.approx(step(3), abs=10)
    assert (np.diff(swell[step(1.5) : step(4.5), 2]) > 0).all()
    assert (np.diff(fade[step(1.5) : step(3.5), 2]) < 0).all()


def test_both_segments_are_of_one_length_and_elbows_point_down() -> None:
    angles = conductor().joint_angles.reshape(-1, 2, 4)
    posture = kinematics.posture_from_angles(angles.reshape(-1, 8)).reshape(-1, 2, 2, 3)
    elbow, wrist = posture[:, :, 0], posture.sum(axis=2)
    np.testing.assert_allclose(np.linalg.norm(wrist - elbow, axis=2), 1.0, atol=1e-9)
    assert (elbow[..., 2] < 0.5 * wrist[..., 2]).all()
