"""How runs are shared out among workers."""

import hypothesis
import hypothesis.strategies as st
import pytest

from mpma_mj.experiments.batching import cut
from mpma_mj.experiments.spec import by_point, without_seed
from tests.experiments.runs import spec_of

GRIDS = st.sampled_from([(), ("nodes=5,6",), ("nodes=5,6,7,8", "modules=1,2,3")])


@hypothesis.given(grid=GRIDS, runs=st.integers(1, 50), workers=st.integers(1, 30))
def test_every_run_is_in_one_crowd_of_its_like(
    grid: tuple[str, ...], runs: int, workers: int
) -> None:
    sweep = spec_of(*grid, runs=runs)
    batches = cut(sweep.configs, workers)
    assert sorted(c.seed for batch in batches for c in batch) == sorted(
        c.seed for c in sweep.configs
    )
    assert {c for batch in batches for c in batch} == set(sweep.configs)
    assert all(len({without_seed(config) for config in batch}) == 1 for batch in batches)
    assert max(map(len, batches)) <= 20
    assert len(batches) >= min(workers, len(sweep.configs), runs)
    sizes = [
        len(batch) * batch[0].option("modules") * batch[0].option("nodes") for batch in batches
    ]
    assert sizes == sorted(sizes, reverse=True)


@pytest.mark.parametrize(("workers", "sizes"), [(1, [20]), (2, [10, 10]), (3, [6, 7, 7])])
def test_few_points_are_cut_among_all_workers(workers: int, sizes: list[int]) -> None:
    sweep = spec_of("nodes=50,100,200,400", runs=20)
    batches = cut(sweep.configs, workers)
    for point in by_point(sweep.configs):
        assert sorted(len(c) for c in batches if without_seed(c[0]) == point) == sizes


def test_many_points_stay_whole() -> None:
    sweep = spec_of("nodes=1,2,3,4,5,6,7,8", runs=20)
    assert [len(batch) for batch in cut(sweep.configs, 2)] == [20] * 8


@pytest.mark.parametrize(("nodes", "largest"), [(200, 20), (400, 20), (1000, 9), (3000, 1)])
def test_crowds_of_large_networks_are_small(nodes: int, largest: int) -> None:
    sweep = spec_of(f"nodes={nodes}", "modules=4", runs=20)
    batches = cut(sweep.configs, 1)
    assert sorted(c.seed for batch in batches for c in batch) == list(range(20))
    assert max(map(len, batches)) <= largest
    assert len(batches) == -(-20 // largest)
    bytes_of_a_crowd = max(map(len, batches)) * 3 * 4 * (nodes + 40) ** 2 * 8
    assert bytes_of_a_crowd <= 1e9 or largest == 1
