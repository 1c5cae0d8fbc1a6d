"""That exponents are those of the curves, and that a point is trained at its size."""

from collections.abc import Mapping

import numpy as np
import pytest

from benchmarks.speed import scaling
from benchmarks.speed.__main__ import main
from benchmarks.speed.scaling import AMOUNTS, BASE, Measured, exponent, report
from benchmarks.speed.timing import in_own_process
from mpma_mj.motions import ymca

SMALL = {"steps": 20, "modules": 2, "nodes": 5, "runs": 1}


@pytest.mark.parametrize("power", [0.0, 0.5, 1.0, 2.3])
def test_the_exponent_of_a_power_law_is_its_own(power: float) -> None:
    amounts = np.array([1.0, 3.0, 10.0, 30.0])
    assert exponent(amounts, 7.0 * amounts**power) == pytest.approx(power, abs=1e-9)


def test_a_fixed_cost_counts_in_the_smaller_half_only() -> None:
    amounts = [1, 2, 4, 8, 16, 32, 64]
    values = [100.0, 100.0, 100.0, 8.0, 16.0, 32.0, 64.0]
    assert exponent(amounts, values) == pytest.approx(1.0)


@pytest.mark.parametrize(("power", "told"), [(1.0, "1.00"), (1.2, "1.20 (missed)")])
def test_targets_follow_the_curves(power: float, told: str) -> None:
    found = {
        axis: [
            Measured(amount, (2.0 * amount**power,) * 3, 1000 * amount, 500 * amount)
            for amount in amounts
        ]
        for axis, amounts in AMOUNTS.items()
    }
    lines = report(found).markdown()
    for axis in ("steps", "modules"):
        assert f"| exponent of an epoch's time in {axis} | ≤ 1.1 | {told} |" in lines
        assert f"| {axis} | {told.split()[0]} | 1.00 |" in lines
    assert "| peak memory of 100,000 steps | ≤ 1 GB | 0.10 GB |" in lines  # 1 kB a step
    assert "over that of motion and trace | ≤ 1 | 2.00 (missed) |" in lines  # 1000 bytes over 500
    assert lines.count("\n| nodes | ") == len(AMOUNTS["nodes"]) + 1


def test_every_axis_that_is_asked_for_goes_as_far() -> None:
    ends = {axis: (amounts[0], amounts[-1]) for axis, amounts in AMOUNTS.items()}
    assert ends == {
        "steps": (1_000, 100_000),
        "modules": (1, 64),
        "nodes": (50, 1600),
        "runs": (1, 64),
    }


@pytest.mark.parametrize("steps", [10, 75, 76, 227])
def test_a_dance_is_as_long_as_is_asked_for(steps: int) -> None:
    motion = scaling.motion_of(steps)
    assert len(motion) == steps + 1
    fastest = np.abs(np.diff(ymca().posture, axis=0)).max()
    assert np.abs(np.diff(motion.posture, axis=0)).max() <= fastest  # no jump where it is joined


@pytest.mark.parametrize("runs", [1, 3])
def test_a_point_is_trained_at_its_size(runs: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(scaling, "_MOST", 2)
    measured = scaling.train(SMALL | {"runs": runs})
    assert len(measured.seconds) == 2
    assert min(measured.seconds) > 0.0
    assert 0 < measured.inherent < measured.memory


def test_a_point_in_a_process_of_its_own_has_its_own_peak_memory() -> None:
    held = np.ones(scaling._peak_memory() // 8 + 10_000_000)  # 80 MB more than ever
    ours = scaling._peak_memory()
    assert ours > held.nbytes
    assert in_own_process(scaling.train, SMALL).memory < ours


def test_all_points_are_trained_one_thing_varied(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    trained: list[Mapping[str, int]] = []

    def train(work: object, point: Mapping[str, int]) -> Measured:
        assert work is scaling.train
        trained.append(point)
        return Measured(0, (1.0, 3.0), 2000 * point["steps"], point["steps"])

    monkeypatch.setattr(scaling, "in_own_process", train)
    main(("scaling",))
    assert len(trained) == sum(map(len, AMOUNTS.values()))
    assert trained[0] == BASE | {"steps": 1000}
    assert all(len(point.items() - BASE.items()) <= 1 for point in trained)
    assert "| runs | 64 | 2 | 1 to 3 | 0 |" in capsys.readouterr().out
