"""Latency that is a range in training: traces, agents' specs, run folders, command line."""

import json
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

import mpma_mj
from mpma_mj.cli import main
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.errors import BadOptionError, OptionWarning
from mpma_mj.experiments.sweep import points
from mpma_mj.trace import Trace
from mpma_mj.training.config import RunConfig
from mpma_mj.training.config_json import OutsideConfig
from mpma_mj.training.rollout import record_epoch
from mpma_mj.training.run import _warn_of_latency, resume, train
from mpma_mj.training.run_folder import RunFolder
from tests.training.test_run import RESULTS

OPTIONS: dict[str, Any] = {"repeats": 1, "latency": (0, 5), "latency_every": (0.1, 0.5)}


def test_a_trace_has_the_latency_that_each_action_met() -> None:
    envs, env = mpma_mj.make_vec(2, "ymca", **OPTIONS), mpma_mj.load("ymca", **OPTIONS)
    batch = record_epoch(envs, mpma_mj.make_agent(envs, kind="feedback_only"), 3)
    alone = record_epoch(env, mpma_mj.make_agent(env, kind="feedback_only"), 3)
    assert batch.latency is not None
    assert batch.latency.shape == (len(batch), 2)
    first = batch.of_run(0)
    np.testing.assert_array_equal(first.latency, alone.latency)
    np.testing.assert_array_equal(first.posture, alone.posture)
    single = gymnasium.make("mpma_mj:TwoArmImitation-v0", motion="ymca", **OPTIONS)
    single.reset(seed=0)
    for _ in range(2):
        single.reset()
    info = single.reset()[1]
    met = []
    for action in alone.action:
        met.append(info["latency"])
        info = single.step(action)[-1]
    assert alone.latency is not None
    assert alone.latency.dtype == np.intp
    assert alone.latency.tolist() == met
    assert {0, 5} < set(met) <= set(range(6))
    envs.close()


def test_a_trace_with_one_latency_has_none() -> None:
    env = mpma_mj.load("ymca", repeats=1, latency=2)
    trace = record_epoch(env, mpma_mj.make_agent(env, kind="feedback_only"), 0)
    assert trace.latency is None
    assert "latency" not in trace.to_arrays()
    assert Trace.from_arrays(trace.to_arrays()).latency is None


@pytest.mark.parametrize(("latency", "known"), [(0, 0), (3, 3), ((0, 5), None), ((3, 3), None)])
def test_an_agents_spec_has_a_known_latency_and_the_lookahead(latency: Any, known: Any) -> None:
    envs = mpma_mj.make_vec(2, "ymca", latency=latency, lookahead=4)
    for env in (mpma_mj.load("ymca", latency=latency, lookahead=4), envs):
        spec = mpma_mj.make_agent(env, kind="feedback_only").spec
        assert (spec.latency, spec.lookahead) == (known, 4)
    assert mpma_mj.make_agent(mpma_mj.load("ymca"), kind="feedback_only").spec.lookahead == 0
    envs.close()


def test_a_range_survives_json() -> None:
    config = RunConfig.of(**OPTIONS)
    again = RunConfig.from_json(json.loads(json.dumps(config.to_json())))
    assert again == config
    assert hash(again) == hash(config)


def test_the_command_line_takes_a_range_and_its_run_is_resumed(
    tmp_path: Path, refused: Callable[..., None]
) -> None:
    out = str(tmp_path / "run")
    words = f"imitate ymca --repeats 1 --nodes 5 --modules 2 --epochs 1 --no-video --out {out}"
    typed = ["--latency", "0", "5", "--latency-every", "0.1", "0.5"]
    assert main([*words.split(), *typed]) == 0
    folder = RunFolder(Path(out))
    assert folder.read_config().env == EnvironmentOptions(**OPTIONS)
    latency = folder.read_trace().latency
    assert latency is not None
    assert {0, 5} < set(latency) <= set(range(6))
    resume = ["imitate", "--resume", out, "--epochs", "1", "--no-video"]
    assert main(resume) == 0
    assert main([*resume, *typed]) == 0
    refused(
        [*resume, "--latency", "0", "4"], "latency is 0 4, but the run to resume has 0 5; leave"
    )
    refused([*resume, *typed[:3], "--latency-every", "1", "2"], "latency-every is 1.0 2.0, but the")


@pytest.mark.parametrize(
    "options",
    [
        {"latency": (0, 3), "lookahead": 6},
        {"latency": (0, 3), "latency_every": (0.2, 0.6)},
        {"latency": 2, "observation_noise": 0.02, "state_estimate": True},
    ],
    ids=["drawn", "jumping, not shown", "noisy"],
)
def test_a_resumed_run_that_makes_up_for_latency_equals_an_uninterrupted_one(
    options: dict[str, Any], tmp_path: Path
) -> None:
    config = RunConfig.of(nodes=10, modules=2, repeats=1, reference_noise=0.25, **options)
    whole, parts = RunFolder(tmp_path / "whole"), RunFolder(tmp_path / "parts")
    train(config, 5, folder=whole)
    train(config, 2, folder=parts)
    resume(parts, 3)
    for name in RESULTS:
        assert (whole.path / name).read_bytes() == (parts.path / name).read_bytes(), name


def test_the_command_line_takes_one_number_as_before(tmp_path: Path) -> None:
    out = tmp_path / "run"
    words = f"imitate ymca --repeats 1 --nodes 5 --modules 2 --epochs 1 --no-video --out {out}"
    assert main([*words.split(), "--latency", "2"]) == 0
    assert RunFolder(out).read_config().env == EnvironmentOptions(repeats=1, latency=2)


@pytest.mark.parametrize(
    ("typed", "message"),
    [
        (
            "--latency",
            "--latency has no value; expected one whole number, such as 3, or a range of two",
        ),
        (
            "--latency 0.5",
            "--latency has '0.5'; expected one whole number, such as 3, or a range of",
        ),
        ("--latency 1 2 3", "--latency has '1 2 3'; expected one whole number"),
        ("--latency 3 ymca", "--latency has '3 ymca'; expected one whole number"),
        ("--latency 3 ymca", "such as 0 5; put motions before --latency"),
        ("--latency 5 0", "--latency is 5 0; expected a whole number from 0 to 100, or a range"),
        ("--latency -1 5", "--latency is -1 5; expected a whole number from 0 to 100, or a"),
        ("--latency-every 1 3", "give --latency two numbers that differ, or leave it out"),
        ("--latency 0 5 --latency-every 3 1", "--latency-every is 3.0 1.0; expected two times"),
        ("--latency 0 5 --latency-every 0.01 1", "expected a range from 0.05 s up, one control"),
    ],
)
def test_bad_latencies_on_the_command_line_are_one_line(
    typed: str, message: str, refused: Callable[..., None], tmp_path: Path
) -> None:
    words = ["imitate", "ymca", "--epochs", "1", "--no-video", "--out"]
    refused([*words, str(tmp_path / "run"), *typed.split()], message)


def test_the_help_shows_how_latency_is_typed(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["imitate", "--help"])
    shown = capsys.readouterr().out
    assert "--latency STEPS|{LOW HIGH}" in shown
    assert "--latency-every LOW HIGH" in shown


def test_a_grid_has_latencies_of_one_number_only() -> None:
    assert [c.option("latency") for c in points(["latency=0,3"], RunConfig())] == [0, 3]
    with pytest.raises(BadOptionError, match=r"grid has latency 'x'; expected a whole number$"):
        points(["latency=x"], RunConfig())
    for name in ("latency_every", "switch_every", "plants", "perturbation"):
        with pytest.raises(
            BadOptionError, match=f"grid has {name}, which takes several values at once"
        ):
            points([f"{name}=1"], RunConfig())


@pytest.mark.parametrize(
    "options",
    [
        *({"agent": name} for name in ("bc", "dagger", "promp", "dmp", "mosaic", "adaptive")),
        {"agent": "mpma", "models": "posture", "rule": "gated"},
    ],
)
@pytest.mark.parametrize("latency", [3, (0, 3)])
def test_an_agent_that_does_not_compensate_latency_is_warned_of(
    options: dict[str, Any], latency: Any
) -> None:
    config = RunConfig.of(**options, latency=latency)
    with pytest.warns(OptionWarning) as caught:
        _warn_of_latency(config)
    assert str(caught[0].message) == (
        f"{config.agent_name} does not compensate latency, as it does not use the commands under"
        " way; use the joint models of agent=mpma, best with lookahead=4"
    )
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        _warn_of_latency(config.replace(latency=0))
        for other in ("mpma", "single", "oracle"):
            _warn_of_latency(RunConfig.of(agent=other, latency=latency))
        name = "mine.py:Mine"  # of which nothing is known
        outside = OutsideConfig(options={"name": name})
        env = EnvironmentOptions(latency=latency)
        _warn_of_latency(RunConfig(agent=outside, agent_name=name, env=env))


def test_the_warning_of_latency_is_one_line_before_the_epochs(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = "imitate ymca --agent bc --expert-episodes 1 --arms kinematic --repeats 1 --no-video"
    assert main([*words.split(), "--latency", "1", "--out", str(tmp_path / "run")]) == 0
    first, second, *_ = capsys.readouterr().err.splitlines()
    assert first.startswith("mpma: warning: bc does not compensate latency, as it does not use")
    assert first.endswith("use the joint models of --agent mpma, best with --lookahead 2")
    assert second.startswith("epoch   1")
