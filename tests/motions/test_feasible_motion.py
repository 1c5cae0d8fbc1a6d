import dataclasses
import itertools
import re
from pathlib import Path

import numpy as np
import pytest

from mpma_mj.envs.load import arm_limits
from mpma_mj.errors import InfeasibleMotionError
from mpma_mj.joint_paths import nearest_turn
from mpma_mj.kinematics import posture_from_angles
from mpma_mj.metrics import posture_error_percent
from mpma_mj.motions import Motion, read_motion, save_motion, ymca
from mpma_mj.motions.feasibility import beyond_limits, joint_speeds
from mpma_mj.motions.feasible_motion import feasible, feasible_tempo, fitted
from mpma_mj.motions.loader import import_motion
from mpma_mj.motions.options import ReadingOptions
from mpma_mj.motions.transforms import at_rate, join, mirrored, repeat
from tests.motions.known_motions import LIMITS, SPEED, moving, raising, singular
from tests.robots.humanoid import check_limits, humanoid_limits, short_dance


def changed(motion: Motion) -> Motion:
    motion, change = feasible(motion, LIMITS)
    assert change is not None
    return motion


def test_the_package_has_these_limits() -> None:
    for found, expected in zip(arm_limits("physics"), LIMITS, strict=True):
        np.testing.assert_array_equal(found, expected)


def test_a_motion_within_the_limits_stays_the_object_that_it_is() -> None:
    motion = ymca()
    assert feasible(motion, LIMITS) == (motion, None)


@pytest.mark.parametrize("seed", range(4))
def test_angles_are_within_the_limits_with_room_for_a_controller(seed: int) -> None:
    motion = changed(singular(seed))
    assert (joint_speeds(motion).max(axis=0) <= 0.901 * SPEED).all()
    elbows = motion.joint_angles[:, 3::4]
    assert elbows.min() >= 0.0
    assert elbows.max() <= 2.8
    assert not beyond_limits(motion, LIMITS)
    assert feasible(motion, LIMITS)[0] is motion


def test_the_posture_stays_the_original() -> None:
    np.testing.assert_array_equal(changed(singular(0)).posture, singular(0).posture)


def test_the_change_is_reported_in_numbers() -> None:
    motion, change = feasible(dataclasses.replace(singular(0), start=2.0), LIMITS)
    assert change is not None
    shown = posture_from_angles(motion.joint_angles)
    vectors = (shown * motion.posture).reshape(-1, 4, 3).sum(axis=2).clip(-1.0, 1.0)
    most = np.degrees(np.arccos(vectors)).max(axis=1)
    assert change.changed == pytest.approx((most > 1.0).mean())
    assert change.mean == pytest.approx(most.mean())
    assert change.largest == pytest.approx(most.max())
    assert change.unavoidable == pytest.approx(50.0 * np.abs(shown - motion.posture).mean())
    assert change.where.endswith(f" at {2.0 + most.argmax() / 20.0:.2f} s")
    assert change.unavoidable < 0.2
    assert str(change).startswith("right_elbow would have to be at 3.04 rad at 2.25 s, but")


def test_a_cyclic_motion_stays_cyclic() -> None:
    motion = changed(singular(1))
    back = nearest_turn(motion.joint_angles[0], near=motion.joint_angles[-1])
    assert (np.abs(back) <= 0.901 * SPEED / 20.0).all()
    posture, _, angles = repeat(motion, 3, SPEED)
    assert angles is not None
    assert len(posture) == len(angles) == 600
    assert (np.abs(np.diff(angles, axis=0)) <= 0.901 * SPEED / 20.0).all()


def test_an_elbow_beyond_its_range_is_clamped() -> None:
    angles = np.tile([0.3, 0.1, 0.2, 1.0] * 2, (60, 1))
    angles[:, 7] = 1.5 + 1.4 * np.sin(np.arange(60) / 60 * 2 * np.pi)  # up to 2.9
    motion, change = feasible(moving(angles), LIMITS)
    assert change is not None
    assert change.largest < np.degrees(0.15)
    assert motion.joint_angles[:, 7].max() <= 2.8
    np.testing.assert_allclose(motion.joint_angles[:30, 3], 1.0, atol=1e-3)


def test_an_unseen_angle_alone_changes_nothing_but_is_followed() -> None:
    angles = np.tile([0.3, 0.1, 0.2, 0.5] * 2, (60, 1))
    angles[20:40, 3] = 0.02
    motion, change = feasible(moving(angles), LIMITS)
    assert motion.feasible_angles is not None
    assert change is None or change.largest < 3.0


@pytest.mark.parametrize("seed", range(3))
def test_a_slower_tempo_is_never_worse(seed: int) -> None:
    motion = singular(seed, frames=400, seconds=0.6)
    left = []
    for tempo in (2.0, 1.5, 1.0, 0.7, 0.5):
        change = feasible(at_rate(motion, 20.0, tempo), LIMITS)[1]
        left.append(0.0 if change is None else change.unavoidable)
    assert all(slower <= faster + 0.005 for faster, slower in itertools.pairwise(left))


def test_the_tempo_that_is_found_needs_no_change_and_the_next_one_does() -> None:
    def read(tempo: float) -> Motion:
        return at_rate(raising(20.0, frames=30), 20.0, tempo)

    tempo = feasible_tempo(read, LIMITS)
    assert feasible(read(tempo), LIMITS)[1] is None
    assert feasible(read(tempo + 0.01), LIMITS)[1] is not None
    assert 0.5 < tempo < 0.7


def test_no_tempo_bends_an_elbow_less(tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    save_motion(path, moving(np.tile([0.3, 0.1, 0.2, 3.1] * 2, (60, 1))))
    expected = rf"^{re.escape(str(path))}: no tempo is slow enough: .*_elbow would"
    with pytest.raises(InfeasibleMotionError, match=expected):
        read_motion(path, tempo="auto", limits=LIMITS)


def test_it_is_the_same_after_it_was_written(tmp_path: Path) -> None:
    motion = changed(singular(0))
    save_motion(tmp_path / "a.npz", motion)
    again = read_motion(tmp_path / "a.npz", limits=LIMITS)
    np.testing.assert_array_equal(again.feasible_angles, motion.feasible_angles)
    cut = read_motion(tmp_path / "a.npz", start=2.0, end=4.0)
    np.testing.assert_array_equal(cut.feasible_angles, motion.joint_angles[40:80])
    assert read_motion(tmp_path / "a.npz", tempo=0.5).feasible_angles is None


def test_other_limits_fit_the_original_again() -> None:
    slower = LIMITS._replace(max_speed=0.5 * SPEED)
    motion = changed(singular(0))
    again, change = feasible(motion, slower)
    assert change is not None
    assert (joint_speeds(again).max(axis=0) <= 0.901 * 0.5 * SPEED).all()
    np.testing.assert_array_equal(
        again.feasible_angles, feasible(singular(0), slower)[0].feasible_angles
    )


def test_ranges_of_shoulders_are_kept() -> None:
    narrow = LIMITS._replace(
        lowest=np.array([-2.5, -2.5, -2.5, 0.0] * 2), highest=np.array([2.5, 2.5, 2.5, 2.8] * 2)
    )
    motion, change = feasible(singular(0), narrow)
    assert change is not None
    assert change.unavoidable < 2.0
    assert (motion.joint_angles >= narrow.lowest).all()
    assert (motion.joint_angles <= narrow.highest).all()


def test_a_mirrored_motion_has_mirrored_angles() -> None:
    motion = mirrored(changed(singular(0)))
    np.testing.assert_allclose(
        posture_from_angles(motion.joint_angles),
        mirrored(
            dataclasses.replace(
                singular(0), posture=posture_from_angles(changed(singular(0)).joint_angles)
            )
        ).posture,
        atol=1e-12,
    )


def test_a_mirrored_motion_of_a_robot_is_fitted_again() -> None:
    limits, dance = humanoid_limits(), short_dance()
    motion = fitted(mirrored(dance), limits)[0]
    check_limits(motion.joint_angles, motion.rate)
    off = [
        posture_error_percent(limits.kinematics.posture(one.joint_angles), one.posture)
        for one in (dance, motion)
    ]
    assert off[1] < 1.5 * off[0]


def test_a_repertoire_with_it_has_angles_throughout() -> None:
    joined = join([changed(singular(0)), ymca()], SPEED)
    assert joined.feasible_angles is not None
    assert not beyond_limits(joined, LIMITS._replace(max_speed=1.01 * SPEED))
    assert np.abs(np.diff(joined.joint_angles, axis=0)).max() < 1.0
    shown = posture_from_angles(joined.joint_angles[-len(ymca()) :])
    np.testing.assert_allclose(shown, ymca().posture, atol=1e-9)


def test_options_that_need_limits_say_so(tmp_path: Path) -> None:
    save_motion(tmp_path / "a.npz", raising(20.0, frames=30))
    strict = ReadingOptions(strict=True)
    with pytest.raises(
        ValueError, match=r"needed for strict; give them with limits=mpma_mj.arm_limits"
    ):
        import_motion(tmp_path / "a.npz", strict)
    with pytest.raises(InfeasibleMotionError, match=r"a\.npz: .* leave out strict"):
        import_motion(tmp_path / "a.npz", strict, limits=LIMITS)
    with pytest.raises(ValueError, match="needed for tempo=auto"):
        import_motion(tmp_path / "a.npz", ReadingOptions(tempo="auto"))
    slowed = read_motion(tmp_path / "a.npz", tempo="auto", strict=True, limits=LIMITS)
    assert 0.5 < slowed.tempo < 0.7
