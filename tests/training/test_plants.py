"""Plants in training: recorded in traces, saved in run folders, named on the command line."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mpma_mj
from mpma_mj.cli import main
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.envs.plants import Plant
from mpma_mj.experiments.compare import jobs
from mpma_mj.trace import Trace
from mpma_mj.training.config import RunConfig
from mpma_mj.training.rollout import record_epoch
from mpma_mj.training.run_folder import RunFolder

OPTIONS: dict[str, Any] = {
    "repeats": 1,
    "plants": [{}, {"payload": 3.0}, {"actuator_gain": 1.5, "payload": 1.0}],
    "switch_every": (0.1, 0.5),
}


def test_a_trace_has_the_plant_that_each_action_met() -> None:
    envs, env = mpma_mj.make_vec(2, "ymca", **OPTIONS), mpma_mj.load("ymca", **OPTIONS)
    batch = record_epoch(envs, mpma_mj.make_agent(envs, kind="feedback_only"), 3)
    alone = record_epoch(env, mpma_mj.make_agent(env, kind="feedback_only"), 3)
    assert batch.plant is not None
    assert batch.plant.shape == (len(batch), 2)
    first = batch.of_run(0)
    np.testing.assert_array_equal(first.plant, alone.plant)
    np.testing.assert_array_equal(first.posture, alone.posture)
    env.task.episode = 3
    env.reset()
    met = []
    for action in alone.action:
        met.append(env.task.plant)
        env.step(action)
    assert alone.plant is not None
    assert alone.plant.tolist() == met
    assert set(met) == {0, 1, 2}
    envs.close()


def test_a_trace_without_plants_has_none() -> None:
    env = mpma_mj.load("ymca", repeats=1)
    trace = record_epoch(env, mpma_mj.make_agent(env, kind="feedback_only"), 0)
    assert trace.plant is None
    assert "plant" not in trace.to_arrays()
    assert Trace.from_arrays(trace.to_arrays()).plant is None


def test_epochs_of_training_meet_plants_in_turns() -> None:
    env = mpma_mj.load("ymca", repeats=1, plants=[{}, {"payload": 1.0}], epochs_per_plant=2)
    agent = mpma_mj.make_agent(env, kind="feedback_only")
    met = [set(record_epoch(env, agent, epoch).plant.tolist()) for epoch in range(5)]  # type: ignore[union-attr]
    assert met == [{0}, {0}, {1}, {1}, {0}]


def test_plants_survive_json() -> None:
    config = RunConfig.of(**OPTIONS)
    again = RunConfig.from_json(json.loads(json.dumps(config.to_json())))
    assert again == config
    assert hash(again) == hash(config)


def test_kinds_of_arms_are_not_compared_with_plants() -> None:
    config, motion = RunConfig.of(plants=[{}]), mpma_mj.read_motion("ymca")
    with pytest.raises(mpma_mj.errors.BadOptionError, match="kinds of arms are compared"):
        jobs([config], motion, epochs=1, fine_tune=1)


def test_the_command_line_takes_plants_and_their_run_is_resumed(
    tmp_path: Path, refused: Callable[..., None]
) -> None:
    out = str(tmp_path / "run")
    words = f"imitate ymca --repeats 1 --nodes 5 --modules 2 --epochs 1 --no-video --out {out}"
    typed = "--plants default payload=3 actuator-gain=1.5,payload=1 --switch-every 0.1 0.5"
    plants = typed.split()
    assert main([*words.split(), *plants]) == 0
    folder = RunFolder(Path(out))
    own = (Plant(), Plant(payload=3.0), Plant(actuator_gain=1.5, payload=1.0))
    expected = EnvironmentOptions(repeats=1, plants=own, switch_every=(0.1, 0.5))
    assert folder.read_config().env == expected
    plant = folder.read_trace().plant
    assert plant is not None
    assert plant.dtype == np.intp
    assert set(plant) == {0, 1, 2}
    resume = ["imitate", "--resume", out, "--epochs", "1", "--no-video"]
    assert main(resume) == 0
    assert main([*resume, *plants]) == 0
    message = (
        "plants is default payload=1, but the run to resume has"
        " default payload=3 payload=1,actuator_gain=1.5"
    )
    refused([*resume, "--plants", "default", "payload=1"], message)
    plants[-1] = "0.4"
    refused([*resume, *plants], "switch-every is 0.1 0.4, but the run to resume has 0.1 0.5;")


@pytest.mark.parametrize(
    ("typed", "message"),
    [
        (
            "--plants",
            "--plants has no plant; expected default, or each option once, such as payload",
        ),
        ("--plants default ymca", "--plants has 'ymca'; expected default, or each option once, s"),
        ("--plants payload=1,payload=2", "put motions before --plants"),
        ("--plants payloat=1", "plants[0] has no option 'payloat'; did you mean payload?"),
        ("--plants default payload=x", "plants[1]: payload is 'x'; expected 0 to 1000, in kg"),
        ("--plants default actuator-gain=0", "plants[1]: actuator_gain is 0.0; expected 0.01 to"),
        ("--switch-every 1 3", "give --plants too, or leave --switch-every out"),
        ("--epochs-per-plant 5", "give --plants too, or leave --epochs-per-plant out"),
        ("--plants default payload=1 --switch-every 3 1", "--switch-every is 3.0 1.0; expected"),
        ("--plants default payload=1 --switch-every 0.01 1", "expected a range from 0.05 s up"),
        ("--arms kinematic --plants default damping=1", "plants[1]: --damping is 1.0; ideal arms"),
    ],
)
def test_bad_plants_on_the_command_line_are_one_line(
    typed: str, message: str, refused: Callable[..., None], tmp_path: Path
) -> None:
    words = ["imitate", "ymca", "--epochs", "1", "--no-video", "--out"]
    refused([*words, str(tmp_path / "run"), *typed.split()], message)


def test_the_help_shows_how_plants_are_typed(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["imitate", "--help"])
    assert "--plants [default|OPTION=NUMBER" in capsys.readouterr().out
