"""Every option: what it may be, what it does, and that the documentation has it."""

import inspect
import itertools
import re
from collections.abc import Callable
from dataclasses import dataclass, field, fields
from fractions import Fraction
from pathlib import Path
from typing import Any

import dm_env
import numpy as np
import pytest
import tyro
from hypothesis import given, settings
from hypothesis import strategies as st

import mpma_mj
from mpma_mj import metrics
from mpma_mj.envs.demonstration import Demonstration
from mpma_mj.envs.load import load
from mpma_mj.envs.options import EnvironmentOptions, options_from
from mpma_mj.envs.reward import mean_reward, reward_weights
from mpma_mj.errors import BadOptionError
from mpma_mj.feedback import feedback_action
from mpma_mj.kinematics import JOINT_NAMES, SEGMENT_NAMES, posture_from_angles
from mpma_mj.motions import Motion, read_motion, ymca

DOCS = Path(__file__).parents[2] / "docs" / "environment.md"
NAMES = [option.name for option in fields(EnvironmentOptions)]


@dataclass(frozen=True)
class Run:
    env: EnvironmentOptions = field(default_factory=EnvironmentOptions)


def at_rest(env: dm_env.Environment, steps: int) -> list[dm_env.TimeStep]:
    return [env.reset()] + [env.step(np.zeros(8)) for _ in range(steps)]


def followed(env: dm_env.Environment) -> float:
    """Return p_e of an episode under the feedback controller, percent."""
    timestep, postures, references = env.reset(), [], []
    while not timestep.last():
        seen = timestep.observation
        speed, timestep_s = env.task.max_joint_speed, env.control_timestep()
        action = feedback_action(seen["joint_angles"], seen["reference"], speed, timestep_s)
        timestep = env.step(action)
        postures.append(env.physics.posture())
        references.append(timestep.observation["reference"])
    return metrics.posture_error_percent(np.array(postures), np.array(references))


@pytest.mark.parametrize(
    ("option", "value", "message"),
    [
        ("arms", "rubber", "arms is 'rubber'; expected one of physics, kinematic"),
        ("arms", np.array(["a", "b"]), "arms is array"),
        ("repeats", 0, "repeats is 0; expected a whole number from 1 to 1000"),
        ("repeats", 1.5, "repeats is 1.5"),
        ("repeats", True, "repeats is True"),
        ("reference_noise", -0.1, "reference_noise is -0.1; expected 0 to 1, such as 0.01"),
        ("reference_noise", float("nan"), "reference_noise is nan"),
        ("reference_noise", "1 %", "reference_noise is '1 %'"),
        ("control_timestep", 0.0, "control_timestep is 0.0; expected 0.001 to 1, in seconds"),
        ("gravity_compensation", 1, "gravity_compensation is 1; expected True or False"),
        ("payload", -1.0, "payload is -1.0; expected 0 to 1000, in kg"),
        ("payload", float("inf"), "payload is inf"),
        ("actuator_strength", 0.0, "actuator_strength is 0.0; expected 0.01 to 100"),
        (
            "locked_joint",
            "knee",
            f"locked_joint is 'knee'; expected one of {', '.join(JOINT_NAMES)}",
        ),
        ("locked_joint", 3, "locked_joint is 3; expected one of left_shoulder_abduction"),
        ("latency", -1, "latency is -1; expected a whole number from 0 to 100"),
        ("latency", 0.5, "latency is 0.5"),
        ("observation_noise", 2.0, "observation_noise is 2.0; expected 0 to 1"),
        ("perturbation", 5.0, "perturbation is 5.0; expected rate (0 to 100 a second) and size"),
        ("perturbation", (1.0, -5.0), "perturbation is (1.0, -5.0)"),
        ("perturbation", (1.0,), "perturbation is (1.0,)"),
        ("perturbation", {1.0, 2.0}, "perturbation is {1.0, 2.0}"),
        ("perturbation", {1.0: 2.0, 3.0: 4.0}, "perturbation is {1.0: 2.0"),
        ("perturbation", ("often", 3), "perturbation is ('often', 3)"),
        ("collisions", "yes", "collisions is 'yes'; expected True or False"),
        ("random_start", 0, "random_start is 0; expected True or False"),
        (
            "termination_distance",
            0.0,
            "termination_distance is 0.0; expected 0.001 to 10, in metres",
        ),
        ("reward_weights", {"elbow": 1.0}, "expected a weight for some of left_upper_arm, "),
        (
            "reward_weights",
            {"left_forearm": -1.0},
            "expected 0 to 1e+06 for left_forearm",
        ),
        (
            "reward_weights",
            {"left_forearm": float("inf")},
            "reward_weights is {'left_forearm': inf}",
        ),
        ("reward_weights", [1, 1, 1, 1], "reward_weights is [1, 1, 1, 1]"),
        ("lookahead", -1, "lookahead is -1; expected a whole number from 0 to 1000"),
        ("phase", None, "phase is None; expected True or False"),
        ("repeats", 1001, "repeats is 1001"),
        ("latency", 101, "latency is 101"),
        ("lookahead", 1001, "lookahead is 1001"),
        ("reference_noise", True, "reference_noise is True"),
        ("perturbation", (101.0, 1.0), "perturbation is (101.0, 1.0)"),
        ("perturbation", (1.0, 10_001.0), "perturbation is (1.0, 10001.0)"),
        ("perturbation", (True, 1.0), "perturbation is (True, 1.0)"),
        ("model", 5, "model is 5; expected the path of an MJCF file"),
        ("model", "none.xml", "model is 'none.xml'; expected an MJCF file, and there is none"),
    ],
)
def test_what_an_option_may_not_be_is_one_line(option: str, value: Any, message: str) -> None:
    with pytest.raises(BadOptionError) as caught:
        load("ymca", **{option: value})
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("motion", [5, None, ["ymca"]])
def test_what_is_no_movement_is_refused(motion: Any) -> None:
    with pytest.raises(BadOptionError, match=r"motion is .*; expected a name, a path, or what"):
        load(motion)


def test_options_keep_their_own_plain_copies() -> None:
    weights = {"left_forearm": np.float32(2)}
    options = EnvironmentOptions(
        repeats=np.uint8(200), reference_noise=Fraction(1, 100), phase=np.True_,
        perturbation=np.array([0.5, 30.0]),
        reward_weights=weights, model=Path("arms.xml"),
    )  # fmt: skip
    weights["left_forearm"] = np.float32(-1)
    assert options.reward_weights == {"left_forearm": 2.0}
    assert type(options.repeats) is int
    assert options.model == "arms.xml"
    assert (options.reference_noise, options.phase, options.perturbation) == (
        0.01,
        True,
        (0.5, 30.0),
    )
    load("ymca", arms="kinematic", perturbation=[0.0, 0.0])
    assert load("ymca", repeats=np.uint8(200)).task.steps == 200 * len(ymca()) - 1


def test_no_reward_is_above_one_whatever_the_weights() -> None:
    for weights in itertools.product((1.0, 2.0, 3.0, 4.0, 1e6), repeat=4):
        named = dict(zip(SEGMENT_NAMES, weights, strict=True))
        assert 1.0 - 1e-12 < mean_reward(np.ones(4), reward_weights(named)) <= 1.0


def test_weights_that_are_all_zero_are_refused() -> None:
    names = ("left_upper_arm", "left_forearm", "right_upper_arm", "right_forearm")
    with pytest.raises(
        BadOptionError, match=r"reward_weights is .*; expected at least one above 0"
    ):
        load("ymca", reward_weights=dict.fromkeys(names, 0))


@pytest.mark.parametrize(
    "options",
    [
        {"gravity_compensation": True},
        {"payload": 1.0},
        {"actuator_strength": 0.5},
        {"perturbation": (1.0, 10.0)},
        {"collisions": True},
    ],
)
def test_ideal_arms_refuse_what_acts_by_forces(options: dict[str, Any]) -> None:
    (name,) = options
    with pytest.raises(
        BadOptionError, match=f"{name} is .*; ideal arms have no mass: leave {name} out"
    ):
        load("ymca", arms="kinematic", **options)
    load("ymca", arms="physics", **options)


def test_numpys_numbers_are_numbers() -> None:
    EnvironmentOptions(
        repeats=np.int64(2),
        reference_noise=np.float32(0.5),
        perturbation=[np.float64(1), np.int32(2)],
    )


def test_a_misspelt_option_is_guessed() -> None:
    with pytest.raises(
        BadOptionError, match=r"^no option 'refrence_noise'; did you mean reference_noise\?$"
    ):
        options_from({"refrence_noise": 0.1})
    with pytest.raises(BadOptionError, match=r"^no option 'tempi'; expected motion, seed, arms, "):
        options_from({"tempi": 2})


def test_equal_options_have_equal_hashes() -> None:
    one = EnvironmentOptions(payload=1, perturbation=[0.5, 30], reward_weights={"left_forearm": 2})  # type: ignore[arg-type]
    other = EnvironmentOptions(
        payload=np.float32(1.0),  # type: ignore[arg-type]
        perturbation=(0.5, 30.0),
        reward_weights={"left_forearm": 2.0},
    )
    assert one == other
    assert hash(one) == hash(other)
    assert one != EnvironmentOptions(payload=1.0)
    assert len({one, other, EnvironmentOptions()}) == 2


def test_the_command_line_takes_them_as_they_are() -> None:
    given = tyro.cli(
        tyro.conf.OmitArgPrefixes[Run],
        args=["--payload", "1.0", "--perturbation", "0.5", "30", "--model", "arms.xml"],
    )
    assert given.env == EnvironmentOptions(payload=1.0, perturbation=(0.5, 30.0), model="arms.xml")


@pytest.mark.parametrize("function", [mpma_mj.load, mpma_mj.make_vec])
def test_signatures_show_every_option_with_its_default(function: Callable[..., object]) -> None:
    parameters = inspect.signature(function).parameters
    default = EnvironmentOptions()
    for name in NAMES:
        expected = None if name == "reward_weights" else getattr(default, name)
        assert parameters[name].default == expected, name
    assert list(parameters)[-len(NAMES) :] == NAMES


def test_every_option_stands_in_the_documentation_with_its_default() -> None:
    rows = re.findall(r"^\| `(\w+)` \|.*?\| `(.*?)` \|", DOCS.read_text(), re.MULTILINE)
    defaults = inspect.signature(load).parameters
    shown = {name: eval(default) for name, default in rows}
    assert list(shown) == ["motion", "seed", *NAMES]
    for name, default in shown.items():
        assert default == ({} if name == "reward_weights" else defaults[name].default), name


# What each does


def test_control_timestep_is_that_of_a_recording_read_at_that_rate() -> None:
    env = load("ymca", control_timestep=0.025, repeats=1)
    assert env.control_timestep() == pytest.approx(0.025)
    assert env.task.steps == len(read_motion("ymca", rate=40.0)) - 1
    load(ymca(rate=40.0), control_timestep=0.025)


def test_a_movement_of_another_rate_is_refused() -> None:
    with pytest.raises(
        BadOptionError, match=r"expected 0.05 s, .*; or read the motion with rate=40"
    ):
        load(ymca(), control_timestep=0.025)
    with pytest.raises(
        BadOptionError,
        match=r"of 5 ms, as at 28\.5714 or 33\.3333 Hz; take control_timestep=0\.035 or",
    ):
        load("ymca", control_timestep=0.033)
    with pytest.raises(BadOptionError, match=r"physics steps of 5 ms, as at 100 or 200 Hz"):
        load("ymca", control_timestep=0.006)


def test_compensated_arms_stand_still_and_others_sink() -> None:
    motion = ymca()
    raised = Motion(
        posture_from_angles(np.tile([1.5, 0, 0, 0.5] * 2, (20, 1))),
        np.ones((20, 1)),
        ("up",),
        motion.rate,
        "raised",
        "arms held sideways",
    )
    sunk = {}
    for compensated in (True, False):
        angles = [
            t.observation["joint_angles"]
            for t in at_rest(load(raised, gravity_compensation=compensated), 15)
        ]
        sunk[compensated] = np.abs(angles[-1] - angles[0]).max()
    assert sunk[True] < 1e-3
    assert sunk[False] > 0.05


def test_gravity_compensation_does_not_know_the_payload() -> None:
    env = load("ymca", gravity_compensation=True, payload=2.0)
    env.reset()
    force = env.physics.data.qfrc_gravcomp + env.physics.data.qfrc_passive
    bare = load("ymca", gravity_compensation=True)
    bare.reset()
    np.testing.assert_allclose(
        force, bare.physics.data.qfrc_gravcomp + bare.physics.data.qfrc_passive, atol=1e-9
    )
    assert env.physics.model.body_gravcomp[env.physics.model.body("left_hand_payload").id] == 0


@pytest.mark.parametrize("kilograms", [0.5, 3.0])
def test_payload_is_so_many_kilograms_in_each_hand(kilograms: float) -> None:
    bare, loaded = load("ymca"), load("ymca", payload=kilograms)
    mass = loaded.physics.model.body_mass.sum() - bare.physics.model.body_mass.sum()
    assert mass == pytest.approx(2 * kilograms)
    for env in (bare, loaded):
        with env.physics.reset_context():
            env.physics.data.qpos[:] = np.array([np.pi / 2, 0, 0, 0] * 2)
    lever = 0.2817 + 0.2689 + 0.0681  # shoulder to the middle of the hand, m
    torque = loaded.physics.data.qfrc_bias[0] - bare.physics.data.qfrc_bias[0]
    assert torque == pytest.approx(9.81 * kilograms * lever, rel=1e-3)


def test_strength_scales_the_greatest_forces() -> None:
    ranges = [
        load("ymca", actuator_strength=s).physics.model.actuator_forcerange for s in (1.0, 0.25)
    ]
    np.testing.assert_allclose(ranges[1], 0.25 * ranges[0])


def test_what_is_harder_is_followed_worse() -> None:
    easy = followed(load("ymca", repeats=1))
    for harder in (
        {"payload": 5.0},
        {"actuator_strength": 0.1},
        {"latency": 2},
        {"perturbation": (5.0, 100.0)},
    ):
        assert followed(load("ymca", repeats=1, **harder)) > 1.1 * easy, harder


@pytest.mark.parametrize("arms", ["physics", "kinematic"])
@pytest.mark.parametrize("latency", [1, 3])
def test_latency_delays_actions_by_so_many_steps(arms: Any, latency: int) -> None:
    plain, late = load("ymca", arms=arms), load("ymca", arms=arms, latency=latency)
    rng = np.random.default_rng(0)
    actions = list(rng.uniform(-1, 1, (10, 8)))
    plain.reset(), late.reset()
    for action in [np.zeros(8)] * latency + actions:
        expected = plain.step(action).observation["posture"]
    for action in actions + [np.ones(8)] * latency:  # what is pending at the end has no effect
        got = late.step(action).observation["posture"]
    np.testing.assert_array_equal(got, expected)


def test_an_action_that_waits_is_the_one_that_was_given() -> None:
    env, action = load("ymca", arms="kinematic", latency=1), np.full(8, 0.25)
    env.reset()
    env.step(action)
    action[:] = -1.0
    velocities = env.step(action).observation["joint_velocities"]
    np.testing.assert_allclose(velocities[:3], 0.25 * env.task.max_joint_speed[:3])


def test_latency_begins_anew_with_each_episode() -> None:
    env = load("ymca", arms="kinematic", latency=2)
    for _ in range(2):
        start = env.reset().observation["joint_angles"]
        np.testing.assert_array_equal(env.step(np.ones(8)).observation["joint_angles"], start)


@pytest.mark.parametrize("arms", ["physics", "kinematic"])
def test_observation_noise_is_as_large_as_said_and_only_observed(arms: Any) -> None:
    env, exact = load("ymca", arms=arms, observation_noise=0.02), load("ymca", arms=arms)
    rng = np.random.default_rng(1)
    seen, true = [env.reset()], [exact.reset()]
    while not seen[-1].last():
        action = rng.uniform(-0.2, 0.2, 8)
        seen.append(env.step(action)), true.append(exact.step(action))
        assert seen[-1].reward == true[-1].reward

    def off(name: str) -> np.ndarray:
        pairs = zip(seen, true, strict=True)
        return np.array([s.observation[name] - t.observation[name] for s, t in pairs])

    assert off("joint_angles").std() == pytest.approx(0.02, rel=0.05)
    velocity = off("joint_velocities") / env.task.max_joint_speed
    assert velocity.std() == pytest.approx(0.02, rel=0.05)
    # Unit vectors keep the noise of two of three directions.
    assert off("posture").std() == pytest.approx(0.02 * np.sqrt(2 / 3), rel=0.05)
    vectors = np.array([t.observation["posture"] for t in seen]).reshape(-1, 3)
    np.testing.assert_allclose(np.linalg.norm(vectors, axis=1), 1.0)
    for name in ("reference", "target", "context"):
        assert not off(name).any()


@given(st.floats(0.1, 3.0), st.floats(5.0, 50.0))
@settings(max_examples=10)
def test_pushes_come_as_often_and_as_hard_as_said(rate: float, size: float) -> None:
    demonstration = demonstration_of(repeats=200, perturbation=(rate, size))
    forces = demonstration.episode(0, 0).perturbations
    assert forces is not None
    seconds = len(forces) / demonstration.motion.rate
    lasting = 2  # steps of 0.05 s in a tenth of a second
    # Of a Poisson process: impulses of random direction add up like a random walk, also where
    # pushes meet.
    expected = rate * seconds * lasting * size**2
    assert (forces**2).sum() == pytest.approx(expected, rel=6.0 / np.sqrt(rate * seconds))
    sizes = np.linalg.norm(forces, axis=-1)
    alone = np.isclose(sizes, size)
    assert alone.sum() > 0.6 * (sizes > 0).sum()
    np.testing.assert_allclose(
        forces[alone].mean(axis=0), 0.0, atol=6 * size / np.sqrt(alone.sum())
    )
    assert abs((sizes[:, 0] > 0).mean() / (sizes > 0).any(axis=1).mean() - 0.5) < 0.3


def demonstration_of(**options: Any) -> Demonstration:
    return Demonstration(ymca(), EnvironmentOptions(**options), np.full(8, 12.0))


def test_a_push_lasts_a_tenth_of_a_second_and_at_least_one_step() -> None:
    for rate, steps in ((20.0, 2), (50.0, 5), (4.0, 1)):
        motion = ymca(rate=rate)
        options = EnvironmentOptions(perturbation=(0.05, 1.0), repeats=100)
        forces = Demonstration(motion, options, np.full(8, 100.0)).episode(0, 0).perturbations
        assert forces is not None
        perturbed = np.concatenate([[0], (np.abs(forces).sum(axis=(1, 2)) > 0).astype(int), [0]])
        (begins,), (ends,) = np.where(np.diff(perturbed) == 1), np.where(np.diff(perturbed) == -1)
        assert len(begins) > 3
        assert np.median(ends - begins) == steps


def test_a_push_moves_the_arm_that_is_pushed() -> None:
    env, calm = load("ymca", perturbation=(2.0, 100.0)), load("ymca")
    perturbed, left = at_rest(env, 60), at_rest(calm, 60)
    apart = np.array(
        [
            p.observation["posture"] - c.observation["posture"]
            for p, c in zip(perturbed, left, strict=True)
        ]
    ).reshape(-1, 2, 6)
    forces = env.task._drawn.perturbations[:60]
    first, hand = np.argwhere(np.linalg.norm(forces, axis=-1) > 0)[0]
    assert not apart[: first + 1].any()
    assert np.abs(apart[first + 1, hand]).max() > 0.01
    assert np.abs(apart[first + 1, 1 - hand]).max() < 1e-9


def test_arms_that_collide_do_not_pass_through_the_body() -> None:
    angles = {}
    for collide in (True, False):
        env = load("ymca", collisions=collide)
        env.reset()
        with env.physics.reset_context():
            env.physics.data.qpos[:] = np.array([0.0, 0.9, 0.0, 1.2] * 2)
        for _ in range(20):  # forearms turn inwards, towards the chest
            env.physics.set_control(np.array([0.0, 0.0, -3.0, 0.0] * 2))
            env.physics.step(10)
        angles[collide] = env.physics.joint_angles()
        assert env.physics.divergence == ""
    assert angles[False][2] < angles[True][2] - 0.3


def test_arms_that_hang_touch_nothing() -> None:
    env = load("ymca", collisions=True)
    with env.physics.reset_context():
        pass
    assert env.physics.data.ncon == 0


def test_random_starts_are_anywhere_and_in_the_demonstrations_motion() -> None:
    env = load("ymca", random_start=True, reference_noise=0.0, repeats=2)
    starts = set()
    for _ in range(30):
        observation = env.reset().observation
        starts.add(env.task._step)
        np.testing.assert_allclose(observation["posture"], observation["reference"], atol=1e-9)
        moved = posture_from_angles(
            observation["joint_angles"] + 0.05 * observation["joint_velocities"]
        )
        np.testing.assert_allclose(moved, observation["target"], atol=1e-9)
    assert len(starts) > 20
    assert min(starts) >= 0
    assert max(starts) < env.task.steps


def test_an_episode_that_starts_later_ends_with_the_demonstration() -> None:
    env = load("ymca", random_start=True, repeats=1)
    env.reset()
    left = env.task.steps - env.task._step
    timesteps = at_rest_until_the_end(env)
    assert len(timesteps) == left
    assert timesteps[-1].discount == 1.0


def at_rest_until_the_end(env: dm_env.Environment) -> list[dm_env.TimeStep]:
    timesteps = [env.step(np.zeros(8))]
    while not timesteps[-1].last():
        timesteps.append(env.step(np.zeros(8)))
    return timesteps


@given(st.floats(0.05, 0.5))
def test_early_termination_is_at_the_distance_that_was_said(distance: float) -> None:
    env = load("ymca", arms="kinematic", termination_distance=distance, repeats=1)
    env.reset()
    sites = env.physics.site_positions

    def farthest(timestep: dm_env.TimeStep) -> float:
        seen = timestep.observation
        offset = sites(seen["posture"]) - sites(seen["reference"])
        return float(np.linalg.norm(offset, axis=-1).max())

    *before, last = at_rest_until_the_end(env)
    assert all(farthest(timestep) <= distance for timestep in before)
    assert farthest(last) > distance
    assert last.discount == 0.0
    assert last.reward > 0.0
    assert env.reset().first()
    assert env.task.termination_reason == ""


def test_weights_of_the_reward_are_those_of_its_terms() -> None:
    weights = {"left_forearm": 3.0, "right_forearm": 0.0}
    env = load("ymca", reward_weights=weights)
    timestep = at_rest(env, 20)[-1]
    terms = env.task.reward_terms(env.physics)
    full = dict.fromkeys(terms, 1.0) | weights
    expected = np.average(list(terms.values()), weights=list(full.values()))
    assert timestep.reward == pytest.approx(expected)
    assert len(set(terms.values())) == 4


def test_lookahead_shows_the_targets_to_come() -> None:
    env = load("ymca", lookahead=5, repeats=1)
    assert env.observation_spec()["lookahead"].shape == (5, 12)
    timesteps = [env.reset(), *at_rest_until_the_end(env)]
    references = np.array([t.observation["reference"] for t in timesteps])
    for now, timestep in enumerate(timesteps):
        lookahead = timestep.observation["lookahead"]
        np.testing.assert_array_equal(lookahead[0], timestep.observation["target"])
        shown = references[np.minimum(now + 1 + np.arange(5), len(references) - 1)]
        np.testing.assert_array_equal(lookahead, shown)


def test_phase_goes_round_once_a_repetition() -> None:
    env = load("ymca", phase=True)
    timesteps = [env.reset(), *at_rest_until_the_end(env)]
    phase = np.array([t.observation["phase"] for t in timesteps])
    np.testing.assert_allclose(np.linalg.norm(phase, axis=1), 1.0)
    turn = np.unwrap(np.arctan2(phase[:, 0], phase[:, 1]))
    np.testing.assert_allclose(turn, 2 * np.pi * np.arange(len(turn)) / env.task.period, atol=1e-9)


def test_spoilt_phases_and_futures_spoil_no_later_episode() -> None:
    env = load("ymca", phase=True, lookahead=2)
    first = {name: value.copy() for name, value in env.reset().observation.items()}
    env.task.episode = 0
    for value in env.reset().observation.values():
        value[:] = 7.0
    env.task.episode = 0
    for name, value in env.reset().observation.items():
        np.testing.assert_array_equal(value, first[name])


def test_arms_start_no_faster_than_they_can_turn() -> None:
    options = EnvironmentOptions(random_start=True)
    slow = Demonstration(ymca(), options, np.full(8, 0.5))
    speeds = [np.abs(slow.start_of(slow.episode(0, number))[1]).max() for number in range(20)]
    assert max(speeds) == 0.5


def test_what_is_random_depends_on_seed_and_episode_alone() -> None:
    options = {"observation_noise": 0.1, "perturbation": (1.0, 10.0), "random_start": True}
    one, other = demonstration_of(**options), demonstration_of(**options)
    a, b, c = one.episode(5, 7), other.episode(5, 7), one.episode(5, 8)
    assert a.start == b.start
    for name in ("reference", "sensor_noise", "perturbations"):
        np.testing.assert_array_equal(getattr(a, name), getattr(b, name))
        assert not np.array_equal(getattr(a, name), getattr(c, name))
    # Nor on what else is asked for.
    plain = demonstration_of().episode(5, 7)
    np.testing.assert_array_equal(plain.reference, a.reference)


def test_observations_share_no_memory_whatever_is_asked_for() -> None:
    env = load("ymca", lookahead=3, phase=True, observation_noise=0.01, latency=1)
    one, other = env.reset().observation, env.step(np.zeros(8)).observation
    kept = {name: value.copy() for name, value in one.items()}
    for value in other.values():
        value[:] = 7.0
    env.step(np.ones(8))
    for name, value in kept.items():
        np.testing.assert_array_equal(one[name], value)
        assert not any(np.shares_memory(one[name], later) for later in other.values())
    spec = env.observation_spec()
    assert one.keys() == spec.keys()
    for name, value in kept.items():
        spec[name].validate(value)
