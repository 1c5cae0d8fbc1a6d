"""What tests of readers share."""

import pytest

from tests.motions.readers import writers


@pytest.fixture
def points() -> writers.Points:
    return writers.arm_points()
