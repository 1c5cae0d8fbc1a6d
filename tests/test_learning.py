"""That it learns: small networks quickly here, all seeds in the slow suite."""

from pathlib import Path

import pytest

from mpma_mj.training.config import RunConfig
from mpma_mj.training.imitate import start
from mpma_mj.training.run_folder import RunFolder


@pytest.mark.parametrize("arms", ["physics", "kinematic"])
def test_the_dance_is_learned_by_several_modules(arms: str, tmp_path: Path) -> None:
    config = RunConfig(nodes=100, arms=arms)  # type: ignore[arg-type]
    summary = start(config, RunFolder(tmp_path / "run"), 30)
    assert summary["converged"]
    assert summary["p_e_percent"] < 1.0
    assert summary["feedback_ratio"] < 0.1
    assert summary["modules_used"] >= 3
    assert summary["repeatability"]["responsibility"] > 0.8


def test_the_papers_rule_converges(tmp_path: Path) -> None:
    summary = start(RunConfig(nodes=100, rule="gated"), RunFolder(tmp_path / "run"), 25)
    assert summary["converged"]
    assert summary["p_e_percent"] < 3.0
    assert all(1 <= count <= 3 for count in summary["active_modules"].values())


def test_one_module_dances_too(tmp_path: Path) -> None:
    summary = start(RunConfig(nodes=100, modules=1), RunFolder(tmp_path / "run"), 30)
    assert summary["converged"]
    assert summary["nmi"] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(20))
def test_every_seed_converges(seed: int, tmp_path: Path) -> None:
    summary = start(RunConfig(seed=seed), RunFolder(tmp_path / "weighted"), 30)
    assert summary["converged"]
    assert summary["epochs"] <= 9
    assert summary["p_e_percent"] < 0.8
    gated = RunConfig(seed=seed, rule="gated", nodes=100)
    assert start(gated, RunFolder(tmp_path / "gated"), 25)["p_e_percent"] < 3.0
