"""Built-in motions by name: NAME, or NAME:WORD where a motion spells a word."""

from __future__ import annotations

import functools
from collections.abc import Callable
from pathlib import Path

from mpma_mj.errors import UnknownMotionError
from mpma_mj.motions.choreographies import conductor, wave
from mpma_mj.motions.motion import Motion
from mpma_mj.motions.semaphore import normal_form, semaphore
from mpma_mj.motions.synthetic import SYNTHETIC_MOTIONS, synthetic_motion, ymca
from mpma_mj.utils.text import did_you_mean

__all__ = ["BUILT_IN", "HAND_MADE", "built_in", "file_stem", "unknown_motion"]

Maker = Callable[[float, float], Motion]

BUILT_IN: dict[str, Maker] = {
    "ymca": ymca,
    "wave": wave,
    "conductor": conductor,
    "synthetic": synthetic_motion,
    **{
        f"synthetic-{n}": functools.partial(synthetic_motion, number=n)
        for n in range(1, SYNTHETIC_MOTIONS + 1)
    },
}
"""Built-in motions by name, given rate in Hz and tempo; there is also semaphore:WORD."""

_SPELLING = "semaphore"

HAND_MADE = f"ymca, wave, conductor, {_SPELLING}:WORD"
"""Built-in motions made by hand, as help texts and errors name them."""


def built_in(source: str | Path) -> Maker | None:
    """Return what makes a built-in motion, given rate in Hz and tempo; None for a path.

    A file or folder of such a name is read as ./NAME, given as text.

    Args:
        source: A name of `BUILT_IN`, semaphore:WORD, or a path.

    Raises:
        BadOptionError: Semaphore has no word, or one that it cannot spell.
    """
    word = _word(str(source))
    if word is not None:
        return functools.partial(semaphore, normal_form(word))
    return BUILT_IN.get(str(source))


def file_stem(source: str) -> str:
    """Return what files and folders of a motion are called: semaphore-A-B of semaphore:A b."""
    word = _word(source)
    if word is not None:
        return "-".join([_SPELLING, *normal_form(word).split()])
    return Path(source).stem


def _word(source: str) -> str | None:
    """Return the word of semaphore:WORD, empty where it is missing; None for something else."""
    name, _, word = source.partition(":")
    is_path = "/" in word and Path(source).exists()  # such as a file in the folder ./semaphore:A
    return word if name == _SPELLING and not is_path else None


def unknown_motion(source: object, kind: str = "motion", others: str = "") -> UnknownMotionError:
    """Return the error of a name that is neither of a built-in motion nor of a file.

    Args:
        source: The name.
        kind: What was expected.
        others: What may be given besides, before the built-in motions.
    """
    name, _, word = str(source).partition(":")
    spelled = f"{_SPELLING}:{word if word.isalnum() else 'WORD'}"
    return UnknownMotionError(
        f"no {kind} '{source}'; expected {others}{HAND_MADE}, synthetic, synthetic-1 to"
        f" synthetic-{SYNTHETIC_MOTIONS}, or the path of a recording",
        remedy=did_you_mean(name, [*BUILT_IN, _SPELLING]).replace(_SPELLING, spelled),
    )
