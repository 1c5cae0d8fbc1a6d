from typing import Any

import numpy as np
import pytest

from mpma_mj.utils.saved_arrays import Expected, array_problem, assign, shared_count

OWN = np.array([[0.5, 1.0, 2.0]])
DAMAGED: list[Any] = [
    OWN[0],
    OWN.T,
    np.zeros(()),
    np.zeros((0, 3)),
    OWN + 0j,
    OWN.astype(np.float32),
    OWN.astype(">f8"),
    OWN.astype(str),
    OWN > 1.0,
    np.array([[None] * 3]),
    np.where(OWN > 1.0, np.nan, OWN),
    np.where(OWN > 1.0, np.inf, OWN),
    1e31 * OWN,
]


@pytest.mark.parametrize("value", DAMAGED)
def test_only_finite_numbers_of_the_same_shape_and_type_are_assigned(value: Any) -> None:
    array = OWN.copy()
    with pytest.raises(ValueError, match=r"in place of|a value that is not"):
        assign(array, value)
    np.testing.assert_array_equal(array, OWN)
    assign(array, 3.0 * OWN)
    np.testing.assert_array_equal(array, 3.0 * OWN)


def test_bounds_hold_and_nan_is_a_value_where_it_may_be() -> None:
    array = np.zeros(1)
    assign(array, np.array([np.nan]), nan=True)
    for value in (-0.1, 1.1):
        with pytest.raises(ValueError, match="not one from 0 to 1"):
            assign(array, np.array([value]), low=0.0, high=1.0)


def test_counts_are_not_negative() -> None:
    assert shared_count(np.full(2, 3), (2,)) == 3
    for value in (np.full(2, -1), np.full(3, 1), np.full(2, 1.0)):
        with pytest.raises(ValueError, match=r"in place of|a value that is not"):
            shared_count(value, (2,))


@pytest.mark.parametrize("value", DAMAGED[:-1])
def test_arrays_are_described(value: Any) -> None:
    expected = {"x": Expected((1, "n"), 2.0), "y": Expected(("n",), kinds="iu")}
    arrays = {"x": OWN, "y": np.arange(3)}
    assert array_problem(arrays, expected) == ""
    assert array_problem({"x": OWN}, expected) == "lacks y"
    assert "has y int64(4,)" in array_problem(arrays | {"y": np.arange(4)}, expected)
    assert "has a value in x" in array_problem(arrays | {"x": 2.0 * OWN}, expected)
    if value.dtype.kind not in "fiu" or value.shape != OWN.shape or not np.isfinite(value).all():
        assert " x " in array_problem(arrays | {"x": value}, expected)
