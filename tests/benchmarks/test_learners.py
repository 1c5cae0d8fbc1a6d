"""That the learners of benchmarks/learners learn in the environment that they are measured in."""

import importlib
import importlib.util
from pathlib import Path
from types import ModuleType

import pytest

LEARNERS = Path(__file__).parents[2] / "benchmarks" / "learners"


def module(name: str, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """Return a module of the benchmark, which is no package."""
    monkeypatch.syspath_prepend(str(LEARNERS))
    return importlib.import_module(name)


def test_the_same_seed_gives_the_same_curve(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("cma")
    monkeypatch.setenv("MUJOCO_GL", "disable")  # as the benchmark does for its process
    learners = ("random", "MPMA", "CMA-ES + feedback")
    for out in (tmp_path / "a.csv", tmp_path / "b.csv"):
        module("train", monkeypatch).main(
            learners, "kinematic", seeds=1, mpma_steps=500, cma_steps=9000, out=out
        )
    first = (tmp_path / "a.csv").read_text(encoding="utf-8")
    assert first == (tmp_path / "b.csv").read_text(encoding="utf-8")
    assert {line.split(",")[0] for line in first.splitlines()[1:]} == set(learners)


def test_a_run_takes_the_place_of_an_earlier_one(monkeypatch: pytest.MonkeyPatch) -> None:
    curves = module("curves", monkeypatch)
    old = [curves.Row("PPO", 0, 100, 9.0), curves.Row("PPO", 1, 100, 8.0)]
    new = [curves.Row("PPO", 0, 200, 1.0)]
    assert curves.replace_curves(old, new) == [old[1], *new]


def test_what_was_not_trained_for_is_not_told(monkeypatch: pytest.MonkeyPatch) -> None:
    curves = module("curves", monkeypatch)
    rows = [curves.Row("PPO", 0, steps, p_e) for steps, p_e in ((100, 9.0), (1000, 2.0))]
    assert curves.p_e_after(rows, 50) is None
    assert curves.p_e_after(rows, 900) == 9.0
    assert curves.p_e_after(rows, 995) == 2.0  # a whole episode more
    assert curves.p_e_after(rows, 5000) is None
    assert curves.p_e_after([curves.Row("random", 0, 0, 34.0)], 5000) == 34.0
