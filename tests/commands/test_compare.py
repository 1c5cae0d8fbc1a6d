"""The command `mpma compare` as a user types it."""

import json
from pathlib import Path

import pytest

from mpma_mj.cli import main
from mpma_mj.experiments import compare
from mpma_mj.experiments.compare import ARMS, UNTRAINED
from tests.conftest import Refused


def test_a_comparison_writes_tables_and_figures(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = "compare ymca --runs 1 --nodes 5 --modules 2 --epochs 2 --fine-tune 1 --no-video"
    capsys.readouterr()
    assert main([*words.split(), "--out", str(tmp_path)]) == 0
    printed = capsys.readouterr()
    assert printed.out.splitlines()[-1] == str(tmp_path)
    trained = sorted(line.split()[-1] for line in printed.err.splitlines())
    assert trained == sorted([UNTRAINED, *ARMS])
    assert (tmp_path / "compare.md").read_text().strip() in printed.out
    content = json.loads((tmp_path / "compare.json").read_text())
    assert (content["runs"], content["fine_tune"]) == (1, 1)
    for figure in ("transfer.png", "episodes.png"):
        assert (tmp_path / figure).read_bytes().startswith(b"\x89PNG")
    assert {path.name for path in tmp_path.iterdir()} == {
        *("compare.md", "compare.csv", "compare.json", "transfer.png", "episodes.png"),
    }


def test_ctrl_c_reports_that_nothing_is_saved(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(compare, "compare", interrupted)
    words = "compare ymca --runs 1 --nodes 5 --modules 2 --workers 1 --no-video --out"
    assert main([*words.split(), str(tmp_path / "out")]) == 130
    told = "mpma: nothing is saved: a comparison is written at its end\nmpma: interrupted\n"
    assert capsys.readouterr().err == told
    assert not (tmp_path / "out").exists()


@pytest.mark.usefixtures("opengl")
def test_robots_are_compared_in_tables_a_video_and_a_picture(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "overlaid.mp4").touch()  # of an earlier comparison
    words = "compare ymca --robots two_arm cmu_humanoid --repeats 1 --runs 1 --nodes 5 --modules 2"
    capsys.readouterr()
    assert main([*words.split(), "--epochs", "2", "--out", str(tmp_path)]) == 0
    printed = capsys.readouterr()
    assert (tmp_path / "compare.md").read_text().strip() in printed.out
    assert "cmu_humanoid has joints and speeds of its own" in printed.err
    content = json.loads((tmp_path / "compare.json").read_text())
    assert content["robots"] == ["two_arm", "cmu_humanoid"]
    assert "fine_tune" not in content
    assert {path.name for path in tmp_path.iterdir()} == {
        *("compare.md", "compare.csv", "compare.json", "robots.png", "robots.mp4"),
    }


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("ymca --robots", "--robots has no value; give one"),
        ("ymca --robots two_arm cmu_humanoit", "--robots is 'cmu_humanoit'; expected one of"),
        ("ymca --robots two_arm --robot cmu_humanoid", "--robot is for one robot"),
        ("ymca --robots two_arm --fine-tune 2", "--fine-tune is for kinds of arms"),
        ("ymca --robots two_arm --tempo auto", "--tempo auto is another tempo for each robot"),
        ("ymca --robots two_arm --locked-joint left_elbow", "--locked-joint is a joint of one"),
        ("ymca --robots two_arm --runs 0", "--runs is 0; expected at least 1"),
        ("ymca --robots two_arm --epochs 0", "--epochs is 0; expected at least 1"),
        ("ymca --robots two_arm two_arm", "robot two_arm is given twice"),
        ("--robots two_arm ymca", "no motion given; try: mpma compare ymca"),
    ],
)
def test_bad_robots_are_one_line_and_exit_2(
    words: str, message: str, tmp_path: Path, refused: Refused
) -> None:
    out = tmp_path / "out"
    refused(["compare", *words.split(), "--no-video", "--out", str(out)], message)
    assert not out.exists()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("", "no motion given; try: mpma compare ymca"),
        ("nonsense", "nonsense"),
        ("ymca --runs 0", "--runs is 0; expected at least 1"),
        ("ymca --epochs 0", "--epochs is 0; expected at least 1"),
        ("ymca --fine-tune 0", "--fine-tune is 0; expected at least 1"),
        ("ymca --nodes 0", "nodes is 0"),
        ("ymca --modules 0", "modules is 0"),
        ("ymca --agent open_loop", "--agent is 'open_loop'; expected an agent that learns"),
        ("ymca --agent mosaic --rule gated", "mosaic has no option --rule"),
        ("ymca --tempo 5 --strict", "leave out --strict"),
    ],
)
def test_bad_input_is_one_line_and_exit_2(
    words: str, message: str, tmp_path: Path, refused: Refused
) -> None:
    out = tmp_path / "out"
    refused(["compare", *words.split(), "--no-video", "--out", str(out)], message)
    assert not out.exists()
