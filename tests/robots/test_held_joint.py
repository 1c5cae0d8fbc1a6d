from collections.abc import Callable

import numpy as np
import pytest

from mpma_mj.kinematics import after_abduction, wrap
from mpma_mj.robots.held_joint import with_first, with_third
from tests.robots.known_chains import CHAINS, LEFT, random_chain

BOTH = pytest.mark.parametrize(("held", "joint"), [(with_first, 0), (with_third, 2)])
Held = Callable[..., np.ndarray]


@BOTH
def test_the_other_joints_are_found_where_the_directions_are_held(held: Held, joint: int) -> None:
    rng = np.random.default_rng(0)
    for _ in range(100):
        chain, angles = random_chain(rng), rng.uniform(-3.0, 3.0, (5, 4))
        found = held(chain, chain.directions(angles), angles[:, joint])
        off = np.sum((chain.directions(found) - chain.directions(angles)[:, None]) ** 2, axis=-1)
        assert off.min(axis=1).max() < 1e-12
        np.testing.assert_array_equal(found[..., joint], np.tile(angles[:, joint, None], 2))


# The third joint of "parallel" moves the upper arm as none of the others can.
@pytest.mark.parametrize("name", ["tilted", "narrow"])
@BOTH
def test_a_joint_that_is_a_little_off_costs_little(held: Held, joint: int, name: str) -> None:
    chain, rng = CHAINS[name], np.random.default_rng(0)
    angles = rng.uniform(chain.lowest, chain.highest, (200, 4))
    directions = chain.directions(angles)
    found = held(chain, directions, angles[:, joint] + 0.2)
    off = np.sum((chain.directions(found) - directions[:, None]) ** 2, axis=-1).min(axis=1)
    moved = angles + 0.2 * np.eye(4)[joint]
    as_it_was = np.sum((chain.directions(moved) - directions) ** 2, axis=-1)
    assert np.mean(off) < np.mean(as_it_was)


def test_an_abduction_that_is_held_gives_the_flexion_of_the_package() -> None:
    rng = np.random.default_rng(0)
    angles = rng.uniform([-3.0, -1.5, -3.0, 0.2], [3.0, 1.5, 3.0, 2.8], (100, 4))
    directions, held = LEFT.directions(angles), angles[:, 0] + 0.5
    found = with_first(LEFT, directions, held)
    flexion, *_ = after_abduction(directions, held)
    off = np.abs(wrap(found[..., 1] - flexion[:, None])).max()
    assert off < 1e-12


def test_a_rotation_that_is_held_leaves_the_upper_arm_in_its_place() -> None:
    rng = np.random.default_rng(0)
    angles = rng.uniform(-3.0, 3.0, (100, 4))
    directions = LEFT.directions(angles)
    found = with_third(LEFT, directions, angles[:, 2] + 0.7)
    shown = LEFT.directions(found)
    np.testing.assert_allclose(shown[..., :3], np.tile(directions[:, None, :3], (2, 1)), atol=1e-12)
    # No other elbow brings the forearm nearer.
    for bend in (-0.01, 0.01):
        moved = LEFT.directions(found + bend * np.eye(4)[3])
        goal = directions[:, None, 3:]
        nearer = np.sum((moved[..., 3:] - goal) ** 2, -1) < np.sum((shown[..., 3:] - goal) ** 2, -1)
        assert not nearer.any()
