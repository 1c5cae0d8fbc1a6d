"""Environments that are changed while they run."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

from mpma_mj.envs.interventions import Intervention
from mpma_mj.envs.load import make_environment
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.envs.plants import Plant
from mpma_mj.errors import BadOptionError, StateError
from mpma_mj.motions import ymca
from tests.envs.user_models import edited

STEPS = 40
PLANTS = (Plant(), Plant(payload=2.0, actuator_gain=0.7), Plant(damping=1.0))
OPTIONS: dict[str, dict[str, Any]] = {
    "plain": {},
    "kinematic": {"arms": "kinematic", "actuator_gain": 0.8},
    "late": {"latency": 2},
    "noisy": {"observation_noise": 0.02, "lookahead": 3, "phase": True},
    "pushed": {"perturbation": (3.0, 30.0)},
    "switching": {"plants": PLANTS, "switch_every": (0.2, 0.4)},
    "jumping": {"latency": (0, 3), "latency_every": (0.2, 0.5)},
    "drawn": {"payload": (0.5, 2.0), "actuator_gain": (0.5, 1.5)},
    "collisions": {"collisions": True},
}


def made(*, adjustable: bool = True, **options: Any) -> Any:
    motion = ymca()
    return make_environment(motion, EnvironmentOptions(**options), 3, adjustable=adjustable)


def actions(steps: int = STEPS) -> np.ndarray:
    """Return actions that swing all joints far out."""
    turns = np.arange(steps)[:, None] / 8.0 + np.arange(8)
    return np.sin(turns)


def episode(env: Any, before_step: Any = lambda env, step: None) -> list[np.ndarray]:
    """Return all observations of an episode, each as one array."""
    env.task.episode = 5
    found = [env.reset()]
    for step, action in enumerate(actions()):
        before_step(env, step)
        found.append(env.step(action))
    return [np.concatenate([*map(np.ravel, t.observation.values())]) for t in found]


def intervene(env: Any, **changes: Any) -> None:
    env.task.intervene(env.physics, Intervention(**changes))


@pytest.mark.parametrize("kind", OPTIONS)
def test_that_an_environment_is_adjustable_changes_no_bit(kind: str) -> None:
    expected = episode(made(adjustable=False, **OPTIONS[kind]))
    np.testing.assert_array_equal(episode(made(**OPTIONS[kind])), expected)
    untouched = episode(made(**OPTIONS[kind]), lambda env, step: intervene(env))
    np.testing.assert_array_equal(untouched, expected)


@pytest.mark.parametrize("changes", [{"payload": 1.7}, {"actuator_gain": 0.6}, {"latency": 3}])
@pytest.mark.parametrize("arms", ["physics", "kinematic"])
def test_what_is_set_by_hand_equals_the_option_of_that_name(
    changes: dict[str, Any], arms: Any
) -> None:
    env = made(arms=arms)
    intervene(env, **changes)
    if arms == "kinematic" and "payload" in changes:
        changes = {}  # ideal arms have no mass
    np.testing.assert_array_equal(episode(env), episode(made(arms=arms, **changes)))


def test_a_plant_with_another_payload_keeps_its_gain() -> None:
    env = made(plants=PLANTS)
    intervene(env, plant=1, payload=0.5)
    expected = made(payload=0.5, actuator_gain=0.7)
    np.testing.assert_array_equal(episode(env), episode(expected))
    assert env.task.plant == 1


@pytest.mark.parametrize("payload", [0.0, 0.25, 1.0, 3.0])
def test_a_payload_that_is_set_makes_the_model_that_is_compiled(payload: float) -> None:
    env = made(payload=1.0)
    env.reset()
    env.step(np.ones(8))
    before = env.physics.data.ptr.qpos.copy(), env.physics.data.ptr.qvel.copy()
    intervene(env, payload=payload)
    np.testing.assert_array_equal(env.physics.data.ptr.qpos, before[0])
    np.testing.assert_array_equal(env.physics.data.ptr.qvel, before[1])
    model = env.physics.model.ptr
    expected = made(payload=payload).physics.model.ptr
    compared = 0
    for name in dir(model):
        value = getattr(model, name)
        if not name.startswith("_") and isinstance(value, np.ndarray):
            np.testing.assert_array_equal(value, getattr(expected, name), err_msg=name)
            compared += 1
    assert compared > 100
    # As MuJoCo derives constants, with data of its own, since it would reset the pose of these.
    derived = model.body_subtreemass.copy(), model.dof_invweight0.copy()
    mujoco.mj_setConst(model, mujoco.MjData(model))
    np.testing.assert_array_equal(model.body_subtreemass, derived[0])
    np.testing.assert_allclose(model.dof_invweight0, derived[1], rtol=1e-12)


@pytest.mark.parametrize("kind", ["switching", "jumping"])
def test_switching_by_hand_equals_a_schedule(kind: str) -> None:
    scheduled = made(**OPTIONS[kind])
    schedule: list[tuple[int | None, int | None]] = []

    def record(env: Any, step: int) -> None:
        schedule.append((env.task.plant, env.task.latency))

    expected = episode(scheduled, record)
    assert len(set(schedule)) > 2
    options = {n: v for n, v in OPTIONS[kind].items() if n in ("plants",)}

    def switch(env: Any, step: int) -> None:
        plant, latency = schedule[step]
        intervene(env, plant=plant, latency=latency)

    np.testing.assert_array_equal(episode(made(**options), switch), expected)


@pytest.mark.parametrize("kind", ["switching", "jumping", "drawn"])
def test_what_is_no_longer_set_is_as_drawn(kind: str) -> None:
    def release(env: Any, step: int) -> None:
        if step == 0:
            intervene(env, payload=3.0, actuator_gain=2.0, latency=5)
            intervene(env)

    expected = episode(made(**OPTIONS[kind]))
    np.testing.assert_array_equal(episode(made(**OPTIONS[kind]), release), expected)


def test_what_is_set_by_hand_stays_in_the_next_episode() -> None:
    env = made()
    intervene(env, payload=1.5, latency=1)
    episode(env)
    expected = made(payload=1.5, latency=1)
    np.testing.assert_array_equal(episode(env), episode(expected))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"payload": -1.0}, "payload is -1.0; expected 0 to 1000"),
        ({"actuator_gain": 0.0}, "actuator_gain is 0.0; expected"),
        ({"latency": 11}, "latency is 11; expected a whole number from 0 to 10"),
        ({"latency": 0.5}, "latency is 0.5; expected"),
        ({"plant": 3}, "plant is 3; expected an index below 3"),
    ],
)
def test_what_the_arms_cannot_become_is_refused(changes: dict[str, Any], message: str) -> None:
    env = made(plants=PLANTS)
    with pytest.raises(BadOptionError, match=message):
        intervene(env, **changes)
    np.testing.assert_array_equal(episode(env), episode(made(plants=PLANTS)))


def test_without_plants_none_can_be_set() -> None:
    with pytest.raises(BadOptionError, match="plant is 0; expected None: there are no plants"):
        intervene(made(), plant=0)


def test_a_model_without_hands_can_be_set_but_for_its_payload(tmp_path: Path) -> None:
    changes = ('name="left_hand"', 'name="left_tool"'), ('name="right_hand"', 'name="right_tool"')
    model = edited(tmp_path / "arms.xml", *changes)
    env = made(robot=model)
    intervene(env, actuator_gain=0.6)
    np.testing.assert_array_equal(episode(env), episode(made(robot=model, actuator_gain=0.6)))
    with pytest.raises(
        BadOptionError, match=r"payload is 1\.0; expected 0, since the model has no"
    ):
        intervene(env, payload=1.0)


def test_an_environment_that_is_not_adjustable_is_refused() -> None:
    with pytest.raises(StateError, match="made with adjustable=True"):
        intervene(made(adjustable=False), payload=1.0)


def test_pushes_move_the_hand_that_is_pushed() -> None:
    free, pushed = made(), made()
    for env in (free, pushed):
        env.reset()
    pushed.task.push = np.array([[0.0, 0.0, 0.0], [80.0, 0.0, 0.0]])
    for _ in range(3):
        free.step(np.zeros(8))
        pushed.step(np.zeros(8))
    moved = np.abs(pushed.physics.posture() - free.physics.posture())
    assert moved[:6].max() == 0.0
    assert moved[6:].max() > 0.01
    pushed.task.push = np.zeros((2, 3))
    pushed.step(np.zeros(8))
    assert not pushed.physics.data.ptr.xfrc_applied.any()


def test_pushes_by_hand_are_added_to_those_that_are_drawn() -> None:
    env = made(perturbation=(20.0, 30.0))
    env.reset()
    env.task.push = np.ones((2, 3))
    drawn = 0
    for _ in range(20):
        expected = env.task._drawn.perturbations[env.task.step] + 1.0
        drawn += bool((expected != 1.0).any())
        env.step(np.zeros(8))
        applied = env.physics.data.ptr.xfrc_applied[env.physics.hand_ids, :3]
        np.testing.assert_array_equal(applied, expected)
    assert drawn
