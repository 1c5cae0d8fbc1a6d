"""The simulation behind the page: one thread owns it, all others put requests in its queue."""

from __future__ import annotations

import contextlib
import dataclasses
import queue
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, ParamSpec

import mujoco
import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents import FeedbackOnlyConfig
from mpma_mj.browser.live_episode import LiveEpisode, Moment, error_percent
from mpma_mj.envs.interventions import Intervention
from mpma_mj.envs.load import make_environment
from mpma_mj.envs.options import FIELDS_OF_PLANTS, MASS_OPTIONS, EnvironmentOptions
from mpma_mj.envs.physics import KinematicArms
from mpma_mj.envs.plants import Plant
from mpma_mj.errors import BadOptionError, MpmaError, one_line
from mpma_mj.evaluation.evaluate import EVALUATION_EPISODE
from mpma_mj.motions import Motion
from mpma_mj.options import Arms
from mpma_mj.training.checkpoints import load_state
from mpma_mj.training.config import RunConfig
from mpma_mj.training.factory import agent_of, one_thread
from mpma_mj.training.run_folder import RunFolder

__all__ = ["LARGEST_PUSH", "TEMPOS", "LiveSimulation", "spring_force"]

Array = NDArray[np.float64]
P = ParamSpec("P")

TEMPOS = (0.1, 4.0)
"""Lowest and highest tempo, as a multiple of real time (choice)."""
LARGEST_PUSH = 80.0
"""Largest force of a drag, N (choice)."""
_STIFFNESS = 400.0  # of the spring between hand and pointer, N/m (choice)
_RECENT = 2.0  # s over which p_e and the real-time factor are measured (choice)
_LATEST = 0.2  # s of real time that are caught up at most (choice)
_IDLE = 0.1  # s between two looks at the event that ends the loop


def spring_force(hand: Array, pointer: Array) -> Array:
    """Return the force on a hand that is dragged, shape (3,), N: a spring, limited to 80 N.

    Args:
        hand: Position of the hand, shape (3,), m.
        pointer: Position of the pointer, shape (3,), m.
    """
    force = _STIFFNESS * (pointer - hand)
    return force * min(1.0, LARGEST_PUSH / max(float(np.linalg.norm(force)), 1e-9))


class LiveSimulation:
    """An agent that dances without learning, and everything that can be done to it meanwhile.

    The thread that calls `run_until` owns it. Others only call `request`, with one of the methods
    below and its arguments; it is called between two steps. Attributes are plain values, which
    other threads may read, too.

    Attributes:
        live: Episode of the arms of the run.
        compared: Episode of the other kind of arms beside it; None while it is not shown.
        playing: Whether it plays; else it is paused.
        tempo: Tempo as a multiple of real time.
        shown: Index of the past moment that is shown while paused; None for the present.
        dragged: Index of the hand that is dragged, and position of the pointer, shape (3,), m;
            None while none is.
        intervention: Payload, gain, plant and latency that are set by hand.
        error: What went wrong, in one line; empty since the last request that worked.
    """

    def __init__(
        self,
        config: RunConfig,
        motion: Motion,
        state: Mapping[str, Array] | None = None,
        source: Path | None = None,
    ) -> None:
        """Begin paused at the first moment of an episode that no training has had.

        Args:
            config: Config of the run.
            motion: Its motion.
            state: State of the agent, as `state_dict` returns it; an agent that does not learn has
                none.
            source: File from which the state was read, for errors.

        Raises:
            MpmaError: The arms cannot follow the motion, or the state does not fit the config.
        """
        self._config, self._motion, self._state, self._source = config, motion, state, source
        self.live = self._episode(config.env, EVALUATION_EPISODE)
        self.compared: LiveEpisode | None = None
        self.playing, self.tempo = False, 1.0
        self.shown: int | None = None
        self.dragged: tuple[int, Array] | None = None
        self.intervention = Intervention()
        self.error = ""
        self._requests: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        self._requested = threading.Event()
        self._due = 0.0  # time of the next step, s
        self._stepped: deque[float] = deque()  # times of the last steps, s

    @classmethod
    def of_run(cls, folder: RunFolder) -> LiveSimulation:
        """Return the agent of a run's best epoch with its arms and motion.

        Raises:
            MpmaError: There is no run, or it is damaged.
        """
        config = folder.read_config()
        state, _ = folder.read_best(config)
        return cls(config, folder.read_motion(), state, folder.checkpoint("best"))

    @classmethod
    def of_motion(cls, motion: Motion, arms: Arms = "physics") -> LiveSimulation:
        """Return arms that the feedback controller alone lets follow a motion.

        Raises:
            MpmaError: The arms cannot follow the motion.
        """
        env = EnvironmentOptions(arms=arms)
        config = RunConfig(agent=FeedbackOnlyConfig(), agent_name="feedback_only", env=env)
        return cls(config, motion)

    def _episode(self, options: EnvironmentOptions, number: int) -> LiveEpisode:
        """Return an episode of the agent, with arms of these options, at its beginning."""
        seed = self._config.seed
        env = make_environment(self._motion, options, seed, adjustable=True)
        agent = agent_of(self._config, env, seed)
        if self._state is not None:
            load_state(agent, self._state, self._source)
        return LiveEpisode(env, agent, number)

    @property
    def motion(self) -> Motion:
        """The motion that is imitated."""
        return self._motion

    @property
    def modules(self) -> int:
        """Number of modules; 0 of an agent without."""
        enabled = self.live.enabled_modules
        return 0 if enabled is None else len(enabled)

    @property
    def enabled_modules(self) -> list[bool]:
        """Which modules may control."""
        enabled = self.live.enabled_modules
        return [] if enabled is None else enabled.tolist()

    @property
    def plants(self) -> tuple[Plant, ...]:
        """Plants of the environment, among which `set_plant` chooses."""
        return self.live.env.task.options.plants or ()

    @property
    def step_duration(self) -> float:
        """Simulated time of a step, s."""
        return float(self.live.env.control_timestep())

    @property
    def moments(self) -> Sequence[Moment]:
        """Moments of the present episode so far."""
        return self.live.moments

    @property
    def moment(self) -> Moment:
        """The moment that is shown."""
        return self.moments[-1 if self.shown is None else self.shown]

    @property
    def recent_error_percent(self) -> float:
        """p_e of the two seconds up to the moment that is shown, percent; NaN at the beginning."""
        steps = max(1, round(_RECENT / self.step_duration))
        return error_percent(self._until_shown()[-steps:])

    @property
    def episode_error_percent(self) -> float:
        """p_e of the episode up to the moment that is shown, percent; NaN at the beginning."""
        return error_percent(self._until_shown())

    def _until_shown(self) -> Sequence[Moment]:
        """Return the moments that count for p_e: without the first, at which the arms start."""
        return self.moments[1 : None if self.shown is None else self.shown + 1]

    @property
    def model(self) -> mujoco.MjModel:
        """Model of the arms of the run, whose payload changes."""
        return self.live.env.physics.model.ptr

    @property
    def data(self) -> mujoco.MjData:
        """State of the arms of the run at the moment that is shown, for the owning thread."""
        return self.live.data(self.shown)

    @property
    def compared_data(self) -> mujoco.MjData | None:
        """State of the other arms at the moment that is shown; None while they are not."""
        return None if self.compared is None else self.compared.data(self.shown)

    def site_positions(self, posture: Array) -> Array:
        """Return shoulder, elbow and wrist of both arms in a posture, shape (2, 3, 3), m."""
        return self.live.env.physics.site_positions(posture)

    @property
    def hand_positions(self) -> Array | None:
        """Positions of left and right hand at the moment that is shown, shape (2, 3), m.

        None where they cannot be pushed: of ideal arms, and of models without hands.
        """
        physics = self.live.env.physics
        if isinstance(physics, KinematicArms) or not physics.compiled_plants.compiler.has_balls:
            return None
        positions: Array = self.data.xipos[physics.hand_ids].copy()
        return positions

    @property
    def real_time_factor(self) -> float:
        """Simulated time over real time of the last two seconds; 0 while paused."""
        if not self.playing or len(self._stepped) < 2:
            return 0.0
        elapsed = self._stepped[-1] - self._stepped[0]
        return (len(self._stepped) - 1) * self.step_duration / max(elapsed, 1e-9)

    def request(self, change: Callable[P, None], *args: P.args, **kwargs: P.kwargs) -> None:
        """Let the owning thread call a method of this simulation, before its next step."""
        self._requests.put(lambda: change(*args, **kwargs))
        self._requested.set()

    def play(self) -> None:
        """Play on, from the present."""
        self.playing, self.shown = True, None
        self._due = time.monotonic()
        self._stepped.clear()

    def pause(self) -> None:
        """Pause."""
        self.playing = False

    def single_step(self) -> None:
        """Pause, and do one step from the present."""
        self.playing, self.shown = False, None
        self._advance()

    def restart(self) -> None:
        """Begin the next episode."""
        self.shown, number = None, self.live.episode + 1
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
        self.tempo = float(np.clip(tempo, *TEMPOS))

    def set_payload(self, payload: float | None) -> None:
        """Set the mass of a ball in each hand, kg; None for that of the run."""
        self._intervene(payload=payload)

    def set_actuator_gain(self, gain: float | None) -> None:
        """Set the factor on commanded velocities; None for that of the run."""
        self._intervene(actuator_gain=gain)

    def set_latency(self, latency: int | None) -> None:
        """Set the control steps from an action to its effect; None for those of the run."""
        self._intervene(latency=latency)

    def set_plant(self, plant: int | None) -> None:
        """Set the index of the plant that is on; None for the plants of the run in their turn."""
        self._intervene(plant=plant)

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
        """Show the other kind of arms beside those of the run, moved by the same agent; or not.

        Their episode is repeated up to the present, without pushes.
        """
        if not shown:
            self.compared = None
        elif self.compared is None:
            other = self._episode(other_arms(self._config.env), self.live.episode)
            other.intervene(_without_plants_of_others(self.intervention, other))
            if self.modules:
                other.set_enabled_modules(self.enabled_modules)
            while len(other.moments) < len(self.moments) and not other.is_over:
                other.advance()
            self.compared = other

    @property
    def _episodes(self) -> list[LiveEpisode]:
        return [self.live] if self.compared is None else [self.live, self.compared]

    def _intervene(self, **changes: Any) -> None:
        intervention = dataclasses.replace(self.intervention, **changes)
        self.live.intervene(intervention)
        self.intervention = intervention
        if self.compared is not None:
            self.compared.intervene(_without_plants_of_others(intervention, self.compared))

    def _advance(self) -> None:
        """Do one step of all arms."""
        push = np.zeros((2, 3))
        if self.dragged is not None and (positions := self.hand_positions) is not None:
            hand, pointer = self.dragged
            push[hand] = spring_force(positions[hand], pointer)
        self.live.advance(push)
        if self.compared is None:
            return
        if self.compared.episode != self.live.episode:
            self.compared.begin(self.live.episode)
        elif not self.compared.is_over:
            self.compared.advance(push)

    def handle_requests(self) -> bool:
        """Do what was requested since the last call; return whether something was."""
        self._requested.clear()
        any_request = False
        with contextlib.suppress(queue.Empty):
            while True:
                change = self._requests.get_nowait()
                any_request, self.error = True, ""
                self._attempt(change)
        return any_request

    def run_until(self, stop: threading.Event, draw: Callable[[], None] = lambda: None) -> None:
        """Do requests, and steps in real time, until an event.

        What the computer is late is caught up by at most 0.2 s. What fails is reported as `error`,
        and pauses.

        Args:
            stop: Ends the loop.
            draw: Called at first, after each step and after requests.
        """
        changed, self._due = True, time.monotonic()
        with one_thread():
            while not stop.is_set():
                changed |= self.handle_requests()
                now = time.monotonic()
                if self.playing and now >= self._due:
                    self._attempt(self._advance)
                    self._due = max(self._due + self.step_duration / self.tempo, now - _LATEST)
                    self._stepped.append(now)
                    while now - self._stepped[0] > _RECENT:
                        self._stepped.popleft()
                    changed = True
                if changed:
                    self._attempt(draw)
                changed = False
                wait = self._due - time.monotonic() if self.playing else _IDLE
                self._requested.wait(min(max(wait, 0.0), _IDLE))

    def _attempt(self, change: Callable[[], None]) -> None:
        """Do something; where it fails, say why and pause."""
        try:
            change()
        except Exception as error:  # the loop goes on, whatever happens
            self.playing = False
            kind = "" if isinstance(error, MpmaError) else f"{type(error).__name__}: "
            self.error = one_line(f"{kind}{error}")


def other_arms(options: EnvironmentOptions) -> EnvironmentOptions:
    """Return options with the other kind of arms; ideal arms have no mass and one plant."""
    if options.arms == "kinematic":
        return dataclasses.replace(options, arms="physics")
    defaults = EnvironmentOptions()
    changes = {name: getattr(defaults, name) for name in MASS_OPTIONS + FIELDS_OF_PLANTS}
    return dataclasses.replace(options, arms="kinematic", **changes)


def _without_plants_of_others(intervention: Intervention, episode: LiveEpisode) -> Intervention:
    """Return what is set by hand, without a plant where the arms of an episode have one only."""
    has_plants = episode.env.task.options.plants is not None
    return intervention if has_plants else dataclasses.replace(intervention, plant=None)
