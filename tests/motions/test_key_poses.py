import numpy as np
import pytest

from mpma_mj import kinematics
from mpma_mj.errors import BadOptionError
from mpma_mj.motions.key_poses import moves, whole_samples


def test_moves_begin_at_one_key_and_hold_the_next() -> None:
    keys = [np.full(8, angle) for angle in (0.1, 0.5, 0.2)]
    postures = moves(keys, np.array([0.0, 0.5, 1.0, 1.4]))
    expected = kinematics.posture_from_angles(
        np.repeat([0.1, 0.3, 0.5, 0.5, 0.5, 0.35, 0.2, 0.2], 8).reshape(-1, 8)
    )
    np.testing.assert_allclose(postures, expected, atol=1e-12)


def test_a_part_has_whole_samples_and_at_least_two() -> None:
    assert whole_samples(1.02, "letter", 10.0, 1.0) == 10
    with pytest.raises(BadOptionError, match=r"rate 2 and tempo 3 leave 1 sample\(s\) a letter"):
        whole_samples(0.5, "letter", 2.0, 3.0)
