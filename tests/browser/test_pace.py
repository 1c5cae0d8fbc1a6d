"""Steps in real time."""

import pytest

from mpma_mj.browser.pace import Pace


def dance(pace: Pace, times: list[float], start: float = 0.0) -> list[float]:
    """Return the times of the steps of a loop that looks at these times whether one is due."""
    pace.start(start)
    done = []
    for now in times:
        if not pace.wait(now):
            pace.step(now)
            done.append(now)
    return done


@pytest.mark.parametrize("tempo", [0.5, 1.0, 2.0])
def test_steps_are_done_in_real_time_at_a_tempo(tempo: float) -> None:
    pace = Pace(0.05)
    pace.tempo = tempo
    steps = dance(pace, [i / 1000 for i in range(4000)])
    assert len(steps) == pytest.approx(4.0 * tempo / 0.05, abs=1)
    assert pace.real_time_factor == pytest.approx(tempo, rel=0.02)


def test_a_short_delay_is_caught_up() -> None:
    late = [i / 1000 for i in range(1000) if not 400 < i < 550]
    assert len(dance(Pace(0.05), late)) == pytest.approx(20, abs=1)


def test_of_a_long_delay_a_fifth_of_a_second_is_caught_up() -> None:
    late = [i / 1000 for i in range(11000) if not 400 < i < 10400]
    steps = dance(Pace(0.05), late)
    assert len(steps) == pytest.approx(1.0 / 0.05 + 0.2 / 0.05, abs=2)


def test_a_pause_is_not_caught_up() -> None:
    pace = Pace(0.05)
    dance(pace, [0.0, 0.05])
    assert dance(pace, [9.0, 9.001, 9.002], start=9.0) == [9.0]
    assert pace.real_time_factor == 0.0


def test_waiting_ends_when_the_next_step_is_due() -> None:
    pace = Pace(0.05)
    pace.start(3.0)
    assert pace.wait(3.0) == 0.0
    pace.step(3.0)
    assert pace.wait(3.01) == pytest.approx(0.04)
