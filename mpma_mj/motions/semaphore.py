"""Flag semaphore: two arms that spell a word, made by hand."""

from __future__ import annotations

import itertools
import string

import numpy as np
from numpy.typing import NDArray

from mpma_mj.context import one_hot
from mpma_mj.errors import BadOptionError
from mpma_mj.motions.key_poses import moves, whole_samples
from mpma_mj.motions.motion import Motion

__all__ = ["FLAGS", "POSITIONS", "REST", "normal_form", "pose", "semaphore", "signs_of"]

Array = NDArray[np.float64]

POSITIONS = {
    "across low": -45.0,
    "down": 0.0,
    "low": 45.0,
    "out": 90.0,
    "high": 135.0,
    "up": 180.0,
    "across high": 225.0,
}
"""Angle of an arm from hanging outwards, seen from the front, degrees; no flag is across out."""

REST = "rest"
NUMERALS, LETTERS = "numerals", "letters"

FLAGS = {
    "A": ("down", "low"),
    "B": ("down", "out"),
    "C": ("down", "high"),
    "D": ("down", "up"),
    "E": ("high", "down"),
    "F": ("out", "down"),
    "G": ("low", "down"),
    "H": ("across low", "out"),
    "I": ("across low", "high"),
    "J": ("out", "up"),
    "K": ("up", "low"),
    "L": ("high", "low"),
    "M": ("out", "low"),
    "N": ("low", "low"),
    "O": ("across high", "out"),
    "P": ("up", "out"),
    "Q": ("high", "out"),
    "R": ("out", "out"),
    "S": ("low", "out"),
    "T": ("up", "high"),
    "U": ("high", "high"),
    "V": ("low", "up"),
    "W": ("out", "across high"),
    "X": ("low", "across high"),
    "Y": ("out", "high"),
    "Z": ("out", "across low"),
    NUMERALS: ("high", "up"),
    REST: ("down", "down"),
}
"""Positions of the left and of the right flag, the signaller's own left and right.

A to G have one flag down while the other goes round; in the second circle (H, I, K to N), the
third (O to S) and the fourth (T, U, Y) one flag stays where it is in A, B and C; J, V and numerals
have one up; W and X have one at E and the other at F and G, where Z has both (Boy Scouts of America
1911, Boy Scouts Handbook, "The Semaphore Signal Code"). Which hand holds which: the list of the
Scout Notebook (web.ukonline.co.uk/scoutnotebook, "The Semaphore System"), in which hands cross
the body only to a diagonal. Its I is a misprint, as it is its K; that the left hand is at A in H
and I, and the right one from K on, say the 3rd Billericay Scouts (3rdbillericayscouts.org.uk,
"Semaphore").
"""

_ALPHABETIC = "J"  # pose of the sign after which letters follow
_NUMBERS = dict(zip("1234567890", "ABCDEFGHIK", strict=True))  # letters whose flags they have
_ALLOWED = f"{string.ascii_letters}{string.digits} "
_MOST = 60  # signs: 72 s, which is long for a motion that is learned as a whole (choice)

# The robot's arms (choice): straight but for 6°, since the rotation of an arm that is quite
# straight cannot be seen; a little in front of the body, and in front of head and chest where they
# cross it. Seen from the front the angles are exact.
_ELBOW = 0.1  # rad
_FORWARD = 0.15  # flexion, rad
_FORWARD_ACROSS = 0.65

_SECONDS_PER_SIGN = 1.2
_MOVING = 0.75  # share of it that the move to a sign takes; the rest is held (choice)
_LOWERED = np.pi / 3  # how far arms go towards rest between two equal signs, rad (choice)


def semaphore(word: str, rate: float = 20.0, tempo: float = 1.0) -> Motion:
    """Return the flags of a word, and of the rest that ends it.

    The motion is made by hand, not recorded: the arms point where a signaller's flags do, and
    minimum-jerk moves in joint space join the signs, 1.2 s each at tempo 1. Between two equal
    signs the arms are lowered for a moment, by 60°. A space is a rest, with hanging arms. Before
    digits stands the sign for numerals, and before letters that follow them the sign for letters.
    No shoulder winds: from across low to across high it goes round outside.

    Args:
        word: Letters A to Z of either case, digits, and spaces; several count as one.
        rate: Postures per second, Hz.
        tempo: Speed.

    Returns:
        The motion, named semaphore-WORD. Its labels are the signs, each once: letters, digits,
        numerals, letters and rest; the entry of a sign is 1 from the start of the move towards it
        to the end of its hold.

    Raises:
        BadOptionError: The word is empty, too long or has other signs; or it is so fast or so
            coarsely sampled that a sign has no two samples.
    """
    word = normal_form(word)
    signs = signs_of(word)
    samples = whole_samples(_SECONDS_PER_SIGN / tempo, "sign", rate, tempo)
    phase = np.arange(samples) / samples / _MOVING
    passed = [
        _again(key, phase) if np.array_equal(before, key) else moves([before, key], phase)
        for before, key in itertools.pairwise(map(pose, (REST, *signs)))
    ]
    labels = tuple(dict.fromkeys(signs))
    index = [labels.index(sign) for sign in signs]
    return Motion(
        posture=np.concatenate(passed),
        context=one_hot(np.repeat(index, samples), len(labels)),
        labels=labels,
        rate=rate,
        name=f"semaphore-{word.replace(' ', '-')}",
        source=f"made by hand: flag semaphore of {word}, minimum-jerk moves",
        tempo=tempo,
    )


def normal_form(word: str) -> str:
    """Return a word in capitals, with single spaces inside.

    Raises:
        BadOptionError: It is empty, too long, or has signs that semaphore lacks.
    """
    words = " ".join(word.split())
    allowed = "the letters A to Z, digits and spaces, such as semaphore:HELLO"
    if not words:
        raise BadOptionError(f"semaphore has no word; expected {allowed}")
    for sign in words:
        if sign not in _ALLOWED:
            raise BadOptionError(f"semaphore has no sign '{sign}'; expected {allowed}")
    count = len(signs_of(words.upper()))
    if count > _MOST:
        raise BadOptionError(
            f"semaphore:{words[:10]}… takes {count} signs, {count * _SECONDS_PER_SIGN:.0f} s, with"
            f" rests; expected at most {_MOST}, as a motion is learned as a whole; spell the words"
            " one by one, as a repertoire"
        )
    return words.upper()


def signs_of(word: str) -> tuple[str, ...]:
    """Return the signs of a word in normal form, with the rest that ends it."""
    signs: list[str] = []
    numbers = False
    for character in word:
        if character != " " and (character in _NUMBERS) != numbers:
            numbers = not numbers
            signs.append(NUMERALS if numbers else LETTERS)
        signs.append(REST if character == " " else character)
    return (*signs, REST)


def pose(sign: str) -> Array:
    """Return the joint angles of a sign, shape (8,), rad."""
    letter = _ALPHABETIC if sign == LETTERS else _NUMBERS.get(sign, sign)
    return np.concatenate([_arm(position) for position in FLAGS[letter]])


def _arm(position: str) -> Array:
    """Return the joint angles of an arm with its flag in a position, shape (4,), rad."""
    forward = _FORWARD_ACROSS if position.startswith("across") else _FORWARD
    return np.array([np.radians(POSITIONS[position]), forward, 0.0, _ELBOW])


def _again(key: Array, phase: Array) -> Array:
    """Return postures that lower the arms from a sign and raise them to it again, shape (T, 12)."""
    lowered = key.copy()
    abduction = key[0::4]
    lowered[0::4] -= np.sign(abduction) * np.minimum(_LOWERED, np.abs(abduction))
    half = phase < 0.5
    down = moves([key, lowered], 2.0 * phase[half])
    return np.concatenate([down, moves([lowered, key], 2.0 * phase[~half] - 1.0)])
