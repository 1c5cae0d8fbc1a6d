import numpy as np
import pytest

from mpma_mj.joint_paths import held_angles
from mpma_mj.kinematics import as_left_arms, segment_jacobian
from mpma_mj.motions.branch_search import best_branches
from mpma_mj.motions.joint_fit import StepLimits, fit_joint_angles
from tests.motions.known_motions import singular

STEP = np.array([0.5, 0.5, 0.85, 0.6])


@pytest.mark.parametrize("seed", range(3))
def test_the_path_is_within_the_ranges_and_near_the_directions(seed: int) -> None:
    directions = as_left_arms(singular(seed).posture)[0]
    low, high = np.array([-4.0, -4.0, -4.0, 0.0]), np.array([4.0, 4.0, 4.0, 2.8])
    path = best_branches(directions, StepLimits(STEP, low, high))
    assert ((path >= low) & (path <= high)).all()
    assert np.abs(segment_jacobian(path)[0] - directions).mean() < 0.1


def test_a_fit_from_it_is_closer_where_ranges_exclude_the_nearest_branch() -> None:
    distances = []
    for seed in range(4):
        motion = singular(seed)
        directions = as_left_arms(motion.posture)[0]
        limits = StepLimits(STEP, np.array([-2.5] * 3 + [0.0]), np.array([2.5] * 3 + [2.8]))
        starts = held_angles(motion.posture)[:, :4], best_branches(directions, limits)
        distances.append(
            [fit_joint_angles(directions, segment_jacobian, one, limits)[1] for one in starts]
        )
    nearest, searched = np.sum(distances, axis=0)
    assert searched < 0.5 * nearest


def test_an_exact_branch_is_found() -> None:
    angles = np.tile([2.6, 0.4, -2.0, 1.0], (20, 1))
    angles[:, 0] += np.arange(20) * 0.05  # over π, where the principal value jumps
    low, high = np.array([-4.0, -4.0, -4.0, 0.0]), np.array([4.0, 4.0, 4.0, 2.8])
    path = best_branches(segment_jacobian(angles)[0], StepLimits(STEP, low, high))
    np.testing.assert_allclose(segment_jacobian(path)[0], segment_jacobian(angles)[0], atol=1e-9)
    assert np.abs(np.diff(path, axis=0)).max() < 0.06


def test_ranges_that_exclude_every_candidate_are_kept() -> None:
    directions = as_left_arms(singular(0).posture)[0]
    low, high = np.full(4, 0.1), np.full(4, 0.11)
    path = best_branches(directions, StepLimits(STEP, low, high))
    assert ((path >= low) & (path <= high)).all()
