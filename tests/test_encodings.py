"""Terminals that are not UTF-8: what they lack is a mark, and no result is lost."""

import io
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from mpma_mj.cli import main
from mpma_mj.commands import COMMANDS
from tests.test_cli import mpma

TINY = ("--nodes", 5, "--modules", 2, "--repeats", 1, "--epochs", 1, "--no-video")
SMALL_COMPARISON = (
    *("--nodes", 5, "--modules", 2, "--epochs", 1, "--fine-tune", 1),
    *("--runs", 1, "--workers", 1, "--no-video"),
)
PICTURES = {"responsibility.png", "module_output.png", "trajectory.png"}


@pytest.mark.parametrize(
    "environment",
    [
        {"PYTHONIOENCODING": "latin-1"},
        {"PYTHONIOENCODING": "ascii:strict"},
        {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"},
    ],
)
def test_a_run_is_whole_on_a_terminal_that_lacks_its_characters(
    environment: dict[str, str], tmp_path: Path
) -> None:
    result = mpma("imitate", "ymca", *TINY, "--out", tmp_path / "run", **environment)
    assert result.returncode == 0, result.stderr
    assert "label ? dominant module: Y ? " in result.stdout
    assert {path.name for path in (tmp_path / "run" / "figures").iterdir()} == PICTURES


def test_tables_are_shown_on_a_terminal_of_ascii(small_run: Path, tmp_path: Path) -> None:
    run = shutil.copytree(small_run, tmp_path / "run")
    result = mpma("analyse", run, "lesion", "--fine-tune", 0, PYTHONIOENCODING="ascii")
    assert result.returncode == 0, result.stderr
    assert "largest ? at once" in result.stdout


@pytest.mark.parametrize("command", COMMANDS)
def test_every_commands_help_is_shown_on_a_terminal_of_ascii(
    command: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    terminal = io.TextIOWrapper(io.BytesIO(), encoding="ascii")
    monkeypatch.setattr(sys, "stdout", terminal)
    with pytest.raises(SystemExit) as ended:
        main([command, "--help"])
    assert ended.value.code == 0
    assert b"usage: mpma" in terminal.buffer.getvalue()  # type: ignore[attr-defined]
    assert terminal.errors == "strict"  # as it was


def test_errors_name_files_that_a_terminal_cannot_show() -> None:
    result = mpma("imitate", "踊り\udcff.csv", PYTHONIOENCODING="ascii")
    assert result.returncode == 2
    shown = r"\u8e0a\u308a\udcff.csv"
    assert result.stderr == f"mpma: {shown}: no such file; give the path of a recording\n"


@pytest.mark.parametrize(
    ("words", "files"),
    [
        (["imitate", "ymca", *TINY, "--out", "run"], ["run/figures/trajectory.png"]),
        (["motion", "ymca", "--out", "a.npz"], ["ymca-motion.png", "a.npz"]),
        (["analyse", "small"], ["small/modules.json", "small/figures/modules.png"]),
        (
            ["compare", "ymca", *SMALL_COMPARISON, "--out", "compared"],
            ["compared/transfer.png", "compared/episodes.png"],
        ),
    ],
)
def test_files_are_written_before_anything_is_printed(
    words: list[object], files: list[str], small_run: Path, tmp_path: Path
) -> None:
    shutil.copytree(small_run, tmp_path / "small")
    reader, writer = os.pipe()
    os.close(reader)
    try:
        result = subprocess.run(
            [sys.executable, "-u", "-m", "mpma_mj.cli", *map(str, words)],
            stdout=writer,
            stderr=subprocess.PIPE,
            cwd=tmp_path,
            text=True,
            check=False,
        )
    finally:
        os.close(writer)
    assert result.returncode == 141, result.stderr
    for name in files:
        assert (tmp_path / name).exists(), name
