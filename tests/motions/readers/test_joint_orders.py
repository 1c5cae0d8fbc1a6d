"""Skeletons known by their number of joints are found by their arms and trunk, or not at all."""

import numpy as np
import pytest
from numpy.typing import NDArray

from mpma_mj.motions.marker_sets import choose_markers
from mpma_mj.motions.readers.joint_orders import JointOrder, find_order, known_orders
from tests.motions.readers.writers import body_joints

COUNTS = (17, 18, 19, 20, 22, 24, 25, 32, 33, 45, 52, 55, 75, 127, 133, 543, 553)
ORDERS = [(order, count) for count in COUNTS for order in known_orders(count)]


def of(order: JointOrder, count: int) -> NDArray[np.float64]:
    """Return a body in an order, shape (T, count, 3)."""
    return body_joints(order.names(count))


@pytest.mark.parametrize(("order", "count"), ORDERS, ids=lambda value: str(value)[:40])
def test_a_skeleton_is_found_among_those_of_its_count(order: JointOrder, count: int) -> None:
    assert find_order(of(order, count)) == order


@pytest.mark.parametrize(("order", "count"), ORDERS, ids=lambda value: str(value)[:40])
def test_its_names_are_recognised(order: JointOrder, count: int) -> None:
    names = order.names(count)
    assert len(set(names)) == len(names) == count
    groups = choose_markers("a.npy", names, {})  # type: ignore[arg-type]  # for messages
    assert {point: "+".join(group) for point, group in groups.items() if "_" in point} == {
        f"{side}_{part}": f"{side}_{part}"
        for side in ("left", "right")
        for part in ("shoulder", "elbow", "wrist")
    }
    assert {"pelvis", "neck"} <= groups.keys()


def test_joints_in_another_order_are_none_of_them() -> None:
    rng = np.random.default_rng(0)
    for order, count in ORDERS:
        points = of(order, count)
        moved = points[:, np.roll(np.arange(count), 1)]
        assert find_order(moved) is None, order.name
        shuffled = points[:, rng.permutation(count)]
        assert find_order(shuffled) is None, order.name


def test_an_arm_that_is_never_seen_is_no_skeleton() -> None:
    points = of(known_orders(22)[0], 22)
    points[:, 18] = np.nan
    assert find_order(points) is None


def test_an_arm_whose_length_varies_is_no_skeleton() -> None:
    points = of(known_orders(22)[0], 22)
    for elbow, wrist in ((18, 20), (19, 21)):
        forearm = points[:, wrist] - points[:, elbow]
        points[:, wrist] = (
            points[:, elbow] + forearm * np.where(np.arange(60) % 2, 0.6, 1.2)[:, None]
        )
    assert find_order(points) is None


def test_shoulders_along_the_trunk_are_no_skeleton() -> None:
    order = known_orders(22)[0]
    points = of(order, 22)
    shoulders = points[:, 16:18]
    across, up = shoulders[:, :1] - shoulders[:, 1:], np.array([0.0, 0.0, 1.0])
    turned = np.array([0.5, -0.5])[:, None] * np.linalg.norm(across, axis=2, keepdims=True) * up
    moved = shoulders.mean(axis=1, keepdims=True) + turned - shoulders  # (T, 2, 3)
    for part in (16, 18, 20):
        points[:, part : part + 2] += moved
    points[:, 1:3] = points[:, 1:3].mean(axis=1, keepdims=True) + turned  # the flanks stay alike
    assert find_order(points) is None


def test_joints_that_are_lost_for_a_while_do_not_matter() -> None:
    points = of(known_orders(22)[0], 22)
    points[5:20, 18] = np.nan
    assert find_order(points) == known_orders(22)[0]
