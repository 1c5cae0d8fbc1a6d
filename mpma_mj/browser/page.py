"""Page of a live simulation: a scene of arms and forces, with readings and controls.

The thread that owns the simulation draws, and adds and removes viewers; callbacks of widgets only
put requests in its queue. All viewers see the same. One has the controls: the first, until another
takes them or that one leaves.
"""

from __future__ import annotations

import dataclasses
import math
import threading
import time
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np

from mpma_mj.browser.controls import Controls, on_user
from mpma_mj.browser.readings import bars_html, status_html, timeline_html
from mpma_mj.browser.server import Address, open_server
from mpma_mj.browser.simulation import LiveSimulation
from mpma_mj.errors import OptionWarning
from mpma_mj.robots.assembly import HANDS
from mpma_mj.visualization.viser_arms import ArmNodes, ForceNode, GhostNodes, add_lights

__all__ = ["CAMERAS", "FIELD_OF_VIEW", "LOOK_AT", "Page", "serve"]

_BESIDE = 1.3  # m from the arms of the run to the compared ones (choice)
_REACH = 0.98  # m, from the middle of the shoulders to the end of a stretched arm, and some more
_GRAB_RADIUS, _GRAB_COLOUR = 0.085, (240, 228, 66)
_TEXTS_EVERY, _TIMELINE_EVERY = 0.1, 0.4  # s (choice)
LOOK_AT, FIELD_OF_VIEW = (0.0, 0.0, 1.12), math.radians(40.0)
"""Point in the middle of the picture, m, and vertical angle of view, rad, of all cameras."""

CAMERAS = {
    "front": (2.7, 0.0, 1.45),
    "side": (0.0, 2.7, 1.45),
    "three_quarter": (1.95, 1.65, 1.75),
}
"""Places of the camera, m, by name."""


def serve(
    address: Address,
    simulation: LiveSimulation,
    *,
    on_open: Callable[[str], None],
    stop: threading.Event | None = None,
) -> None:
    """Serve the page and simulate in this thread, until it is interrupted.

    Args:
        address: As `find_address` returned it.
        simulation: The simulation.
        on_open: Called once with the address to type into a browser, as soon as it answers.
        stop: Event that ends it, too.

    Raises:
        MpmaError: viser is not installed.
    """
    with open_server(address) as server:
        page = Page(server, simulation)
        page.draw()
        if address.is_open:
            warnings.warn(
                OptionWarning(
                    f"{address.host} is open: all who reach this machine can watch and control the"
                    " page, without password or encryption",
                    remedy="leave {host} out to keep it to this machine",
                ),
                stacklevel=2,
            )
        on_open(dataclasses.replace(address, port=server.get_port()).url)
        simulation.run_until(stop or threading.Event(), page.draw)


class Page:
    """What viewers see, and the widgets of the one who has the controls.

    Attributes:
        viewers: Viewers by their numbers, in the order in which they came.
        controls: Widgets of the viewer who has the controls; None while there is no viewer.
        in_control: Number of that viewer.
    """

    def __init__(self, server: Any, simulation: LiveSimulation) -> None:
        """Add everything to an empty page; it belongs to the thread that calls this.

        Args:
            server: `viser.ViserServer`.
            simulation: The simulation.
        """
        self._server, self._simulation = server, simulation
        self.viewers: dict[int, Any] = {}
        self.controls: Controls | None = None
        self.in_control: int | None = None
        server.gui.configure_theme(show_logo=False, show_share_button=False)
        server.gui.set_panel_label("mpma")
        server.gui.main_panel.dock_right()
        self._add_scene()
        self._add_readings()
        self._error = ""
        self._texts_drawn = self._timeline_drawn = 0.0
        request = simulation.request
        server.on_client_connect(lambda viewer: request(self._admit, viewer))
        server.on_client_disconnect(lambda viewer: request(self._leave, viewer))

    def draw(self) -> None:
        """Show the present state of the simulation."""
        simulation = self._simulation
        moment = simulation.moment
        # Any request clears the simulation's error; the page keeps it until play or restart.
        if simulation.error or simulation.playing or len(simulation.moments) == 1:
            self._error = simulation.error
        with self._server.atomic():
            self._arms.update(simulation.data, simulation.model)
            self._ghost.update(simulation.site_positions(moment.reference))
            hands = simulation.hand_positions
            if hands is not None:
                for node, hand, force in zip(self._forces, hands, moment.push, strict=True):
                    node.update(hand, force)
            self._draw_beside(simulation.site_positions(moment.reference))
        now = time.monotonic()
        # Texts cost a browser more than the arms; a state that stays is drawn at once.
        if not simulation.playing or now - self._texts_drawn >= _TEXTS_EVERY:
            self._texts_drawn = now
            self._status.content = status_html(simulation, self._error)
            if simulation.modules:
                self._bars.content = bars_html(moment.responsibility, simulation.enabled_modules)
            if self.controls is not None:
                self.controls.update()
        if not simulation.playing or now - self._timeline_drawn >= _TIMELINE_EVERY:
            self._timeline_drawn = now
            self._timeline.content = timeline_html(
                simulation.moments,
                simulation.steps,
                simulation.index,
                modules=simulation.modules,
            )

    def _add_scene(self) -> None:
        server, simulation = self._server, self._simulation
        scene, physics = server.scene, simulation.episode.env.physics
        add_lights(scene)
        server.initial_camera.position = CAMERAS["front"]
        server.initial_camera.look_at = LOOK_AT
        server.initial_camera.fov = FIELD_OF_VIEW
        self._arms = ArmNodes(scene, simulation.model, simulation.data)
        self._ghost = GhostNodes(scene, physics.segment_lengths)
        self._forces = [ForceNode(scene, name=f"/force/{name}") for name in HANDS]
        self._beside: tuple[ArmNodes, GhostNodes, list[Any]] | None = None
        if simulation.hand_positions is not None:
            for hand in range(len(HANDS)):
                self._add_grab(hand)

    def _add_grab(self, hand: int) -> None:
        """Add what a user drags: a sphere around a hand, which moves with it."""
        simulation, name = self._simulation, HANDS[hand]
        node = self._server.scene.add_icosphere(
            f"/arms/{name}/grab",
            _GRAB_RADIUS,
            _GRAB_COLOUR,
            opacity=0.22,
            cast_shadow=False,
            receive_shadow=False,
            position=simulation.model.body(name).ipos,
        )

        @node.on_drag("left")  # type: ignore[untyped-decorator]
        async def _(event: Any) -> None:
            if event.phase == "end":
                simulation.request(simulation.drag, hand, None)
            elif event.client_id == self.in_control:
                simulation.request(simulation.drag, hand, event.end_position)

    def _draw_beside(self, reference: Any) -> None:
        """Show, move or remove the other kind of arms."""
        simulation, scene = self._simulation, self._server.scene
        data, episode = simulation.compared_data, simulation.compared
        if data is None or episode is None:
            if self._beside is not None:
                arms, ghost, labels = self._beside
                for node in (arms.root, ghost.root, *labels):
                    node.remove()
                self._beside = None
                self._look_from("front")
            return
        if self._beside is None:
            place, physics = (0.0, _BESIDE, 0.0), episode.env.physics
            kinds = [one.env.task.options.arms for one in (simulation.episode, episode)]
            self._beside = (
                ArmNodes(scene, physics.model.ptr, data, name="/beside", position=place),
                GhostNodes(scene, physics.segment_lengths, name="/ghost_beside", position=place),
                [
                    scene.add_label(f"/kind/{i}", kind, position=(0.0, i * _BESIDE, 1.75))
                    for i, kind in enumerate(kinds)
                ],
            )
            self._look_from("front")
        arms, ghost, _ = self._beside
        arms.update(data)
        ghost.update(reference)

    def _add_readings(self) -> None:
        gui = self._server.gui
        self._status = gui.add_html("", order=0)
        self._bars = gui.add_html("", order=1)
        self._timeline = gui.add_html("", order=2)
        self._cameras = gui.add_button_group("camera", tuple(CAMERAS), order=9)
        request = self._simulation.request

        @self._cameras.on_click  # type: ignore[untyped-decorator]
        async def _(event: Any) -> None:
            if event.client is not None:  # each viewer looks from where they like
                request(self._look_from, event.target.value, event.client)

    def _look_from(self, name: str, viewer: Any = None) -> None:
        """Move the camera of a viewer, or of all, to where all arms fit into the picture."""
        middle, half_width = np.array(LOOK_AT), _REACH
        if self._beside is not None:
            middle[1] += _BESIDE / 2.0
            half_width += _BESIDE / 2.0
        eye = np.array(CAMERAS[name]) - LOOK_AT
        for each in [viewer] if viewer is not None else self.viewers.values():
            camera = each.camera
            width = math.tan(FIELD_OF_VIEW / 2.0) * camera.aspect * float(np.linalg.norm(eye))
            with each.atomic():
                camera.position = middle + eye * max(1.0, half_width / width)
                camera.look_at, camera.fov = middle, FIELD_OF_VIEW

    def _admit(self, viewer: Any) -> None:
        """Add a viewer, who has the controls if nobody else does."""
        if not self.viewers and len(self._simulation.moments) == 1:
            self._simulation.play()
        self.viewers[viewer.client_id] = viewer
        self._look_from("front", viewer)
        if self.in_control is None:
            self._give_controls(viewer)
        else:
            self._offer_controls(viewer)

    def _leave(self, viewer: Any) -> None:
        """Remove a viewer; the next one has the controls where this one did."""
        self.viewers.pop(viewer.client_id, None)
        if viewer.client_id == self.in_control:
            self.in_control, self.controls = None, None
            self._simulation.drag(0, None)
            for other in self.viewers.values():
                self._give_controls(other)
                break

    def _give_controls(self, viewer: Any) -> None:
        """Give a viewer the controls; the one who had them can only watch."""
        before = self.viewers.get(-1 if self.in_control is None else self.in_control)
        self.in_control = viewer.client_id
        self._simulation.drag(0, None)
        viewer.gui.reset()
        self.controls = Controls(viewer.gui, self._simulation)
        if before is not None and before is not viewer:
            self._offer_controls(before)

    def _offer_controls(self, viewer: Any) -> None:
        viewer.gui.reset()
        take = viewer.gui.add_button("Take the controls", order=10)
        take.hint = "Another viewer has them, and can only watch afterwards."
        on_user(take, lambda _: self._simulation.request(self._give_controls, viewer))
