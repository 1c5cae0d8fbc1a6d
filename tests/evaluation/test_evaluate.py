"""Evaluation and fine-tuning of trained agents under conditions."""

import dataclasses
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mpma_mj.cli import main
from mpma_mj.errors import CheckpointError, DivergedError, RunFolderError
from mpma_mj.evaluation import evaluate as evaluation
from mpma_mj.evaluation.evaluate import EvalCondition, evaluate, fine_tune, posture_errors_percent
from mpma_mj.motions import ymca
from mpma_mj.motions.motion import motion_arrays
from mpma_mj.motions.transforms import mirrored
from mpma_mj.training.checkpoints import TrainedAgents
from mpma_mj.training.config import RunConfig
from mpma_mj.training.rollout import Rollout
from mpma_mj.training.run_folder import RunFolder
from mpma_mj.training.trainer import train_agents
from mpma_mj.utils import data_files

SMALL = RunConfig.of(nodes=20, modules=2, repeats=1)
HOME = EvalCondition("home", ymca(), {})
CARRIED = EvalCondition("carried", ymca(), {"gravity_compensation": True})


def trained(*seeds: int, agent: str = "mpma") -> TrainedAgents:
    configs = [SMALL.replace(seed=seed, agent=agent) for seed in seeds]
    return train_agents(configs, ymca(), 8, {})


@pytest.mark.parametrize(
    "agent", ["mpma", "mosaic", "hammer", "adaptive", "oracle", "resolved_rate"]
)
def test_an_agent_in_a_batch_is_evaluated_to_the_bit_as_alone(agent: str) -> None:
    both = evaluate(trained(3, 5, agent=agent), CARRIED)
    (alone,) = evaluate(trained(5, agent=agent), CARRIED)
    assert both[1] is not None
    assert alone is not None
    batched, single = both[1].to_arrays(), alone.to_arrays()
    assert batched.keys() == single.keys()
    for name, signal in single.items():
        np.testing.assert_array_equal(batched[name], signal)


@pytest.mark.parametrize("agent", ["mpma", "mosaic"])
def test_an_evaluation_learns_nothing(agent: str) -> None:
    agents = trained(0, agent=agent)
    before = {name: array.copy() for name, array in agents.state.items()}
    first, second = (posture_errors_percent(evaluate(agents, HOME)) for _ in range(2))
    np.testing.assert_array_equal(first, second)
    for name, array in before.items():
        np.testing.assert_array_equal(agents.state[name], array)


def test_the_agent_of_a_run_is_that_of_a_batch(tmp_path: Path) -> None:
    words = "imitate ymca --nodes 20 --modules 2 --repeats 1 --seed 5 --epochs 8 --no-video --out"
    assert main([*words.split(), str(tmp_path / "run")]) == 0
    agents = trained(3, 5)
    of_run = TrainedAgents.of_run(RunFolder(tmp_path / "run"))
    assert of_run.seeds == [5]
    assert of_run.epochs[0] == agents.epochs[1]
    assert of_run.state.keys() == agents.state.keys()
    for name, array in of_run.state.items():
        np.testing.assert_array_equal(array[0], agents.state[name][1])


def test_fine_tuning_adapts_agents_of_ideal_arms_to_a_payload() -> None:
    configs = [SMALL.replace(nodes=50, repeats=3, arms="kinematic")]
    agents = train_agents(configs, ymca(), 30, {})
    heavy = EvalCondition("heavy", ymca(), {"arms": "physics", "payload": 2.0})
    at_once = posture_errors_percent(evaluate(agents, heavy))
    adapted, errors = fine_tune(agents, heavy, 3)
    assert errors.shape == (3, 1)
    assert errors[0] == pytest.approx(at_once, rel=0.2)  # before anything is learned there
    assert posture_errors_percent(evaluate(adapted, heavy)) < 0.8 * at_once
    assert posture_errors_percent(evaluate(agents, heavy)) == at_once  # the others are as they were


def test_agents_trained_without_latency_are_fine_tuned_with_one() -> None:
    agents = train_agents([SMALL], ymca(), 4, {})
    late = EvalCondition("late", ymca(), {"latency": 2})
    at_once = posture_errors_percent(evaluate(agents, late))
    adapted, _ = fine_tune(agents, late, 6)
    assert posture_errors_percent(evaluate(adapted, late)) < 0.5 * at_once
    home = posture_errors_percent(
        evaluate(adapted, HOME)
    )  # what is added for a latency is left out
    assert home < 2.0 * posture_errors_percent(evaluate(agents, HOME))


def test_a_checkpoint_of_other_settings_is_refused_by_its_folder(
    small_run: Path, tmp_path: Path
) -> None:
    folder = RunFolder(shutil.copytree(small_run, tmp_path / "run"))
    config = folder.read_config()
    state, row = folder.read_best(config)
    weights = state.pop("forward.weights")
    damaged: list[Any] = [weights[:1], np.zeros(()), weights + 0j, weights.astype(np.float16)]
    damaged += [weights.astype(str), np.full_like(weights, np.nan), np.full_like(weights, 1e31)]
    folder.write_checkpoint("best", config, state, {"row": row})
    with pytest.raises(CheckpointError, match=r"best\.npz: lacks forward\.weights; train"):
        evaluate(TrainedAgents.of_run(folder), HOME)
    for weights in damaged:
        state["forward.weights"] = weights
        folder.write_checkpoint("best", config, state, {"row": row})
        with pytest.raises(CheckpointError, match=r"best\.npz: does not fit its config"):
            evaluate(TrainedAgents.of_run(folder), HOME)


@pytest.mark.parametrize(
    "meta",
    [
        *({}, {"row": None}, {"row": {}}, {"row": [2]}, {"row": {"epoch": 1}}),
        *(
            {"row": {"epoch": n, "p_e_percent": 1.0}}
            for n in (None, -5, 0, 1.5, "1", True, 10**400)
        ),
        *({"row": {"epoch": float(n), "p_e_percent": 1.0}} for n in ("inf", "nan")),
        *({"row": {"epoch": 1, "p_e_percent": float(n)}} for n in ("inf", "nan", -1)),
    ],
)
def test_a_checkpoint_without_its_epoch_is_refused(
    meta: dict[str, object], small_run: Path, tmp_path: Path
) -> None:
    folder = RunFolder(shutil.copytree(small_run, tmp_path / "run"))
    config = folder.read_config()
    folder.write_checkpoint("best", config, folder.read_best(config)[0], meta)
    with pytest.raises(CheckpointError, match=r"best\.npz: (lacks the metrics|has)"):
        TrainedAgents.of_run(folder)


def test_no_run_and_one_of_another_version_are_refused(small_run: Path, tmp_path: Path) -> None:
    with pytest.raises(RunFolderError, match="is not a run"):
        TrainedAgents.of_run(RunFolder(tmp_path))
    other = RunFolder(shutil.copytree(small_run, tmp_path / "run"))
    data_files.write_json(other.path / "config.json", {"format": 1, "config": {}})
    with pytest.raises(CheckpointError, match="format 1, written by mpma-mj of another version"):
        TrainedAgents.of_run(other)


@pytest.mark.parametrize("other", ["shorter", "elsewhere", "other music"])
def test_a_run_folder_of_another_motion_is_refused(
    small_run: Path, tmp_path: Path, other: str
) -> None:
    folder = RunFolder(shutil.copytree(small_run, tmp_path / "run"))
    motion = folder.read_motion()
    changed = {
        "shorter": {"posture": motion.posture[:-4], "context": motion.context[:-4]},
        "elsewhere": {"posture": mirrored(motion).posture[::-1]},
        "other music": {"context": motion.context[::-1]},
    }[other]
    arrays = motion_arrays(dataclasses.replace(motion, **changed))
    header = {"config": folder.read_config().to_json()}
    data_files.write_arrays(folder.checkpoint("motion"), "motion", arrays, header)
    said = "has 228 moments" if other == "shorter" else "is not the motion of trace.npz"
    with pytest.raises(CheckpointError, match=said):
        TrainedAgents.of_run(folder)
    assert main(["evaluate", str(folder.path)]) == 2


def test_training_that_diverges_names_the_seed(monkeypatch: pytest.MonkeyPatch) -> None:
    from mpma_mj.training import trainer

    real = trainer.rollout

    def second_diverges(*given: object) -> Rollout:
        recorded = real(*given)  # type: ignore[arg-type]
        return Rollout(recorded.trace, {1: "the simulation diverged"})

    monkeypatch.setattr(trainer, "rollout", second_diverges)
    with pytest.raises(DivergedError, match="seed 4, epoch 1: the simulation diverged"):
        trained(3, 4)


def test_a_run_that_diverges_in_fine_tuning_stays_diverged(monkeypatch: pytest.MonkeyPatch) -> None:
    agents = trained(0, 1)
    real, epochs = evaluation.rollout, iter(range(9))

    def second_diverges_once(*given: object) -> Rollout:
        recorded = real(*given)  # type: ignore[arg-type]
        failures = {1: "the simulation diverged"} if next(epochs) == 1 else {}
        return Rollout(recorded.trace, failures)

    monkeypatch.setattr(evaluation, "rollout", second_diverges_once)
    _, course = fine_tune(agents, HOME, 3)
    assert np.isfinite(course[:, 0]).all()
    np.testing.assert_array_equal(np.isnan(course[:, 1]), [False, True, True])
