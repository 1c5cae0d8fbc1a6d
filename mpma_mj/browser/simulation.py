"""Live simulation behind the page: one thread owns it, all others put requests in its queue."""

from __future__ import annotations

import dataclasses
import queue
import threading
import time
from collections.abc import Callable, Sequence
from typing import Any, ParamSpec

import mujoco
import numpy as np
from numpy.typing import NDArray

from mpma_mj.browser.episode_factory import EpisodeFactory, intervention_for, other_arms
from mpma_mj.browser.live_episode import LiveEpisode, Moment, error_percent
from mpma_mj.browser.pace import Pace
from mpma_mj.envs.interventions import Intervention
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.envs.plants import Plant
from mpma_mj.errors import BadOptionError, DivergedError, MpmaError, one_line
from mpma_mj.evaluation.evaluate import EVALUATION_EPISODE
from mpma_mj.motions import Motion
from mpma_mj.training.factory import one_thread

__all__ = ["TEMPOS", "LiveSimulation"]

Array = NDArray[np.float64]
P = ParamSpec("P")

TEMPOS = (0.1, 4.0)
"""Lowest and highest tempo, as a multiple of real time (choice)."""
_RECENT = 2.0  # s over which p_e is measured (choice)
_IDLE = 0.1  # s between two looks at the event that ends the loop


class LiveSimulation:
    """Episodes of an agent that does not learn, in real time, with what is changed by hand.

    The thread that calls `run_until` owns it. Others only call `request`, with one of the methods
    below and its arguments; it is called between two steps. Everything is read in `draw`, which
    the owning thread calls.

    Attributes:
        episode: Episode of the arms of the run.
        compared: Episode of the other kind of arms; None while it is not shown.
        playing: Whether it plays; else it is paused.
        shown: Index of the past moment that is shown while paused; None for the present.
        dragged: Index of the hand that is dragged, and position of the pointer, shape (3,), m;
            None while none is.
        intervention: Payload, gain, plant and latency that are set by hand.
        error: The error that paused it, in one line; empty from the next request on.
    """

    def __init__(self, factory: EpisodeFactory) -> None:
        """Begin paused, at the first moment of an episode that no training has had.

        Args:
            factory: Factory of the episodes.

        Raises:
            MpmaError: The arms cannot follow the motion, or the agent's state does not fit it.
        """
        self._factory = factory
        self.episode = factory.make(EVALUATION_EPISODE)
        self.compared: LiveEpisode | None = None
        self.playing = False
        self.shown: int | None = None
        self.dragged: tuple[int, Array] | None = None
        self.intervention = Intervention()
        self.error = ""
        self._pace = Pace(self.episode.env.control_timestep())
        self._requests: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        self._requested = threading.Event()

    @property
    def motion(self) -> Motion:
        """The motion that is imitated."""
        return self._factory.motion

    @property
    def modules(self) -> int:
        """Number of modules; 0 of an agent without."""
        enabled = self.episode.enabled_modules
        return 0 if enabled is None else len(enabled)

    @property
    def enabled_modules(self) -> list[bool]:
        """Which modules may control."""
        enabled = self.episode.enabled_modules
        return [] if enabled is None else enabled.tolist()

    @property
    def options(self) -> EnvironmentOptions:
        """Options of the environment of the run."""
        return self.episode.env.task.options

    @property
    def plants(self) -> tuple[Plant, ...]:
        """Plants of the environment, among which `intervene` chooses."""
        return self.options.plants or ()

    @property
    def steps(self) -> int:
        """Number of steps of an episode."""
        return self.episode.env.task.steps

    @property
    def tempo(self) -> float:
        """Tempo as a multiple of real time."""
        return self._pace.tempo

    @property
    def moments(self) -> Sequence[Moment]:
        """Moments of the present episode so far."""
        return self.episode.moments

    @property
    def moment(self) -> Moment:
        """The moment that is shown."""
        return self.moments[self.index]

    @property
    def recent_error_percent(self) -> float:
        """p_e of the two seconds up to the moment that is shown, percent; NaN at the beginning."""
        steps = max(1, round(_RECENT / self._pace.step_duration))
        return error_percent(self.moments, self.index - steps, self.index)

    @property
    def episode_error_percent(self) -> float:
        """p_e of the episode up to the moment that is shown, percent; NaN at the beginning."""
        return error_percent(self.moments, 0, self.index)

    @property
    def index(self) -> int:
        """Index among `moments` of the moment that is shown."""
        return len(self.moments) - 1 if self.shown is None else self.shown

    @property
    def model(self) -> mujoco.MjModel:
        """Model of the arms of the run at the moment that is shown, whose payload changes."""
        return self.episode.model(self.shown)

    @property
    def data(self) -> mujoco.MjData:
        """State of the arms of the run at the moment that is shown, for the owning thread."""
        return self.episode.data(self.shown)

    @property
    def compared_data(self) -> mujoco.MjData | None:
        """State of the other arms at the moment that is shown; None while they are not."""
        return None if self.compared is None else self.compared.data(self.shown)

    def site_positions(self, posture: Array) -> Array:
        """Return shoulder, elbow and wrist of both arms in a posture, shape (2, 3, 3), m."""
        return self.episode.env.physics.site_positions(posture)

    @property
    def hand_positions(self) -> Array | None:
        """Positions of left and right hand at the moment that is shown, shape (2, 3), m.

        None where they cannot be pushed: of ideal arms, and of models without hands.
        """
        return self.episode.hand_positions(self.shown)

    @property
    def real_time_factor(self) -> float:
        """Simulated time over real time of the last two seconds; 0 while paused."""
        return self._pace.real_time_factor if self.playing else 0.0

    def request(self, change: Callable[P, None], *args: P.args, **kwargs: P.kwargs) -> None:
        """Let the owning thread call a method of this simulation, before its next step."""
        self._requests.put(lambda: change(*args, **kwargs))
        self._requested.set()

    def play(self) -> None:
        """Play on, from the present."""
        self.playing, self.shown = True, None
        self._pace.start(time.monotonic())

    def pause(self) -> None:
        """Pause."""
        self.playing = False

    def single_step(self) -> None:
        """Pause, and do one step from the present."""
        self.playing, self.shown = False, None
        self._advance()

    def restart(self) -> None:
        """Begin the next episode."""
        self.shown, number = None, self.episode.number + 1
        for episode in self._episodes:
            episode.begin(number)

    def show(self, index: int) -> None:
        """Pause, and show a moment of the past.

        Args:
            index: Index among `moments`; the nearest counts.
        """
        self.playing = False
        self.shown = min(max(int(index), 0), len(self.moments) - 1)

    def start_here(self) -> None:
        """Go back to the moment that is shown; what was set by hand stays."""
        if self.shown is not None:
            index, self.shown = self.shown, None
            for episode in self._episodes:
                episode.go_back(min(index, len(episode.moments) - 1))

    def set_tempo(self, tempo: float) -> None:
        """Set the tempo as a multiple of real time; the nearest of `TEMPOS` counts."""
        self._pace.tempo = float(np.clip(tempo, *TEMPOS))

    def intervene(self, **changes: Any) -> None:
        """Set payload, gain, latency or plant by hand; what is not named stays.

        Args:
            **changes: Values of fields of `Intervention`; None for that of the run.

        Raises:
            BadOptionError: A value is out of bounds, or the arms cannot have it.
        """
        intervention = dataclasses.replace(self.intervention, **changes)
        self.episode.intervene(intervention)
        self.intervention = intervention
        if self.compared is not None:
            options = self.compared.env.task.options
            self.compared.intervene(intervention_for(options, intervention))

    def set_enabled_modules(self, enabled: Sequence[bool]) -> None:
        """Switch modules off or on, shape (M,)."""
        for episode in self._episodes:
            episode.set_enabled_modules(enabled)

    def enable_module(self, index: int, enabled: bool) -> None:
        """Switch one module off or on."""
        mask = self.enabled_modules
        mask[index] = enabled
        self.set_enabled_modules(mask)

    def drag(self, hand: int, pointer: Sequence[float] | Array | None) -> None:
        """Pull a hand towards a pointer from now on, with 80 N at most.

        Args:
            hand: 0 for the left hand, 1 for the right.
            pointer: Position of the pointer, shape (3,), m; None to let go.
        """
        if pointer is None:
            self.dragged = None
            return
        position = np.array(pointer, np.float64)
        if hand not in (0, 1) or position.shape != (3,) or not np.isfinite(position).all():
            expected = "three finite coordinates, and hand 0 or 1"
            raise BadOptionError(option="pointer", value=pointer, expected=expected)
        self.dragged = hand, position

    def compare(self, shown: bool) -> None:
        """Show the other kind of arms next to those of the run, moved by the same agent; or not.

        Their episode is repeated up to the present, without pushes.
        """
        if not shown:
            self.compared = None
        elif self.compared is None:
            options = other_arms(self._factory.config.env)
            other = self._factory.make(self.episode.number, options)
            other.intervene(intervention_for(options, self.intervention))
            if self.modules:
                other.set_enabled_modules(self.enabled_modules)
            while len(other.moments) < len(self.moments) and not other.is_over:
                other.advance()
            self.compared = other

    @property
    def _episodes(self) -> list[LiveEpisode]:
        return [self.episode] if self.compared is None else [self.episode, self.compared]

    def _advance(self) -> None:
        """Do one step of all arms.

        Raises:
            DivergedError: The simulation diverged; the next step begins the next episode.
        """
        push = None if self.dragged is None else self.episode.pull(*self.dragged)
        self.episode.advance(push)
        if self.compared is not None:
            if self.compared.number != self.episode.number:
                self.compared.begin(self.episode.number)
            elif not self.compared.is_over:
                self.compared.advance(push)
        if self.episode.failure:
            raise DivergedError(f"{self.episode.failure}; the next step begins another episode")

    def handle_requests(self) -> bool:
        """Do what was requested since the last call; return whether something was."""
        self._requested.clear()
        if number := self._requests.qsize():
            self.error = ""
        for _ in range(number):
            self._attempt(self._requests.get())
        return number > 0

    def run_until(self, stop: threading.Event, draw: Callable[[], None] = lambda: None) -> None:
        """Do requests, and steps in real time, until an event.

        What fails is reported as `error`, and pauses.

        Args:
            stop: Event that ends the loop.
            draw: Called at first, after each step and after requests.
        """
        changed, pace = True, self._pace
        with one_thread():
            while not stop.is_set():
                changed |= self.handle_requests()
                now = time.monotonic()
                if self.playing and not pace.wait(now):
                    self._attempt(self._advance)
                    pace.step(now)
                    changed = True
                if changed:
                    self._attempt(draw)
                changed = False
                wait = pace.wait(time.monotonic()) if self.playing else _IDLE
                self._requested.wait(min(wait, _IDLE))

    def _attempt(self, change: Callable[[], None]) -> None:
        """Do something; where it fails, keep the error and pause."""
        try:
            change()
        except Exception as error:  # the loop goes on, whatever happens
            self.playing = False
            kind = "" if isinstance(error, MpmaError) else f"{type(error).__name__}: "
            self.error = one_line(f"{kind}{error}")
