"""Lesions: agents without some modules, tables and figures."""

import contextlib
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mpma_mj import make_agent
from mpma_mj.agents.base import ModuleSignals
from mpma_mj.agents.gain_schedule import Gains
from mpma_mj.agents.wrappers import AgentWrapper
from mpma_mj.analysis.lesion import (
    Dropped,
    LabelMeasures,
    Lesion,
    Lesions,
    _measure,
    apply_lesion,
    possible_lesions,
)
from mpma_mj.analysis.lesion_report import drawn, matrix, summary, write_figure
from mpma_mj.evaluation.evaluate import (
    EVALUATION_EPISODE,
    EvalCondition,
    evaluate,
    posture_errors_percent,
)
from mpma_mj.metrics import posture_error_percent
from mpma_mj.motions import ymca
from mpma_mj.trace import Trace
from mpma_mj.training.checkpoints import TrainedAgents
from mpma_mj.training.config import RunConfig
from mpma_mj.training.factory import agent_of, make_environments
from mpma_mj.training.rollout import record_epoch
from mpma_mj.training.run_folder import RunFolder
from mpma_mj.utils import data_files


@pytest.fixture(scope="module")
def trained(small_run: Path) -> TrainedAgents:
    return TrainedAgents.of_run(RunFolder(small_run))


def untrained(**settings: Any) -> TrainedAgents:
    """Return an agent that has learned nothing."""
    config = RunConfig.of("ymca", nodes=10, repeats=1, arms="kinematic", **settings)
    motion = ymca()
    with contextlib.closing(make_environments(config, [0], motion)) as envs:
        state = agent_of(config, envs, [0]).state_dict()
    return TrainedAgents((config,), motion, state, np.array([1]))


def test_lesions_are_of_each_module_each_pair_and_all() -> None:
    singles, pairs = [(0,), (1,), (2,)], [(0, 1), (0, 2), (1, 2)]
    assert possible_lesions(untrained(modules=3)) == [(), *singles, *pairs, (0, 1, 2)]


def test_two_modules_have_no_pair_that_leaves_one() -> None:
    assert possible_lesions(untrained(modules=2)) == [(), (0,), (1,), (0, 1)]


def test_modules_of_plants_that_were_not_found_are_no_lesions() -> None:
    found = untrained(modules=2, max_plants=3)
    assert possible_lesions(found) == [(), (0,), (1,), (0, 1)]
    found.state["plants.recruited"][0] = 2
    assert possible_lesions(found)[:5] == [(), (0,), (1,), (2,), (3,)]
    silent = apply_lesion(found, (0, 1, 2, 3), 1)
    assert silent.fine_tuned is None
    lesion = apply_lesion(found, (0, 1), 1)
    assert lesion.fine_tuned is not None
    assert not lesion.fine_tuned.responsibility[:, :2].any()


def test_an_agent_in_a_wrapper_has_lesions() -> None:
    wrapped = untrained(context_signal="nothing", modules=2)
    assert apply_lesion(wrapped, (1,), 0).at_once.responsibility[:, 1].max() == 0.0


def test_an_intact_agent_is_that_of_any_evaluation(trained: TrainedAgents) -> None:
    intact = apply_lesion(trained, (), 0)
    assert intact.fine_tuned is None
    (error,) = posture_errors_percent(evaluate(trained, EvalCondition("same", trained.motion, {})))
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
    silent = apply_lesion(trained, (0, 1, 2), 1)
    assert silent.at_once.p_e_percent == pytest.approx(expected, rel=1e-9)
    assert silent.fine_tuned is None
    assert expected > 3.0 * apply_lesion(trained, (), 0).at_once.p_e_percent


def test_dropped_modules_have_no_responsibility_and_the_others_learn(
    trained: TrainedAgents,
) -> None:
    lesion = apply_lesion(trained, (0, 2), 1)
    assert lesion.fine_tuned is not None
    for found in (lesion.at_once, lesion.fine_tuned):
        np.testing.assert_allclose(found.responsibility, [[0, 1, 0]] * 4)
        np.testing.assert_array_equal(found.dominant, 1)
    assert lesion.fine_tuned.p_e_percent != lesion.at_once.p_e_percent
    # At once does not depend on whether it will learn.
    assert apply_lesion(trained, (0, 2), 0).at_once.p_e_percent == lesion.at_once.p_e_percent


def test_hammer_that_was_prepared_is_not_fine_tuned() -> None:
    hammer = untrained(agent="hammer")
    assert apply_lesion(hammer, (1,), 1).fine_tuned is not None
    hammer.state["prepared"][...] = 3
    lesion = apply_lesion(hammer, (1,), 1)
    assert lesion.fine_tuned is None
    assert not lesion.at_once.responsibility[:, 1].any()


def test_errors_are_of_the_label_to_which_a_step_leads() -> None:
    steps, reference = 4, np.zeros((5, 12))
    posture = reference + np.array([0.9, 0.2, 0.2, 0.6, 0.6])[:, None]  # the first is reset
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
    # Responsibilities are of the label that is active.
    np.testing.assert_allclose(dance.responsibility, [[1, 0, 0], [0, 0, 1], [np.nan] * 3])
    np.testing.assert_array_equal(dance.dominant, [0, 2, -1])


def measures(errors: list[float], shares: list[list[float]]) -> LabelMeasures:
    share = np.array(shares)
    return LabelMeasures(float(np.mean(errors)), np.array(errors), share, share.argmax(axis=1))


def made_up(scale: float = 1.0, *, learned: bool = True) -> Lesions:
    """Return lesions of an agent of three modules and two labels, of modules 1 and 2."""

    def lesion(dropped: Dropped, before: float, after: float, shares: list[list[float]]) -> Lesion:
        own = np.isin([0, 1], dropped)
        at_once = measures([scale * (before if gone else 1.0) for gone in own], shares)
        return Lesion(dropped, at_once, measures([after, after], shares) if learned else None)

    return Lesions(
        ("Y", "M"),
        (
            lesion((), 1.0, 0.5, [[0.8, 0.1, 0.1], [0.0, 1.0, 0.0]]),
            lesion((0,), 4.0, 2.0, [[0.0, 0.4, 0.6], [0.0, 1.0, 0.0]]),
            lesion((1,), 6.0, 3.0, [[0.9, 0.0, 0.1], [0.2, 0.0, 0.8]]),
            lesion((2,), 9.0, 1.0, [[0.9, 0.1, 0.0], [0.0, 1.0, 0.0]]),
            lesion((0, 1), 8.0, 4.0, [[0.0, 0.0, 1.0], [0.0, 0.0, 1.0]]),
            replace(lesion((0, 1, 2), 12.0, 0.0, [[1, 0, 0], [0, 1, 0]]), fine_tuned=None),
        ),
        epochs=3 if learned else 0,
    )


def test_a_summary_separates_own_labels_from_others() -> None:
    lines = summary([made_up()]).splitlines()
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
    line = summary([made_up(), made_up(scale=2.0)]).splitlines()[2]
    assert "| 7.50 [5.00, 10.00] |" in line


def test_without_fine_tuning_there_is_no_column_of_it() -> None:
    stayed = made_up(learned=False)
    assert "after" not in summary([stayed])
    assert "→" not in matrix(stayed)
    mixed = summary([stayed, made_up()]).splitlines()[2]
    assert mixed.endswith("| 1.00 | 5.00 | 0.50 | 2.50 | 12.00 |")


def test_a_matrix_has_a_row_for_every_lesion() -> None:
    lines = matrix(made_up()).splitlines()
    assert lines[0] == "| p_e, %, at once → after fine-tuning | Y | M | all |"
    assert lines[3] == "| without 1 | 4.00 → 2.00 | 1.00 → 2.00 | 2.50 → 2.00 |"
    assert lines[7] == "| all silent | 12.00 | 12.00 | 12.00 |"
    assert lines[12] == "| without 1 | 3 (0.60) → 3 (0.60) | 2 (1.00) → 2 (1.00) |"
    assert len(lines) == 8 + 1 + 7


def test_a_label_that_does_not_occur_is_a_dash_and_null(tmp_path: Path) -> None:
    unused = LabelMeasures(
        1.0, np.array([1.0, np.nan]), np.array([[1.0], [np.nan]]), np.array([0, -1])
    )
    gone = Lesion((0,), unused, None)
    silent = Lesion((0,), replace(unused, label_p_e_percent=np.array([9.0, np.nan])), None)
    without = Lesions(("Y", "M"), (Lesion((), unused, None), gone, silent), 0)
    assert "| intact | 1.00 | – | 1.00 |" in matrix(without)
    assert "nan" not in summary([without])
    data_files.write_json(tmp_path / "lesion.json", without.as_json())
    first = json.loads((tmp_path / "lesion.json").read_text())["lesions"][0]
    assert first["at_once"]["labels"]["M"]["p_e_percent"] is None
    write_figure(tmp_path / "lesion.png", without, "a dance")


def test_pairs_are_not_drawn_where_they_are_many() -> None:
    few = made_up()
    assert drawn(few) == list(few.lesions)
    pairs = few.lesions[4:5] * 20
    many = replace(few, lesions=(*few.lesions[:4], *pairs, few.silent))
    assert drawn(many) == [*few.lesions[:4], few.silent]


@pytest.mark.parametrize("learned", [True, False])
def test_a_figure_is_drawn_whatever_labels_are_called(tmp_path: Path, learned: bool) -> None:
    without = replace(made_up(learned=learned), labels=("a dance of a long name", "M"))
    write_figure(tmp_path / "lesion.png", without, "two dances")
    assert (tmp_path / "lesion.png").read_bytes().startswith(b"\x89PNG")


def test_a_plant_recruited_in_fine_tuning_has_modules_in_the_figure(tmp_path: Path) -> None:
    without = made_up()
    intact = without.intact
    assert intact.fine_tuned is not None
    more = np.pad(intact.fine_tuned.responsibility, ((0, 0), (0, 2)), constant_values=0.5)
    learned = replace(intact, fine_tuned=replace(intact.fine_tuned, responsibility=more))
    without = replace(without, lesions=(learned, *without.lesions[1:]))
    assert without.modules == 5
    write_figure(tmp_path / "lesion.png", without, "in two plants")
    assert (tmp_path / "lesion.png").read_bytes().startswith(b"\x89PNG")
