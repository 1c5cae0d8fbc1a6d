import dataclasses

import numpy as np
import pytest

from mpma_mj.robots.branches import branches, nearest_branch
from mpma_mj.robots.nearest_posture import nearest_posture
from tests.robots.known_chains import CHAINS, LEFT, unit


def anywhere(count: int) -> np.ndarray:
    vectors = unit(np.random.default_rng(0).normal(size=(count, 2, 3)))
    return vectors.reshape(count, 6)


@pytest.mark.parametrize("name", CHAINS)
def test_no_posture_within_the_ranges_is_nearer_than_that_of_no_branch(name: str) -> None:
    chain, rng, directions = CHAINS[name], np.random.default_rng(1), anywhere(300)
    near = rng.uniform(chain.lowest, chain.highest, (300, 4))
    found = nearest_branch(chain, directions, near)
    assert ((found >= chain.lowest) & (found <= chain.highest)).all()
    beyond = ~branches(chain, directions, near).fit.any(axis=1)
    assert 0.1 < beyond.mean() < 1.0
    distance = np.sum((chain.directions(found) - directions) ** 2, axis=1)
    assert distance[~beyond].max() < 1e-15
    starts = rng.uniform(chain.lowest, chain.highest, (20, *near.shape))
    others = nearest_posture(chain, np.broadcast_to(directions, (20, *directions.shape)), starts)[1]
    nearer = others.min(axis=0) < distance - 1e-6
    assert nearer.mean() < 0.03  # it is a local minimum there


def test_it_is_a_minimum_of_each_posture_for_itself() -> None:
    chain, rng, directions = CHAINS["narrow"], np.random.default_rng(1), anywhere(200)
    angles, distance = nearest_posture(chain, directions, np.full((200, 4), 0.1))
    np.testing.assert_allclose(
        distance, np.sum((chain.directions(angles) - directions) ** 2, axis=1)
    )
    for _ in range(50):
        tried = np.clip(angles + rng.normal(0, 0.01, angles.shape), chain.lowest, chain.highest)
        assert (
            np.sum((chain.directions(tried) - directions) ** 2, axis=1) >= distance - 1e-7
        ).all()
    alone = [nearest_posture(chain, one, np.full(4, 0.1))[0] for one in directions[:20]]
    np.testing.assert_allclose(angles[:20], alone, atol=1e-5)


def test_an_elbow_that_bends_too_far_stops_at_its_range() -> None:
    chain = dataclasses.replace(
        LEFT, lowest=np.array([-4.0, -4, -4, 0]), highest=np.array([4.0, 4, 4, 2.5])
    )
    directions = LEFT.directions(np.array([0.5, 0.3, 0.2, 2.9]))[None]
    found = nearest_branch(chain, directions, np.array([[0.5, 0.3, 0.2, 2.5]]))
    assert found[0, 3] == 2.5
    # Both segments turn by half of what is missing, by any of many rotations.
    off = np.sum(chain.directions(found).reshape(2, 3) * directions.reshape(2, 3), axis=1)
    np.testing.assert_allclose(np.arccos(off), 0.2, atol=1e-4)
