import copy
import pickle

import pytest

from mpma_mj.errors import BadOptionError, MpmaError


def flag(option: str, value: str | None) -> str:
    return f"--{option.replace('_', '-')}" + ("" if value is None else f" {value}")


def test_an_error_names_options_in_the_language_of_its_reader() -> None:
    error = MpmaError("a gap of 0.4 s", remedy="bridge it with {max_gap=0.4}, or drop {start}")
    assert str(error) == "a gap of 0.4 s; bridge it with max_gap=0.4, or drop start"
    assert error.describe(flag) == "a gap of 0.4 s; bridge it with --max-gap 0.4, or drop --start"


def test_a_bad_option_is_data() -> None:
    error = BadOptionError(option="max_gap", value=-1, expected="0 or more", remedy="drop {repair}")
    assert (error.option, error.value, error.expected) == ("max_gap", -1, "0 or more")
    assert str(error) == "max_gap is -1; expected 0 or more; drop repair"
    assert error.describe(flag) == "--max-gap is -1; expected 0 or more; drop --repair"


def test_braces_of_a_value_are_no_option() -> None:
    assert str(BadOptionError("weights are {left=3}")) == "weights are {left=3}"
    assert str(BadOptionError(option="map", value="{a=b}")) == "map is '{a=b}'"


@pytest.mark.parametrize("copied", [copy.copy, lambda error: pickle.loads(pickle.dumps(error))])
def test_an_error_survives_the_way_from_a_worker(copied: object) -> None:
    error = BadOptionError(option="nodes", value=0, expected="1 or more", remedy="drop {nodes}")
    assert callable(copied)
    assert str(copied(error)) == str(error)
