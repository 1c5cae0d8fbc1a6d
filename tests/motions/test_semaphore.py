import numpy as np
import pytest

from mpma_mj import kinematics
from mpma_mj.envs.load import arm_limits
from mpma_mj.errors import BadOptionError
from mpma_mj.motions.feasibility import beyond_limits
from mpma_mj.motions.semaphore import (
    FLAGS,
    POSITIONS,
    REST,
    normal_form,
    pose,
    semaphore,
    signs_of,
)
from mpma_mj.motions.transforms import PEAK_SPEED

# Eighths of a circle as the reader sees the two flags, clockwise from down: what letters look
# like, whichever hand holds which flag.
CIRCLES = {
    **{letter: (0, n) for n, letter in enumerate("ABCDEFG", 1)},
    **{letter: (1, n) for n, letter in zip((2, 3, 4, 5, 6, 7), "HIKLMN", strict=True)},
    **{letter: (2, n) for n, letter in enumerate("OPQRS", 3)},
    **{letter: (3, n) for n, letter in zip((4, 5, 6), "TUY", strict=True)},
    **{"numerals": (4, 5), "J": (4, 6), "V": (4, 7)},
    **{"W": (5, 6), "X": (5, 7), "Z": (6, 7), REST: (0, 0)},
}


def eighths(sign: str) -> tuple[int, int]:
    """Return where the flags of a sign are for the reader, who has the left hand to the right."""
    left, right = (round(POSITIONS[position] / 45.0) for position in FLAGS[sign])
    first, second = sorted((-left % 8, right % 8))
    return first, second


def test_the_alphabet_goes_round_in_circles() -> None:
    assert {sign: eighths(sign) for sign in FLAGS} == CIRCLES


def test_no_two_signs_look_alike() -> None:
    assert len({eighths(sign) for sign in FLAGS}) == len(FLAGS) == 26 + 2


def test_there_are_eight_positions_of_which_hands_cross_to_the_diagonals_only() -> None:
    assert set(np.diff(sorted(POSITIONS.values()))) == {45.0}
    seen = {eighth for sign in FLAGS for eighth in eighths(sign)}
    assert seen == set(range(8))
    crossing = {sign for sign, flags in FLAGS.items() if any("across" in flag for flag in flags)}
    assert crossing == set("HIOWXZ")


@pytest.mark.parametrize("sign", FLAGS)
def test_arms_are_straight_and_point_where_the_flags_do(sign: str) -> None:
    arms = kinematics.posture_from_angles(pose(sign)).reshape(2, 2, 3)  # (arm, segment, xyz)
    for arm, position, outward in zip(arms, FLAGS[sign], (1.0, -1.0), strict=True):
        angle = np.radians(POSITIONS[position])
        seen = np.array([outward * np.sin(angle), -np.cos(angle)])  # (left, up)
        across = arm[:, 1:] / np.linalg.norm(arm[:, 1:], axis=1, keepdims=True)
        np.testing.assert_allclose(across, [seen, seen], atol=1e-12)
        assert arm[0] @ arm[1] > np.cos(np.radians(6.0))
        assert (arm[:, 0] > 0.1).all()  # in front of the body


def test_digits_are_letters_after_the_sign_for_numerals() -> None:
    for digit, letter in zip("1234567890", "ABCDEFGHIK", strict=True):
        np.testing.assert_array_equal(pose(digit), pose(letter))
    assert signs_of("R2D") == ("R", "numerals", "2", "letters", "D", REST)
    assert signs_of("12 3A") == ("numerals", "1", "2", REST, "3", "letters", "A", REST)


def test_every_sign_is_reached_and_held() -> None:
    motion = semaphore("hello")
    assert (motion.name, motion.labels) == ("semaphore-HELLO", ("H", "E", "L", "O", REST))
    samples = 24  # 1.2 s
    assert len(motion) == 6 * samples
    for number, sign in enumerate((*"HELLO", REST)):
        held = motion.posture[(number + 1) * samples - 4 : (number + 1) * samples]
        expected = kinematics.posture_from_angles(pose(sign))
        np.testing.assert_allclose(held, np.tile(expected, (4, 1)), atol=1e-12)
        column = motion.context[number * samples : (number + 1) * samples]
        assert (column == (np.array(motion.labels) == sign)).all()


def test_case_and_the_number_of_spaces_make_no_difference() -> None:
    one, other = semaphore("  hi   You "), semaphore("HI YOU")
    assert one.name == other.name == "semaphore-HI-YOU"
    np.testing.assert_array_equal(one.posture, other.posture)


@pytest.mark.parametrize("word", ["LL", "DD", "OO", "4J", "44"])
def test_arms_are_lowered_between_equal_signs(word: str) -> None:
    samples = 24
    sign = signs_of(word)[-2]
    parts = semaphore(word).joint_angles.reshape(-1, samples, 8)[-3:-1]
    away = np.abs(parts - pose(sign)).max(axis=2)  # (sign, T)
    assert away[0, -1] == pytest.approx(0.0, abs=1e-9)
    assert away[1].max() > 0.7
    assert away[1, [0, -1]] == pytest.approx([0.0, 0.0], abs=1e-9)
    lowered = np.abs(parts[1, :, 0::4]) <= np.abs(pose(sign)[0::4]) + 1e-9
    assert lowered.all()


def test_the_end_leads_into_the_start() -> None:
    motion = semaphore("Z")
    np.testing.assert_allclose(motion.posture[-1], motion.posture[0], atol=1e-12)


def test_arms_can_follow_any_two_signs_in_turn() -> None:
    limits = arm_limits("physics")
    poses = np.array([pose(sign) for sign in FLAGS])
    farthest = np.abs(poses[:, None] - poses).max(axis=(0, 1))
    assert np.degrees(farthest[[0, 4]]) == pytest.approx([270.0, 270.0])
    assert (PEAK_SPEED * farthest / 0.9 < 0.9 * limits.max_speed).all()  # in 0.9 s of 1.2
    for word in ("HOZX", "the quick brown fox jumps over the lazy dog", "0123456789"):
        assert not beyond_limits(semaphore(word), limits)


def test_half_the_tempo_takes_twice_as_long() -> None:
    assert semaphore("AB", tempo=0.5).duration == 2 * semaphore("AB").duration


@pytest.mark.parametrize(
    ("word", "message"),
    [
        ("", "semaphore has no word; expected the letters A to Z, digits and spaces, such as"),
        (" \t ", "semaphore has no word"),
        ("HELLO!", "semaphore has no sign '!'; expected the letters A to Z, digits and spaces"),
        ("Straße", "semaphore has no sign 'ß'"),
        ("½", "semaphore has no sign '½'"),
        ("٣", "semaphore has no sign '٣'"),
        ("A" * 60, r"semaphore:AAAAAAAAAA… takes 61 signs, 73 s, with rests; expected at most 60"),
        ("1A" * 15, r"takes 61 signs"),
    ],
)
def test_what_semaphore_cannot_spell_is_refused(word: str, message: str) -> None:
    with pytest.raises(BadOptionError, match=message):
        semaphore(word)
    assert len(signs_of(normal_form("A" * 59))) == 60


def test_too_fast_for_its_rate_is_refused() -> None:
    with pytest.raises(BadOptionError, match=r"leave 1 sample\(s\) a sign"):
        semaphore("A", rate=1.0)
