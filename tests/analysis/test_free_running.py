"""Free-running: own predictions and a closed loop in place of the demonstration."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mpma_mj import MPMAConfig, make_agent
from mpma_mj.agents import Agent
from mpma_mj.agents.wrappers import AlteredContext
from mpma_mj.analysis import free_running
from mpma_mj.analysis.free_running import (
    ANTICIPATION,
    OWN_PREDICTION,
    ClosedLoop,
    DemonstrationSource,
    FreeRunning,
    OwnPrediction,
    run_freely,
)
from mpma_mj.cli import main
from mpma_mj.envs.load import load
from mpma_mj.errors import BadOptionError
from mpma_mj.motions.motion import save_motion
from mpma_mj.training.rollout import record_epoch
from mpma_mj.training.run_folder import RunFolder
from tests.robots.humanoid import HUMANOID, short_dance, without_two_arm

Array = np.ndarray
WARMUP_STEPS = 20


def trained(kind: str = "mpma") -> tuple[Any, Agent]:
    env = load("ymca", arms="kinematic", repeats=1)
    agent = make_agent(env, MPMAConfig(nodes=10, modules=2), kind=kind)
    for epoch in range(2):
        record_epoch(env, agent, epoch)
        agent.learn()
    return env, agent


class Recorded:
    """Record of the observations that a source returns."""

    def __init__(self, source: DemonstrationSource) -> None:
        self.source = source
        self.seen: list[Any] = []
        self.reset = source.reset

    def __call__(self, observation: Any, shown: bool) -> Any:
        self.seen.append(self.source(observation, shown))
        return self.seen[-1]


@pytest.mark.parametrize("kind", ["mpma", "mosaic", "hammer", "single"])
def test_after_the_warm_up_the_own_prediction_replaces_the_demonstration(kind: str) -> None:
    env, agent = trained(kind)
    source = Recorded(OwnPrediction(agent))
    trace = record_epoch(env, FreeRunning(agent, source, WARMUP_STEPS), 2)
    assert trace.modules is not None
    expected = np.einsum("tm,tmd->td", trace.modules.responsibility, trace.modules.predictions)
    for step, seen in enumerate(source.seen):
        np.testing.assert_array_equal(seen["posture"], trace.posture[step])
        np.testing.assert_array_equal(seen["context"], trace.context[step])
        if step < WARMUP_STEPS:
            np.testing.assert_array_equal(seen["reference"], trace.reference[step])
        else:
            np.testing.assert_allclose(seen["reference"], expected[step - 1], atol=1e-12)
            np.testing.assert_array_equal(seen["target"], seen["reference"])


class Counting:
    """Anticipation whose posture at each step is one number, higher by one than that shown."""

    def __init__(self) -> None:
        self.episode = -1
        self.contexts: list[float] = []

    def reset(self, episode: int) -> None:
        self.episode = episode

    def __call__(self, observation: Any) -> Array:
        self.contexts.append(float(observation["context"][0]))
        return np.stack([observation["target"], observation["target"] + 1.0])


def test_a_closed_loop_continues_from_what_it_anticipated_itself() -> None:
    anticipation, clock = Counting(), np.arange(3.0)[:, None]
    loop = ClosedLoop(anticipation, clock)  # type: ignore[arg-type]
    loop.reset(7)
    assert anticipation.episode == 7
    shown = {"reference": np.array([4.0]), "target": np.array([5.0]), "context": np.zeros(1)}
    assert loop(shown, True) == shown
    gone = {name: np.full(1, np.nan) for name in ("reference", "target")} | {"own": np.ones(1)}
    pairs = [
        (seen["reference"].item(), seen["target"].item())
        for seen in (loop(gone, False) for _ in range(3))
    ]
    assert pairs == [(5.0, 6.0), (6.0, 7.0), (7.0, 8.0)]
    assert anticipation.contexts == [0.0, 1.0, 2.0, 0.0]  # its own clock, in repetitions


@pytest.mark.parametrize("closed", [False, True])
def test_the_warm_up_equals_an_episode_with_the_demonstration(closed: bool) -> None:
    env, agent = trained()
    source: DemonstrationSource = OwnPrediction(agent)
    if closed:
        source = ClosedLoop(Counting(), env.task.context)  # type: ignore[arg-type]
    free = record_epoch(env, FreeRunning(agent, source, WARMUP_STEPS), 2)
    held = record_epoch(env, agent, 2)
    np.testing.assert_array_equal(free.action[:WARMUP_STEPS], held.action[:WARMUP_STEPS])
    assert not np.array_equal(free.action, held.action)


def test_a_free_running_agent_learns_nothing_not_even_at_every_step() -> None:
    env, agent = trained("mosaic")
    before = agent.state_dict()
    record_epoch(env, FreeRunning(agent, OwnPrediction(agent), WARMUP_STEPS), 2)
    for name, value in agent.state_dict().items():
        np.testing.assert_array_equal(value, before[name], err_msg=name)


def test_an_agent_with_an_altered_context_can_run_free() -> None:
    env, agent = trained()
    altered = AlteredContext(agent, "constant", env.task.context, env.task.period, 0)
    free = FreeRunning(altered, OwnPrediction(altered), WARMUP_STEPS)
    assert record_epoch(env, free, 2).action.shape == (env.task.steps, 8)


def test_agents_without_forward_models_have_no_own_prediction() -> None:
    agent = make_agent(load("ymca"), kind="feedback_only")
    with pytest.raises(
        BadOptionError, match=r"agent is 'FeedbackOnly'; expected .* forward models"
    ):
        OwnPrediction(agent)


def test_predictions_of_late_agents_are_not_of_the_next_step() -> None:
    agent = make_agent(load("ymca", latency=2, lookahead=3), MPMAConfig(nodes=5))
    with pytest.raises(BadOptionError, match="latency is 2; expected an agent without latency"):
        OwnPrediction(agent)


def test_what_is_learned_of_another_robot_is_with_its_kinematics(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    save_motion(tmp_path / "dance.npz", short_dance())
    words = f"{tmp_path / 'dance.npz'} --robot {HUMANOID} --arms kinematic --out {tmp_path / 'run'}"
    assert main(f"imitate {words} --nodes 10 --modules 2 --epochs 3 --no-video".split()) == 0
    monkeypatch.setattr(free_running, "_DURATION", 1.0)
    without_two_arm(monkeypatch)
    runs, motion = run_freely(RunFolder(tmp_path / "run"))
    np.testing.assert_array_equal(motion.feasible_angles, short_dance().feasible_angles)
    assert list(runs) == [OWN_PREDICTION, ANTICIPATION]


@pytest.mark.parametrize("closed", [False, True])
def test_after_the_warm_up_no_joint_angles_are_demonstrated(closed: bool) -> None:
    env = load(short_dance(), robot=HUMANOID, arms="kinematic", repeats=1, lookahead=2)
    agent = make_agent(env, MPMAConfig(nodes=10, modules=2))
    own: DemonstrationSource = OwnPrediction(agent)
    if closed:
        own = ClosedLoop(Counting(), env.task.context)  # type: ignore[arg-type]
    source = Recorded(own)
    record_epoch(env, FreeRunning(agent, source, WARMUP_STEPS), 0)
    for step, seen in enumerate(source.seen):
        angles = [name for name in seen if name in ("reference_angles", "lookahead_angles")]
        assert len(angles) == (2 if step < WARMUP_STEPS else 0)
