"""Grids as they are typed."""

import pytest

from mpma_mj.errors import BadOptionError
from mpma_mj.experiments.sweep import points
from mpma_mj.training.config import RunConfig, option_types
from tests.experiments.runs import TINY


def test_a_grid_is_all_combinations_the_last_axis_running_fastest() -> None:
    grid = points(["nodes=50,200", "modules=2,4,8", "context_signal=halves,labels"], TINY)
    names = ("nodes", "modules", "context_signal")
    assert [tuple(p.option(name) for name in names) for p in grid[:3]] == [
        (50, 2, "halves"),
        (50, 2, "labels"),
        (50, 4, "halves"),
    ]
    assert len(set(grid)) == 2 * 3 * 2
    assert {p.env.repeats for p in grid} == {TINY.env.repeats}


def test_no_grid_is_one_point() -> None:
    assert points([], TINY) == [TINY]


@pytest.mark.parametrize(
    ("word", "values"),
    [
        ("reference_noise=0,0.5,1e-3", [0.0, 0.5, 1e-3]),
        ("longest=true,no", [True, False]),
        ("unit=mm,none", ["mm", None]),
        ("rate-in=100", [100.0]),
        ("rate_in=none,60", [None, 60.0]),
        ("from=1.5", [1.5]),
        ("labels=bars.csv,none", ["bars.csv", None]),
    ],
)
def test_values_have_the_type_of_their_setting(word: str, values: list[object]) -> None:
    name = {"from": "start"}.get(word.split("=")[0], word.split("=")[0].replace("-", "_"))
    found = [p.option(name) for p in points([word], TINY)]
    assert found == values
    assert list(map(type, found)) == list(map(type, values))


# None of one word, or not varied.
PLAIN = ("perturbation", "reward_weights", "plants", "switch_every", "latency_every")
PLAIN += ("seed",)


@pytest.mark.parametrize("name", [name for name in option_types("mpma") if name not in PLAIN])
def test_every_option_but_the_seed_can_vary(name: str) -> None:
    shown = str(RunConfig().option(name)).lower()
    (point,) = points([f"{name}={shown}"], RunConfig())
    assert point == RunConfig()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["node=5"], "unknown 'node'; did you mean nodes?"),
        (
            ["zzz=5"],
            "unknown 'zzz'; expected one of actuator_gain, actuator_strength, agent, ",
        ),
        (["motions=ymca"], "unknown 'motions'"),
        (["nodes"], "'nodes'; expected name=value,value"),
        (["nodes="], "empty value of nodes; expected a whole number"),
        (["nodes=5,,6"], "empty value of nodes"),
        (["nodes=5.5"], "nodes '5.5'; expected a whole number"),
        (["reference_noise=much"], "reference_noise 'much'; expected a number"),
        (["loop=maybe"], "loop 'maybe'; expected true or false"),
        (["rule=weighted,gated"], "gated is for posture models: choose models=posture"),
        (["rule=gatd"], "rule is 'gatd'; expected weighted, gated, or the path of a class"),
        (["unit=km"], "unit 'km'; expected one of m, cm, mm, inch, ft or none"),
        (["nodes=5", "nodes=6"], "nodes twice; give all its values at once"),
        (["from=1", "start=2"], "start twice"),
        (["nodes=5,6,05"], "a value of nodes twice: '5,6,05'"),
        (["seed=1,2"], "the first with seed, their number with runs"),
    ],
)
def test_what_is_no_grid_is_refused_in_one_line(words: list[str], message: str) -> None:
    with pytest.raises(BadOptionError) as raised:
        points(words, TINY)
    assert message in str(raised.value)
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize("axis", ["perturbation=0.5,30", "reward_weights=posture:2"])
def test_options_of_several_values_are_no_axes(axis: str) -> None:
    with pytest.raises(BadOptionError, match="which takes several values at once; give it with"):
        points([axis], RunConfig())
