"""That what is compared is the same work, and is told as tables; how long it takes is no matter."""

import importlib.util
import re
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
import pytest

from benchmarks.speed import environment, peers, programs, timing, training
from benchmarks.speed.__main__ import main
from benchmarks.speed.timing import Case, Report, Sizes, Target, in_own_process, in_turn, ratio
from mpma_mj.envs.load import load

TINY = Sizes(rounds=1, nodes=5, runs=2)


def test_the_floor_is_the_simulation_that_is_in_a_step() -> None:
    bare, env = load(), load()
    for case in (environment.bare_steps(bare), environment.env_steps(env)):
        case.prepare()
        assert case.run() == environment.STEPS
    np.testing.assert_array_equal(bare.physics.joint_angles(), env.physics.joint_angles())


def test_cases_are_timed_in_turn_and_prepared_before_each_run() -> None:
    calls: list[str] = []

    def run(name: str) -> int:
        calls.append(name)
        return 2

    cases = {
        name: Case(lambda name=name: run(name), lambda name=name: calls.append(f"before {name}"))
        for name in "ab"
    }
    times = in_turn("a and b", cases, 2)
    assert calls == ["before a", "a", "before b", "b"] * 3  # the first round warms up
    assert {name: values.shape for name, values in times.items()} == {"a": (2,), "b": (2,)}


def test_a_time_is_per_unit_of_work_and_without_preparation(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    clock = [100.0]
    monkeypatch.setattr(timing.time, "perf_counter", lambda: clock[0])

    def passes(seconds: float) -> int:
        clock[0] += seconds
        return 4

    case = Case(lambda: passes(2.0), lambda: passes(7.0))
    assert in_turn("naps", {"nap": case}, 3)["nap"].tolist() == [0.5, 0.5, 0.5]


def test_a_report_has_ratios_of_the_same_round_and_says_what_is_missed() -> None:
    one, other = np.array([2.0, 6.0, 4.0]), np.array([1.0, 2.0, 4.0])
    report = Report(
        {"one": one / 1000},
        {
            "most": ratio(one, other, 2.5),
            "less": ratio(one, other, 1.5),
            "least": ratio(one, other, 1.5, at_least=True),
            "more": ratio(one, other, 2.5, at_least=True),
            "rate": Target(100 * other, 150.0, "/s", at_least=True),
        },
        ("A note.",),
    )
    assert report.markdown().splitlines() == [
        "| target | wanted | median | least to greatest |",
        "|---|---|---|---|",
        "| most | ≤ 2.5 | 2.00 | 1.00 to 3.00 |",
        "| less | ≤ 1.5 | 2.00 (missed) | 1.00 to 3.00 |",
        "| least | ≥ 1.5 | 2.00 | 1.00 to 3.00 |",
        "| more | ≥ 2.5 | 2.00 (missed) | 1.00 to 3.00 |",
        "| rate | ≥ 150 /s | 200 /s | 100 to 400 /s |",
        "",
        "| time | median | least to greatest |",
        "|---|---|---|",
        "| one | 4 ms | 2 to 6 ms |",
        "",
        "A note.",
    ]


@pytest.mark.parametrize(
    ("part", "targets", "times"), [("environment", 3, 6), ("training", 4, 9), ("peers", 0, 8)]
)
def test_a_part_is_told_as_tables(
    part: Any,
    targets: int,
    times: int,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr(peers.importlib.util, "find_spec", lambda name: None)
    monkeypatch.setattr(environment, "STEPS", 20)
    monkeypatch.setattr(environment, "_BATCHES", 2)
    monkeypatch.setattr(peers, "_STEPS", 5)
    monkeypatch.setattr(training, "_MOST_EPOCHS", 2)
    main((part,), TINY)
    out = capsys.readouterr().out
    assert len(re.findall(r"^\| [^|]+ \| [-\d.e+]+ [µm]?s \|", out, re.MULTILINE)) == times
    assert out.count("| ≤ ") + out.count("| ≥ ") == targets
    assert ("ReservoirPy is not installed" in out) == (part == "peers")


def test_programs_run_and_a_backend_that_does_not_draw_is_told(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    given: list[tuple[str, ...]] = []

    def record(*words: str) -> Case:
        given.append(words)
        return Case(lambda: 1)

    def draw(work: object, rounds: int, variables: dict[str, str]) -> object:
        times = {"drawn": np.array([0.004, 0.004]), "drawn and encoded": np.array([0.02, 0.02])}
        return "no OpenGL" if variables["MUJOCO_GL"] == "osmesa" else times

    monkeypatch.setattr(programs, "_program", record)
    monkeypatch.setattr(programs, "in_own_process", draw)
    main(("programs",), TINY)
    out = capsys.readouterr().out
    assert "| video frames a second, drawn, egl | ≥ 200 /s | 250 /s | 250 to 250 /s |" in out
    assert "| ≥ 100 /s | 50.00 /s (missed) |" in out
    assert "Not timed with osmesa: no OpenGL" in out
    assert "| seconds of mpma imitate ymca --no-video | ≤ 3 s |" in out
    for _, code in given[:3]:
        exec(code, {})
    assert [words[1:4] for words in given[3:]] == [
        ("mpma_mj", "--help"),
        ("mpma_mj", "imitate", "ymca"),
    ]


def test_a_program_that_fails_ends_the_benchmark_with_what_it_said() -> None:
    assert programs._program("-c", "print('ready')").run() == 1
    with pytest.raises(SystemExit, match="ValueError: too few arms"):
        programs._program("-c", "raise ValueError('too few arms')").run()


@pytest.mark.usefixtures("opengl")
def test_frames_of_a_real_video_are_timed(monkeypatch: pytest.MonkeyPatch) -> None:
    from mpma_mj.visualization import video

    pictures: list[int] = []

    def few(scene: object) -> Iterable[int]:
        pictures.append(1)
        return iter(())

    monkeypatch.setattr(video, "episode_frames", few)
    monkeypatch.setattr(video, "write_frames", lambda path, frames, rate: list(frames))
    found = programs._seconds_of_a_frame(1)
    assert isinstance(found, dict)
    assert found.keys() == {"drawn", "drawn and encoded"}
    assert len(pictures) == 4  # twice to warm up


def test_work_in_a_process_of_its_own_has_its_variables() -> None:
    assert in_own_process(importlib.util.find_spec, "mpma_mj.nothing") is None
    variables = dict(timing.os.environ) | {"MPMA_TRIAL": "there"}
    assert in_own_process(timing.os.getenv, "MPMA_TRIAL", variables) == "there"
    assert "MPMA_TRIAL" not in timing.os.environ


@pytest.mark.parametrize("make", [peers.joined, peers.stepped])
def test_reservoirpys_networks_are_the_same_joined_or_not(make: Callable[..., Any]) -> None:
    pytest.importorskip("reservoirpy")
    inputs = np.random.default_rng(1).uniform(-1, 1, (4, 3))
    steps = [each(12, 0.1, 3, 2, np.random.default_rng(0)) for each in (make, peers.stepped)]
    one, other = (np.stack([step(x) for x in inputs]) for step in steps)
    assert np.ptp(one, axis=0).min() > 0.0
    np.testing.assert_allclose(one, other)
