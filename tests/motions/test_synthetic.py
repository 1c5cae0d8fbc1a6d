import numpy as np
import pytest

from mpma_mj import joint_paths
from mpma_mj.envs.load import arm_limits
from mpma_mj.errors import BadOptionError
from mpma_mj.motions import read_motion, ymca
from mpma_mj.motions.feasibility import beyond_limits
from mpma_mj.motions.synthetic import KEY_POSES, LETTERS, SYNTHETIC_MOTIONS, synthetic_motion


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
    angles = joint_paths.continuous_angles(ymca().posture)
    assert np.abs(np.diff(angles, axis=0)).max() < 0.5


def test_too_fast_for_its_rate_is_refused() -> None:
    with pytest.raises(BadOptionError, match="leave 1 sample"):
        ymca(rate=1.0)


def test_the_dances_in_a_row_are_the_whole() -> None:
    whole = synthetic_motion()
    pieces = [synthetic_motion(number=number) for number in range(1, SYNTHETIC_MOTIONS + 1)]
    assert np.array_equal(whole.posture, np.concatenate([piece.posture for piece in pieces]))
    assert whole.labels == tuple(label for piece in pieces for label in piece.labels)
    assert {piece.duration for piece in pieces} == {5.0}


def test_no_two_dances_are_alike() -> None:
    pieces = [synthetic_motion(number=number).posture for number in range(1, SYNTHETIC_MOTIONS + 1)]
    apart = [np.abs(a - b).mean() for i, a in enumerate(pieces) for b in pieces[:i]]
    assert min(apart) > 0.1


def test_arms_can_follow_them() -> None:
    assert not beyond_limits(synthetic_motion(), arm_limits("physics"))


def test_they_are_the_same_always_and_say_that_nobody_danced_them() -> None:
    motion = read_motion("synthetic-3")
    assert np.array_equal(motion.posture, synthetic_motion(number=3).posture)
    assert motion.name == "synthetic-3"
    assert "synthetic" in motion.source


def test_a_tempo_stretches_them() -> None:
    fast, slow = synthetic_motion(number=1), synthetic_motion(tempo=0.5, number=1)
    assert slow.duration == 2 * fast.duration
    assert slow.posture[::2] == pytest.approx(fast.posture)


def test_a_tempo_without_samples_is_refused() -> None:
    with pytest.raises(BadOptionError, match=r"leave 0 sample\(s\) a pose"):
        synthetic_motion(tempo=100.0)
