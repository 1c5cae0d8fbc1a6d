"""Disturbances, and the conditions at their levels."""

import dataclasses
from typing import Any

import numpy as np
import pytest

from mpma_mj.errors import BadOptionError, MpmaError, RecordingWarning
from mpma_mj.evaluation.disturbances import DISTURBANCES, DisturbanceLevel, disturbance_levels
from mpma_mj.evaluation.evaluate import EvalCondition, evaluate, posture_errors_percent
from mpma_mj.motions import ymca
from mpma_mj.trace import Trace
from mpma_mj.training.checkpoints import TrainedAgents
from mpma_mj.training.config import RunConfig

NONE = {"payload": 0.0, "strength": 1.0, "gravity": "on", "latency": 0.0, "noise": 0.0}
NONE |= {"pushes": 0.0, "tempo": 1.0, "mirrored": "no", "locked": "none"}
MOTION = ymca()


def levels_of(
    name: str = "", *levels: str, config: RunConfig | None = None, **options: Any
) -> tuple[DisturbanceLevel, ...]:
    names = (name,) if name else ()
    config = config or RunConfig.of()
    return disturbance_levels(config, MOTION, disturbances=names, levels=levels, **options)


@pytest.fixture(scope="module")
def undisturbed(small: TrainedAgents) -> Trace:
    """Return an episode of the agent in the condition in which it was trained."""
    (trace,) = evaluate(small, EvalCondition("none", small.motion, {}))
    return trace


@pytest.mark.parametrize("name", NONE)
def test_no_disturbance_is_none_to_the_bit(
    name: str, small: TrainedAgents, undisturbed: Trace
) -> None:
    assert NONE[name] in DISTURBANCES[name].levels
    motion, options = DISTURBANCES[name].change(small.motion, NONE[name])
    (disturbed,) = evaluate(small, EvalCondition("a", motion, options))
    for signal, expected in undisturbed.to_arrays().items():
        np.testing.assert_array_equal(disturbed.to_arrays()[signal], expected, signal)


@pytest.mark.parametrize("name", NONE)
def test_the_hardest_level_changes_p_e(name: str, small: TrainedAgents, undisturbed: Trace) -> None:
    hardest = levels_of(name)[-1]
    disturbed = posture_errors_percent(evaluate(small, hardest.condition))
    assert disturbed != posture_errors_percent([undisturbed])


def test_default_levels_are_possible_and_share_the_undisturbed_condition() -> None:
    found = levels_of()
    none = {one.condition for one in found if NONE.get(one.disturbance) == one.level}
    assert len(none) == 1
    assert len({one.condition for one in found}) == len(found) - len(NONE) + 1
    assert sum(one.disturbance == "unseen" for one in found) == 8
    assert len({(one.disturbance, one.level) for one in found}) == len(found)


def test_a_motion_has_the_given_tempo() -> None:
    half, double = (one.condition for one in levels_of("tempo", "0.5", "2"))
    assert abs(len(half.motion) - 2 * len(MOTION)) <= 2
    assert abs(len(double.motion) - len(MOTION) / 2) <= 1
    np.testing.assert_allclose(half.motion.posture[::2], MOTION.posture, atol=1e-9)
    np.testing.assert_array_equal(half.motion.context[::2], MOTION.context)


def test_a_tempo_beyond_the_arms_is_made_feasible() -> None:
    with pytest.warns(RecordingWarning, match="its actuator reaches"):
        slow, fast = levels_of("tempo", "1", "9")
    assert slow.condition.motion.feasible_angles is None
    assert fast.condition.motion.feasible_angles is not None


def test_unseen_motions_have_the_context_of_the_run() -> None:
    (unseen,) = levels_of("unseen", motions=["synthetic-2"])
    assert unseen.condition.motion.labels == MOTION.labels
    assert unseen.condition.motion.name == "synthetic-2"


def test_learned_motions_are_not_unseen() -> None:
    config = RunConfig.of("synthetic-1", "ymca")
    unseen = [one.level for one in levels_of("unseen", config=config)]
    assert unseen == [f"synthetic-{number}" for number in range(2, 10)]
    with pytest.raises(BadOptionError, match="ymca was learned; name other motions"):
        levels_of("unseen", motions=["ymca"], config=config)
    spelled = RunConfig.of("semaphore:hi", "ymca")
    with pytest.raises(BadOptionError, match="semaphore:HI was learned"):
        levels_of("unseen", motions=["semaphore:HI"], config=spelled)
    with pytest.raises(BadOptionError, match="all synthetic motions were learned"):
        levels_of("unseen", config=RunConfig.of("synthetic"))


def test_a_run_of_ideal_arms_is_evaluated_on_simulated_ones() -> None:
    (none,) = levels_of("payload", "0", config=RunConfig.of(arms="kinematic"))
    assert none.condition.options["arms"] == "physics"


def test_ideal_arms_have_only_disturbances_without_forces(small: TrainedAgents) -> None:
    config = RunConfig.of(payload=1.0)
    found = levels_of(config=config, arms="kinematic")
    names = dict.fromkeys(one.disturbance for one in found)
    assert list(names) == ["latency", "noise", "tempo", "mirrored", "locked", "unseen"]
    for one in found:
        dataclasses.replace(config.env, **one.condition.options)
    with pytest.raises(BadOptionError, match=r"payload 1: payload is 1\.0; ideal arms have no ma"):
        levels_of("payload", "1", arms="kinematic")
    undisturbed = found[0].condition
    physics = EvalCondition("physics", MOTION, {})
    errors = [posture_errors_percent(evaluate(small, one)) for one in (undisturbed, physics)]
    assert errors[0] != errors[1]


def test_a_run_of_jumping_latencies_is_evaluated_with_steady_ones() -> None:
    config = RunConfig.of(latency=(0, 3), latency_every=(0.2, 0.5))
    (late,) = levels_of("latency", "2", config=config)
    options = dataclasses.replace(config.env, **late.condition.options)
    assert (options.latency, options.latency_every) == (2, None)


def test_a_run_with_plants_is_evaluated_without_them() -> None:
    config = RunConfig.of(plants=[{"payload": 1.0}])
    for one in levels_of("payload", "0", "3", config=config):
        options = dataclasses.replace(config.env, **one.condition.options)
        assert (options.plants, options.payload) == (None, one.level)


@pytest.mark.parametrize(
    ("name", "env"),
    [
        ("payload", {"payload": (0.0, 3.0)}),
        ("payload", {"payload": 1.0}),
        ("noise", {"observation_noise": (0.0, 0.05)}),
        ("latency", {"latency": (0, 3), "latency_every": (0.2, 0.5)}),
    ],
)
def test_level_0_of_a_run_that_was_trained_with_others_is_0(name: str, env: dict[str, Any]) -> None:
    config = RunConfig.of(**env)
    (none,) = levels_of(name, "0", config=config)
    options = dataclasses.replace(config.env, **none.condition.options)
    for option in env:
        assert getattr(options, option) == getattr(RunConfig().env, option)


@pytest.mark.parametrize(
    ("name", "level", "message"),
    [
        ("payload", "-1", "payload -1: payload is -1.0; expected 0 to 1000, in kg"),
        ("payload", "heavy", "payload has no level 'heavy'; expected numbers"),
        ("payload", "nan", "payload has no level 'nan'; expected numbers"),
        ("strength", "0", "actuator_strength is 0.0; expected 0.01 to 100"),
        ("gravity", "half", "gravity has no level 'half'; expected some of on, off"),
        ("latency", "1.5", "latency is 1.5; expected a whole number from 0 to 100"),
        ("noise", "200", "observation_noise is 2.0; expected 0 to 1"),
        ("pushes", "-5", "pushes -5: perturbation is (1.0, -5.0); expected rate"),
        ("tempo", "0", "tempo is 0.0; expected 0.01 to 100"),
        ("mirrored", "maybe", "mirrored has no level 'maybe'; expected some of no, yes"),
        ("locked", "knee", "locked has no level 'knee'; expected some of none, left_shoulder"),
        ("unseen", "gone.bvh", "gone.bvh: no such file"),
        ("payloads", "1", "no disturbance 'payloads'; expected one or more of payload, strength, "),
    ],
)
def test_a_level_out_of_bounds_is_one_line(name: str, level: str, message: str) -> None:
    with pytest.raises(MpmaError) as caught:
        levels_of(name, level)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)
    assert ("did you mean payload?" in str(caught.value)) == (name == "payloads")


def test_levels_and_unseen_motions_are_of_one_disturbance() -> None:
    with pytest.raises(
        BadOptionError, match="levels are given, but they belong to a single disturbance"
    ):
        disturbance_levels(
            RunConfig.of(), MOTION, disturbances=["payload", "latency"], levels=["1"]
        )
    with pytest.raises(BadOptionError, match="unseen motions are given, but not evaluated"):
        levels_of("payload", motions=["synthetic-1"])
