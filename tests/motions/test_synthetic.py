"""Invented dances: material of any amount that says what it is."""

import numpy as np
import pytest

from mpma_mj.envs.load import arm_limits
from mpma_mj.errors import BadOptionError
from mpma_mj.motions import read_motion
from mpma_mj.motions.feasibility import check_feasibility
from mpma_mj.motions.synthetic import DANCES, invented


def test_the_dances_in_a_row_are_the_whole() -> None:
    whole = invented()
    pieces = [invented(dance=number) for number in range(1, DANCES + 1)]
    assert np.array_equal(whole.posture, np.concatenate([piece.posture for piece in pieces]))
    assert whole.labels == tuple(label for piece in pieces for label in piece.labels)
    assert {piece.duration for piece in pieces} == {5.0}


def test_no_two_dances_are_alike() -> None:
    pieces = [invented(dance=number).posture for number in range(1, DANCES + 1)]
    apart = [np.abs(a - b).mean() for i, a in enumerate(pieces) for b in pieces[:i]]
    assert min(apart) > 0.1


def test_arms_can_follow_them() -> None:
    check_feasibility(invented(), *arm_limits("physics"))


def test_they_are_the_same_always_and_say_that_nobody_danced_them() -> None:
    motion = read_motion("invented-3")
    assert np.array_equal(motion.posture, invented(dance=3).posture)
    assert motion.name == "invented-3"
    assert "synthetic" in motion.source


def test_a_tempo_stretches_them() -> None:
    fast, slow = invented(dance=1), invented(tempo=0.5, dance=1)
    assert slow.duration == 2 * fast.duration
    assert slow.posture[::2] == pytest.approx(fast.posture)


def test_a_tempo_without_samples_is_refused() -> None:
    with pytest.raises(BadOptionError, match=r"leave 0 sample\(s\) a pose"):
        invented(tempo=100.0)
