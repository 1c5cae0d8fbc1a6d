"""What is made of what was found."""

import math
from pathlib import Path

import pytest

from mpma_mj.agents import AGENTS
from mpma_mj.experiments.robustness import THIS_RUN, Found
from mpma_mj.experiments.robustness_figure import write_figure
from mpma_mj.experiments.robustness_results import MEAN, Results
from mpma_mj.experiments.robustness_table import as_csv, as_markdown, courses_as_csv

NAN = math.nan


def found(
    p_e: dict[int, float], *course: float, agent: str = "mpma", level: float | str = 1.0
) -> list[Found]:
    """Return what seeds found, NaN if they diverged."""
    name = "unseen" if isinstance(level, str) else "payload"
    return [
        Found(agent, seed, name, level, "diverged" if math.isnan(x) else "danced", x, course)
        for seed, x in p_e.items()
    ]


def test_runs_that_diverge_are_told_and_count_in_no_mean() -> None:
    results = Results(found({0: 1.0, 1: NAN, 2: 2.0}), ["mpma"], 0)
    tally = results.p_e("mpma", "payload", 1.0)
    assert (tally.mean.mean, tally.diverged, tally.runs) == (1.5, 1, 3)
    assert tally.text == "1.50 [1.00, 2.00] (1 of 3 diverged)"
    assert "What diverged counts in no mean." in as_markdown(results)
    assert "mpma,payload,1,1,diverged,\n" in as_csv(results)
    lost = Results(found({0: NAN}), ["mpma"], 0)
    assert lost.p_e("mpma", "payload", 1.0).text == "diverged"


@pytest.mark.parametrize(
    ("course", "epochs"),
    [((0.9, 0.8), 0), ((3.0, 1.0, 0.99, 2.0), 2), ((3.0, 2.0), math.inf), ((NAN, 0.5), 1)],
)
def test_recovery_is_the_epochs_of_learning_before_p_e_is_under_one_percent(
    course: tuple[float, ...], epochs: float
) -> None:
    results = Results(found({0: 3.0}, *course), ["mpma"], len(course) - 1)
    assert results.recovery("mpma", "payload", 1.0) == [epochs]
    assert results.p_e_after("mpma", "payload", 1.0).mean.mean == course[-1]


def test_the_table_of_recovery_says_the_median_and_how_many_got_there() -> None:
    all_found = [
        *found({0: 3.0}, 3.0, 0.5, 0.5),
        *found({1: 3.0}, 3.0, 2.0, 2.0),
        *found({2: 3.0}, 3.0, 2.0, 0.5),
        *found({0: 4.0, 1: 4.0, 2: 4.0}, agent="hammer"),
        *found({0: 9.0}, 9.0, 9.0, 9.0, agent=THIS_RUN),
    ]
    text = as_markdown(Results(all_found, ["mpma", "hammer", THIS_RUN], 2))
    first, second = (row for row in text.splitlines() if row.startswith("| payload"))
    assert first == "| payload in each hand, kg | 1 | 3.00 | 4.00 | 9.00 |"
    assert second.startswith("| payload in each hand, kg | 1 | 2; 2 of 3; 1.00 [")
    assert second.endswith(" | >2; 0 of 1; 9.00 |")
    assert "Left out, as they learn nothing more: hammer." in text
    assert "means over 3 seeds" in text
    rows = courses_as_csv(Results(all_found, ["mpma", "hammer", THIS_RUN], 2)).splitlines()
    assert len(rows) == 1 + 4 * 3
    assert rows[2] == "mpma,payload,1,0,1,0.5"


def test_the_mean_of_dances_is_taken_seed_by_seed() -> None:
    dances = [
        *found({0: 1.0, 1: 2.0}, 4.0, 1.0, level="a"),
        *found({0: 3.0, 1: NAN}, 6.0, 3.0, level="b"),
    ]
    results = Results(dances, ["mpma"], 1)
    tally = results.p_e("mpma", "unseen", MEAN)
    assert (tally.mean.mean, tally.diverged) == (2.0, 1)
    assert results.p_e_after("mpma", "unseen", MEAN).mean.mean == 2.0
    one = Results(dances[:2], ["mpma"], 1)
    assert one.levels["unseen"] == ["a"]


def test_what_is_beyond_the_arms_has_a_row() -> None:
    beyond = Found("mpma", 0, "tempo", 9.0, "beyond the arms", NAN, ())
    results = Results([Found("mpma", 0, "tempo", 1.0, "danced", 0.5, ()), beyond], ["mpma"], 0)
    assert "| tempo | 9 | beyond the arms |" in as_markdown(results)
    assert "mpma,tempo,9,0,beyond the arms,\n" in as_csv(results)


def test_means_and_intervals_are_told_where_there_are_some() -> None:
    assert "seeds" not in as_markdown(Results(found({0: 1.0}), ["mpma"], 0))
    assert "means over 2 seeds" in as_markdown(Results(found({0: 1.0, 1: 2.0}), ["mpma"], 0))


def test_every_agent_can_be_drawn(tmp_path: Path) -> None:
    agents = [*AGENTS, THIS_RUN]
    results = Results([one for a in agents for one in found({0: 1.0}, agent=a)], agents, 0)
    write_figure(tmp_path / "a.png", results, agents, results.p_e, "p_e, %")
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.filterwarnings("error", "ignore::DeprecationWarning")  # of old libraries
def test_the_figure_is_drawn_whatever_was_found(tmp_path: Path) -> None:
    odd = [
        *found({0: 1.0, 1: NAN}),
        *found({0: NAN, 1: NAN}, level=2.0),
        *found({0: 1.0, 1: 2.0}, level="a_b.bvh"),
        *(Found("mpma", seed, "tempo", 9.0, "beyond the arms", NAN, ()) for seed in (0, 1)),
    ]
    results = Results(odd, ["mpma"], 0)
    assert list(results.levels) == ["payload", "tempo", "unseen"]
    write_figure(tmp_path / "a.png", results, results.agents, results.p_e, "p_e, %")
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
