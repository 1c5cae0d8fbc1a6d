"""Widgets of the viewer who has the controls; each only puts requests in the simulation's queue."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from mpma_mj.browser.simulation import TEMPOS, LiveSimulation
from mpma_mj.envs.interventions import LONGEST_LATENCY
from mpma_mj.envs.randomisation import PlantValues, plants_of

__all__ = ["Controls", "on_user"]

_HEAVIEST, _GAINS = 5.0, (0.1, 2.0)  # kg; ends of sliders (choice)
_HOLD = 0.5  # s for which the slider is left alone, or a user could not move it (choice)
_AS_IN_RUN = "as in the run"
_STEP, _START_HERE, _RESTART = "step", "start here", "restart"


def on_user(widget: Any, act: Callable[[Any], None]) -> None:
    """Call a function with the value of a widget where a user has changed it.

    Values that this program sets call back, too, but without a client. Coroutines are called in
    order, in the thread of the server; other functions in any thread of a pool. A number that is
    typed beside a slider may lie beyond its ends: the nearest end counts.

    Args:
        widget: Handle of viser, of a button or an input.
        act: The function; it runs in the thread of the server.
    """

    async def callback(event: Any) -> None:
        if event.client_id is not None:
            value, highest = event.target.value, getattr(event.target, "max", None)
            act(value if highest is None else min(max(value, event.target.min), highest))

    (widget.on_click if hasattr(widget, "on_click") else widget.on_update)(callback)


class Controls:
    """Widgets in the panel of one viewer."""

    def __init__(self, gui: Any, simulation: LiveSimulation) -> None:
        """Add the widgets, at the state of the simulation.

        Args:
            gui: `viser.GuiApi` of the viewer.
            simulation: The simulation.
        """
        import viser

        self._gui, self._simulation, self._icons = gui, simulation, viser.Icon
        request = simulation.request
        self._playing = simulation.playing
        self.play = gui.add_button("", order=10)
        self._label_play()
        on_user(
            self.play,
            lambda _: request(simulation.pause if simulation.playing else simulation.play),
        )
        self.steps = gui.add_button_group("move", (_STEP, _START_HERE, _RESTART), order=11)
        moves = {
            _STEP: simulation.single_step,
            _START_HERE: simulation.start_here,
            _RESTART: simulation.restart,
        }
        on_user(self.steps, lambda name: request(moves[name]))
        last, now = simulation.steps, len(simulation.moments) - 1
        self.scrub = gui.add_slider("step", 0, last, 1, now, order=12)
        self._scrubbed = -_HOLD  # time at which it was moved, s
        on_user(self.scrub, self._show)
        self.tempo = gui.add_slider("tempo", *TEMPOS, 0.1, simulation.tempo, order=13)
        on_user(self.tempo, lambda tempo: request(simulation.set_tempo, tempo))
        self.boxes: list[Any] = []
        if simulation.modules:
            with gui.add_folder("Modules", order=20):
                self._add_boxes()
        with gui.add_folder("Arms", order=21):
            self._add_plant()
            self.compare = gui.add_checkbox(
                f"{_other_kind(simulation)} arms", bool(simulation.compared)
            )
            on_user(self.compare, lambda shown: request(simulation.compare, shown))

    def update(self) -> None:
        """Follow the simulation; what a user may be moving is left alone."""
        simulation = self._simulation
        if simulation.playing != self._playing:
            self._playing = simulation.playing
            self._label_play()
        now = time.monotonic()
        if simulation.shown is None and (now - self._scrubbed > _HOLD or not simulation.playing):
            self.scrub.value, self._scrubbed = len(simulation.moments) - 1, now
        for box, enabled in zip(self.boxes, simulation.enabled_modules, strict=True):
            box.value = enabled

    def _show(self, index: int) -> None:
        self._scrubbed = time.monotonic()
        self._simulation.request(self._show_moment, index)

    def _show_moment(self, index: int) -> None:
        """Show a moment of the past, the latest for one to come; in the owning thread."""
        self._simulation.show(index)
        if self._simulation.shown != index:  # else a slider that is still moved would jump back
            self.scrub.value = self._simulation.shown

    def _label_play(self) -> None:
        playing, icons = self._playing, self._icons
        self.play.label = "Pause" if playing else "Play"
        self.play.icon = icons.PLAYER_PAUSE_FILLED if playing else icons.PLAYER_PLAY_FILLED

    def _add_boxes(self) -> None:
        simulation = self._simulation
        for i, enabled in enumerate(simulation.enabled_modules):

            def switch(on: bool, index: int = i) -> None:
                simulation.request(simulation.enable_module, index, on)

            box = self._gui.add_checkbox(f"module {i + 1}", enabled)
            on_user(box, switch)
            self.boxes.append(box)

    def _add_plant(self) -> None:
        gui, simulation = self._gui, self._simulation
        request, values, latency = simulation.request, self._values(), self._latency()
        payload, gain, (low, high) = values["payload"], values["actuator_gain"], _GAINS
        choices = (*(f"plant {i + 1}" for i in range(len(simulation.plants))), _AS_IN_RUN)
        self.plant = gui.add_button_group("plant", choices)
        on_user(self.plant, lambda name: request(self._set_plant, choices.index(name)))
        self.payload = gui.add_slider("payload, kg", 0.0, max(_HEAVIEST, payload), 0.1, payload)
        self.payload.visible = simulation.hand_positions is not None
        self.gain = gui.add_slider("gain", min(low, gain), max(high, gain), 0.05, gain)
        longest = max(LONGEST_LATENCY, latency)
        self.latency = gui.add_slider("latency, steps", 0, longest, 1, latency)
        on_user(self.payload, lambda payload: request(simulation.intervene, payload=payload))
        on_user(self.gain, lambda gain: request(simulation.intervene, actuator_gain=gain))
        on_user(self.latency, lambda latency: request(simulation.intervene, latency=latency))

    def _set_plant(self, index: int) -> None:
        """Let a plant be on, or those of the run in their turn; in the owning thread."""
        simulation = self._simulation
        if index < len(simulation.plants):
            simulation.intervene(plant=index, payload=None, actuator_gain=None)
        else:
            simulation.intervene(plant=None, payload=None, actuator_gain=None, latency=None)
        values, self.latency.value = self._values(), self._latency()
        self.payload.value, self.gain.value = values["payload"], values["actuator_gain"]

    def _values(self) -> PlantValues:
        """Return the present payload and gain; of options that are ranges, the highest."""
        simulation = self._simulation
        by_hand = simulation.intervention
        plant = simulation.moment.plant if by_hand.plant is None else by_hand.plant
        return by_hand.plant_values(plants_of(simulation.options)[plant or 0])

    def _latency(self) -> int:
        """Return the present latency, control steps; the lowest of a range."""
        by_hand = self._simulation.intervention.latency
        if by_hand is not None:
            return by_hand
        of_run = self._simulation.options.latency
        return int(of_run[0] if isinstance(of_run, tuple) else of_run)


def _other_kind(simulation: LiveSimulation) -> str:
    """Return the kind of the arms that the run does not have."""
    return "physics" if simulation.options.arms == "kinematic" else "kinematic"
