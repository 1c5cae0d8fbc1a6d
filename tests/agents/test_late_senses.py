"""Late senses of an artificial linear arm, whose commands act after a known number of steps."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

from mpma_mj.agents.base import AgentSpec
from mpma_mj.agents.late_senses import LateSenses, eased_target
from mpma_mj.agents.state_models import StateModels, kinematic_prior
from mpma_mj.kinematics import posture_from_angles

Array = np.ndarray

SPEC = AgentSpec(2, np.array([12.0, 12.0, 20.0, 15.0] * 2), 0.05, latency=0, lookahead=6)
MOST, STEPS = 5, 60


class Arms:
    """Arms that move by a state model, whose commands act late; shapes are (..., 8)."""

    def __init__(self, shape: tuple[int, ...] = ()) -> None:
        own = kinematic_prior() + 0.03 * np.random.default_rng(1).normal(size=(16, 33))
        self.models = StateModels(SPEC, shape, 1)
        self.models._weights[...] = own
        self.angles = np.full((*shape, 8), 0.3)
        self.speed = np.zeros((*shape, 8))
        self._given: list[Array] = []

    def step(self, command: Array, delay: Any) -> Array:
        """Move by the command that was given so many steps ago; return it."""
        self._given.append(command)
        back = len(self._given) - 1 - np.asarray(delay)
        none = np.zeros_like(command)
        if command.ndim == 1:
            acting = self._given[int(back)] if back >= 0 else none
        else:
            acting = np.array(
                [self._given[b][i] if b >= 0 else none[i] for i, b in enumerate(back.tolist())]
            )
        model = self.models.of_plant(np.zeros(command.shape[:-1], np.intp))
        self.angles, self.speed = self.models.following(model, acting, self.angles, self.speed)
        return acting

    def observation(self, t: int) -> dict[str, Array]:
        """Return what is observed; targets are numbered by their step."""
        shape = self.angles.shape[:-1]
        coming = np.arange(t + 1.0, t + 1.0 + SPEC.lookahead)[:, None]
        return {
            "joint_angles": self.angles,
            "joint_velocities": self.speed * SPEC.max_joint_speed,
            "posture": posture_from_angles(self.angles),
            "reference": np.full((*shape, 12), t + 0.5),
            "target": np.full((*shape, 12), t + 1.0),
            "lookahead": np.broadcast_to(coming, (*shape, SPEC.lookahead, 12)),
            "context": np.ones((*shape, 2)),
        }


def senses(
    latency: int | None, shape: tuple[int, ...] = (), *, exact: bool = True, **options: Any
) -> LateSenses:
    """Return senses, if exact with the arms' own state model."""
    own: dict[str, Any] = {"plants": 1, "max_latency": MOST, "estimates": False, "seed": 0}
    made = LateSenses(dataclasses.replace(SPEC, latency=latency), shape, **own | options)
    if exact:
        made._models._weights[...] = Arms().models._weights
        made._models.variance[...] = 2e-4
        made.reset(0)
    return made


def commands(steps: int, shape: tuple[int, ...] = (), seed: int = 0) -> Array:
    return np.random.default_rng(seed).uniform(-0.4, 0.4, (steps, *shape, 8))


def dance(
    made: LateSenses, arms: Arms, given: Array, delays: Any
) -> tuple[list[Any], list[Any], Array]:
    """Return the observations, those expected, and the commands that acted."""
    observed, expected, acted = [], [], []
    for t, command in enumerate(given):
        observed.append(arms.observation(t))
        expected.append(made(observed[-1], np.zeros(command.shape[:-1], np.intp)))
        made.acting(observed[-1], command)
        acted.append(arms.step(command, delays[t]))
    observed.append(arms.observation(len(given)))
    return observed, expected, np.array(acted)


@pytest.mark.parametrize("latency", range(MOST + 1))
def test_the_state_that_is_expected_is_the_one_in_which_the_command_acts(latency: int) -> None:
    observed, expected, _ = dance(senses(latency), Arms(), commands(STEPS), [latency] * STEPS)
    for t in range(STEPS - latency):
        for name in ("joint_angles", "joint_velocities", "posture"):
            later = observed[t + latency][name]
            np.testing.assert_allclose(expected[t][name], later, atol=1e-9, err_msg=name)


@pytest.mark.parametrize("latency", range(MOST + 1))
def test_targets_are_those_of_the_step_at_which_the_command_acts(latency: int) -> None:
    motion = posture_from_angles(0.3 + 0.02 * np.arange(MOST + 4)[:, None] * np.ones(8))
    made, arms = senses(latency), Arms()
    for t, command in enumerate(commands(3)):
        shown = {"reference": motion[t], "target": motion[t + 1], "lookahead": motion[t + 1 :]}
        seen = made(arms.observation(t) | shown, 0)
        due, following = motion[t + latency], motion[t + latency + 1]
        np.testing.assert_array_equal(seen["reference"], due)
        eased = eased_target(seen["joint_angles"], due, following) if latency else following
        np.testing.assert_array_equal(seen["target"], eased)
        made.acting(shown, command)
        arms.step(command, latency)


def test_an_eased_target_keeps_the_motion_and_corrects_half_of_the_error() -> None:
    rng = np.random.default_rng(0)
    angles = rng.uniform(0.3, 0.6, (5, 8))
    error, moved = rng.uniform(-0.1, 0.1, (2, 5, 8))
    shown, following = (posture_from_angles(q) for q in (angles + error, angles + error + moved))
    eased = eased_target(angles, shown, following)
    np.testing.assert_allclose(eased, posture_from_angles(angles + moved + 0.5 * error), atol=1e-12)
    right = eased_target(angles + error, shown, following)
    np.testing.assert_allclose(right, following, atol=1e-12)


def test_where_the_future_is_not_shown_the_target_is_held_before_learning() -> None:
    made = LateSenses(
        dataclasses.replace(SPEC, latency=3, lookahead=0),
        (),
        plants=1,
        max_latency=MOST,
        estimates=False,
        seed=0,
    )
    arms = Arms()
    shown = arms.observation(0) | {"target": posture_from_angles(np.full(8, 0.5))}
    seen = made(shown, 0)
    np.testing.assert_allclose(seen["reference"], shown["target"], atol=1e-12)
    eased = eased_target(seen["joint_angles"], shown["target"], shown["target"])
    np.testing.assert_allclose(seen["target"], eased, atol=1e-12)


@pytest.mark.parametrize("delay", range(MOST + 1))
def test_a_delay_that_is_not_known_is_found_within_some_steps(delay: int) -> None:
    made = senses(None)
    dance(made, Arms(), commands(STEPS), [delay] * STEPS)
    assert [int(found) for found in made.delays[delay + 4 :]] == [delay] * (STEPS - delay - 4)


@pytest.mark.parametrize(("before", "after"), [(1, 4), (5, 0), (2, 3)])
def test_a_jump_of_the_delay_is_found_within_some_steps(before: int, after: int) -> None:
    made = senses(None)
    delays = [before] * (STEPS // 2) + [after] * (STEPS // 2)
    dance(made, Arms(), commands(STEPS), delays)
    found = [int(delay) for delay in made.delays]
    assert found[STEPS // 2 - 1] == before
    assert found[STEPS // 2 + 8 :] == [after] * (STEPS // 2 - 8)


@pytest.mark.parametrize("latency", [0, 1, 3, None])
def test_aligned_steps_pair_a_command_with_what_it_did(latency: int | None) -> None:
    made, given = senses(latency), commands(STEPS)
    delays = [2] * 25 + [4] * 20 + [1] * 15 if latency is None else [latency] * STEPS
    observed, _, acted = dance(made, Arms(), given, delays)
    steps = {"action": given, "number": np.arange(STEPS)}
    aligned = made.aligned(steps, observed[-1], ())
    count = len(aligned["action"])
    if latency is not None:
        assert count == STEPS - latency
        np.testing.assert_array_equal(aligned["number"], np.arange(STEPS - latency))
    matched = 0
    for row, step in enumerate(range(STEPS - count, STEPS)):
        for name in ("joint_angles", "joint_velocities", "posture"):
            np.testing.assert_allclose(aligned[name][row], observed[step][name], atol=1e-12)
            following = observed[step + 1][name]
            np.testing.assert_allclose(aligned[f"next_{name}"][row], following, atol=1e-12)
        np.testing.assert_array_equal(aligned["action"][row], given[aligned["number"][row]])
        matched += (aligned["action"][row] == acted[step]).all()
    assert matched == count  # the first move after a jump, too: it shows its delay at once


def test_aligned_steps_of_a_batch_are_those_of_each_run() -> None:
    made, given = senses(None, (2,)), commands(STEPS, (2,))
    observed, _, acted = dance(made, Arms((2,)), given, np.tile([1, 3], (STEPS, 1)))
    for run, delay in enumerate((1, 3)):
        last = {name: value[run] for name, value in observed[-1].items()}
        aligned = made.aligned({"action": given[:, run]}, last, (run,))
        np.testing.assert_array_equal(
            aligned["action"][10:], acted[-len(aligned["action"]) + 10 :, run]
        )
        assert STEPS - 10 < len(aligned["action"]) <= STEPS
        assert [int(found[run]) for found in made.delays[10:]] == [delay] * (STEPS - 10)


def test_predictions_are_shifted_to_the_steps_at_which_their_commands_act() -> None:
    made = senses(3)
    dance(made, Arms(), commands(10), [3] * 10)
    predictions = np.arange(10.0)[:, None, None] * np.ones((1, 2, 12))
    shifted = made.effects(predictions)
    np.testing.assert_array_equal(shifted[:, 0, 0], [0, 0, 0, 0, 1, 2, 3, 4, 5, 6])
    assert shifted.shape == predictions.shape


def test_the_last_move_meets_the_prediction_of_the_command_that_caused_it() -> None:
    made = senses(2)
    assert made.of_last_move(None) is None
    arms = Arms()
    found = []
    for t, command in enumerate(commands(6)):
        made(arms.observation(t), 0)
        if t:
            prediction = made.of_last_move(np.full((2, 8), float(t - 1)))
            assert prediction is not None
            found.append(prediction[0, 0])
        made.acting(arms.observation(t), command)
        arms.step(command, 2)
    assert found == [0, 0, 0, 1, 2]  # move t-1 was caused by the command of t-3


def test_runs_of_a_batch_sense_as_alone_to_the_bit() -> None:
    delays = np.array([[0, 3, 5]] * 30 + [[4, 1, 5]] * 30)
    made, given = senses(None, (3,)), commands(STEPS, (3,))
    _, together, _ = dance(made, Arms((3,)), given, delays)
    for run in range(3):
        alone = senses(None)
        _, expected, _ = dance(alone, Arms(), given[:, run], delays[:, run])
        for one, other in zip(together, expected, strict=True):
            for name, values in other.items():
                np.testing.assert_array_equal(one[name][run], values)
        assert [int(d[run]) for d in made.delays] == [int(d) for d in alone.delays]


def test_the_arms_are_learned_from_late_commands() -> None:
    made = senses(3, exact=False)
    for number in range(3):
        made.reset(number)
        arms, given = Arms(), commands(400, seed=number)
        observed, expected, _ = dance(made, arms, given, [3] * 400)
        aligned = made.aligned({"action": given}, observed[-1], ())
        made.learn(aligned, np.ones((len(aligned["action"]), 1)), ())
    away = [expected[t]["joint_angles"] - observed[t + 3]["joint_angles"] for t in range(390)]
    prior = senses(3, exact=False)
    observed, expected, _ = dance(prior, Arms(), given, [3] * 400)
    untrained = [expected[t]["joint_angles"] - observed[t + 3]["joint_angles"] for t in range(390)]
    assert np.abs(away).mean() < np.abs(untrained).mean() / 5


@pytest.mark.parametrize("latency", [3, None])
def test_arms_never_met_are_expected_better_in_the_course_of_an_episode(
    latency: int | None,
) -> None:
    made = senses(latency, exact=False)
    observed, expected, _ = dance(made, Arms(), commands(600), [3] * 600)
    away = [
        np.abs(expected[t]["joint_angles"] - observed[t + 3]["joint_angles"]).mean()
        for t in range(590)
    ]
    assert np.mean(away[-100:]) < 0.5 * np.mean(away[20:120])


def test_without_a_latency_state_models_stay_as_they_were_learned() -> None:
    made = senses(0, exact=False, estimates=True)
    dance(made, Arms(), commands(STEPS), [0] * STEPS)
    np.testing.assert_array_equal(made._models.of_plant(0), kinematic_prior())


def test_an_episode_begins_with_no_command_under_way() -> None:
    made = senses(None)
    dance(made, Arms(), commands(STEPS), [3] * STEPS)
    made.reset(1)
    assert not made.delays
    first = Arms().observation(0)
    np.testing.assert_array_equal(made(first, 0)["joint_angles"], first["joint_angles"])


def test_with_a_state_estimate_the_present_state_is_the_estimate() -> None:
    made = senses(0, estimates=True)
    for _ in range(5):
        made.learn(
            {
                "action": np.zeros((30, 8)),
                **{
                    f"{n}joint_{k}": np.zeros((30, 8))
                    for n in ("", "next_")
                    for k in ("angles", "velocities")
                },
            },
            np.ones((30, 1)),
            (),
        )
    made._models._weights[...] = Arms().models._weights
    made.reset(0)
    arms, rng = Arms(), np.random.default_rng(0)
    observed, present = [], []
    for t, command in enumerate(commands(400)):
        noisy = arms.observation(t)
        noisy = noisy | {"joint_angles": noisy["joint_angles"] + 0.03 * rng.normal(size=8)}
        seen = made(noisy, 0)
        now, _ = made.acting(noisy, command)
        np.testing.assert_array_equal(seen["joint_angles"], now["joint_angles"])
        np.testing.assert_array_equal(now["posture"], posture_from_angles(now["joint_angles"]))
        observed.append(noisy["joint_angles"] - arms.angles)
        present.append(now["joint_angles"] - arms.angles)
        arms.step(command, 0)
    assert np.square(present[100:]).mean() < 0.5 * np.square(observed[100:]).mean()


def test_without_a_state_estimate_the_present_state_is_observed() -> None:
    made, arms = senses(2), Arms()
    shown = arms.observation(0)
    made(shown, 0)
    assert made.present(shown) is shown


def test_targets_that_were_never_anticipated_are_held_in_an_agent_from_elsewhere() -> None:
    blind = dataclasses.replace(SPEC, latency=3, lookahead=0)
    other = LateSenses(blind, (), plants=1, max_latency=MOST, estimates=False, seed=0)
    made = senses(3)
    other.load_state_dict(made.state_dict())
    weights = other.state_dict()
    np.testing.assert_array_equal(weights["state_models.weights"], made._models._weights)
    assert not weights["anticipation.weights"].any()
    # What was anticipated is, with another latency too.
    weights["anticipation.weights"] = np.ones_like(weights["anticipation.weights"])
    again = LateSenses(
        dataclasses.replace(blind, latency=1),
        (),
        plants=1,
        max_latency=MOST,
        estimates=False,
        seed=0,
    )
    again.load_state_dict(weights)
    assert again.state_dict()["anticipation.weights"].all()
    del weights["state_models.weights"]
    with pytest.raises(KeyError, match="state_models"):
        again.load_state_dict(weights)


def test_selected_runs_keep_their_models() -> None:
    made = senses(None, (3,), exact=False)
    made._models._weights[...] = np.arange(3.0)[:, None, None, None]
    made.select_runs(np.array([2, 0]))
    made.reset(1)
    assert made.delay.shape == (2,)
    assert made.state_dict()["state_models.weights"][:, 0, 0, 0].tolist() == [2.0, 0.0]
