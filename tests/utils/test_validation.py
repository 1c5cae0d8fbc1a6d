from dataclasses import dataclass
from fractions import Fraction
from typing import Annotated, Any, Literal

import numpy as np
import pytest

from mpma_mj.errors import BadOptionError
from mpma_mj.utils.validation import Bounds, check_fields


@dataclass(frozen=True)
class Options:
    nodes: Annotated[int, Bounds(1, 100)] = 5
    ridge: Annotated[float, Bounds(0.0, 1.0, above=True, hint="per step")] = 0.5
    timestep: Annotated[float | None, Bounds(0.001, 1.0, hint="in s")] = None
    rule: Literal["weighted", "gated"] = "weighted"
    phase: bool = False
    start: bool | Literal["adaptive"] = False
    payload: Annotated[float, Bounds(0.0, 9.0, hint="in kg")] | tuple[float, float] = 0.0
    latency: Annotated[int, Bounds(0, 9)] | tuple[int, int] = 0
    name: str | None = None

    def __post_init__(self) -> None:
        check_fields(self)


@pytest.mark.parametrize(
    ("option", "value", "expected"),
    [
        ("nodes", 0, "a whole number from 1 to 100"),
        ("nodes", 101, "a whole number from 1 to 100"),
        ("nodes", 1.5, "a whole number from 1 to 100"),
        ("nodes", True, "a whole number from 1 to 100"),
        ("nodes", None, "a whole number from 1 to 100"),
        ("ridge", 0.0, "above 0, at most 1, per step"),
        ("ridge", float("nan"), "above 0, at most 1, per step"),
        ("ridge", "0.5", "above 0, at most 1, per step"),
        ("timestep", 2.0, "0.001 to 1, in s"),
        ("rule", "mine", "one of weighted, gated"),
        ("rule", 3, "one of weighted, gated"),
        ("phase", 1, "True or False"),
        ("start", "yes", "True or False, or adaptive"),
        ("payload", (3, 1), "0 to 9, in kg, or a range of two, the lowest first"),
        ("payload", (1, 10), "0 to 9, in kg, or a range of two, the lowest first"),
        ("payload", {1, 2}, "0 to 9, in kg, or a range of two, the lowest first"),
        ("latency", (1, 2.0), "a whole number from 0 to 9, or a range of two, the lowest first"),
    ],
)
def test_a_value_out_of_bounds_is_reported_as_data(option: str, value: Any, expected: str) -> None:
    with pytest.raises(BadOptionError) as caught:
        Options(**{option: value})
    assert (caught.value.option, caught.value.expected) == (option, expected)
    assert str(caught.value) == f"{option} is {value!r}; expected {expected}"


def test_values_are_kept_as_plain_ones_of_python() -> None:
    options = Options(np.int64(7), Fraction(1, 4), np.float32(0.5), phase=np.bool_(True))  # type: ignore[arg-type]
    assert (options.nodes, options.ridge, options.timestep, options.phase) == (7, 0.25, 0.5, True)
    kinds = [type(getattr(options, name)) for name in ("nodes", "ridge", "timestep", "phase")]
    assert kinds == [int, float, float, bool]


def test_ranges_are_kept_as_plain_tuples() -> None:
    options = Options(payload=np.array([1, 2]), latency=[np.int8(3), 3], start=np.bool_(True))  # type: ignore[arg-type]
    assert (options.payload, options.latency, options.start) == ((1.0, 2.0), (3, 3), True)
    assert [type(n) for n in (*options.payload, *options.latency)] == [float, float, int, int]  # type: ignore[misc]
    assert Options(payload=2, latency=1, start="adaptive").start == "adaptive"


def test_bounds_themselves_are_admitted_unless_excluded() -> None:
    assert Options(nodes=1).nodes == 1
    assert Options(nodes=100, ridge=1.0).ridge == 1.0


def test_what_is_not_declared_is_left_alone() -> None:
    assert Options(name=3).name == 3  # type: ignore[arg-type, comparison-overlap]
