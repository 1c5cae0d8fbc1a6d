"""Training with options that are drawn for each episode: files, command line, other commands."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mpma_mj.cli import main
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.errors import BadOptionError
from mpma_mj.experiments.compare import jobs
from mpma_mj.metrics import posture_error_percent
from mpma_mj.motions import ymca
from mpma_mj.training.checkpoints import demonstrated
from mpma_mj.training.config import RunConfig
from mpma_mj.training.run import resume, train
from mpma_mj.training.run_folder import RunFolder

OPTIONS: dict[str, Any] = {"repeats": 1, "payload": (0.0, 3.0), "observation_noise": (0.0, 0.05)}
TINY: dict[str, Any] = {"nodes": 5, "modules": 2}


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
    typed = ["--payload", "0", "3", "--observation-noise", "0", "0.05"]
    assert main([*words.split(), *typed]) == 0
    assert RunFolder(Path(out)).read_config().env == EnvironmentOptions(**OPTIONS)
    again = ["imitate", "--resume", out, "--epochs", "1", "--no-video"]
    assert main([*again, *typed]) == 0
    refused(
        [*again, "--payload", "0", "2"], "payload is 0.0 2.0, but the run to resume has 0.0 3.0"
    )


def test_one_number_is_typed_as_before(tmp_path: Path) -> None:
    out = tmp_path / "run"
    words = f"imitate ymca --repeats 1 --nodes 5 --modules 2 --epochs 1 --no-video --out {out}"
    assert main([*words.split(), "--payload", "1", "--reference-noise", "0"]) == 0
    expected = EnvironmentOptions(repeats=1, payload=1.0, reference_noise=0.0)
    assert RunFolder(out).read_config().env == expected


def test_a_range_of_equal_ends_is_typed_and_its_agent_is_that_of_the_number(tmp_path: Path) -> None:
    traces = []
    for number, typed in enumerate((["1"], ["1", "1"])):
        out = tmp_path / str(number)
        words = f"imitate ymca --repeats 1 --nodes 5 --modules 2 --epochs 1 --no-video --out {out}"
        assert main([*words.split(), "--payload", *typed]) == 0
        traces.append(RunFolder(out).read_trace())
    np.testing.assert_array_equal(traces[0].posture, traces[1].posture)


def test_the_motion_of_a_run_is_told_from_another_by_the_largest_noise_drawn(
    tmp_path: Path,
) -> None:
    config, folder = RunConfig.of(repeats=1, reference_noise=(0.0, 0.5), **TINY), tmp_path / "run"
    train(config, 1, folder=RunFolder(folder))
    demonstration, trace = demonstrated(RunFolder(folder))
    reference = demonstration.episode(0, 0).reference[: len(trace.reference)]
    # Beyond what is tolerated without noise, percent, or the lowest of the range would do.
    assert 1.0 < posture_error_percent(trace.reference, reference) < 50.0


def test_a_resumed_run_equals_an_uninterrupted_one(tmp_path: Path) -> None:
    config = RunConfig.of(reference_noise=(0.1, 0.3), **TINY, **OPTIONS)
    whole, parts = RunFolder(tmp_path / "whole"), RunFolder(tmp_path / "parts")
    train(config, 5, folder=whole)
    train(config, 2, folder=parts)
    resume(parts, 3)
    for name in ("metrics.csv", "trace.npz"):
        assert (whole.path / name).read_bytes() == (parts.path / name).read_bytes()


@pytest.mark.parametrize(
    ("typed", "message"),
    [
        ("--payload", "--payload has no value; expected one number, or a range of two, the lowest"),
        ("--payload x", "--payload has 'x'; expected one number, or a range of two, the lowest"),
        ("--payload 1 2 3", "--payload has '1 2 3'; expected one number, or a range of two"),
        ("--payload 1 ymca", "the lowest first; put motions before --payload"),
        ("--payload 3 0", "--payload is 3.0 0.0; expected 0 to 1000, in kg, or a range of two"),
        ("--payload -1 1", "--payload is -1.0 1.0; expected 0 to 1000, in kg, or a range of two"),
        (
            "--reference-noise 0 2",
            "--reference-noise is 0.0 2.0; expected 0 to 1, such as 0.01, or",
        ),
        ("--payload 0 3 --plants default payload=1", "give one number, or leave --plants out"),
        ("--arms kinematic --payload 0 3", "ideal arms have no mass: leave --payload out, or"),
        ("--random-start adaptive", "imitate has no option --random-start; leave it out: training"),
    ],
)
def test_bad_ranges_on_the_command_line_are_one_line(
    typed: str, message: str, refused: Callable[..., None], tmp_path: Path
) -> None:
    words = ["imitate", "ymca", "--epochs", "1", "--no-video", "--out"]
    refused([*words, str(tmp_path / "run"), *typed.split()], message)


def test_the_help_shows_how_ranges_are_typed(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["imitate", "--help"])
    assert "--payload NUMBER|{LOW HIGH}" in capsys.readouterr().out


def test_training_refuses_adaptive_starts() -> None:
    with pytest.raises(BadOptionError, match="random_start is 'adaptive'; expected the default"):
        RunConfig.of(random_start="adaptive")


def test_kinds_of_arms_are_compared_with_a_single_plant() -> None:
    message = r"actuator_gain is \(0\.5, 1\.5\); expected one number, as kinds of arms are compared"
    with pytest.raises(BadOptionError, match=message):
        jobs([RunConfig.of(actuator_gain=(0.5, 1.5))], ymca(), epochs=1, fine_tune=1)
