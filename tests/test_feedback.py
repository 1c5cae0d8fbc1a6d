import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from mpma_mj import kinematics
from mpma_mj.feedback import feedback_action, joint_error

SPEED = np.array([12.0, 12.0, 20.0, 15.0] * 2)
bent = arrays(np.float64, 8, elements=st.floats(0.3, 1.2))


@given(bent)
def test_no_error_no_command(angles: np.ndarray) -> None:
    reference = kinematics.posture_from_angles(angles)
    np.testing.assert_allclose(feedback_action(angles, reference, SPEED, 0.05), 0.0, atol=1e-9)


@given(bent, arrays(np.float64, 8, elements=st.floats(-0.1, 0.1)))
def test_the_error_is_the_way_to_the_reference(angles: np.ndarray, way: np.ndarray) -> None:
    wanted = angles + way
    expected = way.copy()
    expected[2::4] *= np.sin(wanted[3::4])
    expected[0::4] *= np.cos(wanted[1::4]) ** 2
    error = joint_error(angles, kinematics.posture_from_angles(wanted))
    np.testing.assert_allclose(error, expected, atol=1e-9)


def test_a_command_undoes_the_error_in_one_step() -> None:
    angles = np.full(8, 0.5)
    wanted = angles.copy()
    wanted[1] += 0.1
    wanted[3] -= 0.2
    action = feedback_action(angles, kinematics.posture_from_angles(wanted), SPEED, 0.05)
    np.testing.assert_allclose(action[:4] * SPEED[:4] * 0.05, [0, 0.1, 0, -0.2], atol=1e-12)


def test_commands_stay_within_what_joints_can_do() -> None:
    rng = np.random.default_rng(1)
    postures = rng.normal(size=(500, 4, 3))
    postures /= np.linalg.norm(postures, axis=-1, keepdims=True)
    action = feedback_action(rng.normal(size=(500, 8)), postures.reshape(500, 12), SPEED, 0.05)
    assert np.abs(action).max() == 1.0


def test_errors_take_the_shorter_way_round() -> None:
    angles = np.array([3.1, 0.0, 0.3, 0.5] * 2)
    wanted = angles.copy()
    wanted[0] = -3.1  # across the top: 0.083 rad ahead
    error = joint_error(angles, kinematics.posture_from_angles(wanted))
    assert np.isclose(error[0], 2 * np.pi - 6.2)


def test_rotation_counts_as_much_as_the_elbow_is_bent() -> None:
    angles = np.array([0.4, 0.2, 0.0, 0.01] * 2)
    wanted = angles.copy()
    wanted[2] = 1.0
    error = joint_error(angles, kinematics.posture_from_angles(wanted))
    assert np.isclose(error[2], np.sin(0.01))
