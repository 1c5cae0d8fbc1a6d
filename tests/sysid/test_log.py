"""Logs on file, and which are refused."""

import dataclasses
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import mpma_mj
from mpma_mj.envs.model import make_model
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.errors import RobotLogError
from mpma_mj.sysid import RobotLog, read_log, record, write_log
from mpma_mj.sysid.log import COLUMNS, check_log

MODEL = make_model(EnvironmentOptions())


def test_what_is_written_is_read_again_to_the_bit(log: RobotLog, tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    write_log(path, log)
    again = read_log(path)
    for name in ("time", "command", "angle", "velocity"):
        assert np.array_equal(getattr(again, name), getattr(log, name)), name
    assert again.source == str(path)


def test_columns_may_stand_in_any_order_among_others(log: RobotLog, tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    write_log(path, log)
    rows = [line.split(",")[::-1] for line in path.read_text().splitlines()]
    path.write_text("\n".join(",".join(["on" if i else "mode", *r]) for i, r in enumerate(rows)))
    assert np.array_equal(read_log(path).velocity, log.velocity)


def test_a_record_tells_what_was_commanded_and_the_state_before_it_acts() -> None:
    env = mpma_mj.load("ymca", seed=0)
    log = record(env, lambda _: np.full(8, 2.0), 0.2)  # beyond [-1, 1], so clipped
    assert log.time == pytest.approx([0.0, 0.05, 0.1, 0.15])
    assert np.array_equal(log.command, np.tile(env.task.max_joint_speed, (4, 1)))
    start = env.reset().observation
    assert np.allclose(log.angle[0], start["joint_angles"])
    assert np.allclose(log.velocity[0], start["joint_velocities"])
    assert (np.abs(log.velocity[1]) > 1.0).all()


def test_a_record_ends_with_the_episode() -> None:
    env = mpma_mj.load("ymca", repeats=1)
    assert len(record(env, lambda _: np.zeros(8), 1000.0)) == env.task.steps


def edited(log: RobotLog, path: Path, edit: Callable[[list[str]], list[str]]) -> str:
    """Return why a file is refused whose lines were edited."""
    write_log(path, log)
    path.write_text("\n".join(edit(path.read_text().splitlines())) + "\n")
    with pytest.raises(RobotLogError) as refused:
        read_log(path)
    assert "\n" not in str(refused.value)
    assert str(refused.value).startswith(f"{path}: ")
    return str(refused.value)


def cell(row: int, column: str, value: str) -> Callable[[list[str]], list[str]]:
    """Return what writes a cell, rows counted as a text editor does."""

    def edit(lines: list[str]) -> list[str]:
        cells = lines[row - 1].split(",")
        cells[COLUMNS.index(column)] = value
        return [*lines[: row - 1], ",".join(cells), *lines[row:]]

    return edit


@pytest.mark.parametrize("value", ["", "nan", "inf", "1,5", "abc", "1_0"])
def test_a_cell_that_is_no_finite_number_is_named(
    log: RobotLog, tmp_path: Path, value: str
) -> None:
    said = edited(log, tmp_path / "a.csv", cell(7, "angle_left_elbow", value))
    if value == "1,5":
        assert "row 7 has 26 cells, but the header has 25" in said
    else:
        assert f"row 7, column angle_left_elbow: '{value}' is not a finite number" in said


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (
            lambda lines: [lines[0].replace("command_left_elbow", "elbow"), *lines[1:]],
            "lacks command_left_elbow; add these columns",
        ),
        (
            lambda lines: [lines[0].replace("angle_left_elbow", "time"), *lines[1:]],
            "lacks angle_left_elbow",
        ),
        (lambda lines: [f"time,{lines[0]}", *lines[1:]], "has column time twice"),
        (lambda lines: lines[1:], "is not a robot's log; expected a first row with the columns"),
        (lambda lines: [line.replace(",", ";") for line in lines], "separated by commas"),
        (lambda lines: [], "is not a robot's log"),
        (lambda lines: lines[:1], "has a header but no rows"),
        (
            lambda lines: [*lines[:4], "1,2,3", *lines[4:]],
            "row 5 has 3 cells, but the header has 25",
        ),
        (lambda lines: [*lines[:4], "", *lines[4:]], "row 5 has 1 cells"),
    ],
)
def test_what_is_no_table_of_a_log_is_refused(
    log: RobotLog, tmp_path: Path, edit: Callable[[list[str]], list[str]], message: str
) -> None:
    assert message in edited(log, tmp_path / "a.csv", edit)


def test_what_is_no_file_of_text_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RobotLogError, match=r"no such file; .* with the header time"):
        read_log(tmp_path / "gone.csv")
    with pytest.raises(RobotLogError, match="is a folder"):
        read_log(tmp_path)
    (tmp_path / "a.csv").write_bytes(b"\0\1\2")
    with pytest.raises(RobotLogError, match="is not a text file"):
        read_log(tmp_path / "a.csv")


def late(time: NDArray[np.float64]) -> NDArray[np.float64]:
    return time + np.where(np.arange(len(time)) == 9, 0.01, 0.0)


def swapped(time: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.where(np.arange(len(time)) == 9, 0.0, time)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (late, r"row 11 comes 0\.06 s after the one before; expected 0\.05 s ± 5 %"),
        (swapped, r"row 11: time is 0 s after 0\.4 s; expected ascending times"),
        (lambda time: 0.4 * time, r"is 2\.38 s long; expected at least 5.5 s"),
        (lambda time: 1.03 * time, r"has a row every 51\.5 ms; .* 5 ms, such as 50 or 55 ms"),
        (lambda time: 6.0 * time, r"has a row every 0\.3 s; expected at most 0\.1 s"),
    ],
)
def test_times_that_do_not_fit_are_refused(
    log: RobotLog, change: Callable[[NDArray[np.float64]], NDArray[np.float64]], message: str
) -> None:
    with pytest.raises(RobotLogError, match=message):
        check_log(dataclasses.replace(log, time=change(log.time)), MODEL)


def test_times_that_shake_a_little_are_taken_as_even(log: RobotLog) -> None:
    shaken = log.time + np.random.default_rng(0).uniform(-0.001, 0.001, len(log))
    shaken[[0, -1]] = log.time[[0, -1]]
    assert check_log(dataclasses.replace(log, time=shaken), MODEL) == 10


def with_cell(array: NDArray[np.float64], row: int, value: float) -> NDArray[np.float64]:
    copy = array.copy()
    copy[row, 3] = value
    return copy


def test_commands_and_angles_that_show_nothing_are_refused(log: RobotLog) -> None:
    still = np.zeros_like(log.command)
    with pytest.raises(RobotLogError, match="no command ever changes"):
        check_log(dataclasses.replace(log, command=still), MODEL)
    with pytest.raises(RobotLogError, match="no angle ever changes"):
        check_log(dataclasses.replace(log, angle=still), MODEL)
    beyond = with_cell(log.command, 5, -16.0)
    with pytest.raises(RobotLogError, match=r"row 7, column command_left_elbow: -16 rad/s, but"):
        check_log(dataclasses.replace(log, command=beyond), MODEL)
    turned = log.angle + 2.0 * np.pi * (np.arange(len(log)) >= 20)[:, None]
    with pytest.raises(RobotLogError, match=r"row 22, column angle_left_.*abduction: jumps by"):
        check_log(dataclasses.replace(log, angle=turned), MODEL)
