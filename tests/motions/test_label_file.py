from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from mpma_mj.context import Span
from mpma_mj.errors import MotionFileError
from mpma_mj.motions.context import read_labels

SPANS = (Span(0.0, 1.5, "Y"), Span(1.5, 2.25, "M"), Span(2.0, 3.0, "Y"))


@pytest.mark.parametrize(
    "text",
    [
        "0,1.5,Y\n1.5,2.25,M\n2,3,Y\n",
        "start,end,label\n0,1.5,Y\n1.5,2.25,M\n2,3,Y",
        "Start;End;Label\n0;1.5;Y\n1.5;2.25;M\n2;3;Y\n",
        "0;1,5;Y\n1,5;2,25;M\n2;3;Y\n",
        "0\t1.5\tY\n1.5\t2.25\tM\n2\t3\tY\n",
        "0\t1,5\tY\n1,5\t2,25\tM\n2\t3\tY\n",
        "\n0, 1.5, Y\n\n1.5, 2.25, M\n2 ,3 ,Y\n\n",
        '"start","end","label"\r\n"0","1.5","Y"\r\n"1.5","2.25","M"\r\n"2","3","Y"\r\n',
        "\ufeffstart,end,label\n0,1.5,Y\n1.5,2.25,M\n2,3,Y\n",
        ",,\n0,1.5,Y\n1.5,2.25,M\n2,3,Y\n",
    ],
)
def test_rows_are_read_however_they_are_written(tmp_path: Path, text: str) -> None:
    path = tmp_path / "labels.csv"
    path.write_text(text, encoding="utf-8", newline="")
    assert read_labels(path) == SPANS


numbers = st.floats(-1e3, 1e6).map(lambda x: round(x, 3))
names = st.text("abcXYZ äß;.-'_ 0123", min_size=1).map(str.strip).filter(bool)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(rows=st.lists(st.tuples(numbers, st.floats(0.001, 1e3), names), min_size=1, max_size=8))
def test_what_is_written_is_read(tmp_path: Path, rows: list[tuple[float, float, str]]) -> None:
    spans = tuple(Span(start, start + length, name) for start, length, name in rows)
    path = tmp_path / "labels.csv"
    lines = [f"{span.start!r},{span.end!r},{span.label}" for span in spans]
    path.write_text("\n".join(lines), encoding="utf-8")
    assert read_labels(path) == spans


def test_a_label_may_have_separators_in_it(tmp_path: Path) -> None:
    path = tmp_path / "labels.csv"
    path.write_text('0,1,"arms up, down"\n1,2,left; right\n')
    assert [span.label for span in read_labels(path)] == ["arms up, down", "left; right"]


def test_a_label_may_last_to_the_end_of_time(tmp_path: Path) -> None:
    path = tmp_path / "labels.csv"
    path.write_text("0,inf,Y\n")
    assert read_labels(path) == (Span(0.0, np.inf, "Y"),)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("0,1,Y\n1,2\n", "line 2: '1,2' is not start,end,label, such as 0,2.5,Y"),
        ("0,1,Y\n1,2,M,C\n", "line 2: '1,2,M,C' is not"),
        ("0,1,Y\n1,2,\n", "line 2: '1,2,' is not"),
        ("0,1,Y\n1,two,M\n", "line 2: '1,two,M' is not"),
        ("o,1,Y\n1,2,M\n", "line 1: 'o,1,Y' is not"),  # no header: half of it is numbers
        ("start,end,label\nstart,end,label\n", "line 2: 'start,end,label' is not"),
        ("0,1,Y\n2,2,M\n", "line 2: the span from 2 to 2 s has no length"),
        ("0,1,Y\n3,2,M\n", "line 2: the span from 3 to 2 s has no length"),
        ("nan,1,Y\n", "line 1: the span from nan to 1 s has no length"),
        ("0,nan,Y\n", "line 1: the span from 0 to nan s has no length"),
        ("-inf,1,Y\n", "line 1: the span from -inf to 1 s has no length"),
        ("", "holds no rows of start,end,label"),
        ("start,end,label\n\n", "holds no rows of start,end,label"),
        ("0,1,Y\n1,2," + "M" * 200_000, "line 2: '1,2,MMMM"),
        ("1_0,20,Y\n0,1,Y\n", "line 1: '1_0,20,Y' is not"),
    ],
)
def test_bad_rows_are_one_line_that_names_them(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "labels.csv"
    path.write_text(text)
    with pytest.raises(MotionFileError) as caught:
        read_labels(path)
    assert str(caught.value).startswith(f"{path}: {message}")
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < len(str(path)) + 200


def test_what_is_no_text_file_is_one_line(tmp_path: Path) -> None:
    binary = tmp_path / "labels.csv"
    binary.write_bytes(b"\0\1\2" * 100)
    for path, problem in {
        binary: "is no text; expected rows of start,end,label in seconds",
        tmp_path / "missing.csv": "cannot be read (No such file or directory)",
        tmp_path: "cannot be read (Is a directory)",
    }.items():
        with pytest.raises(MotionFileError) as caught:
            read_labels(path)
        assert str(caught.value) == f"{path}: {problem}"
