"""That every target that is named is measured, and that what cannot be measured is told."""

import importlib.util
import json
from collections.abc import Iterable
from typing import get_args

import numpy as np
import pytest

from mpma_mj.bench import agent, drawing, parts, peers, programs, reservoirs
from mpma_mj.bench.child import python
from mpma_mj.bench.timing import Case
from mpma_mj.cli import main
from mpma_mj.commands.bench import Part
from mpma_mj.errors import WorkerError


def quietly(rounds: range, title: str) -> Iterable[int]:
    return rounds


def test_all_but_scaling_are_timed_if_nothing_is_named() -> None:
    assert set(parts.PARTS) == set(get_args(Part)) - {"scaling"}


@pytest.mark.usefixtures("small")
def test_training_is_held_against_the_floor() -> None:
    report = agent.measure(quietly)
    wanted = {name: (ratio.wanted, ratio.at_least) for name, ratio in report.ratios.items()}
    assert wanted == {
        "a training epoch over bare mj_step calls": (2.5, False),
        "a training epoch, 2 runs side by side, per run, over bare mj_step calls": (2.0, False),
        "learning the dance, over bare mj_step calls of an epoch": (15.0, False),
        "learning the dance, with what is created before, over bare mj_step calls of an epoch": (
            *(15.0, False),
        ),
    }
    for part in ("act and observe", "refit", "a training epoch", "bare mj_step calls"):
        assert any(name.startswith(part) for name in report.seconds), part


@pytest.mark.usefixtures("small")
def test_missing_peers_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(peers.importlib.util, "find_spec", lambda name: None)
    report = peers.measure(quietly)
    assert report.ratios == {}
    assert "dm_control's reacher, env.step less its physics" in report.seconds
    assert "our arms, env.step less its physics" in report.seconds
    for note, name in zip(report.notes, ("ReservoirPy", "Stable-Baselines3"), strict=True):
        assert note.startswith(f"{name} is not installed")
        assert "[bench]" in note


@pytest.mark.usefixtures("small")
def test_peers_that_are_there_are_beaten_or_not(monkeypatch: pytest.MonkeyPatch) -> None:
    there = {"reservoirpy", "stable_baselines3"}
    monkeypatch.setattr(peers.importlib.util, "find_spec", lambda name: name in there or None)
    monkeypatch.setattr(peers.importlib.metadata, "version", lambda name: "1.2")
    monkeypatch.setattr(peers, "reservoirs", lambda *_, **__: Case(lambda: 1))
    monkeypatch.setattr(peers, "_their_loop", lambda: Case(lambda: 1))
    report = peers.measure(quietly)
    assert all(ratio.at_least for ratio in report.ratios.values())
    assert [ratio.wanted for ratio in report.ratios.values()] == [2.5, 6.0, 2.5, 6.0]
    assert report.notes == ("ReservoirPy 1.2.", "Stable-Baselines3 1.2.")


@pytest.mark.parametrize("joined", [True, False])
def test_reservoirpy_steps_every_network_once_a_step(joined: bool) -> None:
    pytest.importorskip("reservoirpy")
    case = reservoirs.reservoirs(2, 12, 0.1, [(3, 2), (4, 1)], 7, joined=joined)
    assert case.run() == 7


def test_reservoirpys_networks_are_the_same_joined_or_not() -> None:
    pytest.importorskip("reservoirpy")
    inputs = np.random.default_rng(1).uniform(-1, 1, (4, 3))
    steps = [
        make(12, 0.1, 3, 2, np.random.default_rng(0))
        for make in (reservoirs._model, reservoirs._nodes)
    ]
    joined, apart = (np.stack([step(x) for x in inputs]) for step in steps)
    assert np.ptp(joined, axis=0).min() > 0.0
    np.testing.assert_allclose(joined, apart)


def test_stable_baselines3_collects_one_episode() -> None:
    if importlib.util.find_spec("stable_baselines3") is None:
        pytest.skip("Stable-Baselines3 is not installed")
    assert [peers._their_loop().run() for _ in range(2)] == [227, 227]


def test_a_backend_that_does_not_draw_is_told_and_the_other_timed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def draw(*words: str, environment: dict[str, str]) -> str:
        if environment["MUJOCO_GL"] == "osmesa":
            raise WorkerError("no OpenGL")
        return json.dumps({"drawn": [0.004, 0.002], "drawn and encoded": [0.02, 0.02]})

    monkeypatch.setattr(drawing, "python", draw)
    report = drawing.measure(quietly)
    reached = {name: bound.reached for name, bound in report.bounds.items()}
    assert reached == {
        "video frames a second, drawn, egl": True,
        "video frames a second, drawn and encoded, egl": False,
    }
    assert report.bounds["video frames a second, drawn, egl"].spread.greatest == 500.0
    assert report.notes == ("No video with osmesa: no OpenGL",)


@pytest.mark.usefixtures("opengl")
def test_frames_of_a_real_video_are_timed(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from mpma_mj.visualization import video

    pictures: list[int] = []

    def few(trace: object, motion: object) -> Iterable[int]:
        pictures.append(1)
        return iter(())

    monkeypatch.setattr(drawing, "_ROUNDS", 1)
    monkeypatch.setattr(video, "dance_frames", few)
    monkeypatch.setattr(video, "write_frames", lambda path, frames, rate: list(frames))
    drawing.main()
    assert json.loads(capsys.readouterr().out).keys() == {"drawn", "drawn and encoded"}
    assert len(pictures) == 4  # twice to warm up


def test_whole_programs_have_bounds_in_seconds(monkeypatch: pytest.MonkeyPatch) -> None:
    spec: list[tuple[str, ...]] = []

    def record(*words: str) -> Case:
        spec.append(words)
        return Case(lambda: 1)

    monkeypatch.setattr(programs, "program", record)
    report = programs.measure(quietly)
    assert {name: (b.wanted, b.unit) for name, b in report.bounds.items()} == {
        "seconds of mpma --help": (0.5, "s"),
        "seconds of mpma imitate ymca --no-video": (3.0, "s"),
    }
    exec(spec[0][1], {})  # the program of the first step runs
    assert spec[2][:5] == ("-m", "mpma_mj", "imitate", "ymca", "--no-video")


def test_a_program_that_fails_is_one_line() -> None:
    assert python("-c", "print('ready')") == "ready\n"
    with pytest.raises(WorkerError, match=r"ended with 1: ValueError: too few arms$"):
        python("-c", "raise ValueError('too few arms')")
    with pytest.raises(WorkerError, match="ended with 3: nothing"):
        python("-c", "import sys; sys.exit(3)")


@pytest.mark.usefixtures("small")
def test_several_parts_are_one_report(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(programs, "program", lambda *words: Case(lambda: 1))
    assert main(["bench", "programs", "agent", "programs", "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert len(report["seconds"]) == 3 + 9
    assert len(report["ratios"]) == 4
    assert len(report["bounds"]) == 2
    assert report["bounds"]["seconds of mpma --help"]["reached"]
    assert report["versions"]["mujoco"]


def test_a_folder_without_scaling_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "env", "--out", "here"]) == 2
    assert "add scaling, or drop --out" in capsys.readouterr().err
