"""Study of late senses."""

import csv
from pathlib import Path

from mpma_mj.experiments.latency import AGENTS, SENSES, Latency
from mpma_mj.experiments.study import Agents, run_study

TINY: Agents = {
    "mpma": {"agent": "mpma", "nodes": 10, "modules": 2, "repeats": 1},
    "no compensation": {"agent": "mpma", "nodes": 10, "max_latency": 0, "repeats": 1},
    "resolved rate": {"agent": "resolved_rate", "repeats": 1},
}
COLUMNS = ("2 known", "0–5 jumping")


def test_agents_that_make_up_for_latency_are_ahead_and_find_the_delay(tmp_path: Path) -> None:
    senses = {name: SENSES[name] for name in COLUMNS}
    study = Latency(runs=2, epochs=3, agents=TINY, senses=senses)
    printed = run_study(study, tmp_path, 2)
    rows = [*csv.DictReader((tmp_path / "results.csv").read_text().splitlines())]
    assert len(rows) == len(COLUMNS) * len(TINY) * 2
    p_e = {(row["agent"], row["latency"], row["seed"]): float(row["p_e"]) for row in rows}
    for column in COLUMNS:
        for seed in ("0", "1"):
            mine = p_e["mpma", column, seed]
            assert mine < 0.5 * p_e["no compensation", column, seed]
            assert mine < 0.5 * p_e["resolved rate", column, seed]
    looked = {
        (row["agent"], row["latency"]) for row in rows if row["right_delay"] not in ("", "nan")
    }
    assert looked == {("mpma", "0–5 jumping")}
    assert printed.splitlines()[0] == "| agent | 2 known | 0–5 jumping |"
    assert "Steps at which mpma found the delay: " in printed
    assert (tmp_path / "figure.png").stat().st_size > 5_000


def test_every_agent_meets_every_latency_and_its_own_options_count() -> None:
    jobs = Latency(runs=3).jobs()
    assert [(job.part, job.agent) for job in jobs] == [(s, a) for s in SENSES for a in AGENTS]
    for job in jobs:
        env = job.configs[0].env
        assert len(job.configs) == 3
        assert env.latency == SENSES[job.part]["latency"]
        shown = 0 if "one step" in job.agent else SENSES[job.part]["lookahead"]
        assert env.lookahead == shown
