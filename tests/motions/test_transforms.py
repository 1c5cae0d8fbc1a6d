"""Movements made of another."""

import numpy as np

from mpma_mj import kinematics
from mpma_mj.motions.synthetic import invented, ymca
from mpma_mj.motions.transforms import mirrored, with_context_of


def test_mirrored_twice_is_the_same() -> None:
    dance = ymca()
    once = mirrored(dance)
    np.testing.assert_array_equal(mirrored(once).posture, dance.posture)
    assert np.abs(once.posture - dance.posture).max() > 0.5
    np.testing.assert_array_equal(once.context, dance.context)


def test_a_mirrored_dance_has_the_joint_angles_of_the_other_arm() -> None:
    dance = ymca()
    left, right = np.split(kinematics.angles_from_posture(dance.posture), 2, axis=1)
    mirror = kinematics.angles_from_posture(mirrored(dance).posture)
    np.testing.assert_allclose(kinematics.wrap(mirror - np.hstack([right, left])), 0.0, atol=1e-9)


def test_anothers_music_is_heard_for_the_same_shares_of_the_time() -> None:
    dance, music = invented(dance=3), ymca()
    danced = with_context_of(dance, music)
    np.testing.assert_array_equal(danced.posture, dance.posture)
    assert danced.labels == music.labels
    np.testing.assert_allclose(danced.context.mean(axis=0), music.context.mean(axis=0), atol=0.02)
    assert np.all(np.diff(danced.context.argmax(axis=1)) >= 0)
    same = with_context_of(music, music)
    np.testing.assert_array_equal(same.context, music.context)
