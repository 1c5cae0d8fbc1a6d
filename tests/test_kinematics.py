import mujoco
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from mpma_mj.envs.physics import PhysicsArms
from mpma_mj.kinematics import (
    JOINT_NAMES,
    SIDES,
    after_abduction,
    angles_from_posture,
    as_left_arms,
    nearest_step,
    posture_from_angles,
    segment_jacobian,
    segment_leverage,
    wrap,
)

angles_anywhere = arrays(np.float64, 8, elements=st.floats(-7.0, 7.0))
vectors = arrays(np.float64, (4, 3), elements=st.floats(-1.0, 1.0)).filter(
    lambda v: bool((np.linalg.norm(v, axis=1) > 1e-3).all())
)


def unit(v: np.ndarray) -> np.ndarray:
    return (v / np.linalg.norm(v, axis=-1, keepdims=True)).ravel()


@given(vectors)
def test_posture_to_angles_and_back_is_exact(v: np.ndarray) -> None:
    posture = unit(v)
    again = posture_from_angles(angles_from_posture(posture))
    # Below 1e-9 an angle counts as undefined, which costs as much.
    np.testing.assert_allclose(again, posture, atol=3e-9)


@given(vectors, angles_anywhere)
def test_posture_to_angles_near_any_angles_and_back(v: np.ndarray, near: np.ndarray) -> None:
    posture = unit(v)
    angles = angles_from_posture(posture, near=near)
    np.testing.assert_allclose(posture_from_angles(angles), posture, atol=3e-9)
    assert (np.abs(angles - near) <= np.pi + 1e-9).all()


@given(angles_anywhere, arrays(np.float64, 8, elements=st.floats(-0.05, 0.05)))
def test_angles_are_found_again_from_nearby(angles: np.ndarray, offset: np.ndarray) -> None:
    angles[3::4] = 0.3 + np.abs(angles[3::4]) % 2.5
    angles[1::4] = np.where(np.abs(np.cos(angles[1::4])) < 0.2, 0.5, angles[1::4])
    found = angles_from_posture(posture_from_angles(angles), near=angles + offset)
    np.testing.assert_allclose(found, angles, atol=1e-9)


@given(vectors, angles_anywhere)
def test_a_step_knows_the_leverage_of_the_angles_it_leads_to(
    v: np.ndarray, near: np.ndarray
) -> None:
    _, cos_b, sin_e = nearest_step(2.0 * unit(v), near)  # of vectors of any length
    leverage = segment_leverage(angles_from_posture(unit(v), near=near)).reshape(2, 4)
    np.testing.assert_allclose(cos_b[:, 0], leverage[:, 0], atol=3e-9)
    np.testing.assert_allclose(sin_e[:, 0], leverage[:, 2], atol=3e-9)


@given(angles_anywhere)
def test_equal_angles_give_mirrored_postures(angles: np.ndarray) -> None:
    angles[4:] = angles[:4]
    left, right = posture_from_angles(angles).reshape(2, 2, 3)
    np.testing.assert_allclose(left * [1, -1, 1], right, atol=1e-15)


@given(angles_anywhere)
def test_both_branches_are_the_same_posture(angles: np.ndarray) -> None:
    other = angles * np.array([1, -1, 1, 1] * 2) + [np.pi, np.pi, np.pi, 0] * 2
    np.testing.assert_allclose(posture_from_angles(other), posture_from_angles(angles), atol=1e-14)


@pytest.mark.parametrize(
    ("joint", "segment", "direction"),
    [
        ("left_shoulder_abduction", 0, (0, 1, 0)),
        ("left_shoulder_flexion", 0, (1, 0, 0)),
        ("left_elbow", 1, (1, 0, 0)),
        ("right_shoulder_abduction", 2, (0, -1, 0)),
        ("right_shoulder_flexion", 2, (1, 0, 0)),
        ("right_elbow", 3, (1, 0, 0)),
    ],
)
def test_a_right_angle_at_one_joint(joint: str, segment: int, direction: tuple[int, ...]) -> None:
    angles = np.zeros(8)
    angles[JOINT_NAMES.index(joint)] = np.pi / 2
    segments = posture_from_angles(angles).reshape(4, 3)
    np.testing.assert_allclose(segments[segment], direction, atol=1e-15)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_upper_arms_straight_forward_or_back_hold_their_abduction(sign: float) -> None:
    posture = unit(np.array([[sign, 0, 0], [0.2, 0.5, 0.3]] * 2))
    near = np.full(8, 0.7)
    angles = angles_from_posture(posture, near=near)
    assert angles[0] == pytest.approx(0.7)
    assert angles[4] == pytest.approx(0.7)
    np.testing.assert_allclose(posture_from_angles(angles), posture, atol=1e-14)


def test_a_straight_elbow_holds_its_rotation() -> None:
    down = np.tile([0.0, 0.0, -1.0], 4)
    angles = angles_from_posture(down, near=np.full(8, 0.4))
    np.testing.assert_allclose(angles[2::4], 0.4)
    np.testing.assert_allclose(np.delete(angles, [2, 6]), 0.0, atol=1e-15)


def test_the_branch_is_not_chosen_by_the_rotation_of_a_straight_arm() -> None:
    near = np.array([0.0, 1.3, 0.0, 0.01] * 2)
    wanted = np.array([1.5, 1.2, 3.1, 0.01] * 2)
    found = angles_from_posture(posture_from_angles(wanted), near=near)
    np.testing.assert_allclose(found, wanted, atol=1e-9)


def test_batches_are_what_single_postures_are() -> None:
    rng = np.random.default_rng(0)
    postures = np.stack([unit(rng.normal(size=(4, 3))) for _ in range(6)])
    near = rng.normal(size=(6, 8))
    batch = angles_from_posture(postures.reshape(2, 3, 12), near=near.reshape(2, 3, 8))
    singles = [angles_from_posture(p, near=q) for p, q in zip(postures, near, strict=True)]
    np.testing.assert_array_equal(batch.reshape(6, 8), singles)


@given(arrays(np.float64, 8, elements=st.floats(-3.0, 3.0)))
def test_posture_and_its_derivatives_are_those_of_the_model(angles: np.ndarray) -> None:
    physics = PhysicsArms.make()
    physics.data.qpos[:] = angles
    mujoco.mj_forward(physics.model.ptr, physics.data.ptr)
    np.testing.assert_allclose(physics.posture(), posture_from_angles(angles), atol=1e-12)

    step = 1e-6 * np.eye(8)
    ahead, behind = (
        posture_from_angles(angles + step),
        posture_from_angles(angles - step),
    )
    finite_differences = (ahead - behind) / 2e-6  # (8, 12)
    lengths = np.repeat(physics.segment_lengths, 3)
    for side in SIDES:
        sites = [_site_jacobian(physics, f"{side}_{p}") for p in ("shoulder", "elbow", "wrist")]
        rows = slice(0, 6) if side == "left" else slice(6, 12)
        jacobian = np.concatenate([sites[1] - sites[0], sites[2] - sites[1]]) / lengths[rows, None]
        np.testing.assert_allclose(jacobian, finite_differences.T[rows], atol=1e-8)


def _site_jacobian(physics: PhysicsArms, site: str) -> np.ndarray:
    jacobian = np.zeros((3, 8))
    index = physics.model.name2id(site, "site")
    mujoco.mj_jacSite(physics.model.ptr, physics.data.ptr, jacobian, None, index)
    return jacobian


@given(arrays(np.float64, 5, elements=st.floats(-100.0, 100.0)))
def test_wrapped_angles_differ_by_whole_turns(angles: np.ndarray) -> None:
    wrapped = wrap(angles)
    assert ((wrapped >= -np.pi) & (wrapped < np.pi + 1e-12)).all()
    turns = (angles - wrapped) / (2 * np.pi)
    np.testing.assert_allclose(turns, np.round(turns), atol=1e-9)


def test_leverage_vanishes_where_angles_are_undefined() -> None:
    angles = np.array([0.3, np.pi / 2, 0.2, 0.0] * 2)
    np.testing.assert_allclose(segment_leverage(angles), [0, 1, 0, 1] * 2, atol=1e-15)


@given(angles_anywhere)
def test_derivatives_are_those_of_the_directions(angles: np.ndarray) -> None:
    directions, derivatives = segment_jacobian(angles.reshape(2, 4))
    np.testing.assert_allclose(directions, as_left_arms(posture_from_angles(angles))[:, 0])
    for joint in range(4):
        small = np.zeros(4)
        small[joint] = 1e-6
        ahead, behind = (segment_jacobian(angles.reshape(2, 4) + s)[0] for s in (small, -small))
        found = derivatives[:, :, joint]
        np.testing.assert_allclose(found, (ahead - behind) / 2e-6, atol=1e-8)


@given(angles_anywhere)
def test_the_other_angles_follow_a_given_abduction(angles: np.ndarray) -> None:
    directions = as_left_arms(posture_from_angles(angles))[:, 0]
    abduction = angles.reshape(2, 4)[:, 0]
    rest = np.stack([abduction, *after_abduction(directions, abduction)], axis=1)
    np.testing.assert_allclose(segment_jacobian(rest)[0], directions, atol=1e-9)
