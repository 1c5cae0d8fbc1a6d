"""What breaks when modules are switched off, and the command that tells it."""

import contextlib
import json
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mpma_mj import make_agent
from mpma_mj.agents.gain_schedule import Gains
from mpma_mj.agents.signals import ModuleSignals
from mpma_mj.agents.wrappers import AgentWrapper
from mpma_mj.analysis.lesion import (
    Dance,
    Lesion,
    Lesions,
    Lost,
    _measure,
    dance_without,
    what_can_be_lost,
)
from mpma_mj.analysis.lesion_figure import drawn, write_figure
from mpma_mj.analysis.lesion_table import matrix, summary
from mpma_mj.cli import main
from mpma_mj.evaluation.evaluate import EVALUATION_EPISODE, EvalCondition, evaluate, tracking_errors
from mpma_mj.metrics import posture_error_percent
from mpma_mj.motions import ymca
from mpma_mj.trace import Trace
from mpma_mj.training.checkpoints import TrainedAgents
from mpma_mj.training.config import RunConfig
from mpma_mj.training.factory import agent_of, make_environments
from mpma_mj.training.rollout import record_epoch
from mpma_mj.training.run_folder import RunFolder
from mpma_mj.utils import atomic_files
from tests.conftest import Refused

TINY = "--nodes 10 --repeats 1 --no-video --out"


@pytest.fixture(scope="module")
def tiny_run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("runs") / "tiny"
    assert main(["imitate", "ymca", "--modules", "2", *TINY.split(), str(folder)]) == 0
    return folder


@pytest.fixture(scope="module")
def trained(tiny_run: Path) -> TrainedAgents:
    return TrainedAgents.of_run(RunFolder(tiny_run))


@pytest.fixture
def run(tiny_run: Path, tmp_path: Path) -> Path:
    return shutil.copytree(tiny_run, tmp_path / "run")


def untrained(**settings: Any) -> TrainedAgents:
    """Return an agent that has learned nothing."""
    config = RunConfig.of("ymca", nodes=10, repeats=1, arms="kinematic", **settings)
    motion = ymca()
    with contextlib.closing(make_environments(config, [0], motion)) as envs:
        state = agent_of(config, envs, [0]).state_dict()
    return TrainedAgents((config,), motion, state, np.array([1]))


def test_each_module_each_two_and_all_can_be_lost() -> None:
    singles, pairs = [(0,), (1,), (2,)], [(0, 1), (0, 2), (1, 2)]
    assert what_can_be_lost(untrained(modules=3)) == [(), *singles, *pairs, (0, 1, 2)]


def test_of_two_modules_no_two_can_be_lost_and_one_stay() -> None:
    assert what_can_be_lost(untrained(modules=2)) == [(), (0,), (1,), (0, 1)]


def test_modules_of_plants_that_were_never_met_cannot_be_lost() -> None:
    met = untrained(modules=2, max_plants=3)
    assert what_can_be_lost(met) == [(), (0,), (1,), (0, 1)]
    met.state["plants.recruited"][0] = 2
    assert what_can_be_lost(met)[:5] == [(), (0,), (1,), (2,), (3,)]
    silent = dance_without(met, (0, 1, 2, 3), 1)
    assert silent.retrained is None
    lesion = dance_without(met, (0, 1), 1)
    assert lesion.retrained is not None
    assert not lesion.retrained.responsibility[:, :2].any()


def test_an_agent_behind_other_ears_can_lose_modules() -> None:
    deaf = untrained(context_signal="nothing", modules=2)
    assert dance_without(deaf, (1,), 0).at_once.responsibility[:, 1].max() == 0.0


def test_who_lost_nothing_dances_as_in_any_trial(trained: TrainedAgents) -> None:
    intact = dance_without(trained, (), 0)
    assert intact.retrained is None
    (error,) = tracking_errors(evaluate(trained, EvalCondition("same", trained.motion, {})))
    assert intact.at_once.p_e_percent == error


def test_with_all_modules_silent_it_is_the_feedback_controller_with_its_gain(
    trained: TrainedAgents,
) -> None:
    gain = Gains(float(trained.state["progress"][0])).feedback
    assert gain < 0.15

    class Weak(AgentWrapper):
        def act(self, observation: Any) -> np.ndarray:
            return gain * super().act(observation)

    with contextlib.closing(make_environments(trained.configs[0], [0], trained.motion)) as envs:
        alone = Weak(make_agent(envs, kind="feedback_only"))
        trace = record_epoch(envs, alone, EVALUATION_EPISODE).of_run(0)
    expected = posture_error_percent(trace.posture[1:], trace.reference[1:])
    silent = dance_without(trained, (0, 1), 1)
    assert silent.at_once.p_e_percent == pytest.approx(expected, rel=1e-9)
    assert silent.retrained is None
    assert expected > 3.0 * dance_without(trained, (), 0).at_once.p_e_percent


def test_lost_modules_have_no_responsibility_and_the_others_learn(trained: TrainedAgents) -> None:
    lesion = dance_without(trained, (0,), 1)
    assert lesion.retrained is not None
    for dance in (lesion.at_once, lesion.retrained):
        np.testing.assert_allclose(dance.responsibility, [[0, 1]] * 4)
        np.testing.assert_array_equal(dance.dominant, 1)
    assert lesion.retrained.p_e_percent != lesion.at_once.p_e_percent
    # At once does not depend on whether it will learn.
    assert dance_without(trained, (0,), 0).at_once.p_e_percent == lesion.at_once.p_e_percent


def test_hammer_that_was_prepared_learns_no_more() -> None:
    hammer = untrained(agent="hammer")
    assert dance_without(hammer, (1,), 1).retrained is not None
    hammer.state["prepared"][...] = 3
    lesion = dance_without(hammer, (1,), 1)
    assert lesion.retrained is None
    assert not lesion.at_once.responsibility[:, 1].any()


def test_errors_are_of_the_label_to_which_a_step_leads() -> None:
    steps, reference = 4, np.zeros((5, 12))
    posture = reference + np.array([0.9, 0.2, 0.2, 0.6, 0.6])[:, None]  # the first is not danced
    context = np.eye(3)[[0, 0, 0, 1, 1]]
    responsibility = np.array([[1.0, 0.0, 0.0]] * 3 + [[0.0, 0.0, 1.0]] * (steps - 3))
    trace = Trace(
        posture=posture,
        reference=reference,
        context=context,
        joint_angles=np.zeros((5, 8)),
        joint_velocities=np.zeros((5, 8)),
        action=np.zeros((4, 8)),
        reward=np.zeros(4),
        modules=ModuleSignals(
            responsibility, responsibility, np.zeros((4, 3, 8)), np.zeros((4, 3, 12))
        ),
    )
    dance = _measure(trace)
    assert dance.p_e_percent == pytest.approx(20.0)
    np.testing.assert_allclose(dance.label_p_e_percent, [10.0, 30.0, np.nan])
    # And responsibilities are of the label that is heard.
    np.testing.assert_allclose(dance.responsibility, [[1, 0, 0], [0, 0, 1], [np.nan] * 3])
    np.testing.assert_array_equal(dance.dominant, [0, 2, -1])


def dance(errors: list[float], shares: list[list[float]]) -> Dance:
    share = np.array(shares)
    return Dance(float(np.mean(errors)), np.array(errors), share, share.argmax(axis=1))


def invented(scale: float = 1.0, *, learned: bool = True) -> Lesions:
    """Return lesions of an agent of three modules and two labels, of modules 1 and 2."""

    def lesion(lost: Lost, before: float, after: float, shares: list[list[float]]) -> Lesion:
        own = np.isin([0, 1], lost)
        at_once = dance([scale * (before if lost_it else 1.0) for lost_it in own], shares)
        return Lesion(lost, at_once, dance([after, after], shares) if learned else None)

    return Lesions(
        ("Y", "M"),
        (
            lesion((), 1.0, 0.5, [[0.8, 0.1, 0.1], [0.0, 1.0, 0.0]]),
            lesion((0,), 4.0, 2.0, [[0.0, 0.4, 0.6], [0.0, 1.0, 0.0]]),
            lesion((1,), 6.0, 3.0, [[0.9, 0.0, 0.1], [0.2, 0.0, 0.8]]),
            lesion((2,), 9.0, 1.0, [[0.9, 0.1, 0.0], [0.0, 1.0, 0.0]]),
            lesion((0, 1), 8.0, 4.0, [[0.0, 0.0, 1.0], [0.0, 0.0, 1.0]]),
            replace(lesion((0, 1, 2), 12.0, 0.0, [[1, 0, 0], [0, 1, 0]]), retrained=None),
        ),
        epochs=3 if learned else 0,
    )


def test_a_summary_tells_own_labels_from_others() -> None:
    lines = summary([invented()]).splitlines()
    head = (
        "| p_e, %, without | intact | at once | intact, 3 epochs on | after 3 epochs | all silent |"
    )
    assert lines[0] == head
    assert lines[2:6] == [
        "| one module, in its own labels | 1.00 | 5.00 | 0.50 | 2.50 | 12.00 |",
        "| one module, in other labels | 1.00 | 1.00 | 0.50 | 2.50 | 12.00 |",
        "| one module, dominant in none | 1.00 | 1.00 | 0.50 | 1.00 | 12.00 |",
        "| two modules, in its own labels | 1.00 | 8.00 | 0.50 | 4.00 | 12.00 |",
    ]
    assert lines[7] == (
        "| in its own labels, without | taken over at once, % | taken over after 3 epochs, %"
        " | largest λ intact | largest λ at once | largest λ after 3 epochs |"
    )
    assert lines[9:] == [
        f"| one module | {100 * 7 / 11:.0f} | {100 * 9.5 / 11.5:.0f} | 0.90 | 0.70 | 0.70 |",
        f"| two modules | {100 * 4 / 11:.0f} | {100 * 8 / 11.5:.0f} | 0.90 | 1.00 | 1.00 |",
    ]


def test_a_summary_of_several_runs_has_intervals_between_their_values() -> None:
    line = summary([invented(), invented(scale=2.0)]).splitlines()[2]
    assert "| 7.50 [5.00, 10.00] |" in line


def test_without_learning_on_there_is_no_column_of_it() -> None:
    stayed = invented(learned=False)
    assert "after" not in summary([stayed])
    assert "→" not in matrix(stayed)
    mixed = summary([stayed, invented()]).splitlines()[2]
    assert mixed.endswith("| 1.00 | 5.00 | 0.50 | 2.50 | 12.00 |")


def test_a_matrix_has_a_row_for_every_lesion() -> None:
    lines = matrix(invented()).splitlines()
    assert lines[0] == "| p_e, %, at once → after learning on | Y | M | all |"
    assert lines[3] == "| without 1 | 4.00 → 2.00 | 1.00 → 2.00 | 2.50 → 2.00 |"
    assert lines[7] == "| all silent | 12.00 | 12.00 | 12.00 |"
    assert lines[12] == "| without 1 | 3 (0.60) → 3 (0.60) | 2 (1.00) → 2 (1.00) |"
    assert len(lines) == 8 + 1 + 7


def test_a_label_that_is_not_danced_is_a_dash_and_null(tmp_path: Path) -> None:
    undanced = Dance(1.0, np.array([1.0, np.nan]), np.array([[1.0], [np.nan]]), np.array([0, -1]))
    gone = Lesion((0,), undanced, None)
    silent = Lesion((0,), replace(undanced, label_p_e_percent=np.array([9.0, np.nan])), None)
    without = Lesions(("Y", "M"), (Lesion((), undanced, None), gone, silent), 0)
    assert "| intact | 1.00 | – | 1.00 |" in matrix(without)
    assert "nan" not in summary([without])
    atomic_files.write_json(tmp_path / "lesion.json", without.as_json())
    first = json.loads((tmp_path / "lesion.json").read_text())["lesions"][0]
    assert first["at_once"]["labels"]["M"]["p_e_percent"] is None
    write_figure(tmp_path / "lesion.png", without, "a dance")


def test_pairs_are_not_drawn_where_they_are_many() -> None:
    few = invented()
    assert drawn(few) == list(few.lesions)
    pairs = few.lesions[4:5] * 20
    many = replace(few, lesions=(*few.lesions[:4], *pairs, few.silent))
    assert drawn(many) == [*few.lesions[:4], few.silent]


@pytest.mark.parametrize("learned", [True, False])
def test_a_figure_is_drawn_whatever_labels_are_called(tmp_path: Path, learned: bool) -> None:
    without = replace(invented(learned=learned), labels=("a dance of a long name", "M"))
    write_figure(tmp_path / "lesion.png", without, "two dances")
    assert (tmp_path / "lesion.png").read_bytes().startswith(b"\x89PNG")


def test_a_plant_recruited_while_learning_on_has_modules_in_the_figure(tmp_path: Path) -> None:
    without = invented()
    intact = without.intact
    assert intact.retrained is not None
    more = np.pad(intact.retrained.responsibility, ((0, 0), (0, 2)), constant_values=0.5)
    learned = replace(intact, retrained=replace(intact.retrained, responsibility=more))
    without = replace(without, lesions=(learned, *without.lesions[1:]))
    assert without.modules == 5
    write_figure(tmp_path / "lesion.png", without, "in two plants")
    assert (tmp_path / "lesion.png").read_bytes().startswith(b"\x89PNG")


def test_a_run_gets_tables_json_and_a_figure(run: Path) -> None:
    words = [sys.executable, "-m", "mpma_mj.cli", "lesion", str(run), "--retrain", "1"]
    result = subprocess.run(words, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    assert result.stderr == "run: switching modules off\n"
    lines = result.stdout.splitlines()
    assert lines[-1] == str(run / "figures" / "lesion.png")
    assert lines[0] == "| p_e, %, at once → after learning on | Y | M | C | A | all |"
    assert any(line.startswith("| one module, in its own labels | ") for line in lines)
    assert (run / "figures" / "lesion.png").read_bytes().startswith(b"\x89PNG")
    content = json.loads((run / "lesion.json").read_text())
    assert content["retrain_epochs"] == 1
    assert set(content["dominant_module"]) == set("YMCA")
    lost = [lesion["lost"] for lesion in content["lesions"]]
    assert lost == [[], [1], [2], [1, 2]]
    intact, silent = content["lesions"][0]["at_once"], content["lesions"][-1]["at_once"]
    assert silent["p_e_percent"] > 3 * intact["p_e_percent"]
    assert len(intact["labels"]["Y"]["responsibility"]) == 2


def test_several_runs_are_summed_up_and_a_later_look_tells_the_same(
    run: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    other = with_settings(run, seed=5)
    capsys.readouterr()
    assert main(["lesion", str(run), str(other), "--retrain", "0"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "| p_e, %, without | intact | at once | all silent |"
    assert lines[-1] == str(other / "figures" / "lesion.png")
    before = (run / "lesion.json").read_bytes()
    assert main(["lesion", str(run), "--retrain", "0"]) == 0
    assert (run / "lesion.json").read_bytes() == before


def test_runs_that_differ_in_more_than_their_seed_are_not_summed_up(
    run: Path, refused: Refused
) -> None:
    refused(["lesion", str(run), str(run)], "is there twice; leave one out")
    other = with_settings(run, reference_noise=0.02)
    message = f"{other}: differs from {run} in more than its seed"
    refused(["lesion", str(run), str(other)], message)


def with_settings(run: Path, **changed: Any) -> Path:
    """Return a copy of a run that says that it was made with other settings."""
    copy = RunFolder(shutil.copytree(run, run.parent / "other"))
    was = copy.read_config()
    config = was.replace(**changed)
    for name in ("best", "latest"):
        state, meta = copy.read_checkpoint(name, was)
        copy.write_checkpoint(name, config, state, meta | {"config": config.to_json()})
    content = json.loads((copy.path / "config.json").read_text())
    atomic_files.write_json(copy.path / "config.json", content | {"config": config.to_json()})
    return copy.path


def test_overwriting_a_run_removes_what_was_told_about_it(run: Path) -> None:
    folder = RunFolder(run)
    atomic_files.write_json(folder.lesion, {})
    atomic_files.write_text(folder.figures / "lesion.png", "")
    folder.create(folder.read_config(), folder.read_motion(), overwrite=True)
    assert not (run / "lesion.json").exists()
    assert not (run / "figures" / "lesion.png").exists()


@pytest.mark.parametrize(
    "name", ["config.json", "trace.npz", "checkpoint/motion.npz", "checkpoint/best.npz"]
)
def test_a_damaged_run_is_one_line_and_exit_2(run: Path, name: str, refused: Refused) -> None:
    (run / name).write_bytes(b"rubbish")
    refused(["lesion", str(run)], f"{name}: damaged")
    assert not (run / "lesion.json").exists()


def test_a_checkpoint_that_lacks_something_is_one_line_and_exit_2(
    run: Path, refused: Refused
) -> None:
    path = run / "checkpoint" / "best.npz"
    arrays, meta = atomic_files.read_arrays(path, "checkpoint")
    del arrays["inverse.weights"]
    atomic_files.write_arrays(path, "checkpoint", arrays, meta)
    refused(["lesion", str(run)], "the checkpoint lacks inverse.weights; train again")


def test_a_run_of_another_version_is_one_line_and_exit_2(run: Path, refused: Refused) -> None:
    content = json.loads((run / "config.json").read_text())
    atomic_files.write_json(run / "config.json", content | {"format": 1})
    refused(["lesion", str(run)], "config.json: format 1, written by mpma-mj")


def test_one_module_cannot_be_lost(tmp_path: Path, refused: Refused) -> None:
    alone = tmp_path / "alone"
    words = f"imitate ymca --epochs 2 --agent single {TINY} {alone}"
    assert main(words.split()) == 0
    message = f"{alone}: has one module, and none that could take over; expected a run of --modules"
    refused(["lesion", str(alone)], message)
    assert not (alone / "lesion.json").exists()


def test_a_run_whose_modules_do_nothing_yet_is_one_line_and_exit_2(
    run: Path, refused: Refused
) -> None:
    path = run / "trace.npz"
    trace, meta = atomic_files.read_arrays(path, "trace")
    trace["module_actions"][...] = 0.0
    atomic_files.write_arrays(path, "trace", trace, meta)
    message = f"{run}: its modules put out nothing in the kept epoch; go on with"
    refused(["lesion", str(run)], message)


def test_no_run_and_no_number_of_epochs_are_one_line_and_exit_2(
    tmp_path: Path, run: Path, refused: Refused
) -> None:
    refused(["lesion", str(tmp_path / "gone")], "no run there")
    refused(["lesion"], "no run given; try: mpma lesion runs/ymca")
    refused(["lesion", str(run), "--retrain", "-1"], "retrain is -1; expected 0 or more")
    assert not (run / "lesion.json").exists()
