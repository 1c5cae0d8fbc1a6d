"""Runs of other agents than MPMA, and of agents that hear otherwise."""

import json
from pathlib import Path
from typing import Any

import pytest

from mpma_mj.agents import AGENTS
from mpma_mj.cli import main
from mpma_mj.training.config import RunConfig
from mpma_mj.training.run import resume, train
from mpma_mj.training.run_folder import RunFolder
from tests.training.test_run import RESULTS

SMALL = RunConfig.of(nodes=10, modules=2, repeats=1, arms="kinematic")


@pytest.mark.parametrize(
    "settings",
    [
        {"agent": "hammer"},
        {"agent": "single"},
        {"context_signal": "shuffled"},
        {"agent": "mosaic", "context_signal": "halves"},
        {"forward_gating": False, "responsibility_predictors": False},
    ],
    ids=lambda settings: " ".join(map(str, settings.values())),
)
def test_a_resumed_run_equals_an_uninterrupted_one(
    settings: dict[str, Any], tmp_path: Path
) -> None:
    # Posture models, as joint ones converge in two epochs, which would end the run.
    posture: dict[str, Any] = {"models": "posture", "rule": "gated"}
    agent = settings.get("agent", "mpma")
    config = SMALL.replace(**settings | (posture if agent in ("mpma", "single") else {}))
    whole, parts = RunFolder(tmp_path / "whole"), RunFolder(tmp_path / "parts")
    train(config, 5, folder=whole)
    train(config, 2, folder=parts)
    resume(parts, 3)
    same(whole.path, parts.path)


def test_the_command_trains_mosaic_and_goes_on_with_it(tmp_path: Path) -> None:
    words = [
        "imitate",
        "ymca",
        "--agent",
        "mosaic",
        "--nodes",
        "10",
        "--repeats",
        "1",
        "--arms",
        "kinematic",
        "--no-video",
    ]
    whole, parts = tmp_path / "atomic_write", tmp_path / "parts"
    assert main([*words, "--epochs", "5", "--out", str(whole)]) == 0
    assert main([*words, "--epochs", "2", "--out", str(parts)]) == 0
    assert main(["imitate", "--resume", str(parts), "--epochs", "3", "--no-video"]) == 0
    same(whole, parts)
    assert json.loads((whole / "config.json").read_text())["config"]["agent"]["name"] == "mosaic"


def same(whole: Path, parts: Path) -> None:
    for name in RESULTS:
        assert (whole / name).read_bytes() == (parts / name).read_bytes(), name
    assert json.loads((whole / "summary.json").read_text())["epochs"] == 5


@pytest.mark.parametrize(
    ("agent", "setting", "said"),
    [
        ("mosaic", ["--no-forward-gating"], "--forward-gating"),
        ("mosaic", ["--rule", "gated"], "--rule"),
        ("hammer", ["--efference-copy", "module"], "--efference-copy"),
    ],
)
def test_settings_that_an_agent_does_not_have_are_refused_in_one_line(
    agent: str,
    setting: list[str],
    said: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    out = tmp_path / "new"
    words = ["imitate", "ymca", "--agent", agent, *setting, "--out", str(out), "--no-video"]
    assert main(words) == 2
    told = capsys.readouterr().err
    assert told.startswith(f"mpma: {agent} has no option {said}; leave it out, or choose another")
    assert not out.exists()


@pytest.mark.parametrize("agent", [a for a in AGENTS if not AGENTS[a].trainable])
def test_what_does_not_learn_is_refused_in_one_line(
    agent: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "new"
    assert main(["imitate", "ymca", "--agent", agent, "--out", str(out), "--no-video"]) == 2
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err == (
        f"mpma: --agent is '{agent}'; expected an agent that learns, such as mpma, mosaic, hammer,"
        " single, adaptive, oracle, bc, dagger, promp, dmp\n"
    )
    assert not out.exists()
