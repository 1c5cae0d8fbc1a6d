"""Options as they are typed, near matches, and lists."""

import dataclasses

import pytest

from mpma_mj.motions.options import ReadingOptions
from mpma_mj.utils.text import did_you_mean, field_name, listing, option_name


@pytest.mark.parametrize("name", [field.name for field in dataclasses.fields(ReadingOptions)])
def test_an_option_has_one_name_in_python_and_one_on_the_command_line(name: str) -> None:
    assert field_name(option_name(name)) == name


def test_a_question_names_the_nearest_of_the_known_or_is_empty() -> None:
    known = ("payload", "latency")
    assert did_you_mean("paylaod", known) == "did you mean payload?"
    assert did_you_mean("paylaod", known, "{{{}}}") == "did you mean {payload}?"
    assert did_you_mean("gravity", known) == ""
    options = ("lookahead", "locked_joint", "robot", "actuator_strength", "random_start")
    assert did_you_mean("locked", options) == "did you mean locked_joint?"
    assert did_you_mean("strength", options) == "did you mean actuator_strength?"
    assert did_you_mean("delay", options) == did_you_mean("", options) == ""


def test_a_list_counts_what_it_does_not_write_out() -> None:
    assert listing(["a", "b"], 2) == "a, b"
    assert listing(["a", "b", "c", "d"], 1) == "a and 3 more"
    assert listing([1, 2, 3], 2) == "1, 2 and 1 more"
