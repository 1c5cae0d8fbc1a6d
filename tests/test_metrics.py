import numpy as np
import pytest
from sklearn.metrics import mutual_info_score

from mpma_mj import metrics

EYE = np.eye(4)


def test_posture_error_is_zero_when_equal_and_known_for_an_offset() -> None:
    x = np.zeros((5, 12))
    assert metrics.posture_error_percent(x, x) == 0.0
    assert metrics.posture_error_percent(x, x + 0.02) == pytest.approx(1.0)
    assert metrics.posture_error_percent(x - 1, x + 1) == pytest.approx(100.0)


def test_the_error_of_each_moment_has_the_mean_of_all() -> None:
    x = np.zeros((5, 12))
    late = x + 0.02 * np.arange(5)[:, None]
    np.testing.assert_allclose(metrics.error_over_time(x, late), [0.0, 1.0, 2.0, 3.0, 4.0])
    assert metrics.posture_error_percent(x, late) == pytest.approx(2.0)


def test_rp_error_compares_shares() -> None:
    prior = np.array([[0.2, 0.2], [0.9, 0.1]])
    assert metrics.rp_error_percent(prior, np.array([[0.5, 0.5], [0.9, 0.1]])) == pytest.approx(0)
    assert metrics.rp_error_percent(prior, np.array([[0.5, 0.5], [0.7, 0.3]])) == pytest.approx(10)


def test_feedback_ratio() -> None:
    assert metrics.feedback_ratio(np.full((3, 8), 0.1), np.full((3, 8), -0.4)) == pytest.approx(
        0.25
    )
    assert metrics.feedback_ratio(np.zeros((3, 8)), np.zeros((3, 8))) == 0.0


def test_uniform_responsibility_makes_every_module_active() -> None:
    context = np.repeat(EYE, 10, axis=0)
    assert metrics.active_modules(np.full((40, 4), 0.25), context) == [4, 4, 4, 4]


def test_short_bursts_are_not_activity() -> None:
    context = np.ones((100, 1))
    responsibility = np.tile([1.0, 0.0], (100, 1))
    responsibility[:24] = [0.5, 0.5]
    assert metrics.active_modules(responsibility, context) == [1]
    responsibility[:25] = [0.5, 0.5]
    assert metrics.active_modules(responsibility, context) == [2]


def test_a_label_that_is_never_danced_has_no_module() -> None:
    context = np.tile([1.0, 0.0], (10, 1))
    responsibility = np.tile([0.9, 0.1], (10, 1))
    assert metrics.active_modules(responsibility, context) == [1, 0]
    assert metrics.dominant_module(responsibility, context) == [0, -1]
    assert metrics.modules_used(responsibility, context) == 1


def test_nmi_is_one_for_one_module_a_label_and_zero_for_one_module() -> None:
    context = np.repeat(EYE, 10, axis=0)
    assert metrics.nmi(context[:, [2, 0, 3, 1]], context) == pytest.approx(1.0)
    assert metrics.nmi(np.tile(EYE[0], (40, 1)), context) == pytest.approx(0.0)
    halves = np.repeat(EYE[[0, 0, 1, 1]], 10, axis=0)
    assert metrics.nmi(halves, context) == pytest.approx(0.5)
    assert metrics.nmi(halves[:, :2], context) == pytest.approx(0.5)
    assert metrics.nmi(np.ones((40, 1)), np.ones((40, 1))) == 0.0


def test_nmi_is_one_also_for_labels_of_unequal_length() -> None:
    context = np.repeat(np.eye(3), [5, 30, 100], axis=0)
    assert metrics.nmi(context, context) == pytest.approx(1.0)
    assert metrics.nmi(np.eye(2)[[0] * 135], context) == 0.0


def test_nmi_is_that_of_a_library_over_the_entropy_of_labels() -> None:
    rng = np.random.default_rng(0)
    label, module = rng.integers(0, 3, 500), rng.integers(0, 4, 500)
    module[:200] = label[:200]
    counts = np.bincount(label) / 500
    expected = mutual_info_score(label, module) / -np.sum(counts * np.log(counts))
    assert metrics.nmi(np.eye(4)[module], np.eye(3)[label]) == pytest.approx(expected)


def test_modules_are_numbered_from_1_and_none_has_no_number() -> None:
    assert [metrics.module_number(index) for index in (0, 3, -1)] == [1, 4, None]


def test_entropies_of_one_module_at_a_time_and_of_all_at_once() -> None:
    turns = np.repeat(EYE, 10, axis=0)
    assert metrics.sharing_entropy(turns) == 0.0
    assert metrics.usage_entropy(turns) == pytest.approx(1.0)
    alone = np.tile(EYE[2], (40, 1))
    assert metrics.usage_entropy(alone) == metrics.sharing_entropy(alone) == 0.0
    alike = np.full((40, 4), 0.25)
    assert metrics.sharing_entropy(alike) == pytest.approx(1.0)
    assert metrics.usage_entropy(alike) == pytest.approx(1.0)
    two = np.tile([0.5, 0.5, 0.0, 0.0], (40, 1))
    assert metrics.sharing_entropy(two) == pytest.approx(0.5)
    assert metrics.sharing_entropy(np.ones((40, 1))) == metrics.usage_entropy(np.ones((40, 1))) == 0


def test_entropies_do_not_care_which_module_and_usage_is_never_less_than_sharing() -> None:
    responsibility = np.random.default_rng(0).dirichlet(np.full(5, 0.4), 100)
    sharing, usage = metrics.sharing_entropy(responsibility), metrics.usage_entropy(responsibility)
    assert 0 < sharing < usage <= 1
    other = responsibility[:, [3, 0, 4, 2, 1]]
    assert metrics.sharing_entropy(other) == pytest.approx(sharing)
    assert metrics.usage_entropy(other) == pytest.approx(usage)


def test_learned_share_is_0_where_nothing_is_learned_and_has_a_known_offset() -> None:
    rng = np.random.default_rng(0)
    action = rng.uniform(-1, 1, (40, 8))
    assert metrics.learned_share(np.zeros((40, 8)), action) == 0.0
    assert metrics.learned_share(-0.3 * action, action) == pytest.approx(0.3)
    one = np.zeros((40, 8))
    one[:, 2] = 0.1
    assert metrics.learned_share(one, np.full((40, 8), -0.5)) == pytest.approx(0.1 / 8 / 0.5)
    assert metrics.learned_share(2.0 * action, action) == pytest.approx(2.0)  # cancels a command
    assert metrics.learned_share(np.zeros((40, 8)), np.zeros((40, 8))) == 0.0


def test_repeatability_of_a_repeated_an_inverted_and_a_constant_signal() -> None:
    wave = np.sin(np.linspace(0, 6, 50))
    assert metrics.repeatability(np.tile(wave, 3), 50) == pytest.approx(1.0)
    assert metrics.repeatability(np.concatenate([wave, -wave]), 50) == pytest.approx(-1.0)
    assert np.isnan(metrics.repeatability(np.ones(150), 50))
    assert np.isnan(metrics.repeatability(wave, 50))


def test_a_last_repetition_that_is_cut_short_counts() -> None:
    wave = np.sin(np.linspace(0, 6, 50))
    two = np.concatenate([wave, -wave])[:-1]
    assert metrics.repeatability(two, 50) == pytest.approx(-1.0, abs=0.01)
    three = np.concatenate([wave, wave, -wave])[:-1]
    assert metrics.repeatability(three, 50) == pytest.approx(0.0, abs=0.01)


def test_mpkpe_leaves_out_shoulders() -> None:
    sites = np.zeros((7, 2, 3, 3))
    moved = sites.copy()
    moved[:, :, 0, 0] = 5.0
    assert metrics.mpkpe(sites, moved) == 0.0
    moved[:, :, 1, 2] = 0.03
    moved[:, :, 2, 1] = 0.05
    assert metrics.mpkpe(sites, moved) == pytest.approx(0.04)


def wave(steps: int, delay: float) -> np.ndarray:
    """Return smooth courses of postures that come so many steps late, shape (T, 12)."""
    time = np.arange(steps)[:, None] - delay
    return np.sin(0.2 * time + np.arange(12)) + 0.3 * np.cos(0.11 * time * np.arange(1, 13) / 6)


@pytest.mark.parametrize("steps_late", [-7, -1, 0, 1, 4, 10])
def test_phase_lag_of_a_course_that_comes_steps_late_or_early(steps_late: int) -> None:
    lag = metrics.phase_lag(wave(200, steps_late), wave(200, 0.0), 0.05)
    assert lag == pytest.approx(0.05 * steps_late, abs=0.001)


def test_phase_lag_is_found_between_steps() -> None:
    assert metrics.phase_lag(wave(200, 2.3), wave(200, 0.0), 0.05) == pytest.approx(0.115, abs=2e-3)


def test_phase_lag_does_not_depend_on_size_or_place() -> None:
    moved = 3.0 + 0.1 * wave(200, 2.0)
    assert metrics.phase_lag(moved, wave(200, 0.0), 0.05) == pytest.approx(0.1, abs=1e-3)


def test_phase_lag_of_what_does_not_move_is_no_number() -> None:
    assert np.isnan(metrics.phase_lag(np.ones((50, 12)), wave(50, 0.0), 0.05))
