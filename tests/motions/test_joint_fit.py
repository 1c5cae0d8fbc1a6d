import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mpma_mj.joint_paths import held_angles
from mpma_mj.kinematics import as_left_arms, segment_jacobian
from mpma_mj.motions.joint_fit import Seam, StepLimits, fit_joint_angles
from tests.motions.known_motions import singular

WIDE = np.full(4, np.inf)


def limits(step: float, low: float = -np.inf, high: float = np.inf) -> StepLimits:
    return StepLimits(np.full(4, step), np.full(4, low), np.full(4, high))


def swinging(step: float, frames: int = 100) -> np.ndarray:
    """Return joint angles that swing with steps of up to so much, shape (T, 4), rad."""
    phase = np.arange(frames)[:, None] * 0.2 + np.arange(4)
    return np.array([0.3, 0.2, 0.1, 1.3]) + step / 0.2 * np.sin(phase)


def test_angles_within_the_limits_are_kept() -> None:
    angles = swinging(0.1)
    found, distance = fit_joint_angles(
        segment_jacobian(angles)[0], segment_jacobian, angles, limits(0.2)
    )
    np.testing.assert_allclose(found, angles, atol=1e-3)
    assert distance < 1e-4


@settings(max_examples=20, deadline=None)
@given(st.floats(0.03, 0.3), st.booleans(), st.integers(0, 3))
def test_steps_and_ranges_are_kept_whatever_is_shown(step: float, cyclic: bool, seed: int) -> None:
    motion = singular(seed, frames=80)
    within = limits(step, -3.0, 3.0)
    seam = Seam(np.ones(4), np.zeros(4)) if cyclic else None
    start = held_angles(motion.posture)[:, :4]
    target = as_left_arms(motion.posture)[0]
    found, distance = fit_joint_angles(target, segment_jacobian, start, within, seam)
    steps = np.diff(np.concatenate([found, found[:1]]) if cyclic else found, axis=0)
    assert np.abs(steps).max() <= 1.01 * step
    assert np.abs(found).max() <= 3.0
    assert distance == pytest.approx(np.sum((segment_jacobian(found)[0] - target) ** 2))


def test_looser_limits_come_closer() -> None:
    target = as_left_arms(singular(1).posture)[0]
    start = held_angles(singular(1).posture)[:, :4]
    distances = [
        fit_joint_angles(target, segment_jacobian, start, limits(step))[1]
        for step in (0.05, 0.1, 0.2, 0.4)
    ]
    assert distances == sorted(distances, reverse=True)


def test_the_fit_is_a_minimum() -> None:
    """No small change of the whole path comes closer without breaking a limit."""
    angles, within = swinging(0.3), limits(0.2)
    target = segment_jacobian(angles)[0]
    found, distance = fit_joint_angles(target, segment_jacobian, angles, within)
    rng = np.random.default_rng(0)
    for _ in range(200):
        tried = found + 0.01 * rng.normal(size=4) * np.sin(
            np.arange(100)[:, None] * rng.uniform(0, 0.5) + rng.uniform(0, 6, 4)
        )
        tried = tried[0] + np.concatenate(
            [np.zeros((1, 4)), np.cumsum(np.diff(tried, axis=0).clip(-0.2, 0.2), axis=0)]
        )
        assert np.sum((segment_jacobian(tried)[0] - target) ** 2) > distance - 1e-3


def test_a_chain_of_any_joints_is_fitted() -> None:
    def planar(angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        sums = np.cumsum(angles, axis=1)
        directions = np.stack([np.cos(sums), np.sin(sums)], axis=2)
        turned = np.stack([-np.sin(sums), np.cos(sums)], axis=2)
        moves = np.tril(np.ones((3, 3)))[None, :, None, :] * turned[..., None]
        return directions.reshape(-1, 6), moves.reshape(-1, 6, 3)

    phase = np.arange(60)[:, None] * 0.3 + np.arange(3)
    target = planar(np.sin(phase))[0]
    step = StepLimits(np.full(3, 0.2), np.full(3, -0.8), np.full(3, 0.8))
    found, distance = fit_joint_angles(target, planar, np.zeros((60, 3)), step)
    assert np.abs(np.diff(found, axis=0)).max() <= 0.2002
    assert np.abs(found).max() <= 0.8
    assert distance < np.sum((planar(np.zeros((60, 3)))[0] - target) ** 2) / 4


def test_a_seam_on_the_other_branch_costs_nothing() -> None:
    angles = np.tile([0.3, 0.0, 0.2, 1.0], (50, 1))
    angles[:, 1] += np.linspace(0.5, np.pi - 0.5, 50)  # over straight forward to the other branch
    other = Seam(np.array([1.0, -1.0, 1.0, 1.0]), np.array([0.0, np.pi, 0.0, 0.0]))
    target = segment_jacobian(angles)[0]
    found, distance = fit_joint_angles(target, segment_jacobian, angles, limits(0.2), other)
    assert distance < 1e-3
    assert abs(np.pi - found[0, 1] - found[-1, 1]) <= 0.2002
