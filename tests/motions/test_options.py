"""What reading options may not be is one line, whoever gives them."""

from typing import Any

import numpy as np
import pytest

from mpma_mj.errors import BadOptionError, MotionFileError
from mpma_mj.motions import Motion, read_motion, ymca


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"tempo": "fast"}, "tempo is 'fast'; expected 0.01 to 100"),
        ({"rate_in": "fast"}, "rate_in is 'fast'; expected 1 to 10000, Hz"),
        ({"max_gap": True}, "max_gap is True; expected 0 to"),
        ({"start": "1 s"}, "start is '1 s'; expected 0 to"),
        ({"segments": 2.5}, "segments is 2.5; expected a whole number"),
        ({"map": {"left_elbow": "E"}}, "map is .*; expected text such as"),
    ],
)
def test_options_of_other_types_are_refused(options: dict[str, Any], message: str) -> None:
    with pytest.raises(BadOptionError, match=message):
        read_motion("ymca", **options)


def test_a_context_outside_its_bounds_is_refused() -> None:
    motion = ymca()
    context = np.full(motion.context.shape, 7.0)
    with pytest.raises(MotionFileError, match=r"context contains a value outside \[0, 1\]"):
        Motion(motion.posture, context, motion.labels, motion.rate, "loud", "a test")
