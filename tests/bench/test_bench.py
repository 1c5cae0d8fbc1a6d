"""That what is compared is the same work; how long it takes is no matter here."""

import json

import numpy as np
import pytest

from mpma_mj.bench import environment, timing
from mpma_mj.bench.timing import Case, Ratio, Spread, in_turn, ratio, spread
from mpma_mj.cli import main
from mpma_mj.envs.load import load


def test_the_floor_is_the_simulation_that_is_in_a_step() -> None:
    bare, env = load(), load()
    for case in (environment.bare_steps(bare), environment.env_steps(env)):
        case.prepare()
        assert case.run() == environment._STEPS
    np.testing.assert_array_equal(bare.physics.joint_angles(), env.physics.joint_angles())


def test_cases_are_timed_in_turn_and_prepared_before_each_run() -> None:
    calls: list[str] = []

    def run(name: str) -> int:
        calls.append(name)
        return 2

    cases = {
        name: Case(lambda name=name: run(name), lambda name=name: calls.append(f"before {name}"))
        for name in "ab"
    }
    times = in_turn(cases, range(2))
    assert calls == ["before a", "a", "before b", "b"] * 3  # the first round warms up
    assert {name: values.shape for name, values in times.items()} == {"a": (2,), "b": (2,)}


def test_a_time_is_per_unit_of_work_and_without_preparation(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    clock = [100.0]
    monkeypatch.setattr(timing.time, "perf_counter", lambda: clock[0])

    def passes(seconds: float) -> int:
        clock[0] += seconds
        return 4

    case = Case(lambda: passes(2.0), lambda: passes(7.0))
    assert in_turn({"nap": case}, range(3))["nap"].tolist() == [0.5, 0.5, 0.5]


def test_ratios_are_of_the_same_round_and_know_what_is_wanted() -> None:
    one, other = np.array([2.0, 6.0, 4.0]), np.array([1.0, 2.0, 4.0])
    assert spread(one) == Spread(4.0, 2.0, 6.0)
    assert ratio(one, other, 2.5).spread == Spread(2.0, 1.0, 3.0)
    assert ratio(one, other, 2.5).reached
    assert not ratio(one, other, 1.5).reached
    assert ratio(one, other, 1.5, at_least=True).reached
    assert not ratio(one, other, 2.5, at_least=True).reached


@pytest.mark.usefixtures("small")
@pytest.mark.parametrize("form", [[], ["--json"]])
def test_the_command_prints_times_and_ratios(
    form: list[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    if form:  # real programs once are enough
        monkeypatch.setattr(environment, "program", lambda *words: Case(lambda: 1))
    assert main(["bench", "env", *form]) == 0
    out = capsys.readouterr().out
    if form:
        report = json.loads(out)
        assert len(report["ratios"]) == 4
        for name, entry in report["ratios"].items():
            assert (
                Ratio(Spread(**entry["spread"]), entry["wanted"], entry["at_least"]).reached
                == (entry["reached"])
            ), name
        assert all(entry["median"] > 0 for entry in report["seconds"].values())
    else:
        assert out.count("\n| ") == 8 + 4 + 1
        assert "| env.step over bare mj_step calls | ≤ 1.35 |" in out
