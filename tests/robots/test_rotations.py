import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from mpma_mj.robots.rotations import about, across, between, circle, frame, rotated
from tests.robots.known_chains import unit

directions = (
    arrays(np.float64, 3, elements=st.floats(-1.0, 1.0))
    .filter(lambda v: bool(np.linalg.norm(v) > 1e-3))
    .map(unit)
)
angles = st.floats(-7.0, 7.0)


@given(directions, directions, angles)
def test_rotations_are_those_of_scipy(axis: np.ndarray, v: np.ndarray, angle: float) -> None:
    expected = Rotation.from_rotvec(angle * axis).apply(v)
    np.testing.assert_allclose(rotated(v, axis, np.array(angle)), expected, atol=1e-14)


@given(directions, directions, angles)
def test_the_angle_about_an_axis_undoes_a_rotation(
    axis: np.ndarray, v: np.ndarray, angle: float
) -> None:
    turned = rotated(v, axis, np.array(angle))
    back = rotated(v, axis, about(axis, v, turned))
    np.testing.assert_allclose(back, turned, atol=1e-7)


@given(directions, directions, directions, st.floats(0.0, np.pi))
def test_a_circle_has_the_angle_or_the_nearest_to_it(
    axis: np.ndarray, moved: np.ndarray, fixed: np.ndarray, angle: float
) -> None:
    found = between(rotated(moved, axis, circle(axis, moved, fixed, np.array(angle))), fixed)
    alpha, beta = between(axis, fixed), between(axis, moved)
    least, most = abs(alpha - beta), min(alpha + beta, 2.0 * np.pi - alpha - beta)
    np.testing.assert_allclose(found, np.clip(angle, least, most), atol=1e-7)


@given(directions, directions)
def test_frames_are_rotations_also_of_parallel_vectors(u: np.ndarray, f: np.ndarray) -> None:
    for other in (f, u, -u):
        found = frame(u, other)
        np.testing.assert_allclose(found.T @ found, np.eye(3), atol=1e-7)
        np.testing.assert_allclose(found[:, 0], u)
    assert abs(across(u) @ u) < 1e-15


def test_vectors_that_turn_together_come_nearest_together() -> None:
    rng = np.random.default_rng(0)
    axis, both, goal = unit(rng.normal(size=3)), rng.normal(size=(2, 3)), rng.normal(size=(2, 3))
    best = about(axis, both, goal, together=True)
    tried = rotated(both, axis, np.linspace(-np.pi, np.pi, 1000)[:, None])
    distance = np.sum((rotated(both, axis, best[None]) - goal) ** 2)
    assert distance <= np.sum((tried - goal) ** 2, axis=(1, 2)).min() + 1e-12
