"""Factory of environments: signatures, documentation, motions and rates."""

import inspect
import re
from collections.abc import Callable
from dataclasses import fields
from functools import partial
from pathlib import Path
from typing import Any

import dm_env
import gymnasium
import numpy as np
import pytest

import mpma_mj
from mpma_mj import metrics
from mpma_mj.envs.gym_env import ImitationEnv
from mpma_mj.envs.load import load
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.errors import BadOptionError, RecordingWarning
from mpma_mj.feedback import feedback_action
from mpma_mj.motions import read_motion, ymca

DOCS = Path(__file__).parents[2] / "docs" / "guides" / "environment.md"


NAMES = [option.name for option in fields(EnvironmentOptions)]


def followed(env: dm_env.Environment) -> float:
    """Return p_e of an episode under the feedback controller, percent."""
    timestep, postures, references = env.reset(), [], []
    while not timestep.last():
        seen = timestep.observation
        speed, timestep_s = env.task.max_joint_speed, env.control_timestep()
        action = feedback_action(seen["joint_angles"], seen["reference"], speed, timestep_s)
        timestep = env.step(action)
        postures.append(env.physics.posture())
        references.append(timestep.observation["reference"])
    return metrics.posture_error_percent(np.array(postures), np.array(references))


@pytest.mark.parametrize("motion", [5, None, ["ymca"]])
def test_a_value_that_is_no_motion_is_refused(motion: Any) -> None:
    with pytest.raises(BadOptionError, match=r"motion is .*; expected a name, a path, or what"):
        load(motion)


NAMED = "mpma_mj:TwoArmImitation-v0"
MAKERS: dict[str, tuple[Callable[..., Any], str]] = {
    "load": (load, "motion, seed, arms, "),
    "make_vec": (partial(mpma_mj.make_vec, 2), "num_envs, motion, seed, flat, autoreset_mode, "),
    "gymnasium.make": (partial(gymnasium.make, NAMED), "motion, seed, render_mode, width, "),
    "gymnasium.make_vec": (partial(gymnasium.make_vec, NAMED, 2), "num_envs, motion, seed, "),
}


@pytest.mark.parametrize("maker", MAKERS)
def test_a_misspelt_option_is_named_with_the_one_that_may_be_meant(maker: str) -> None:
    make, first = MAKERS[maker]
    for typed, meant in {
        "paylod": "payload",
        "refrence_noise": "reference_noise",
        "sed": "seed",
    }.items():
        with pytest.raises(BadOptionError, match=rf"^no option '{typed}'; did you mean {meant}\?$"):
            make(**{typed: 1})
    with pytest.raises(BadOptionError, match=f"^no option 'tempi'; expected {first}"):
        make(tempi=2)
    if maker != "load":
        with pytest.raises(BadOptionError, match=r"^no option 'camra'; did you mean camera\?$"):
            make(camra="front")


def test_all_arguments_but_the_motion_have_names() -> None:
    with pytest.raises(TypeError, match="positional"):
        load("ymca", "physics")  # type: ignore[misc]


def test_options_can_be_passed_on_by_name() -> None:
    options = vars(EnvironmentOptions(arms="kinematic", lookahead=3))
    assert load("ymca", **options).reset().observation["lookahead"].shape == (3, 12)
    assert ImitationEnv("ymca", **options).reset()[0]["lookahead"].shape == (3, 12)
    assert mpma_mj.make_vec(2, "ymca", **options).reset()[0]["lookahead"].shape == (2, 3, 12)


@pytest.mark.parametrize("function", [mpma_mj.load, mpma_mj.make_vec])
def test_signatures_show_every_option_with_its_default(function: Callable[..., object]) -> None:
    parameters = inspect.signature(function).parameters
    default = EnvironmentOptions()
    for name in NAMES:
        expected = None if name == "reward_weights" else getattr(default, name)
        assert parameters[name].default == expected, name
    assert list(parameters)[-len(NAMES) - 1 :] == [*NAMES, "options"]
    assert parameters["options"].annotation == "Never"  # as type checkers tell of unknown names


def test_every_option_stands_in_the_documentation_with_its_default() -> None:
    rows = re.findall(r"^\| `(\w+)` \|.*?\| `(.*?)` \|", DOCS.read_text(), re.MULTILINE)
    defaults = inspect.signature(load).parameters
    shown = {name: eval(default) for name, default in rows}
    assert list(shown) == ["motion", "seed", *NAMES]
    for name, default in shown.items():
        assert default == ({} if name == "reward_weights" else defaults[name].default), name


def test_control_timestep_sets_the_rate_of_the_motion() -> None:
    env = load("ymca", control_timestep=0.025, repeats=1)
    assert env.control_timestep() == pytest.approx(0.025)
    assert env.task.steps == len(read_motion("ymca", rate=40.0)) - 1
    load(ymca(rate=40.0), control_timestep=0.025)


def test_a_motion_of_another_rate_is_refused() -> None:
    with pytest.raises(
        BadOptionError, match=r"expected 0.05 s, .*; or read the motion with rate=40"
    ):
        load(ymca(), control_timestep=0.025)
    with pytest.raises(
        BadOptionError,
        match=r"of 5 ms, as at 28\.5714 or 33\.3333 Hz; use control_timestep=0\.035 or",
    ):
        load("ymca", control_timestep=0.033)
    with pytest.raises(BadOptionError, match=r"physics steps of 5 ms, as at 100 or 200 Hz"):
        load("ymca", control_timestep=0.006)


def test_tracking_is_worse_in_harder_environments() -> None:
    easy = followed(load("ymca", repeats=1))
    for harder in (
        {"payload": 5.0},
        {"actuator_strength": 0.1},
        {"latency": 2},
        {"perturbation": (5.0, 100.0)},
    ):
        assert followed(load("ymca", repeats=1, **harder)) > 1.1 * easy, harder


def test_a_rate_that_does_not_fit_the_physics_is_refused() -> None:
    with pytest.raises(BadOptionError, match="rate is 30 Hz"):
        load(ymca(rate=30.0))


def test_a_motion_that_is_too_fast_is_made_feasible_and_its_angles_are_observed() -> None:
    with pytest.warns(RecordingWarning, match=r"ymca: .* its actuator reaches 12; in the closest"):
        env = load(ymca(tempo=4.0), reference_noise=0.0, repeats=1)
    angles = env.task.motion.feasible_angles
    seen = env.reset().observation
    np.testing.assert_array_equal(seen["reference_angles"], angles[0])
    np.testing.assert_array_equal(seen["joint_angles"], angles[0])
    for number in (1, 2):
        seen = env.step(np.zeros(8)).observation
        np.testing.assert_array_equal(seen["reference_angles"], angles[number])
        np.testing.assert_array_equal(seen["target_angles"], angles[number + 1])
        np.testing.assert_allclose(seen["reference"], env.task.motion.posture[number], atol=1e-12)
    assert "reference_angles" not in load("ymca").reset().observation
