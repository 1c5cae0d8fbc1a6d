"""Options of an environment: bounds, contradictions, equality, the command line."""

import json
from dataclasses import dataclass, field, fields
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tyro

from mpma_mj.envs.load import load
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.errors import BadOptionError
from mpma_mj.kinematics import JOINT_NAMES
from mpma_mj.motions import ymca

NAMES = [option.name for option in fields(EnvironmentOptions)]


@dataclass(frozen=True)
class Run:
    env: EnvironmentOptions = field(default_factory=EnvironmentOptions)


@pytest.mark.parametrize(
    ("option", "value", "message"),
    [
        ("arms", "rubber", "arms is 'rubber'; expected one of physics, kinematic"),
        ("arms", np.array(["a", "b"]), "arms is array"),
        ("repeats", 0, "repeats is 0; expected a whole number from 1 to 1000"),
        ("repeats", 1.5, "repeats is 1.5"),
        ("repeats", True, "repeats is True"),
        ("reference_noise", -0.1, "reference_noise is -0.1; expected 0 to 1, such as 0.01"),
        ("reference_noise", float("nan"), "reference_noise is nan"),
        ("reference_noise", "1 %", "reference_noise is '1 %'"),
        ("control_timestep", 0.0, "control_timestep is 0.0; expected 0.001 to 1, in seconds"),
        ("gravity_compensation", 1, "gravity_compensation is 1; expected True or False"),
        ("payload", -1.0, "payload is -1.0; expected 0 to 1000, in kg"),
        ("payload", float("inf"), "payload is inf"),
        ("actuator_strength", 0.0, "actuator_strength is 0.0; expected 0.01 to 100"),
        (
            "locked_joint",
            "knee",
            f"locked_joint is 'knee'; expected one of {', '.join(JOINT_NAMES)}",
        ),
        ("locked_joint", 3, "locked_joint is 3; expected one of left_shoulder_abduction"),
        ("latency", -1, "latency is -1; expected a whole number from 0 to 100"),
        ("latency", 0.5, "latency is 0.5"),
        ("observation_noise", 2.0, "observation_noise is 2.0; expected 0 to 1"),
        ("perturbation", 5.0, "perturbation is 5.0; expected rate (0 to 100 a second) and size"),
        ("perturbation", (1.0, -5.0), "perturbation is (1.0, -5.0)"),
        ("perturbation", (1.0,), "perturbation is (1.0,)"),
        ("perturbation", {1.0, 2.0}, "perturbation is {1.0, 2.0}"),
        ("perturbation", {1.0: 2.0, 3.0: 4.0}, "perturbation is {1.0: 2.0"),
        ("perturbation", ("often", 3), "perturbation is ('often', 3)"),
        ("collisions", "yes", "collisions is 'yes'; expected True or False"),
        ("random_start", 0, "random_start is 0; expected True or False"),
        (
            "termination_distance",
            0.0,
            "termination_distance is 0.0; expected 0.001 to 10, in metres",
        ),
        ("reward_weights", {"elbow": 1.0}, "expected a weight for some of left_upper_arm, "),
        (
            "reward_weights",
            {"left_forearm": -1.0},
            "expected 0 to 1e+06 for left_forearm",
        ),
        (
            "reward_weights",
            {"left_forearm": float("inf")},
            "reward_weights is {'left_forearm': inf}",
        ),
        ("reward_weights", [1, 1, 1, 1], "reward_weights is [1, 1, 1, 1]"),
        ("lookahead", -1, "lookahead is -1; expected a whole number from 0 to 1000"),
        ("phase", None, "phase is None; expected True or False"),
        ("repeats", 1001, "repeats is 1001"),
        ("latency", 101, "latency is 101"),
        ("lookahead", 1001, "lookahead is 1001"),
        ("reference_noise", True, "reference_noise is True"),
        ("perturbation", (101.0, 1.0), "perturbation is (101.0, 1.0)"),
        ("perturbation", (1.0, 10_001.0), "perturbation is (1.0, 10001.0)"),
        ("perturbation", (True, 1.0), "perturbation is (True, 1.0)"),
        ("perturbation", (0, 10**400), "perturbation is (0, 1000"),
        ("robot", 5, "robot is 5; expected a name or a path"),
        (
            "robot",
            "none.xml",
            "none.xml: no such file; check the path; expected an MJCF file",
        ),
    ],
)
def test_an_option_out_of_bounds_is_reported_in_one_line(
    option: str, value: Any, message: str
) -> None:
    with pytest.raises(BadOptionError) as caught:
        load("ymca", **{option: value})
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_options_are_plain_copies() -> None:
    weights = {"left_forearm": np.float32(2)}
    options = EnvironmentOptions(
        repeats=np.uint8(200), reference_noise=Fraction(1, 100), phase=np.True_,
        perturbation=np.array([0.5, 30.0]),
        reward_weights=weights, robot=Path("arms.xml"),
    )  # fmt: skip
    weights["left_forearm"] = np.float32(-1)
    assert options.reward_weights == {"left_forearm": 2.0}
    assert type(options.repeats) is int
    assert options.robot == str(Path("arms.xml").absolute())
    assert (options.reference_noise, options.phase, options.perturbation) == (
        0.01,
        True,
        (0.5, 30.0),
    )
    load("ymca", arms="kinematic", perturbation=[0.0, 0.0])
    assert load("ymca", repeats=np.uint8(200)).task.steps == 200 * len(ymca()) - 1


def test_weights_that_are_all_zero_are_refused() -> None:
    names = ("left_upper_arm", "left_forearm", "right_upper_arm", "right_forearm")
    with pytest.raises(
        BadOptionError, match=r"reward_weights is .*; expected at least one above 0"
    ):
        load("ymca", reward_weights=dict.fromkeys(names, 0))


@pytest.mark.parametrize(
    "options",
    [
        {"gravity_compensation": True},
        {"payload": 1.0},
        {"actuator_strength": 0.5},
        {"perturbation": (1.0, 10.0)},
        {"collisions": True},
    ],
)
def test_kinematic_arms_refuse_options_that_act_by_forces(options: dict[str, Any]) -> None:
    (name,) = options
    with pytest.raises(
        BadOptionError, match=f"{name} is .*; ideal arms have no mass: leave {name} out"
    ):
        load("ymca", arms="kinematic", **options)
    load("ymca", arms="physics", **options)


def test_numpys_numbers_are_numbers() -> None:
    EnvironmentOptions(
        repeats=np.int64(2),
        reference_noise=np.float32(0.5),
        perturbation=[np.float64(1), np.int32(2)],
    )


def test_equal_options_have_equal_hashes() -> None:
    one = EnvironmentOptions(payload=1, perturbation=[0.5, 30], reward_weights={"left_forearm": 2})  # type: ignore[arg-type]
    other = EnvironmentOptions(
        payload=np.float32(1.0),  # type: ignore[arg-type]
        perturbation=(0.5, 30.0),
        reward_weights={"left_forearm": 2.0},
    )
    assert one == other
    assert hash(one) == hash(other)
    assert one != EnvironmentOptions(payload=1.0)
    assert len({one, other, EnvironmentOptions()}) == 2


def test_options_survive_a_file() -> None:
    options = EnvironmentOptions(
        robot="arms.xml", perturbation=(0.5, 30.0), reward_weights={"left_forearm": 2.0}
    )
    assert EnvironmentOptions(**json.loads(json.dumps(vars(options)))) == options


def test_the_command_line_takes_them_as_they_are() -> None:
    given = tyro.cli(
        tyro.conf.OmitArgPrefixes[Run],
        args=["--payload", "1.0", "--perturbation", "0.5", "30", "--robot", "arms.xml"],
    )
    assert given.env == EnvironmentOptions(payload=1.0, perturbation=(0.5, 30.0), robot="arms.xml")
