"""Folders that commands write."""

from pathlib import Path

import pytest

from tests.conftest import Refused


@pytest.mark.parametrize(("name", "content"), [("config.json", "run"), ("study.json", "study")])
@pytest.mark.parametrize("words", ["evaluate RUN", "compare ymca --no-video"])
def test_results_are_not_written_to_the_folder_of_a_run_or_a_study(
    words: str, name: str, content: str, small_run: Path, tmp_path: Path, refused: Refused
) -> None:
    (tmp_path / name).write_text("{}")
    typed = words.replace("RUN", str(small_run)).split()
    message = f"{tmp_path}: contains a {content}; choose another folder with --out"
    refused([*typed, "--out", str(tmp_path)], message)
    assert [path.name for path in tmp_path.iterdir()] == [name]
