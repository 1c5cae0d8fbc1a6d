"""`mpma imitate` with other agents than MPMA, and with agents that hear otherwise."""

import json
from pathlib import Path

import pytest

from mpma_mj.agents.kinds import DO_NOT_LEARN
from mpma_mj.cli import main
from tests.training.test_imitate import RESULTS

SMALL = ["--nodes", "10", "--modules", "2", "--repeats", "1", "--no-video"]


def imitate(*words: object) -> int:
    return main(["imitate", *map(str, words)])


@pytest.mark.parametrize(
    "words",
    [
        ["--agent", "mosaic"],
        ["--agent", "hammer"],
        ["--agent", "single"],
        ["--hears", "shuffled"],
        ["--hears", "halves", "--agent", "mosaic"],
        ["--no-forward-gating", "--no-responsibility-predictors"],
    ],
)
def test_a_resumed_run_equals_an_uninterrupted_one(words: list[str], tmp_path: Path) -> None:
    whole, parts = tmp_path / "whole", tmp_path / "parts"
    assert imitate("ymca", *words, *SMALL, "--epochs", 5, "--out", whole) == 0
    assert imitate("ymca", *words, *SMALL, "--epochs", 2, "--out", parts) == 0
    assert imitate("--resume", parts, "--epochs", 3, "--no-video") == 0
    for name in RESULTS:
        assert (whole / name).read_bytes() == (parts / name).read_bytes(), name
    assert json.loads((whole / "summary.json").read_text())["epochs"] == 5


@pytest.mark.parametrize("agent", DO_NOT_LEARN)
def test_what_does_not_learn_is_refused_in_one_line(
    agent: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert imitate("ymca", "--agent", agent, "--out", tmp_path / "new", "--no-video") == 2
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err == (
        f"mpma: agent is {agent}, which does not learn; expected one of mpma, mosaic, hammer,"
        " single\n"
    )
    assert not (tmp_path / "new").exists()
