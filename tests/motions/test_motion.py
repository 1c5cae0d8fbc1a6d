import dataclasses

import numpy as np
import pytest

from mpma_mj.errors import MotionFileError
from mpma_mj.motions import Motion, ymca


def test_a_motion_knows_its_duration() -> None:
    motion = ymca()
    assert motion.duration == pytest.approx(len(motion) / 20.0)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"posture": np.ones((1, 12)) / np.sqrt(3)}, "at least two"),
        ({"posture": np.ones((76, 11))}, r"posture has shape \(76, 11\), expected \(76, 12\)"),
        ({"posture": np.ones((76, 12))}, "not length 1"),
        ({"posture": np.full((76, 12), np.nan)}, "not finite"),
        ({"context": np.ones((76, 3))}, r"context has shape \(76, 3\), expected \(76, 4\)"),
    ],
)
def test_what_is_no_motion_is_refused(change: dict[str, np.ndarray], message: str) -> None:
    with pytest.raises(MotionFileError, match=message):
        dataclasses.replace(ymca(), **change)


def test_a_motion_cannot_be_changed() -> None:
    with pytest.raises(dataclasses.FrozenInstanceError):
        ymca().rate = 10.0  # type: ignore[misc]


def test_motion_is_exported() -> None:
    import mpma_mj

    assert mpma_mj.Motion is Motion
