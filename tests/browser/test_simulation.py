"""The simulation behind the page, without a page."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mpma_mj.browser.episode_factory import EpisodeFactory
from mpma_mj.browser.simulation import LiveSimulation
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.envs.plants import Plant
from mpma_mj.errors import BadOptionError, DivergedError
from mpma_mj.motions import ymca
from mpma_mj.training.config import RunConfig
from mpma_mj.training.run_folder import RunFolder

_PATIENCE = 60.0  # s until a test fails that waits for another thread


@pytest.fixture
def simulation(small_run: Path) -> LiveSimulation:
    return LiveSimulation(EpisodeFactory.of_run(RunFolder(small_run)))


def steps(simulation: LiveSimulation, number: int) -> None:
    for _ in range(number):
        simulation.single_step()


@contextlib.contextmanager
def running(
    simulation: LiveSimulation, draw: Callable[[], None] = lambda: None
) -> Iterator[threading.Thread]:
    """Let a thread own the simulation."""
    stop = threading.Event()
    thread = threading.Thread(target=simulation.run_until, args=(stop, draw))
    thread.start()
    try:
        yield thread
    finally:
        stop.set()
        thread.join(_PATIENCE)
        assert not thread.is_alive()


def done(simulation: LiveSimulation) -> None:
    """Wait until all requests so far are done."""
    reached = threading.Event()
    simulation.request(lambda: reached.set())
    assert reached.wait(_PATIENCE)


def test_it_begins_paused_at_the_first_moment(simulation: LiveSimulation) -> None:
    assert not simulation.playing
    assert simulation.moment.step == 0
    assert simulation.moment.label == "Y"
    assert simulation.moment.responsibility is None
    assert np.isnan(simulation.recent_error_percent)
    assert simulation.real_time_factor == 0.0
    assert (simulation.modules, simulation.enabled_modules) == (3, [True] * 3)
    assert simulation.steps == 227


def test_a_single_step_pauses_and_moves_on_by_a_step(simulation: LiveSimulation) -> None:
    simulation.play()
    simulation.single_step()
    assert not simulation.playing
    assert (simulation.moment.step, len(simulation.moments)) == (1, 2)
    assert simulation.moment.responsibility is not None
    assert simulation.moment.responsibility.sum() == pytest.approx(1.0)


def test_after_the_end_the_next_episode_begins(simulation: LiveSimulation) -> None:
    episode = simulation.episode.number
    steps(simulation, simulation.steps)
    assert simulation.moment.step == simulation.steps
    simulation.single_step()
    assert (simulation.moment.step, simulation.episode.number) == (0, episode + 1)
    assert len(simulation.moments) == 1
    simulation.restart()
    assert simulation.episode.number == episode + 2


def test_a_moment_of_the_past_is_shown_while_paused(simulation: LiveSimulation) -> None:
    steps(simulation, 60)
    now, error = simulation.data.qpos.copy(), simulation.episode_error_percent
    simulation.play()
    simulation.show(20)
    assert not simulation.playing
    assert simulation.moment.step == 20
    assert np.abs(simulation.data.qpos - now).max() > 0.01
    assert simulation.episode_error_percent != error
    simulation.play()
    assert simulation.moment.step == 60
    np.testing.assert_array_equal(simulation.data.qpos, now)
    simulation.show(1000)
    assert simulation.moment.step == 60
    simulation.show(-3)
    assert simulation.moment.step == 0


def test_it_starts_at_the_moment_that_is_shown(simulation: LiveSimulation) -> None:
    steps(simulation, 60)
    expected = [moment.posture for moment in simulation.moments]
    simulation.start_here()  # nothing of the past is shown
    assert len(simulation.moments) == 61
    simulation.show(20)
    simulation.start_here()
    assert (simulation.shown, len(simulation.moments)) == (None, 21)
    steps(simulation, 40)
    np.testing.assert_array_equal([m.posture for m in simulation.moments], expected)


def test_recent_and_episode_errors(simulation: LiveSimulation) -> None:
    steps(simulation, 60)
    single = [50.0 * np.abs(m.posture - m.reference).mean() for m in simulation.moments[1:]]
    assert simulation.episode_error_percent == pytest.approx(np.mean(single))
    assert simulation.recent_error_percent == pytest.approx(np.mean(single[-40:]))


def test_a_module_that_is_switched_off_has_no_responsibility(simulation: LiveSimulation) -> None:
    steps(simulation, 5)
    leading = int(np.argmax(simulation.moment.responsibility))
    simulation.enable_module(leading, False)
    simulation.single_step()
    assert simulation.moment.responsibility is not None
    assert simulation.moment.responsibility[leading] == 0.0
    assert simulation.moment.responsibility.sum() == pytest.approx(1.0)
    assert simulation.enabled_modules == [module != leading for module in range(3)]
    simulation.enable_module(leading, True)
    simulation.single_step()
    assert simulation.moment.responsibility[leading] > 0.0


def test_a_drag_of_80_newtons_multiplies_the_error(simulation: LiveSimulation) -> None:
    steps(simulation, 80)
    before = simulation.recent_error_percent
    simulation.drag(0, [0.0, 5.0, 1.0])
    steps(simulation, 40)
    dragged = simulation.recent_error_percent
    assert dragged > 3.0 * before
    assert np.linalg.norm(simulation.moment.push[0]) == pytest.approx(80.0)
    simulation.drag(0, None)
    steps(simulation, 60)
    assert simulation.recent_error_percent < 0.5 * dragged
    assert not simulation.moment.push.any()


@pytest.mark.parametrize(
    ("hand", "pointer"), [(2, [0.0] * 3), (0, [0.0] * 2), (0, [np.nan, 0.0, 0.0])]
)
def test_a_drag_to_nowhere_is_refused(simulation: LiveSimulation, hand: int, pointer: Any) -> None:
    with pytest.raises(BadOptionError, match="expected three finite coordinates, and hand 0 or 1"):
        simulation.drag(hand, pointer)
    assert simulation.dragged is None


def test_payload_gain_and_latency_disturb_until_they_are_taken_back(
    simulation: LiveSimulation,
) -> None:
    def error() -> float:
        simulation.restart()
        steps(simulation, 76)
        return simulation.episode_error_percent

    undisturbed = error()
    for option, value in {"payload": 3.0, "actuator_gain": 0.5, "latency": 2}.items():
        simulation.intervene(**{option: value})
        assert error() > 1.5 * undisturbed
        simulation.intervene(**{option: None})
    assert simulation.intervention == type(simulation.intervention)()
    assert error() == pytest.approx(undisturbed, rel=0.3)  # with the noise of another episode


def test_plants_are_switched() -> None:
    plants = (Plant(), Plant(payload=2.0))
    env = EnvironmentOptions(plants=plants, switch_every=(1.0, 2.0))
    simulation = LiveSimulation(EpisodeFactory(RunConfig(env=env), ymca()))
    assert simulation.plants == plants
    simulation.compare(True)  # ideal arms, which have one plant
    for plant in (1, 0):
        simulation.intervene(plant=plant)
        steps(simulation, 60)
        assert {moment.plant for moment in simulation.moments[-59:]} == {plant}
    simulation.intervene(plant=None)
    simulation.restart()
    steps(simulation, 200)
    assert {moment.plant for moment in simulation.moments} == {0, 1}


def test_other_arms_are_shown_beside_those_of_the_run(simulation: LiveSimulation) -> None:
    assert simulation.compared_data is None
    steps(simulation, 30)
    simulation.enable_module(0, False)
    simulation.compare(True)
    assert simulation.compared is not None
    assert simulation.compared.env.task.options.arms == "kinematic"
    assert len(simulation.compared.moments) == 31
    steps(simulation, simulation.steps - 10)
    assert simulation.compared.number == simulation.episode.number
    assert [m.step for m in simulation.compared.moments] == [m.step for m in simulation.moments]
    simulation.show(5)
    simulation.start_here()
    steps(simulation, 3)
    for one, other in zip(simulation.moments, simulation.compared.moments, strict=True):
        np.testing.assert_array_equal(one.reference, other.reference)
    assert simulation.compared_data is not None
    assert np.abs(simulation.compared_data.qpos - simulation.data.qpos).max() > 1e-4
    simulation.compare(False)
    assert simulation.compared is None


def test_one_thread_does_everything_that_others_request(simulation: LiveSimulation) -> None:
    threads, drawn = set(), threading.Event()

    def change() -> None:
        threads.add(threading.current_thread())

    def draw() -> None:
        threads.add(threading.current_thread())
        if len(simulation.moments) > 3:
            drawn.set()

    with running(simulation, draw) as owner:
        simulation.request(change)
        simulation.request(simulation.set_tempo, 4.0)
        simulation.request(simulation.play)
        assert drawn.wait(_PATIENCE)
        requests = [
            threading.Thread(
                target=simulation.request,
                args=(simulation.intervene,),
                kwargs={"payload": 0.01 * i},
            )
            for i in range(20)
        ]
        for thread in requests:
            thread.start()
        for thread in requests:
            thread.join()
        simulation.request(simulation.pause)
        done(simulation)
        paused = len(simulation.moments)
        assert simulation.intervention.payload in [0.01 * i for i in range(20)]
    assert threads == {owner}
    assert len(simulation.moments) == paused
    assert simulation.tempo == 4.0


def test_requests_are_done_in_their_order(simulation: LiveSimulation) -> None:
    found: list[int] = []
    for number in range(50):
        simulation.request(found.append, number)
    assert simulation.handle_requests()
    assert found == list(range(50))
    assert not simulation.handle_requests()


def test_what_fails_is_reported_and_pauses_and_the_loop_goes_on(
    simulation: LiveSimulation,
) -> None:
    def fail() -> None:
        raise ValueError("a reason\nof two lines")

    shown: list[tuple[str, bool]] = []
    with running(simulation, lambda: shown.append((simulation.error, simulation.playing))):
        simulation.request(simulation.play)
        simulation.request(fail)
        done(simulation)
    assert ("ValueError: a reason of two lines", False) in shown
    simulation.request(simulation.play)
    simulation.request(simulation.intervene, payload=-1.0)
    simulation.handle_requests()
    assert simulation.error == "payload is -1.0; expected 0 to 1000, in kg"
    assert not simulation.playing
    simulation.request(simulation.play)
    simulation.handle_requests()
    assert (simulation.error, simulation.playing) == ("", True)


def test_a_simulation_that_diverges_is_reported_and_can_go_back(
    simulation: LiveSimulation,
) -> None:
    steps(simulation, 10)
    simulation.intervene(actuator_gain=100.0)
    with pytest.raises(DivergedError, match=r"diverged: the .* ran away; the next step begins"):
        steps(simulation, 100)
    simulation.intervene(actuator_gain=None)
    simulation.show(5)
    simulation.start_here()
    steps(simulation, 30)
    assert simulation.episode_error_percent < 5.0
    simulation.intervene(actuator_gain=100.0)
    simulation.request(simulation.play)
    for _ in range(100):
        simulation.request(simulation.single_step)
        simulation.handle_requests()
        if simulation.error:
            break
    assert "ran away" in simulation.error
    episode = simulation.episode.number
    simulation.single_step()
    assert (simulation.episode.number, simulation.moment.step) == (episode + 1, 0)


def test_a_picture_that_fails_is_reported(simulation: LiveSimulation) -> None:
    def draw() -> None:
        raise RuntimeError("no picture")

    with running(simulation, draw):
        simulation.request(simulation.play)
        done(simulation)
    assert simulation.error == "RuntimeError: no picture"
    assert not simulation.playing


@pytest.mark.parametrize(("tempo", "expected"), [(0.0, 0.1), (1.5, 1.5), (99.0, 4.0)])
def test_the_tempo_is_bounded(simulation: LiveSimulation, tempo: float, expected: float) -> None:
    simulation.set_tempo(tempo)
    assert simulation.tempo == expected


def test_a_motion_is_followed_without_modules() -> None:
    simulation = LiveSimulation(EpisodeFactory.of_motion(ymca()))
    steps(simulation, 60)
    assert (simulation.modules, simulation.plants) == (0, ())
    assert simulation.episode_error_percent > 1.0
    assert simulation.hand_positions is not None
    assert simulation.site_positions(simulation.moment.reference).shape == (2, 3, 3)
    assert (
        LiveSimulation(
            EpisodeFactory.of_motion(ymca(), EnvironmentOptions(arms="kinematic"))
        ).hand_positions
        is None
    )
