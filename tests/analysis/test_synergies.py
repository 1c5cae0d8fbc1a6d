import numpy as np
import pytest
from numpy.typing import NDArray

from mpma_mj.analysis.synergies import (
    factorise,
    find_synergies,
    halves,
    variance_accounted_for,
)

Array = NDArray[np.float64]

RNG = np.random.default_rng(0)


def of_joints(joints: int) -> Array:
    """Return outputs of two modules, the first driving joint 0, the second all others in turn."""
    output = np.zeros((60, 2, 8))
    for step in range(60):
        joint = step % joints
        output[step, min(joint, 1), joint] = 1.0 - 0.001 * joint
    return output


def test_halves_are_what_is_positive_and_what_is_negative() -> None:
    assert halves(np.array([[0.3, -0.2]])) == pytest.approx(np.array([[0.3, 0.0, 0.0, 0.2]]))


@pytest.mark.parametrize("rank", [1, 3, 5])
def test_outputs_of_as_many_joints_need_as_many_synergies(rank: int) -> None:
    found = find_synergies(of_joints(rank))
    assert len(found.weights) == len(found.patterns) == len(found.loads) == rank
    assert found.variance_accounted_for[:rank] == pytest.approx(np.arange(1, rank + 1) / rank, 0.01)


def test_both_directions_of_a_joint_are_two_synergies() -> None:
    output = np.zeros((40, 1, 8))
    output[::2, 0, 2], output[1::2, 0, 2] = 0.5, -0.5
    found = find_synergies(output)
    assert sorted(found.patterns.argmax(axis=1).tolist()) == [2, 8 + 2]


def test_joints_that_are_driven_together_are_one_synergy() -> None:
    strength = RNG.uniform(0.1, 1, size=50)
    pattern = np.array([0.6, -0.8, 0, 0, 0, 0, 0, 0])
    found = find_synergies(strength[:, None, None] * pattern)
    assert len(found.weights) == 1
    assert found.patterns[0] == pytest.approx(halves(pattern), abs=1e-6)


def test_a_synergy_loads_on_the_module_that_uses_it() -> None:
    found = find_synergies(of_joints(2))
    assert found.loads[found.patterns[:, 0].argmax()] == pytest.approx([1.0, 0.0], abs=1e-3)
    assert found.loads[found.patterns[:, 1].argmax()] == pytest.approx([0.0, 1.0], abs=1e-3)
    assert found.loads.sum(axis=1) == pytest.approx(1.0)
    assert found.weights.sum() == pytest.approx(1.0)


def test_a_synergy_that_all_modules_use_loads_on_all() -> None:
    output = np.zeros((30, 3, 8))
    output[:, :, 4] = RNG.uniform(0.1, 1, size=(30, 1)) * [0.5, 0.3, 0.2]
    assert find_synergies(output).loads == pytest.approx(np.array([[0.5, 0.3, 0.2]]), abs=1e-3)


def test_permuting_modules_permutes_loads_alone() -> None:
    output = of_joints(3) + 0.02 * RNG.normal(size=(60, 2, 8))
    found, swapped = find_synergies(output), find_synergies(output[:, ::-1])
    assert swapped.loads == pytest.approx(found.loads[:, ::-1], abs=1e-3)
    assert swapped.patterns == pytest.approx(found.patterns, abs=1e-3)


def test_equal_outputs_give_equal_synergies_the_strongest_first() -> None:
    output = RNG.normal(size=(40, 2, 8))
    found, again = find_synergies(output), find_synergies(output)
    assert np.array_equal(found.loads, again.loads)
    assert np.array_equal(found.variance_accounted_for, again.variance_accounted_for)
    assert (np.diff(found.weights) <= 0).all()


def test_all_that_is_there_is_accounted_for_by_as_many_factors_as_columns() -> None:
    samples = halves(RNG.normal(size=(100, 2)))
    assert variance_accounted_for(samples, *factorise(samples, 4)) > 0.995
    assert variance_accounted_for(samples, np.zeros((100, 1)), np.zeros((1, 4))) == 0.0
