import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from mpma_mj import kinematics
from mpma_mj.robots.branches import branches, nearest_branch, nearest_turns
from mpma_mj.robots.chain import Chain
from tests.robots.known_chains import CHAINS, LEFT, RIGHT, chains, random_chain, unit

angles_anywhere = arrays(np.float64, 4, elements=st.floats(-7.0, 7.0))
vectors = arrays(np.float64, (2, 3), elements=st.floats(-1.0, 1.0)).filter(
    lambda v: bool((np.linalg.norm(v, axis=1) > 1e-3).all())
)


def off(found: np.ndarray, angles: np.ndarray) -> float:
    """Return by how much the nearest branch is off angles, whatever their turns, rad."""
    return float(np.abs(kinematics.wrap(found - angles)).max(axis=-1).min(axis=-1).max())


@pytest.mark.parametrize("count", [1000, pytest.param(20_000, marks=pytest.mark.slow)])
def test_round_trip_on_random_chains(count: int) -> None:
    rng = np.random.default_rng(0)
    for _ in range(count):
        chain, angles = random_chain(rng), rng.uniform(-np.pi, np.pi, 4)
        directions, derivatives = chain.jacobian(angles)
        found = branches(chain, directions)
        assert found.fit.any()
        held = chain.directions(found.angles[found.fit])
        np.testing.assert_allclose(held, np.broadcast_to(directions, held.shape), atol=1e-9)
        if np.linalg.svd(derivatives, compute_uv=False)[-1] > 0.01:
            assert off(found.angles, angles) < 1e-9


@given(chains, vectors)
def test_branches_hold_any_directions_or_say_that_they_do_not(chain: Chain, v: np.ndarray) -> None:
    directions = unit(v).ravel()
    found = branches(chain, v.ravel())  # of vectors of any length
    deviation = np.abs(chain.directions(found.angles) - directions).max(axis=1)
    np.testing.assert_array_equal(found.exist, deviation <= 1e-9)
    assert found.within.all()  # a chain without ranges


@given(chains, arrays(np.float64, (2, 3, 4), elements=st.floats(-3.0, 3.0)))
def test_batches_are_what_single_postures_are(chain: Chain, angles: np.ndarray) -> None:
    directions = chain.directions(angles)
    batch = branches(chain, directions, angles + 0.1)
    assert batch.angles.shape == (2, 3, 4, 4)
    for place in np.ndindex(2, 3):
        single = branches(chain, directions[place], angles[place] + 0.1)
        np.testing.assert_array_equal(batch.exist[place], single.exist)
        if single.exist.all():
            np.testing.assert_allclose(batch.angles[place], single.angles, atol=1e-6)


@given(vectors, arrays(np.float64, 8, elements=st.floats(-7.0, 7.0)))
def test_the_closed_form_of_the_package_is_one_of_the_branches(
    v: np.ndarray, near: np.ndarray
) -> None:
    posture = np.tile(unit(v).ravel(), 2)
    expected = kinematics.angles_from_posture(posture, near)
    leverage = kinematics.segment_leverage(expected).min()  # errors are as large as it is small
    if 1e-10 < leverage < 1e-6:
        return  # regular for one, undefined for the other, or all but undefined
    for arm, chain in enumerate((LEFT, RIGHT)):
        own = slice(4 * arm, 4 * arm + 4)
        found = branches(chain, posture[:6], near[own])
        assert off(found.angles, expected[own]) < 1e-14 / max(leverage, 1e-6)


def test_the_closed_form_of_the_package_is_met_to_1e_14() -> None:
    rng = np.random.default_rng(0)
    angles = rng.uniform([0.0, -1.2, -3.0, 0.3] * 2, [3.0, 1.2, 3.0, 2.8] * 2, (1000, 8))
    posture = kinematics.posture_from_angles(angles)
    expected = kinematics.angles_from_posture(posture, angles)
    for arm, chain in enumerate((LEFT, RIGHT)):
        own = slice(4 * arm, 4 * arm + 4)
        found = branches(chain, posture.reshape(-1, 2, 6)[:, arm], angles[:, own])
        assert off(found.angles, expected[:, None, own]) < 1e-14


@pytest.mark.parametrize("bend", [0.0, np.pi])
@given(angles=angles_anywhere, near=angles_anywhere)
def test_a_straight_elbow_holds_its_rotation(
    bend: float, angles: np.ndarray, near: np.ndarray
) -> None:
    angles[3] = bend
    directions = LEFT.directions(angles)
    found = branches(LEFT, directions, near)
    assert found.exist.all()
    np.testing.assert_allclose(found.angles[:, 2], near[2], atol=1e-14)


@pytest.mark.parametrize("bend", [1.0, 0.0])
def test_an_upper_arm_along_the_first_axis_holds_the_first_angle(bend: float) -> None:
    directions = LEFT.directions(np.array([0.4, np.pi / 2, 0.3, bend]))
    found = branches(LEFT, directions, np.full(4, 0.7))
    assert found.exist.all()
    np.testing.assert_allclose(found.angles[:, 0], 0.7)


@given(
    chains,
    angles_anywhere,
    angles_anywhere,
    arrays(np.float64, 4, elements=st.floats(0.1, 9.0)),
)
def test_turns_are_within_the_ranges_where_possible(
    chain: Chain, angles: np.ndarray, lowest: np.ndarray, width: np.ndarray
) -> None:
    ranged = dataclasses.replace(chain, lowest=lowest, highest=lowest + width)
    found = nearest_turns(ranged, angles)
    turns = (found - angles) / (2.0 * np.pi)
    np.testing.assert_allclose(turns, np.round(turns), atol=1e-9)
    room = (angles - lowest) % (2.0 * np.pi)  # of the first turn above the lowest angle
    possible = (room <= width) & (room < 2.0 * np.pi - 1e-6)
    inside = (found >= lowest - 1e-8) & (found <= ranged.highest + 1e-8)
    np.testing.assert_array_equal(inside[possible], True)


@given(chains, angles_anywhere, angles_anywhere)
def test_turns_are_nearest_where_there_is_no_range(
    chain: Chain, angles: np.ndarray, near: np.ndarray
) -> None:
    assert (np.abs(nearest_turns(chain, angles, near) - near) <= np.pi + 1e-9).all()


@pytest.mark.parametrize("name", CHAINS)
def test_within_the_ranges_every_posture_is_found_again(name: str) -> None:
    chain, rng = CHAINS[name], np.random.default_rng(0)
    angles = rng.uniform(chain.lowest, chain.highest, (500, 4))
    directions = chain.directions(angles)
    found = nearest_branch(chain, directions, angles + rng.normal(0.0, 0.01, angles.shape))
    assert ((found >= chain.lowest) & (found <= chain.highest)).all()
    np.testing.assert_allclose(chain.directions(found), directions, atol=1e-7)
    regular = np.linalg.svd(chain.jacobian(angles)[1], compute_uv=False)[:, -1] > 0.2
    np.testing.assert_allclose(found[regular], angles[regular], atol=1e-6)
