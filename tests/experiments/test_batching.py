"""How runs are shared out among workers."""

import dataclasses

import hypothesis
import hypothesis.strategies as st
import pytest

from mpma_mj.errors import BadOptionError
from mpma_mj.experiments.batching import cut, pieces, seeds, without_seed
from mpma_mj.experiments.sweep import points
from mpma_mj.training.config import RunConfig
from tests.experiments.runs import TINY

GRIDS = st.sampled_from([(), ("nodes=5,6",), ("nodes=5,6,7,8", "modules=1,2,3")])


def configs_of(*grid: str, runs: int = 2) -> list[RunConfig]:
    return [run for point in points(grid, TINY) for run in seeds(point, runs)]


@hypothesis.given(grid=GRIDS, runs=st.integers(1, 50), workers=st.integers(1, 30))
def test_every_run_is_in_one_batch_of_its_like(
    grid: tuple[str, ...], runs: int, workers: int
) -> None:
    configs = configs_of(*grid, runs=runs)
    batches = cut(configs, workers)
    assert sorted(c.seed for batch in batches for c in batch) == sorted(c.seed for c in configs)
    assert {c for batch in batches for c in batch} == set(configs)
    assert all(len({without_seed(config) for config in batch}) == 1 for batch in batches)
    assert max(map(len, batches)) <= 20
    assert len(batches) >= min(workers, len(configs), runs)
    sizes = [
        len(batch) * batch[0].option("modules") * batch[0].option("nodes") for batch in batches
    ]
    assert sizes == sorted(sizes, reverse=True)


@pytest.mark.parametrize(("workers", "sizes"), [(1, [20]), (2, [10, 10]), (3, [6, 7, 7])])
def test_few_points_are_cut_among_all_workers(workers: int, sizes: list[int]) -> None:
    configs = configs_of("nodes=50,100,200,400", runs=20)
    batches = cut(configs, workers)
    for point in points(["nodes=50,100,200,400"], TINY):
        assert sorted(len(c) for c in batches if without_seed(c[0]) == point) == sizes


def test_many_points_stay_whole() -> None:
    configs = configs_of("nodes=1,2,3,4,5,6,7,8", runs=20)
    assert [len(batch) for batch in cut(configs, 2)] == [20] * 8


@pytest.mark.parametrize(("nodes", "largest"), [(200, 20), (400, 20), (1000, 9), (3000, 1)])
def test_batches_of_large_networks_are_small(nodes: int, largest: int) -> None:
    configs = configs_of(f"nodes={nodes}", "modules=4", runs=20)
    batches = cut(configs, 1)
    assert sorted(c.seed for batch in batches for c in batch) == list(range(20))
    assert max(map(len, batches)) <= largest
    assert len(batches) == -(-20 // largest)
    bytes_of_a_batch = max(map(len, batches)) * 3 * 4 * (nodes + 40) ** 2 * 8
    assert bytes_of_a_batch <= 1e9 or largest == 1


def test_nothing_is_cut_into_nothing() -> None:
    assert pieces([], 3) == []
    assert [len(batch) for batch in pieces(seeds(TINY, 2), 5)] == [1, 1]


def test_runs_of_a_point_have_seeds_from_its_own_up() -> None:
    point = TINY.replace(seed=3)
    assert [run.seed for run in seeds(point, 3)] == [3, 4, 5]
    assert {dataclasses.replace(run, seed=3) for run in seeds(point, 3)} == {point}
    with pytest.raises(BadOptionError, match="runs is 0; expected at least 1"):
        seeds(TINY, 0)
