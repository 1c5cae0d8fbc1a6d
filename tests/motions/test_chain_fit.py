import dataclasses
from pathlib import Path

import numpy as np
import pytest

from mpma_mj.metrics import posture_error_percent
from mpma_mj.motions import Motion, read_motion, ymca
from mpma_mj.motions.chain_fit import fit_chain
from mpma_mj.motions.chain_search import interpolated, starting_paths
from mpma_mj.motions.joint_fit import StepLimits, fit_joint_angles
from mpma_mj.motions.transforms import leads_on
from mpma_mj.robots.chain import Chain
from tests.motions.known_motions import singular
from tests.robots.known_chains import CHAINS, LEFT, unit

SPEEDS = {
    "tilted": np.array([9.0, 9.0, 20.0, 20.0]),
    "narrow": np.array([16.7, 16.7, 5.4, 5.4]),
    "parallel": np.array([15.0, 15.0, 20.0, 20.0]),
}  # rad/s
MIRROR = np.array([1.0, -1.0, 1.0])


def right(chain: Chain) -> Chain:
    """Return the mirror image, of which equal angles give mirrored directions."""
    return dataclasses.replace(
        chain,
        axes=-MIRROR * chain.axes,
        upper_arm=MIRROR * chain.upper_arm,
        forearm=MIRROR * chain.forearm,
    )


def steps(angles: np.ndarray, cyclic: bool) -> np.ndarray:
    return np.abs(np.diff(np.concatenate([angles, angles[:1]]) if cyclic else angles, axis=0))


def fitted(motion: Motion, name: str) -> np.ndarray:
    """Return the posture of the closest motion of both arms, shape (T, 12)."""
    shown = []
    for chain, directions in zip(
        (CHAINS[name], right(CHAINS[name])), np.split(motion.posture, 2, axis=1), strict=True
    ):
        angles = fit_chain(directions, chain, SPEEDS[name], motion.rate, leads_on(motion))
        shown.append(chain.directions(angles))
    return np.concatenate(shown, axis=1)


@pytest.mark.parametrize("cyclic", [False, True])
@pytest.mark.parametrize("name", CHAINS)
def test_ranges_and_speeds_are_kept(name: str, cyclic: bool) -> None:
    chain = CHAINS[name]
    directions = singular(1, frames=40).posture[:, :6]
    angles = fit_chain(directions, chain, SPEEDS[name], 20.0, cyclic)
    assert ((angles >= chain.lowest) & (angles <= chain.highest)).all()
    assert (steps(angles, cyclic) <= 1.002 * SPEEDS[name] / 20.0).all()


@pytest.mark.parametrize("name", CHAINS)
def test_a_motion_within_the_limits_is_followed(name: str) -> None:
    chain, phase = CHAINS[name], np.arange(100)[:, None] * 0.2 + np.arange(4)
    middle, half = 0.5 * (chain.lowest + chain.highest), 0.5 * (chain.highest - chain.lowest)
    angles = middle + np.minimum(0.5 * half, 0.6 * SPEEDS[name] / 20.0 / 0.2) * np.sin(phase)
    directions = chain.directions(angles)
    found = fit_chain(directions, chain, SPEEDS[name], 20.0, cyclic=False)
    assert np.abs(chain.directions(found) - directions).max() < 0.01


def test_a_joint_without_a_range_may_turn_on_and_on() -> None:
    phase = np.arange(80) * 2.0 * np.pi / 80
    angles = np.stack([phase, 0.3 * np.sin(phase), 0.2 * np.cos(phase), 0.0 * phase + 1.2], axis=1)
    found = fit_chain(LEFT.directions(angles), LEFT, np.full(4, 8.0), 20.0, cyclic=True)
    assert np.abs(LEFT.directions(found) - LEFT.directions(angles)).max() < 0.01
    turned = found[-1] - found[0]
    assert abs(turned[0]) == pytest.approx(2.0 * np.pi, abs=0.1)
    end = found[-1] - 2.0 * np.pi * np.round(turned / (2.0 * np.pi))
    assert (np.abs(found[0] - end) <= 1.002 * 8.0 / 20.0).all()


@pytest.mark.parametrize(("name", "percent"), [("tilted", 0.1), ("narrow", 0.5)])
def test_ymca_is_followed_closely(name: str, percent: float) -> None:
    assert posture_error_percent(fitted(ymca(), name), ymca().posture) <= percent


@pytest.mark.parametrize(("name", "percent"), [("tilted", 0.1), ("narrow", 0.5)])
@pytest.mark.parametrize("recording", ["cmu_amc/01_01.amc", "qualisys_tsv/dance.tsv"])
@pytest.mark.filterwarnings("ignore::mpma_mj.errors.RecordingWarning")
def test_recordings_are_followed_closely(
    mocap: Path, recording: str, name: str, percent: float
) -> None:
    motion = read_motion(mocap / recording)
    assert posture_error_percent(fitted(motion, name), motion.posture) <= percent


@pytest.mark.parametrize("name", ["tilted", pytest.param("narrow", marks=pytest.mark.slow)])
def test_a_slower_tempo_is_not_worse(name: str) -> None:
    chain, off = CHAINS[name], []
    for tempo in (1.0, 0.5):
        directions = read_motion("ymca", tempo=tempo).posture[:, :6]
        angles = fit_chain(directions, chain, SPEEDS[name], 20.0, cyclic=True)
        off.append(np.mean((chain.directions(angles) - directions) ** 2))
    assert (np.diff(off) <= 0.01 * np.array(off[:-1]) + 1e-6).all()  # as samples are others


@pytest.mark.parametrize(
    ("name", "seed", "frames", "factor", "arm"),
    [
        ("tilted", 10, 24, 0.5, 1),
        pytest.param("narrow", 46, 60, 0.1, 0, marks=pytest.mark.slow),
    ],
)
def test_a_motion_is_not_farther_than_at_twice_its_tempo(
    name: str, seed: int, frames: int, factor: float, arm: int
) -> None:
    chain, directions = CHAINS[name], np.split(singular(seed, frames).posture, 2, axis=1)[arm]
    angles, faster = (
        fit_chain(shown, chain, factor * SPEEDS[name], 20.0, cyclic=True)
        for shown in (directions, directions[::2])
    )
    slowed = interpolated(faster, 2, frames, chain, cyclic=True)
    off = [np.sum((chain.directions(one) - directions) ** 2) for one in (angles, slowed)]
    assert off[0] < off[1]


@pytest.mark.parametrize("name", CHAINS)
def test_higher_speeds_are_not_worse(name: str) -> None:
    chain, directions = CHAINS[name], singular(2, frames=30).posture[:, :6]
    off = []
    for factor in (0.5, 1.0):
        angles = fit_chain(directions, chain, factor * SPEEDS[name], 20.0, cyclic=True)
        off.append(np.sum((chain.directions(angles) - directions) ** 2))
    assert (np.diff(off) <= 0.01 * np.array(off[:-1])).all()


def test_a_joint_without_a_range_does_not_turn_faster_than_it_can() -> None:
    phase, speed = np.arange(24) * 2.0 * np.pi / 24, np.full(4, 1.2)
    upper_arm = unit(np.stack([phase**0, 0.05 * np.sin(phase), -0.05 * np.cos(phase)], axis=1))
    directions = np.concatenate([upper_arm, unit(upper_arm + np.array([0.0, 0.3, -0.8]))], axis=1)
    angles = fit_chain(directions, LEFT, speed, 20.0, cyclic=True)
    assert (steps(angles, cyclic=True) <= 1.002 * speed / 20.0).all()
    assert np.abs(LEFT.directions(angles) - directions).max() < 0.06


def test_a_whole_turn_that_is_too_fast_is_left_out() -> None:
    phase, speed = np.arange(40) * 2.0 * np.pi / 40, np.full(4, 1.5)
    turning = np.stack([phase, 0.3 * np.sin(phase), 0.2 * np.cos(phase), 0.0 * phase + 1.2], axis=1)
    directions = LEFT.directions(turning)
    angles = fit_chain(directions, LEFT, speed, 20.0, cyclic=True)
    assert (steps(angles, cyclic=True) <= 1.002 * speed / 20.0).all()
    shown = (LEFT.directions(angles), LEFT.directions(turning[20]))
    off = [np.sum((one - directions) ** 2) for one in shown]
    assert off[0] < 0.5 * off[1]


def test_several_starts_come_closer_than_the_nearest_path() -> None:
    chain, directions = CHAINS["tilted"], ymca().posture[:, :6]
    limits = StepLimits(SPEEDS["tilted"] / 20.0, chain.lowest, chain.highest)
    nearest = starting_paths(directions, chain, limits.step, 20.0, False)[0]
    alone = fit_joint_angles(directions, chain.jacobian, nearest, limits)[1]
    angles = fit_chain(directions, chain, SPEEDS["tilted"], 20.0, cyclic=False)
    assert np.sum((chain.directions(angles) - directions) ** 2) < 0.2 * alone


# Each is a motion that only one of the starts brings so close: the nearest path, the cheapest of
# the exact branches, the coarse search.
@pytest.mark.parametrize(
    ("name", "seed", "frames", "factor", "cyclic", "most"),
    [
        ("narrow", 8, 24, 1.0, False, 6.2),
        ("parallel", 61, 24, 0.2, True, 5.35),
        ("tilted", 37, 32, 0.2, False, 0.65),
    ],
)
def test_every_start_comes_closest_to_some_motion(
    name: str, seed: int, frames: int, factor: float, cyclic: bool, most: float
) -> None:
    chain, directions = CHAINS[name], singular(seed, frames).posture[:, :6]
    angles = fit_chain(directions, chain, factor * SPEEDS[name], 20.0, cyclic)
    assert np.sum((chain.directions(angles) - directions) ** 2) < most


def test_mirrored_arms_have_equal_angles() -> None:
    chain, directions = CHAINS["tilted"], singular(3, frames=30).posture[:, :6]
    mirrored = (directions.reshape(-1, 2, 3) * MIRROR).reshape(-1, 6)
    angles, other = (
        fit_chain(shown, arm, SPEEDS["tilted"], 20.0, cyclic=False)
        for shown, arm in ((directions, chain), (mirrored, right(chain)))
    )
    np.testing.assert_allclose(angles, other, atol=0.02)


def test_equal_calls_are_equal_to_the_bit() -> None:
    directions = singular(0, frames=16).posture[:, :6]
    one, two = (
        fit_chain(directions, CHAINS["narrow"], SPEEDS["narrow"], 20.0, True) for _ in range(2)
    )
    np.testing.assert_array_equal(one, two)
