"""Disturbances, and the worlds that they make."""

import dataclasses

import numpy as np
import pytest

from mpma_mj.errors import BadOptionError, MotionReachError, MpmaError
from mpma_mj.evaluation.conditions import trials
from mpma_mj.evaluation.disturbances import DISTURBANCES
from mpma_mj.evaluation.evaluate import EvalCondition, evaluate, tracking_errors
from mpma_mj.training.checkpoints import TrainedAgents

NONE = {"payload": 0.0, "strength": 1.0, "gravity": "on", "latency": 0.0, "noise": 0.0}
NONE |= {"pushes": 0.0, "tempo": 1.0, "mirrored": "no", "locked": "none"}


@pytest.mark.parametrize("name", NONE)
def test_no_disturbance_is_none_to_the_bit(name: str, tiny: TrainedAgents) -> None:
    assert NONE[name] in DISTURBANCES[name].levels
    motion, options = DISTURBANCES[name].change(tiny.motion, NONE[name])
    (danced,) = evaluate(tiny, EvalCondition("a", motion, options))
    (undisturbed,) = evaluate(tiny, EvalCondition("b", tiny.motion, {}))
    assert danced is not None
    assert undisturbed is not None
    for signal, expected in undisturbed.to_arrays().items():
        np.testing.assert_array_equal(danced.to_arrays()[signal], expected, signal)


@pytest.mark.parametrize("name", NONE)
def test_the_hardest_level_is_another_world(name: str, tiny: TrainedAgents) -> None:
    (trial,) = trials([name], [str(DISTURBANCES[name].levels[-1])], [], tiny)
    assert trial.condition is not None
    disturbed = tracking_errors(evaluate(tiny, trial.condition))
    assert disturbed != tracking_errors(evaluate(tiny, EvalCondition("none", tiny.motion, {})))


def test_all_usual_levels_can_be_and_share_the_undisturbed_world(tiny: TrainedAgents) -> None:
    found = trials(list(DISTURBANCES), [], [], tiny)
    assert all(trial.condition is not None for trial in found)
    none = {trial.condition for trial in found if NONE.get(trial.disturbance) == trial.level}
    assert len(none) == 1
    assert len({trial.condition for trial in found}) == len(found) - len(NONE) + 1
    assert sum(trial.disturbance == "unseen" for trial in found) == 8
    assert len({(trial.disturbance, trial.level) for trial in found}) == len(found)


def test_a_dance_is_as_fast_as_asked(tiny: TrainedAgents) -> None:
    half, double = (trial.condition for trial in trials(["tempo"], ["0.5", "2"], [], tiny))
    assert half is not None
    assert double is not None
    frames = len(tiny.motion)
    assert abs(len(half.motion) - 2 * frames) <= 2
    assert abs(len(double.motion) - frames / 2) <= 1
    np.testing.assert_allclose(half.motion.posture[::2], tiny.motion.posture, atol=1e-9)
    np.testing.assert_array_equal(half.motion.context[::2], tiny.motion.context)


def test_what_is_too_fast_for_the_arms_is_told_and_not_dropped(tiny: TrainedAgents) -> None:
    slow, fast = trials(["tempo"], ["1", "9"], [], tiny)
    assert slow.condition is not None
    assert (fast.level, fast.condition) == (9.0, None)


def test_dances_never_seen_are_danced_to_the_runs_music(tiny: TrainedAgents) -> None:
    (trial,) = trials(["unseen"], [], ["invented-2"], tiny)
    assert trial.condition is not None
    assert trial.condition.motion.labels == tiny.motion.labels
    assert trial.condition.motion.name == "invented-2"


def test_what_a_run_has_learned_is_not_unseen(tiny: TrainedAgents) -> None:
    config = tiny.configs[0].replace(motions=("invented-1", "ymca"))
    own = dataclasses.replace(tiny, configs=(config,))
    assert [trial.level for trial in trials(["unseen"], [], [], own)] == [
        f"invented-{number}" for number in range(2, 10)
    ]
    with pytest.raises(BadOptionError, match="the run has learned ymca; name another dance"):
        trials(["unseen"], [], ["ymca"], own)
    config = config.replace(motions=("invented",))
    with pytest.raises(BadOptionError, match="the run has learned all invented dances"):
        trials(["unseen"], [], [], dataclasses.replace(tiny, configs=(config,)))


def test_a_run_of_ideal_arms_is_tried_with_simulated_ones(tiny: TrainedAgents) -> None:
    config = tiny.configs[0].replace(arms="kinematic")
    (none,) = trials(["payload"], ["0"], [], dataclasses.replace(tiny, configs=(config,)))
    assert none.condition is not None
    assert none.condition.options["arms"] == "physics"


def test_a_run_of_jumping_latencies_is_tried_with_steady_ones(tiny: TrainedAgents) -> None:
    config = tiny.configs[0].replace(latency=(0, 3), latency_every=(0.2, 0.5))
    (late,) = trials(["latency"], ["2"], [], dataclasses.replace(tiny, configs=(config,)))
    assert late.condition is not None
    options = dataclasses.replace(config.env, **late.condition.options)
    assert (options.latency, options.latency_every) == (2, None)


@pytest.mark.parametrize(
    ("name", "level", "said"),
    [
        ("payload", "-1", "payload is -1.0; expected 0 to 1000, in kg"),
        ("payload", "heavy", "payload has no level 'heavy'; expected numbers"),
        ("payload", "nan", "payload has no level 'nan'; expected numbers"),
        ("strength", "0", "actuator_strength is 0.0; expected 0.01 to 100"),
        ("gravity", "half", "gravity has no level 'half'; expected some of on, off"),
        ("latency", "1.5", "latency is 1.5; expected a whole number from 0 to 100"),
        ("noise", "200", "observation_noise is 2.0; expected 0 to 1"),
        ("pushes", "-5", "perturbation is (1.0, -5.0); expected rate"),
        ("tempo", "0", "tempo is 0.0; expected a number above 0"),
        ("mirrored", "maybe", "mirrored has no level 'maybe'; expected some of no, yes"),
        (
            "locked",
            "knee",
            "locked has no level 'knee'; expected some of none, left_shoulder",
        ),
        ("unseen", "gone.bvh", "gone.bvh: no such file"),
        ("wind", "1", "no disturbance 'wind'; expected some of payload, strength, "),
    ],
)
def test_what_is_out_of_range_is_one_line(
    name: str, level: str, said: str, tiny: TrainedAgents
) -> None:
    with pytest.raises(MpmaError) as caught:
        trials([name], [level], [], tiny)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_levels_are_those_of_one_disturbance(tiny: TrainedAgents) -> None:
    with pytest.raises(BadOptionError, match="levels are those of one disturbance"):
        trials(["payload", "latency"], ["1"], [], tiny)


def test_a_dance_that_is_too_fast_says_how_to_mend_it(tiny: TrainedAgents, write_tsv) -> None:
    path = write_tsv(rate="400")
    with pytest.raises(
        MotionReachError, match=r"slow the movement .*: mpma motion, with .* out=FILE"
    ):
        trials(["unseen"], [], [str(path)], tiny)
