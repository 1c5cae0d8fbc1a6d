"""Kinematics of arms: laws that hold for any robot."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mpma_mj import joint_paths, kinematics
from mpma_mj.arm_kinematics import TWO_ARMS, ArmKinematics
from mpma_mj.feedback import joint_error
from mpma_mj.robots.chain import Chain
from mpma_mj.robots.chain_arms import ChainArms

SEEDS = st.integers(0, 2**32 - 1)
# Axes that do not meet at right angles, and ranges on some joints.
AXES = [[0.0, 1.0, 0.1], [1.0, 0.1, 0.0], [0.0, 0.2, 1.0], [0.1, 1.0, 0.0]]
LOWEST, HIGHEST = [-2.5, -np.inf, -2.0, -0.2], [2.5, np.inf, 2.0, 2.4]


def chain(side: float, **changes: object) -> Chain:
    own = {"axes": AXES, "upper_arm": [0.0, 0.1 * side, -1.0], "forearm": [0.2, 0.0, -1.0]}
    return Chain(**(own | {"lowest": LOWEST, "highest": HIGHEST} | changes))  # type: ignore[arg-type]


CHAINS = ChainArms("skew", chain(1.0), chain(-1.0))
ARMS = pytest.mark.parametrize("arms", [TWO_ARMS, CHAINS], ids=["two_arm", "skew"])


def regular(seed: int, count: int = 5) -> np.ndarray:
    """Return joint angles within all ranges, away from singular postures, shape (count, 8), rad."""
    rng = np.random.default_rng(seed)
    low, high = np.array([-1.0, -1.0, -1.0, 0.5]), np.array([1.0, 1.0, 1.0, 2.0])
    return rng.uniform(np.tile(low, 2), np.tile(high, 2), (count, 8))


@ARMS
@given(seed=SEEDS)
def test_the_angles_of_a_posture_hold_it(arms: ArmKinematics, seed: int) -> None:
    angles = regular(seed)
    near = angles + np.random.default_rng(seed).uniform(-0.05, 0.05, angles.shape)
    np.testing.assert_allclose(arms.angles(arms.posture(angles), near), angles, atol=1e-7)


@ARMS
@given(seed=SEEDS)
def test_a_step_leads_to_the_same_posture(arms: ArmKinematics, seed: int) -> None:
    goal, near = regular(seed), regular(seed + 1)
    reached = near + arms.step_to(goal, near)
    np.testing.assert_allclose(arms.posture(reached), arms.posture(goal), atol=1e-9)
    np.testing.assert_array_equal(joint_error(near, goal, arms), arms.step_to(goal, near))


@ARMS
@given(seed=SEEDS)
def test_a_correction_leads_toward_a_posture(arms: ArmKinematics, seed: int) -> None:
    near = regular(seed)
    goal = near + np.random.default_rng(seed).uniform(-0.1, 0.1, near.shape)
    posture = arms.posture(goal)
    for arm in (slice(0, 6), slice(6, 12)):
        before, after = (
            np.linalg.norm((arms.posture(angles) - posture)[:, arm], axis=1)
            for angles in (near, near + arms.correction(posture, near))
        )
        assert (after < before).all()
    np.testing.assert_array_equal(joint_error(near, posture, arms), arms.correction(posture, near))


@ARMS
@given(seed=SEEDS)
def test_a_continuation_holds_the_same_posture(arms: ArmKinematics, seed: int) -> None:
    (angles,), (near,) = regular(seed, 1), 6.0 * regular(seed + 1, 1)
    sign, offset = arms.continuation(angles, near)
    continued = sign * angles + offset
    np.testing.assert_allclose(arms.posture(continued), arms.posture(angles), atol=1e-9)
    np.testing.assert_allclose(continued, near + arms.step_to(angles, near), atol=1e-9)


def test_two_arms_are_the_closed_forms() -> None:
    rng = np.random.default_rng(0)
    angles, near = rng.uniform(-3.0, 3.0, (2, 20, 8))
    posture = kinematics.posture_from_angles(angles)
    np.testing.assert_array_equal(TWO_ARMS.posture(angles), posture)
    solved = kinematics.angles_from_posture(posture, near=near)
    np.testing.assert_array_equal(TWO_ARMS.angles(posture, near), solved)
    step = joint_paths.nearest_turn(angles, near=near)
    np.testing.assert_array_equal(TWO_ARMS.step_to(angles, near), step)


def test_a_joint_with_a_range_does_not_turn_through_its_limits() -> None:
    near, goal = np.zeros(8), np.zeros(8)
    near[[0, 1]], goal[[0, 1]] = -2.4, 2.4
    step = CHAINS.step_to(goal, near)
    assert step[0] == pytest.approx(4.8)  # joint 2 has no range, joint 1 has
    assert step[1] == pytest.approx(4.8 - 2.0 * np.pi)


def test_a_correction_stays_within_the_ranges() -> None:
    limit = np.tile([2.5, 0.0, 2.0, 2.4], 2)
    beyond = CHAINS.posture(limit + 0.3)
    reached = limit + CHAINS.correction(beyond, limit)
    assert (reached <= np.tile(HIGHEST, 2) + 1e-12).all()


def test_other_geometry_is_another_name() -> None:
    same = ChainArms("skew", chain(1.0), chain(-1.0))
    assert same == CHAINS
    assert hash(same) == hash(CHAINS)
    for changes in ({"forearm": [0.21, 0.0, -1.0]}, {"highest": [2.5, np.inf, 2.0, 2.3]}):
        other = ChainArms("skew", chain(1.0, **changes), chain(-1.0))
        assert other != CHAINS
        assert other.name != CHAINS.name
