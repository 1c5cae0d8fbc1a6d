import pytest

from mpma_mj.agents.gain_schedule import Gains, performance


def test_gains_begin_and_end_as_in_the_paper() -> None:
    assert Gains().feedback == 1.0
    assert Gains().inverse == 0.01
    assert Gains(1.0).feedback < 0.15
    assert Gains(1.0).inverse == 1.0


def test_gains_are_linear_in_progress() -> None:
    middle = Gains(0.5)
    assert middle.feedback == pytest.approx((Gains().feedback + Gains(1.0).feedback) / 2)
    assert middle.inverse == pytest.approx((Gains().inverse + Gains(1.0).inverse) / 2)


def test_full_performance_arrives_in_four_epochs_and_stays() -> None:
    gains = Gains()
    for epoch in range(1, 5):
        gains = gains.after(1.0)
        assert gains.progress == pytest.approx(epoch / 4)
    assert gains == Gains(1.0)
    assert gains.after(1.0) == Gains(1.0)


def test_without_performance_nothing_moves() -> None:
    assert Gains(0.3).after(0.0) == Gains(0.3)


@pytest.mark.parametrize(
    ("error", "expected"), [(25.0, 0.0), (14.0, 0.5), (3.0, 1.0), (0.5, 1.0), (40.0, 0.0)]
)
def test_performance_is_the_way_to_the_criterion(error: float, expected: float) -> None:
    assert performance(error, untrained_error=25.0) == pytest.approx(expected)


def test_predictions_that_were_good_from_the_start_do_not_divide_by_zero() -> None:
    assert performance(1.0, untrained_error=2.0) == 1.0
