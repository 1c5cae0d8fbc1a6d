"""Study of motions that were not learned."""

import csv
from pathlib import Path

import numpy as np
import pytest

from mpma_mj.errors import BadOptionError
from mpma_mj.experiments.study import Agents, run_study
from mpma_mj.experiments.unseen import Unseen

TINY: Agents = {
    "mpma": {"agent": "mpma", "nodes": 10, "modules": 2},
    "resolved rate": {"agent": "resolved_rate"},
}
MOTIONS = ("ymca", "synthetic-1", "synthetic-2")


def test_each_motion_is_left_out_once(tmp_path: Path) -> None:
    run_study(Unseen(motions=MOTIONS, runs=2, epochs=2, agents=TINY), tmp_path, 2)
    rows = [*csv.DictReader((tmp_path / "results.csv").read_text().splitlines())]
    assert len(rows) == len(MOTIONS) * len(TINY) * 2
    assert {row["unseen"] for row in rows} == {*MOTIONS}
    assert all(0.0 < float(row["p_e"]) < 50.0 for row in rows)
    head, _, *agents = (tmp_path / "table.md").read_text().splitlines()[:4]
    assert head == "| agent | ymca | synthetic-1 | synthetic-2 |"
    assert [line.split(" | ")[0] for line in agents] == ["| mpma", "| resolved rate"]
    assert (tmp_path / "figure.png").stat().st_size > 5_000


def test_what_is_left_out_is_not_learned_and_has_the_labels_of_the_others() -> None:
    jobs = Unseen(motions=MOTIONS, runs=1, agents=TINY).jobs()
    for job in jobs:
        assert job.condition["unseen"] not in job.learned.labels
        assert job.condition["unseen"] not in job.configs[0].motions
        assert len(job.configs[0].motions) == len(MOTIONS) - 1
        assert job.imitated.labels == job.learned.labels
        counts = job.imitated.context.sum(axis=0)
        assert np.ptp(counts) <= 1


def test_fewer_than_3_motions_are_refused() -> None:
    with pytest.raises(BadOptionError, match="at least 3 motions, not only ymca and synth"):
        Unseen(motions=("ymca", "synthetic")).jobs()
