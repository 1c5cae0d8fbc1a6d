"""Guesses of what is up, and of which arm is the left one."""

import mujoco
import numpy as np
import pytest

from mpma_mj.robots.geometry import arm_points
from mpma_mj.robots.limbs import Limb
from mpma_mj.robots.torso_guess import UPS, guess_up, is_left
from tests.robots.figures import figure, names

Arms = tuple[Limb, Limb]


def described(text: str) -> tuple[mujoco.MjModel, mujoco.MjData, Arms, np.ndarray]:
    """Return a figure, its simulation, the arms and their points."""
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    sides = ("left", "right") if "left_pitch" in text else ("one", "two")
    one, two = (tuple(model.joint(name).id for name in names(side)) for side in sides)
    points = np.stack([arm_points(model, data, arm, None) for arm in (one, two)])
    return model, data, (one, two), points


@pytest.mark.parametrize("named", [True, False])
def test_the_other_arm_is_the_other_side(named: bool) -> None:
    text = figure()
    if not named:
        text = text.replace("left", "one").replace("right", "two")
    model, _, arms, points = described(text)
    assert is_left(model, arms, points, UPS["z"])[0]
    assert is_left(model, arms[::-1], points[::-1], UPS["z"])[0] is False
    # Upside down the sides are exchanged, unless names tell them.
    assert is_left(model, arms, points, UPS["-z"])[0] is named


def test_gravity_tells_what_is_up() -> None:
    for gravity in ("0 0 -9.81", "0 0 0", "0 9 0"):
        text = figure(legs=False).replace(
            "<worldbody>", f'<option gravity="{gravity}"/><worldbody>'
        )
        up, why = guess_up(*described(text))
        assert up == UPS["z"]
        assert why.startswith("z is up, ")
