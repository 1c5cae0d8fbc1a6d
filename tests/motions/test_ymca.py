import numpy as np
import pytest

from mpma_mj import kinematics
from mpma_mj.errors import BadOptionError
from mpma_mj.motions import ymca
from mpma_mj.motions.synthetic import KEY_POSES, LETTERS
from mpma_mj.motions.transforms import PEAK_SPEED, minimum_jerk


def test_every_letter_is_reached_and_held() -> None:
    motion = ymca()
    samples = len(motion) // len(LETTERS)
    for i, letter in enumerate(LETTERS):
        key = np.array(KEY_POSES[letter])
        key = (key / np.linalg.norm(key, axis=1, keepdims=True)).ravel()
        held = motion.posture[(i + 1) * samples - 4 : (i + 1) * samples]
        np.testing.assert_allclose(held, np.tile(key, (4, 1)), atol=1e-12)
        assert (motion.context[i * samples : (i + 1) * samples, i] == 1).all()
    assert (motion.context.sum(axis=1) == 1).all()


@pytest.mark.parametrize("letter", ["Y", "M", "A"])
def test_y_m_and_a_are_symmetrical(letter: str) -> None:
    left, right = np.array(KEY_POSES[letter]).reshape(2, 2, 3)
    np.testing.assert_array_equal(left * [1, -1, 1], right)


def test_the_tempo_is_that_of_the_song() -> None:
    beats_per_minute = 8 / ymca().duration * 60
    assert beats_per_minute == pytest.approx(127, rel=0.01)


def test_half_the_tempo_takes_twice_as_long() -> None:
    assert ymca(tempo=0.5).duration == pytest.approx(2 * ymca().duration, abs=0.2)


def test_the_end_leads_into_the_start() -> None:
    motion = ymca()
    np.testing.assert_allclose(motion.posture[-1], motion.posture[0], atol=1e-12)


def test_angles_stay_on_one_branch() -> None:
    angles = kinematics.continuous_angles(ymca().posture)
    assert np.abs(np.diff(angles, axis=0)).max() < 0.5


def test_too_fast_for_its_rate_is_refused() -> None:
    with pytest.raises(BadOptionError, match="leave 1 sample"):
        ymca(rate=1.0)


def test_minimum_jerk_is_at_rest_at_both_ends_and_fastest_half_way() -> None:
    phase = np.linspace(-0.2, 1.2, 14001)
    way = minimum_jerk(phase)
    speed, acceleration = np.gradient(way, phase), np.gradient(np.gradient(way, phase), phase)
    assert way[0] == 0.0
    assert way[-1] == 1.0
    assert speed.max() == pytest.approx(PEAK_SPEED, rel=1e-6)
    assert phase[speed.argmax()] == pytest.approx(0.5, abs=1e-3)
    ends = np.isclose(phase, 0.0, atol=1e-9) | np.isclose(phase, 1.0, atol=1e-9)
    np.testing.assert_allclose(speed[ends], 0.0, atol=1e-6)
    np.testing.assert_allclose(acceleration[ends], 0.0, atol=0.02)
