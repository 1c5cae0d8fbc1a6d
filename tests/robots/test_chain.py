import dataclasses
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from mpma_mj.errors import BadOptionError
from mpma_mj.kinematics import posture_from_angles, segment_jacobian
from mpma_mj.robots.chain import Chain
from tests.robots.known_chains import LEFT, RIGHT, chains

angles_anywhere = arrays(np.float64, (2, 4), elements=st.floats(-7.0, 7.0))


@given(angles_anywhere)
def test_the_arms_of_the_package_are_two_chains(angles: np.ndarray) -> None:
    posture = posture_from_angles(angles.ravel())
    for own, chain, expected in zip(angles, (LEFT, RIGHT), posture.reshape(2, 6), strict=True):
        np.testing.assert_allclose(chain.directions(own), expected, rtol=0.0, atol=1e-14)
    for found, known in zip(LEFT.jacobian(angles), segment_jacobian(angles), strict=True):
        np.testing.assert_allclose(found, known, rtol=0.0, atol=1e-14)


@given(chains, angles_anywhere)
def test_directions_are_unit_vectors_with_derivatives_of_theirs(
    chain: Chain, angles: np.ndarray
) -> None:
    directions, derivatives = chain.jacobian(angles)
    np.testing.assert_allclose(directions, chain.directions(angles), atol=1e-15)
    np.testing.assert_allclose(np.linalg.norm(directions.reshape(2, 2, 3), axis=2), 1.0)
    for joint, small in enumerate(1e-6 * np.eye(4)):
        ahead, behind = chain.directions(angles + small), chain.directions(angles - small)
        np.testing.assert_allclose(derivatives[..., joint], (ahead - behind) / 2e-6, atol=1e-8)


@given(chains, angles_anywhere)
def test_any_leading_axes_are_batches_of_single_postures(chain: Chain, angles: np.ndarray) -> None:
    batch = np.stack([angles, angles + 0.1, angles - 0.1])
    directions, derivatives = chain.jacobian(batch)
    assert derivatives.shape == (3, 2, 6, 4)
    for place in np.ndindex(3, 2):
        for found, single in zip(
            (directions[place], derivatives[place]), chain.jacobian(batch[place]), strict=True
        ):
            np.testing.assert_allclose(found, single, atol=1e-15)


def test_lengths_of_axes_and_directions_do_not_matter_and_are_copied() -> None:
    axes = 3.0 * LEFT.axes
    chain = dataclasses.replace(LEFT, axes=axes, forearm=0.2 * LEFT.forearm)
    axes[:] = 0.0
    np.testing.assert_allclose(chain.axes, LEFT.axes)
    np.testing.assert_allclose(chain.forearm, LEFT.forearm)


NAMES = ("l_pitch", "l_roll", "l_yaw", "l_elbow")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"axes": [[1, 0, 0], [-1, 0, 0.05], [0, 0, 1], [0, 1, 0]]},
            "l_pitch and l_roll turn about parallel axes; neighbouring joints",
        ),
        (
            {"axes": [[1, 0, 0], [0, 1, 0], [0, 1, 0], [1, 0, 0]]},
            "l_roll and l_yaw turn about parallel axes",
        ),
        ({"upper_arm": [0, 1, 0]}, "l_elbow cannot bend the elbow, as the upper arm points along"),
        ({"forearm": [0, -1, 0.05]}, "l_elbow cannot bend the elbow, as the forearm points along"),
        ({"forearm": [0, 0, 0]}, "forearm of a chain is zero or not finite"),
        ({"axes": np.full((4, 3), np.nan)}, "axes of a chain is zero or not finite"),
        ({"axes": np.eye(3)}, r"axes of a chain has shape \(3, 3\), not \(4, 3\)"),
        ({"lowest": [0, 0, 0.5, 0], "highest": [1, 1, 0.5, 1]}, "the range of l_yaw is empty: 0.5"),
        (
            {"lowest": [0, -1, 0, 0], "highest": [1, np.inf, 1, 1]},
            "the range of l_roll has one end",
        ),
        ({"lowest": [0, 0, np.nan, 0], "highest": np.ones(4)}, "the range of l_yaw is empty: nan"),
    ],
)
def test_a_chain_that_is_no_arm_is_refused(change: dict[str, Any], message: str) -> None:
    with pytest.raises(BadOptionError, match=f"^{message}") as refused:
        dataclasses.replace(LEFT, joints=NAMES, **change)
    assert "\n" not in str(refused.value)
