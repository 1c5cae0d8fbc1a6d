"""What is said about what was found."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest

from mpma_mj.sysid import Identified
from mpma_mj.sysid.report import Estimate, Latency, as_markdown
from mpma_mj.utils.data_files import write_json

ANGLES = np.zeros((2, 3, 8))
ELBOW = Estimate("kv_elbow", np.array([20.0, 20.0]), 1.1, 0.01, 0.01)
FOREARM = Estimate("forearm_mass", np.array([1.6]), 1.25, 0.01, 0.0)
LATE = Latency(0.1, 0.0025, 0.05)


def result(*estimates: Estimate, late: Latency = LATE, missing: tuple[str, ...] = ()) -> Identified:
    off = ANGLES + np.radians(2.0)
    return Identified(estimates, missing, late, np.zeros((2, 3)), ANGLES, off, 0.5 * off)


def line(found: Identified, name: str) -> list[str]:
    """Return the cells of a parameter's row."""
    rows = [row.strip("| ").split(" | ") for row in as_markdown(found).splitlines()]
    return next(row for row in rows if row[0] == name)


def test_a_determined_parameter_has_its_value_and_interval_and_no_remark() -> None:
    found = result(ELBOW, FOREARM)
    assert line(found, "kv_elbow")[:5] == ["kv_elbow", "N m s/rad", "20", "22", "21.78 to 22.22"]
    assert "not determined" not in as_markdown(found)
    assert "2° before, 1° with what was found" in as_markdown(found)


def test_joints_that_differ_in_the_model_have_a_span() -> None:
    own = dataclasses.replace(ELBOW, model=np.array([20.0, 30.0]))
    assert line(result(own, FOREARM), "kv_elbow")[2:4] == ["20 … 30", "22 … 33"]


def test_what_is_known_only_in_ratio_is_said_so() -> None:
    scale = math.log(2.0)
    found = result(
        dataclasses.replace(ELBOW, half_width=scale), dataclasses.replace(FOREARM, half_width=scale)
    )
    assert line(found, "kv_elbow")[5] == (
        "not determined, but factor over forearm_mass's: 0.880 ± 1.0 %"
    )
    assert line(found, "forearm_mass")[5] == "not determined to ± 20 %"
    assert "their common scale is not" in as_markdown(found)


@pytest.mark.parametrize("width", [0.5, 10.0, 1000.0, math.inf])
def test_what_is_not_determined_is_said_so(width: float, tmp_path: Path) -> None:
    loose = dataclasses.replace(ELBOW, half_width=width, ratio_half_width=width)
    found = result(loose, FOREARM)
    row = line(found, "kv_elbow")
    assert row[5] == "not determined to ± 20 %"
    assert (row[4] == "anything") == (width > math.log(10.0))
    assert "common scale" not in as_markdown(found)
    write_json(tmp_path / "a.json", found.as_json())


def test_the_edge_of_the_search_is_no_result() -> None:
    edge = dataclasses.replace(ELBOW, factor=4.0)
    assert not edge.determined
    assert line(result(edge, FOREARM), "kv_elbow")[5].endswith("as far off the model as is looked")
    late = Latency(0.3, 0.0025, 0.05)
    assert line(result(ELBOW, late=late), "latency")[5].endswith("as long as is looked")


def test_a_latency_between_control_steps_is_told_with_the_nearest() -> None:
    between = Latency(0.065, 0.0075, 0.05)
    assert not between.is_integer
    assert line(result(ELBOW, late=between), "latency")[3:] == [
        "65",
        "57.5 to 72.5",
        "1.3 × the control step of 50 ms; load() takes whole ones, latency=1",
    ]
    assert Latency(0.001, 0.0025, 0.05).interval == (0.0, 0.0035)
    assert Latency(0.099, 0.0025, 0.05).is_integer


def test_parameters_that_are_0_in_the_model_are_told() -> None:
    assert "armature: 0 in the model, and left so" in as_markdown(
        result(ELBOW, missing=("armature",))
    )
