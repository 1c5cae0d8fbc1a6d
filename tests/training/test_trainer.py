"""Runs side by side: each goes as it would alone."""

import itertools
import json
import re
from typing import Any

import numpy as np
import pytest

from mpma_mj.agents import AGENTS
from mpma_mj.envs.arm_batch import PhysicsBatch
from mpma_mj.envs.vector_env import VectorImitationEnv
from mpma_mj.errors import BadOptionError
from mpma_mj.motions import ymca
from mpma_mj.training import trainer as training
from mpma_mj.training.config import RunConfig
from mpma_mj.training.factory import one_thread
from mpma_mj.training.trainer import Trainer, check, train_batch

SMALL = RunConfig.of(nodes=10, modules=2, repeats=1)
EPOCHS = 10
FIXED = [name for name, agent in AGENTS.items() if not agent.trainable]
# Each agent, and each signal of its own: one case of each path.
SETTINGS: list[tuple[str, dict[str, Any]]] = [
    ("physics", {}),
    ("kinematic", {"models": "posture", "rule": "gated", "efference_copy": "module"}),
    ("kinematic", {"forward_gating": False, "context_signal": "shuffled"}),
    ("kinematic", {"responsibility_predictors": False}),
    *(("kinematic", {"agent": agent}) for agent in ("mosaic", "hammer", "single", "oracle")),
    ("physics", {"agent": "adaptive"}),
    ("kinematic", {"agent": "mosaic", "models": "posture"}),
    *(("physics", {"agent": agent}) for agent in FIXED),
]


def seeds(count: int, **settings: Any) -> list[RunConfig]:
    return [SMALL.replace(seed=seed, **settings) for seed in range(count)]


def alone(config: RunConfig, epochs: int) -> dict[str, Any]:
    """Return the summary of a run by itself, as `mpma imitate` trains it."""
    with one_thread():
        trainer = Trainer([config], ymca())
        trainer.run_epoch()
        trainer.run(epochs)
    (summary,) = trainer.summaries()
    return summary


def exact(summaries: list[dict[str, Any]]) -> str:
    """Return all digits, also of what is not a number."""
    return json.dumps(summaries, default=float)


@pytest.mark.parametrize(("arms", "settings"), SETTINGS, ids=str)
def test_each_run_is_to_the_bit_what_it_is_alone(arms: str, settings: dict[str, Any]) -> None:
    configs = seeds(3, arms=arms, **settings)
    together = train_batch(configs, ymca(), 3)
    epochs = 3 if AGENTS[configs[0].agent_name].trainable else 1
    assert exact(together) == exact([alone(config, epochs) for config in configs])
    if configs[0].agent_name != "feedback_only":
        assert len({summary["p_e_percent"] for summary in together}) == 3


@pytest.mark.parametrize(
    ("arms", "noise", "models"),
    [
        ("physics", 0.14, {}),
        ("kinematic", 0.01, {"models": "posture", "rule": "gated"}),
    ],
    ids=str,
)
def test_those_who_stay_do_not_notice_who_leaves(
    arms: str, noise: float, models: dict[str, Any]
) -> None:
    configs = seeds(4, reference_noise=noise, arms=arms, **models)
    together = train_batch(configs, ymca(), EPOCHS)
    assert len({summary["epochs"] for summary in together}) > 1
    assert any(a["epochs"] < b["epochs"] for a, b in itertools.pairwise(together))
    assert exact(together) == exact([alone(config, EPOCHS) for config in configs])


def test_without_a_stop_all_epochs_are_danced_and_the_best_counts() -> None:
    configs = seeds(2, arms="kinematic")
    stopped = train_batch(configs, ymca(), EPOCHS)
    going_on = train_batch(configs, ymca(), EPOCHS, stop=False)
    assert [summary["epochs"] for summary in going_on] == [EPOCHS] * 2
    for before, after in zip(stopped, going_on, strict=True):
        assert before["converged"]
        assert before["epochs"] < EPOCHS
        assert after["converged"]
        assert after["p_e_percent"] <= before["p_e_percent"]
    assert any(after["best_epoch"] > EPOCHS / 2 for after in going_on)


@pytest.mark.parametrize("agent", ["mpma", "feedback_only"])
def test_a_run_that_diverges_fails_alone(agent: str, monkeypatch: pytest.MonkeyPatch) -> None:
    configs = seeds(3, agent=agent)
    undisturbed = train_batch(configs, ymca(), EPOCHS)
    epoch = 2 if AGENTS[agent].trainable else 1
    steps = undisturbed[0]["environment_steps"] // undisturbed[0]["epochs"]
    calls, step = itertools.count(), PhysicsBatch.step

    def step_or_diverge(batch: PhysicsBatch, *args: Any) -> np.ndarray:
        if next(calls) == (epoch - 1) * steps + 5:
            batch.set_joint_state(1, np.zeros(8), np.full(8, 1e12))
        return step(batch, *args)

    monkeypatch.setattr(PhysicsBatch, "step", step_or_diverge)
    disturbed = train_batch(configs, ymca(), EPOCHS)
    assert disturbed[1] == {"failed": f"epoch {epoch}: the simulation diverged at step 6"}
    assert exact([disturbed[0], disturbed[2]]) == exact([undisturbed[0], undisturbed[2]])


@pytest.mark.parametrize("agent", ["mpma", "mosaic", "feedback_only"])
def test_runs_that_all_diverge_at_once_all_fail(
    agent: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls, step = itertools.count(), PhysicsBatch.step

    def step_or_diverge(batch: PhysicsBatch, *args: Any) -> np.ndarray:
        if next(calls) == 5:
            for row in range(len(batch)):
                batch.set_joint_state(row, np.zeros(8), np.full(8, 1e12))
        return step(batch, *args)

    monkeypatch.setattr(PhysicsBatch, "step", step_or_diverge)
    outcomes = train_batch(seeds(3, agent=agent), ymca(), EPOCHS)
    assert outcomes == [{"failed": "epoch 1: the simulation diverged at step 6"}] * 3


def test_environments_are_closed_also_where_an_epoch_fails(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    closed: list[int] = []

    def close(envs: VectorImitationEnv) -> None:
        closed.append(id(envs))
        envs.closed = True

    def fail(*_: Any) -> None:
        raise RuntimeError("of the test")

    monkeypatch.setattr(VectorImitationEnv, "close", close)

    monkeypatch.setattr(training, "rollout", fail)
    with pytest.raises(RuntimeError, match="of the test"):
        train_batch(seeds(2), ymca(), EPOCHS)
    assert len(closed) == 1


NO_MPMA: dict[str, Any] = {
    "rule": "gated",
    "efference_copy": "module",
    "responsibility_predictors": False,
    "forward_gating": False,
}
NO_MODELS: dict[str, Any] = NO_MPMA | {
    "proprioception": False,
    "spectral_radius": 0.5,
    "reservoir_noise": 0.1,
    "context_signal": "nothing",
}


@pytest.mark.parametrize(
    ("agent", "name", "value"),
    [(agent, *setting) for agent in ("mosaic", "hammer") for setting in NO_MPMA.items()]
    + [(agent, *setting) for agent in FIXED for setting in NO_MODELS.items()],
)
def test_options_that_an_agent_does_not_have_are_refused(
    agent: str, name: str, value: object
) -> None:
    with pytest.raises(BadOptionError, match=f"{agent} has no option {name}, which mpma"):
        RunConfig.of(agent=agent, **{name: value})


@pytest.mark.parametrize("agent", AGENTS)
def test_all_agents_can_stand_in_one_grid_of_sizes(agent: str) -> None:
    (config,) = seeds(1, agent=agent)
    check(config.replace(modules=3, nodes=7), ymca())


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        (
            {"agent": "bogus", "context_signal": "nothing"},
            "agent is 'bogus'; expected one of mpma, ",
        ),
        (
            {"context_signal": "bogus"},
            "context_signal is 'bogus'; expected one of labels, nothing, ",
        ),
        ({"nodes": 30000}, "nodes is 30000; expected a whole number from 1 to 20000"),
        ({"nodes": "many"}, "nodes is 'many'"),
    ],
)
def test_what_no_run_can_have_is_refused_before_it_begins(
    setting: dict[str, Any], message: str
) -> None:
    with pytest.raises(BadOptionError, match=re.escape(message)):
        RunConfig.of(**setting)
