"""That exponents are those of the curves, and that a point is trained at its size."""

import csv
import json
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pytest

from mpma_mj.bench import point, scaling
from mpma_mj.bench.scaling import AXES, Measured, Point, Scaling, exponent
from mpma_mj.cli import main
from mpma_mj.motions import ymca
from mpma_mj.utils.system import peak_memory


def power_laws(time: float, memory: float) -> Scaling:
    """Return points whose time and memory are powers of every amount."""
    return Scaling(
        tuple(
            Measured(
                point=Point(axis, **{axis: amount}),
                seconds=(2.0 * amount**time,) * 3,
                memory=round(1000 * amount**memory),
                inherent=500 * amount,
            )
            for axis, amounts in AXES.items()
            for amount in reversed(amounts)
        )
    )


@pytest.mark.parametrize("power", [0.0, 0.5, 1.0, 2.3])
def test_the_exponent_of_a_power_law_is_its_own(power: float) -> None:
    amounts = np.array([1.0, 3.0, 10.0, 30.0])
    assert exponent(amounts, 7.0 * amounts**power) == pytest.approx(power, abs=1e-9)


def test_a_fixed_cost_counts_in_the_smaller_half_only() -> None:
    amounts = [1, 2, 4, 8, 16, 32, 64]
    values = [100.0, 100.0, 100.0, 8.0, 16.0, 32.0, 64.0]
    assert exponent(amounts, values) == pytest.approx(1.0)


@pytest.mark.parametrize(("time", "linear"), [(1.0, True), (1.2, False)])
def test_targets_follow_the_curves(time: float, linear: bool) -> None:
    report = power_laws(time, 1.0).report()
    reached = {name: bound.reached for name, bound in report.bounds.items()}
    assert reached == {
        "exponent of an epoch's time in steps": linear,
        "exponent of an epoch's time in modules": linear,
        "peak memory of 100,000 steps": True,  # 1 kB a step
    }
    (growth,) = report.ratios.values()
    assert growth.spread.median == pytest.approx(2.0)  # 1000 bytes a step over 500
    assert not growth.reached


def test_every_axis_that_is_asked_for_goes_as_far() -> None:
    ends = {axis: (amounts[0], amounts[-1]) for axis, amounts in AXES.items()}
    assert ends == {
        "steps": (1_000, 100_000),
        "modules": (1, 64),
        "nodes": (50, 1600),
        "runs": (1, 64),
    }


@pytest.mark.parametrize("steps", [10, 75, 76, 227])
def test_a_dance_is_as_long_as_is_asked_for(steps: int) -> None:
    motion = point.motion_of(steps)
    assert len(motion) == steps + 1
    fastest = np.abs(np.diff(ymca().posture, axis=0)).max()
    assert np.abs(np.diff(motion.posture, axis=0)).max() <= fastest  # no jump where it is joined


@pytest.mark.parametrize("axis", ["steps", "runs"])
def test_a_point_is_trained_at_its_size(
    axis: scaling.Axis, monkeypatch: pytest.MonkeyPatch
) -> None:
    small = Point(axis, steps=20, modules=2, nodes=5, runs=3)
    monkeypatch.setattr(point, "_MOST", 2)
    measured = point.train(small)
    assert measured.point == small
    assert len(measured.seconds) == 2
    assert min(measured.seconds) > 0.0
    assert 0 < measured.inherent < measured.memory


def test_peak_memory_knows_what_was_held() -> None:
    before = peak_memory()
    held = np.ones(before // 8 + 10_000_000)  # 80 MB more than ever
    assert peak_memory() > before
    del held
    assert peak_memory() > before


def test_each_point_is_a_process_of_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    spec: list[Point] = []

    def python(*words: str) -> str:
        assert words[:2] == ("-m", "mpma_mj.bench.point")
        spec.append(Point(**json.loads(words[2])))
        said = {"point": json.loads(words[2]), "seconds": [1.0, 3.0], "memory": 2, "inherent": 1}
        return json.dumps(said)

    def quietly(rounds: range, title: str) -> Iterable[int]:
        return rounds

    monkeypatch.setattr(scaling, "python", python)
    measured = scaling.measure(quietly).measured
    assert [one.point for one in measured] == spec
    assert len(spec) == sum(map(len, AXES.values()))
    assert {one.epoch for one in measured} == {2.0}
    assert spec[0] == Point("steps", steps=1000, modules=4, nodes=200, runs=1)


def test_the_program_of_a_point_prints_what_was_measured() -> None:
    said = scaling.python(
        *("-m", "mpma_mj.bench.point"),
        json.dumps({"axis": "modules", "steps": 10, "modules": 1, "nodes": 3, "runs": 1}),
    )
    assert json.loads(said).keys() == {"point", "seconds", "memory", "inherent"}


@pytest.mark.parametrize("form", [[], ["--json"]])
def test_the_command_writes_tables_and_a_picture(
    form: list[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr(scaling, "measure", lambda progress: power_laws(1.0, 0.5))
    assert main(["bench", "scaling", "--out", str(tmp_path), *form]) == 0
    out = capsys.readouterr().out
    points = sum(map(len, AXES.values()))
    assert {path.name for path in tmp_path.iterdir()} == {
        f"scaling.{kind}" for kind in ("csv", "json", "md", "png")
    }
    written = json.loads((tmp_path / "scaling.json").read_text())
    assert len(written["scaling"]) == points
    assert written["scaling"][0]["epoch_s"] == 2000.0
    with (tmp_path / "scaling.csv").open() as file:
        assert len(list(csv.DictReader(file))) == points
    if form:
        assert json.loads(out) == written
    else:
        assert out == (tmp_path / "scaling.md").read_text()
        assert "| modules | 1.00 | 0.5" in out
