"""The README: examples run as they stand, options and links exist."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from mpma_mj.cli import main

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("code", re.findall(r"```python\n(.*?)```", README, re.DOTALL))
def test_python_examples_run(code: str, tmp_path: Path) -> None:
    result = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False, cwd=tmp_path
    )
    assert result.returncode == 0, result.stderr


@pytest.mark.parametrize(
    "command",
    [
        "evaluate",
        "imitate",
        "motion",
        "play",
    ],
)
def test_options_that_are_shown_exist(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    shown = {
        option
        for line in re.findall(rf"^mpma {command} .*$", README, re.MULTILINE)
        for option in re.findall(r"--[a-z-]+", line.split("#")[0])
    }
    with pytest.raises(SystemExit, match="0"):
        main([*command.split(), "--help"])
    offered = capsys.readouterr().out
    assert shown
    assert {option for option in shown if option not in offered} == set()


@pytest.mark.parametrize("path", re.findall(r"\]\((?!http)([^)#]+)", README))
def test_links_lead_somewhere(path: str) -> None:
    assert (ROOT / path).exists()
