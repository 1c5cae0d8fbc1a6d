"""Results of evaluations: tallies over seeds, tables and figures."""

import dataclasses
import math
from pathlib import Path

import pytest

from mpma_mj.errors import BadOptionError
from mpma_mj.evaluation.disturbances import disturbance_levels
from mpma_mj.evaluation.robustness import (
    MEAN,
    LevelResult,
    Robustness,
    as_csv,
    as_markdown,
    evaluate_levels,
)
from mpma_mj.evaluation.robustness_figure import write_figures
from mpma_mj.training.checkpoints import TrainedAgents

NAN = math.nan


def found(
    p_e: dict[int, float], *course: float, agent: str = "mpma", level: float | str = 1.0
) -> list[LevelResult]:
    """Return results of seeds, NaN where they diverged."""
    name = "unseen" if isinstance(level, str) else "payload"
    fine_tuned = {str(n): None if math.isnan(x) else x for n, x in enumerate(course)}
    return [
        LevelResult(agent, seed, name, level, "diverged", None, fine_tuned)
        if math.isnan(x)
        else LevelResult(agent, seed, name, level, "completed", x, fine_tuned)
        for seed, x in p_e.items()
    ]


def test_runs_that_diverge_count_in_no_mean() -> None:
    results = Robustness(found({0: 1.0, 1: NAN, 2: 2.0}), ["mpma"], 0)
    tally = results.p_e("mpma", "payload", 1.0)
    assert (tally.mean.mean, tally.diverged, tally.runs) == (1.5, 1, 3)
    assert tally.text == "1.50 [1.00, 2.00] (1 of 3 diverged)"
    assert "Episodes that diverged count in no mean." in as_markdown(results)
    assert "mpma,1,payload,1,diverged,\n" in as_csv(results)
    lost = Robustness(found({0: NAN}), ["mpma"], 0)
    assert lost.p_e("mpma", "payload", 1.0).text == "diverged"


@pytest.mark.parametrize(
    ("course", "epochs"),
    [((0.9, 0.8), 0), ((3.0, 1.0, 0.99, 2.0), 2), ((3.0, 2.0), math.inf), ((NAN, 0.5), 1)],
)
def test_recovery_is_the_epochs_of_learning_before_p_e_is_under_one_percent(
    course: tuple[float, ...], epochs: float
) -> None:
    results = Robustness(found({0: 3.0}, *course), ["mpma"], len(course) - 1)
    assert results.recovery("mpma", "payload", 1.0) == [epochs]
    assert results.p_e_after("mpma", "payload", 1.0).mean.mean == course[-1]


def test_the_table_of_recovery_says_the_median_and_how_many_got_there() -> None:
    all_found = [
        *found({0: 3.0}, 3.0, 0.5, 0.5),
        *found({1: 3.0}, 3.0, 2.0, 2.0),
        *found({2: 3.0}, 3.0, 2.0, 0.5),
        *found({0: 4.0, 1: 4.0, 2: 4.0}, agent="hammer"),
        *found({0: 9.0}, 9.0, 9.0, 9.0, agent="runs/own"),
    ]
    text = as_markdown(Robustness(all_found, ["mpma", "hammer", "runs/own"], 2))
    first, second = (row for row in text.splitlines() if row.startswith("| payload"))
    assert first == "| payload in each hand, kg | 1 | 3.00 | 4.00 | 9.00 |"
    assert second.startswith("| payload in each hand, kg | 1 | 2; 2 of 3; 1.00 [")
    assert second.endswith(" | >2; 0 of 1; 9.00 |")
    assert "Not fine-tuned, as they cannot learn on: hammer." in text
    assert "means over 3 seeds" in text
    rows = as_csv(Robustness(all_found, ["mpma", "hammer", "runs/own"], 2)).splitlines()
    assert len(rows) == 1 + 7
    assert rows[0].endswith(",p_e_percent,fine_tuned.0,fine_tuned.1,fine_tuned.2")
    assert rows[1] == "mpma,0,payload,1,completed,3.0,3.0,0.5,0.5"
    assert rows[4] == "hammer,0,payload,1,completed,4.0,,,"


def test_the_mean_of_unseen_motions_is_taken_seed_by_seed() -> None:
    dances = [
        *found({0: 1.0, 1: 2.0}, 4.0, 1.0, level="a"),
        *found({0: 3.0, 1: NAN}, 6.0, 3.0, level="b"),
    ]
    results = Robustness(dances, ["mpma"], 1)
    tally = results.p_e("mpma", "unseen", MEAN)
    assert (tally.mean.mean, tally.diverged) == (2.0, 1)
    assert results.p_e_after("mpma", "unseen", MEAN).mean.mean == 2.0
    one = Robustness(dances[:2], ["mpma"], 1)
    assert one.levels["unseen"] == ["a"]


def test_the_number_of_seeds_stands_below_means_over_seeds() -> None:
    assert "seeds" not in as_markdown(Robustness(found({0: 1.0}), ["mpma"], 0))
    assert "means over 2 seeds" in as_markdown(Robustness(found({0: 1.0, 1: 2.0}), ["mpma"], 0))


def test_fine_tuned_agents_have_a_figure_of_their_own(tmp_path: Path) -> None:
    path, second = tmp_path / "a.png", tmp_path / "a_fine_tuned.png"
    agents = [f"agent {number}" for number in range(12)]
    results = [one for agent in agents for one in found({0: 1.0}, 2.0, 1.0, agent=agent)]
    write_figures(path, Robustness(results, agents, 1))
    assert path.read_bytes().startswith(b"\x89PNG")
    assert second.read_bytes().startswith(b"\x89PNG")
    write_figures(path, Robustness(found({0: 1.0}), ["mpma"], 0))
    assert not second.exists()


@pytest.mark.filterwarnings("error", "ignore::DeprecationWarning")  # of old libraries
def test_the_figure_is_drawn_for_any_results(tmp_path: Path) -> None:
    odd = [
        *found({0: 1.0, 1: NAN}),
        *found({0: NAN, 1: NAN}, level=2.0),
        *found({0: 1.0, 1: 2.0}, level="a_b.bvh"),
        *(LevelResult("mpma", s, "tempo", 9.0, "completed", 0.5, {}) for s in (0, 1)),
    ]
    results = Robustness(odd, ["mpma"], 0)
    assert list(results.levels) == ["payload", "tempo", "unseen"]
    write_figures(tmp_path / "a.png", results)
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")


def test_a_level_that_the_agent_cannot_have_is_one_line(small: TrainedAgents) -> None:
    late = disturbance_levels(
        small.configs[0], small.motion, disturbances=["latency"], levels=["8"]
    )
    message = (
        r"latency 8: max_latency is 5; expected at least 8.*; choose other levels, or an agent"
    )
    with pytest.raises(BadOptionError, match=message):
        evaluate_levels("own", small, late)


def test_results_are_those_of_each_level_and_seed(small: TrainedAgents) -> None:
    levels = disturbance_levels(
        small.configs[0], small.motion, disturbances=["payload"], levels=["0", "3"]
    )
    alone = evaluate_levels("own", small, levels)
    assert [(one.level, one.seed, one.outcome) for one in alone] == [
        (0.0, 0, "completed"),
        (3.0, 0, "completed"),
    ]
    tuned = evaluate_levels("own", small, levels, 1)
    assert [list(one.fine_tuned) for one in tuned] == [["0", "1"]] * 2
    assert [dataclasses.replace(one, fine_tuned={}) for one in tuned] == alone


def test_the_figure_shows_names_that_cannot_be_printed(tmp_path: Path) -> None:
    agent = "a run\n\x1b[31m\udcff"
    results = [*found({0: 1.0}, agent=agent), *found({0: 1.0}, agent=agent, level="\n\udcfe.bvh")]
    write_figures(tmp_path / "a.png", Robustness(results, [agent], 0))
    assert (tmp_path / "a.png").exists()
