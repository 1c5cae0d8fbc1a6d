"""Parameters of a model in memory."""

import hypothesis
import mujoco
import numpy as np
import pytest
from hypothesis import strategies

from mpma_mj.envs.model import make_model
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.robots.robot_file import read_robot
from mpma_mj.sysid.parameters import UNITS, scaled, values

MODEL = make_model(EnvironmentOptions())


@hypothesis.given(
    strategies.fixed_dictionaries({name: strategies.floats(0.3, 3.0) for name in UNITS})
)
@hypothesis.settings(max_examples=10)
def test_values_are_multiplied_and_the_model_stays_as_it_is(factors: dict[str, float]) -> None:
    before = values(MODEL)
    after = values(scaled(MODEL, factors))
    for name in UNITS:
        assert np.allclose(after[name], factors[name] * before[name], rtol=1e-12)
        assert np.array_equal(values(MODEL)[name], before[name])


def test_masses_are_those_of_the_arms_and_no_others() -> None:
    masses = values(MODEL)
    assert masses["upper_arm_mass"] == pytest.approx(1.9783)
    assert masses["forearm_mass"] == pytest.approx(1.1826 + 0.4453)
    heavier = scaled(MODEL, {"upper_arm_mass": 2.0, "forearm_mass": 2.0})
    assert heavier.body("torso").mass == MODEL.body("torso").mass
    assert heavier.body("left_hand").inertia == pytest.approx(2.0 * MODEL.body("left_hand").inertia)


def test_joints_in_bodies_of_their_own_belong_to_the_upper_arm() -> None:
    spec = mujoco.MjSpec.from_file(str(read_robot("two_arm").model))
    for side in ("left", "right"):
        bone = spec.body(f"{side}_upper_arm").add_body(name=f"{side}_bone", mass=0.5)
        bone.inertia, bone.explicitinertial = np.full(3, 1e-3), True
    assert values(spec.compile())["upper_arm_mass"] == pytest.approx(1.9783 + 0.5)
