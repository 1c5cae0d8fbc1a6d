"""Real recordings, where MPMA_MOCAP names a folder that has them."""

from pathlib import Path

import numpy as np
import pytest

from mpma_mj.envs.load import load
from mpma_mj.errors import MotionFileError
from mpma_mj.motions import read_motion


def test_the_qualisys_dance_is_read_whole(mocap: Path) -> None:
    motion = read_motion(mocap / "qualisys_tsv" / "dance.tsv")
    assert motion.posture.shape == (500, 12)
    assert motion.duration == pytest.approx(25.0)
    # A dancer's hands are mostly below the shoulders and in front.
    forearms = motion.posture.reshape(-1, 4, 3)[:, 1::2]
    assert forearms[..., 0].mean() > 0.2
    assert np.abs(np.diff(motion.posture, axis=0)).max() < 0.5


def test_the_gap_in_the_qualisys_walk_is_refused_by_name(mocap: Path) -> None:
    path = mocap / "qualisys_tsv" / "walk.tsv"
    with pytest.raises(MotionFileError, match="Shoulder_R is missing in frames 305 to 320"):
        read_motion(path)
    motion = read_motion(path, max_gap=0.3)
    assert motion.posture.shape == (117, 12)
    # Walking: upper arms hang.
    assert (motion.posture.reshape(-1, 4, 3)[:, ::2, 2] < -0.6).all()


def test_both_can_be_danced(mocap: Path) -> None:
    for name in ("dance", "walk"):
        motion = read_motion(mocap / "qualisys_tsv" / f"{name}.tsv", max_gap=0.3)
        assert load(motion).reset().first()
