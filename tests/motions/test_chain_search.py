import dataclasses

import numpy as np
import pytest

from mpma_mj.motions import ymca
from mpma_mj.motions.chain_search import starting_paths
from tests.motions.known_motions import singular
from tests.robots.known_chains import CHAINS, LEFT

STEP = np.array([0.5, 0.5, 0.85, 0.6])


@pytest.mark.parametrize("cyclic", [False, True])
@pytest.mark.parametrize("name", CHAINS)
def test_paths_are_within_the_ranges_and_near_the_directions(name: str, cyclic: bool) -> None:
    chain, directions = CHAINS[name], ymca().posture[:, :6]
    paths = starting_paths(directions, chain, STEP, 20.0, cyclic)
    for path in paths:
        assert path.shape == (len(directions), 4)
        assert ((path >= chain.lowest) & (path <= chain.highest)).all()
        assert np.abs(chain.directions(path) - directions).mean() < 0.12
    assert not np.array_equal(paths[0], paths[2])


def test_a_path_within_the_limits_is_followed_over_a_whole_turn() -> None:
    angles = np.tile([2.6, 0.4, -2.0, 1.0], (20, 1))
    angles[:, 0] += np.arange(20) * 0.05  # over π, where the principal value jumps
    wide = dataclasses.replace(LEFT, lowest=np.full(4, -4.0), highest=np.full(4, 4.0))
    for chain in (LEFT, wide):
        directions = chain.directions(angles)
        for path in starting_paths(directions, chain, STEP, 20.0, False)[:2]:
            np.testing.assert_allclose(chain.directions(path), directions, atol=1e-7)
            assert np.abs(np.diff(path, axis=0)).max() < 0.06


def test_any_rate_and_length_has_paths() -> None:
    chain = CHAINS["narrow"]
    for frames in (1, 2, 7):
        for rate in (1.0, 5.0, 300.0):
            for cyclic in (False, True):
                directions = singular(0).posture[:frames, :6]
                paths = starting_paths(directions, chain, STEP, rate, cyclic)
                assert {path.shape for path in paths} == {(frames, 4)}
