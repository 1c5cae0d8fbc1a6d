"""The command `mpma identify` as a user types it."""

import json
from pathlib import Path

import numpy as np
import pytest

from mpma_mj.cli import main
from mpma_mj.sysid import RobotLog, write_log
from tests.conftest import Refused
from tests.sysid.conftest import LATENCY, dance_of


def test_a_log_gives_a_table_and_a_model_that_dances_like_the_robot(
    log: RobotLog, factors: dict[str, float], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert max(abs(factor - 1.0) for factor in factors.values()) > 0.2
    write_log(tmp_path / "log.csv", log)
    out = tmp_path / "found"
    capsys.readouterr()
    assert main(["identify", str(tmp_path / "log.csv"), "--out", str(out)]) == 0
    printed = capsys.readouterr()
    assert printed.err == "simulating the log with other parameters\n"
    lines = printed.out.splitlines()
    assert lines[0] == "| parameter | unit | in the model | found | 95 % interval | remark |"
    assert lines[2].startswith("| kv_shoulder_abduction | N m s/rad | 20 | ")
    assert "| latency | ms | 0 | 100 | 97.5 to 102.5 | 2 × the control step of 50 ms |" in lines
    assert lines[-2].startswith("RMS error of the angles over windows of 1 s: ")
    assert lines[-1] == str(out)
    assert (out / "identified.png").read_bytes().startswith(b"\x89PNG")
    content = json.loads((out / "identified.json").read_text())
    assert content["parameters"].keys() == factors.keys()
    for name, told in content["parameters"].items():
        assert told["factor"] == pytest.approx(factors[name], rel=0.01), name
        assert told["determined"], name
    assert content["latency"]["seconds"] == pytest.approx(0.1)
    assert content["latency"]["control_steps"] == LATENCY
    assert max(content["rms_after"].values()) < 0.01 < min(content["rms_before"].values())
    again = dance_of(out / "identified.xml", 2.0, latency=LATENCY)
    assert np.abs(again.angle - log.angle[: len(again.time)]).max() < 0.02


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (
            ["gone.csv"],
            "gone.csv: no such file; check the path; a robot's log is CSV with the header time,",
        ),
        (["bad.csv"], "mpma: bad.csv: lacks command_left_shoulder_abduction, "),
        (["robot.csv", "--robot", "robot.csv"], "robot.csv: is no MJCF file: no XML in UTF-8"),
        (["robot.csv", "--robot", "cmu_humanoid"], "--robot is 'cmu_humanoid'; expected two_arm"),
        (["robot.csv", "--robot", "gone.xml"], "gone.xml: no such file; check the path"),
    ],
)
def test_bad_input_is_one_line_and_exit_2(
    words: list[str],
    message: str,
    log: RobotLog,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    write_log(Path("robot.csv"), log)
    Path("bad.csv").write_text("time,angle\n0,1\n")
    capsys.readouterr()
    assert main(["identify", *words]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    errors = [text for text in printed.err.splitlines() if text.startswith("mpma: ")]
    assert len(errors) == 1
    assert message in errors[0]
    assert "Traceback" not in printed.err
    assert {path.name for path in tmp_path.iterdir()} == {"bad.csv", "robot.csv"}


def test_the_result_is_not_written_to_the_folder_of_a_run(
    log: RobotLog, tmp_path: Path, refused: Refused
) -> None:
    write_log(tmp_path / "robot.csv", log)
    (tmp_path / "config.json").write_text("{}")
    message = f"{tmp_path}: contains a run; choose another folder with --out"
    refused(["identify", str(tmp_path / "robot.csv"), "--out", str(tmp_path)], message)
