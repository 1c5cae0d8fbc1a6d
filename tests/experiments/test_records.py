"""Records of runs: measures over seeds, and what is said about runs that did not end well."""

import math

import pytest

from mpma_mj.evaluation.statistics import MeanStd
from mpma_mj.experiments.records import (
    flat,
    matching,
    mean_std_over_seeds,
    measured,
    of_agent,
    over_seeds,
    remarks,
    value,
)
from tests.experiments.runs import diverged, finished


def test_measures_skip_what_is_not_there() -> None:
    records = [finished({}, nmi=nmi) for nmi in (0.2, 0.4, None)] + [diverged({})]
    assert measured(records, "nmi") == [0.2, 0.4]
    assert measured(records, "active_modules", "M") == [2.0] * 3
    assert mean_std_over_seeds(records, "nmi") == MeanStd(
        pytest.approx(0.3), pytest.approx(math.sqrt(0.02))
    )
    assert over_seeds(records, "nmi").mean == pytest.approx(0.3)
    assert math.isnan(over_seeds(records, "nothing", "here").mean)


def test_a_measure_of_nested_entries_is_their_mean() -> None:
    assert value(finished({}), "active_modules") == 1.5
    assert value(finished({}), "repeatability", "module_output") is None
    assert value(finished({}), "nmi", "Y") is None


def test_records_are_found_by_their_entries_and_agents_in_the_order_of_seeds() -> None:
    records = [finished({"nodes": nodes}, seed) for nodes in (5, 6) for seed in (1, 0)]
    assert [one["seed"] for one in matching(records, {"nodes": 6})] == [1, 0]
    assert [one["seed"] for one in of_agent(records, "mpma")] == [0, 0, 1, 1]
    assert of_agent(records, "random") == []


def test_runs_that_did_not_end_well_are_counted() -> None:
    again = finished({}) | {"attempts": 2}
    assert remarks([[finished({}), finished({})]], 1) == []
    assert remarks([[finished({})], [diverged({}), diverged({})], [again]], 5) == [
        "2 of 5 runs are missing, because their workers died or the command was stopped; resume"
        " with the same command.",
        "1 of 5 runs diverged; they count in no mean.",
        "1 of 5 runs were tried again, because their worker died.",
    ]


def test_nested_entries_get_their_path_as_name() -> None:
    assert flat({"a": {"b": 1, "c": {"d": 2}}, "e": 3}) == {"a.b": 1, "a.c.d": 2, "e": 3}


def test_a_measure_without_entries_has_no_value() -> None:
    assert value({"modules": {"Y": 1, "M": 3}}, "modules") == 2.0
    assert value({"modules": {}}, "modules") is None
    assert measured([{"modules": {}}, {"modules": {"Y": 1}}], "modules") == [1.0]
