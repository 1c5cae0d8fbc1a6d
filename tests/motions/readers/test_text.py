"""Text files are read line by line, and no line without bounds."""

from pathlib import Path

import pytest

from mpma_mj.errors import MotionFileError
from mpma_mj.motions.readers import text
from mpma_mj.motions.readers.text import TextFile


def test_a_line_without_end_is_refused_where_it_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(text, "LONGEST_LINE", 100)
    path = tmp_path / "dance.csv"
    path.write_text("time\n" + "1," * 1000)
    file = TextFile.open(path)
    assert file is not None
    assert file.head(1) == ["time"]
    with pytest.raises(MotionFileError, match="line 2 has more than 100 characters"):
        list(file.lines())


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_lines_begin_where_asked(tmp_path: Path, end: str) -> None:
    path = tmp_path / "dance.csv"
    path.write_bytes(end.join("abcd").encode())
    file = TextFile.open(path)
    assert file is not None
    assert list(file.lines(2)) == ["c", "d"]
