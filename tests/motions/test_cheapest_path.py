import itertools

import numpy as np
import pytest

from mpma_mj.motions.cheapest_path import PathCost, cheapest_cycle, cheapest_path

STEP = np.array([0.3, 0.5])
ALL = PathCost(farthest=np.inf)


def cost_of(path: np.ndarray, distance: float, cost: PathCost, closed: bool = False) -> float:
    change = np.abs(np.diff(np.concatenate([path, path[:1]]) if closed else path, axis=0)) / STEP
    excess = np.maximum(change - cost.excess_from, 0.0)
    return distance + float(np.sum(cost.speed_weight * change**2 + cost.excess_weight * excess**2))


def cheapest_of_all(
    angles: np.ndarray, distance: np.ndarray, cost: PathCost, closed: bool
) -> float:
    frames, count, _ = angles.shape
    steps = np.arange(frames)
    return min(
        cost_of(angles[steps, list(places)], distance[steps, list(places)].sum(), cost, closed)
        for places in itertools.product(range(count), repeat=frames)
    )


def candidates(seed: int, frames: int = 5, count: int = 4) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    return rng.normal(0.0, 0.5, (frames, count, 2)), rng.uniform(0.0, 1.0, (frames, count))


def own_distance(path: np.ndarray, angles: np.ndarray, distance: np.ndarray) -> float:
    chosen = (angles == path[:, None]).all(axis=-1).argmax(axis=1)
    return float(distance[np.arange(len(path)), chosen].sum())


@pytest.mark.parametrize("cost", [ALL, PathCost(0.5, 1.0, 1.0, np.inf)])
@pytest.mark.parametrize("seed", range(5))
def test_no_path_is_cheaper(seed: int, cost: PathCost) -> None:
    angles, distance = candidates(seed)
    path = cheapest_path(angles, distance, STEP, cost)
    found = cost_of(path, own_distance(path, angles, distance), cost)
    assert found == pytest.approx(cheapest_of_all(angles, distance, cost, closed=False))


@pytest.mark.parametrize("seed", range(8))
def test_no_cycle_is_cheaper(seed: int) -> None:
    angles, distance = candidates(seed)
    path = cheapest_cycle(angles, distance, STEP, ALL)
    found = cost_of(path, own_distance(path, angles, distance), ALL, closed=True)
    assert found == pytest.approx(cheapest_of_all(angles, distance, ALL, closed=True))


def test_a_cycle_starts_where_it_ends() -> None:
    phase = np.arange(40) * 2.0 * np.pi / 40
    up = np.stack([np.sin(phase), np.cos(phase)], axis=1)
    angles = np.stack([up, up + 3.0], axis=1)
    distance = np.tile([0.0, 0.1], (40, 1))
    distance[0] = [5.0, 0.0]  # the other candidate is closer in the first step only
    assert cheapest_path(angles, distance, STEP, ALL)[0, 0] == 3.0
    np.testing.assert_array_equal(cheapest_cycle(angles, distance, STEP, ALL), up + 3.0)


def test_far_candidates_take_no_part() -> None:
    angles = np.array([[[0.0, 0.0], [1.0, 1.0]]] * 3)
    distance = np.array([[0.0, 1.0], [0.4, 0.0], [0.0, 1.0]])
    np.testing.assert_array_equal(
        cheapest_path(angles, distance, STEP)[:, 0],
        [0.0, 1.0, 0.0],  # of 0.4 above the least
    )
    np.testing.assert_array_equal(cheapest_path(angles, distance, STEP, ALL), 0.0)


def test_infinite_distance_excludes_a_candidate() -> None:
    angles = np.array([[[0.0, 0.0], [2.0, 2.0]]] * 3)
    distance = np.array([[0.0, 0.1], [np.inf, 0.1], [0.0, 0.1]])
    assert cheapest_path(angles, distance, STEP)[1, 0] == 2.0
