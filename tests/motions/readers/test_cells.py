"""What cells of tables mean."""

import math

import pytest

from mpma_mj.motions.readers.cells import is_missing, is_number, positive, seconds_of


@pytest.mark.parametrize(
    "cell",
    [
        *("", " ", "NaN", "-nan(ind)", "nan(snan)", "1.#QNAN", "-1.#IND00", "1.#INF", "inf"),
        *("#N/A", "#VALUE!", "#DIV/0!", "NULL", "None", "n/a", "NA", ".", "-", "--", "?", "\\N"),
    ],
)
def test_words_for_nothing(cell: str) -> None:
    assert is_missing(cell)


@pytest.mark.parametrize("cell", ["0", "-1", "1.5e3", "x7", "left", "1.2.3", "nano", "-.5"])
def test_other_words_are_no_gaps(cell: str) -> None:
    assert not is_missing(cell)


def test_numbers() -> None:
    assert is_number("-1.5e3")
    assert not is_number("1_000")
    assert positive("60") == 60.0
    assert positive("-60") is positive("inf") is positive("fast") is None


@pytest.mark.parametrize(
    ("cell", "seconds"),
    [
        *(("12.5", 12.5), ("01:02:03.25", 3723.25), ("2:03", 123.0), ("12:00:00,017", 43200.017)),
        *(("2024-05-01 12:00:00.017", 43200.017), ("2024-05-01T12:00:00.017+02:00", 43200.017)),
        *(("2024-05-01T12:00:00Z", 43200.0), ("01/05/2024 12:00:00.017123456", 43200.017123456)),
    ],
)
def test_times_of_day_are_seconds(cell: str, seconds: float) -> None:
    assert seconds_of(cell) == pytest.approx(seconds)


@pytest.mark.parametrize("cell", ["01:02:03:04", "01:02:03;04", "foo", "2024-05-01", ""])
def test_what_is_no_time_is_missing(cell: str) -> None:
    assert math.isnan(seconds_of(cell))
