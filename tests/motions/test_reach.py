"""What a robot can reach, and what it can do at its speeds."""

import re

import numpy as np
import pytest

from mpma_mj.envs.load import arm_limits
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.motions import Motion, read_motion, ymca
from mpma_mj.motions.feasibility import JointLimits
from mpma_mj.motions.feasible_motion import feasible, feasible_tempo, fitted
from mpma_mj.motions.reach import Reach, close_tempo, reach_lines, reach_of


@pytest.fixture(scope="module")
def humanoid() -> JointLimits:
    return arm_limits(EnvironmentOptions(arms="kinematic", robot="cmu_humanoid"))


def _slower(limits: JointLimits, factor: float) -> JointLimits:
    return limits._replace(max_speed=factor * limits.max_speed)


def _half(tempo: float = 1.0) -> Motion:
    return read_motion("ymca", tempo=tempo, end=1.9)


def test_own_arms_reach_every_posture_and_do_all_of_ymca() -> None:
    reach = reach_of(ymca(), arm_limits())
    assert (reach.reachable, reach.feasible) == (1.0, 1.0)
    assert reach.unavoidable < 1e-9


def test_what_ranges_do_not_allow_is_not_reachable(humanoid: JointLimits) -> None:
    reach = reach_of(fitted(ymca(), humanoid)[0], humanoid)
    assert 0.8 < reach.reachable < 0.95
    narrow = arm_limits()._replace(highest=np.tile([np.inf, np.inf, np.inf, 1.0], 2))
    assert 0.2 < reach_of(fitted(ymca(), narrow)[0], narrow).reachable < 0.8


def test_speeds_change_what_is_feasible_and_not_what_is_reachable(humanoid: JointLimits) -> None:
    slow = _slower(humanoid, 0.3)
    fast_reach, reach = (reach_of(fitted(ymca(), one)[0], one) for one in (humanoid, slow))
    assert reach.reachable == fast_reach.reachable
    assert reach.feasible < 0.8 < fast_reach.feasible <= fast_reach.reachable


def test_a_slow_robot_does_nearly_all_at_the_tempo_that_is_found() -> None:
    slow = _slower(arm_limits(), 0.2)
    tempo, share = close_tempo(_half, slow)
    assert 0.25 < tempo < 1.0
    slowest, found, faster = (
        reach_of(fitted(_half(one), slow)[0], slow).feasible for one in (0.25, tempo, tempo + 0.05)
    )
    assert share == found >= slowest - 0.05
    assert faster < slowest - 0.05


def test_who_is_too_slow_learns_which_tempo_would_do(humanoid: JointLimits) -> None:
    _, change = feasible(_half(), humanoid)
    assert change is not None
    assert change.remedy == ""  # its ranges are why it cannot do more
    slow = _slower(humanoid, 0.25)
    _, change = feasible(_half(0.8), slow)
    assert change is not None
    with_tempo = re.fullmatch(
        r"\{tempo=(0.4|0.2)\} leaves (\d+) % of the steps within 5°, this one (\d+) %",
        change.remedy,
    )
    assert with_tempo is not None
    tempo, share, now = map(float, with_tempo.groups())
    assert share > now + 10
    again = reach_of(fitted(_half(tempo), slow)[0], slow)
    assert 100 * again.feasible == pytest.approx(share, abs=5)  # sampled otherwise


def test_a_robot_that_is_fast_enough_keeps_its_tempo(humanoid: JointLimits) -> None:
    assert feasible_tempo(_half, humanoid) == 1.0


@pytest.mark.parametrize(
    ("reach", "factor", "line"),
    [
        (Reach(1.0, 1.0, 0.0), 1.0, None),
        (Reach(0.9, 0.8, 0.5), 1.0, "a slower tempo hardly changes that"),
        (Reach(1.0, 0.8, 0.5), 0.2, "of this tempo all of it is feasible"),
        (Reach(1.0, 0.1, 9.0), 0.02, " % of it is feasible"),
    ],
)
def test_lines_say_at_which_tempo_all_is_feasible(
    reach: Reach, factor: float, line: str | None
) -> None:
    lines = reach_lines(reach, _half, _slower(arm_limits(), factor))
    assert lines[0].startswith(f"reachable: {100 * reach.reachable:.1f} % of the postures")
    assert f"an error of {reach.unavoidable:.2f} %" in lines[1]
    assert len(lines) == 2 if line is None else line in lines[2]
