"""A viewer without a browser: what viser's page sends and receives, by a raw websocket."""

import threading
import time
from collections.abc import Callable
from typing import Any

import msgspec.msgpack
import viser
import zstandard
from viser import _messages
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect
from websockets.typing import Origin, Subprotocol

from mpma_mj.browser.server import Address


class Viewer:
    """A connected viewer.

    Attributes:
        widgets: Properties and value of each widget that it sees, by uuid; as viser's page has it.
        positions: Position of each node of the scene, by name.
        messages: All messages, as dictionaries.
    """

    def __init__(self, address: Address) -> None:
        self.widgets: dict[str, dict[str, Any]] = {}
        self.positions: dict[str, Any] = {}
        self.messages: list[dict[str, Any]] = []
        self._socket = connect(
            f"ws://{address.host}:{address.port}",
            origin=Origin(address.url),
            subprotocols=[Subprotocol(f"viser-v{viser.__version__}")],
            max_size=None,
            compression=None,
        )
        self._thread = threading.Thread(target=self._receive, daemon=True)
        self._thread.start()
        x, up, zero = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, 0.0)
        view = (0.7, 0.01, 100.0, 560, 1000)
        self.send(_messages.ViewerCameraMessage((1.0, *x), x, *view, zero, up))

    def send(self, message: Any) -> None:
        self._socket.send(msgspec.msgpack.encode(message.as_serializable_dict([])))

    def set(self, label: str, value: Any) -> None:
        """Change a widget as a user does, by its label."""
        uuid = until(lambda: self.find(label))
        self.send(_messages.GuiUpdateMessage(uuid, {"value": value}))

    def find(self, label: str) -> str | None:
        """Return the uuid of a widget with a label; None if there is none."""
        for uuid, widget in list(self.widgets.items()):
            if widget["props"].get("label") == label:
                return uuid
        return None

    def value(self, label: str) -> Any:
        return self.widgets[until(lambda: self.find(label))]["value"]

    def text(self) -> str:
        """Return all HTML that is shown."""
        return "".join(widget["props"].get("content", "") for widget in list(self.widgets.values()))

    def drag(self, node: str, phase: str, position: tuple[float, float, float]) -> None:
        zero = (0.0, 0.0)
        message = _messages.SceneNodeDragMessage
        self.send(message(phase, node, None, position, zero, position, zero, "left", None))

    def close(self) -> None:
        self._socket.close()
        self._thread.join(timeout=5)

    def _receive(self) -> None:
        try:
            for raw in self._socket:
                size = int.from_bytes(raw[8:16], "little")
                inner = zstandard.ZstdDecompressor().decompress(raw[16 : 16 + size])
                for message in msgspec.msgpack.decode(inner)["messages"]:
                    self._take(message)
        except ConnectionClosed:
            pass

    def _take(self, message: dict[str, Any]) -> None:
        self.messages.append(message)
        kind = message["type"]
        if kind == "GuiRemoveMessage":
            self.widgets.pop(message["uuid"], None)
        elif kind == "GuiUpdateMessage":
            widget = self.widgets.get(message["uuid"])
            for name, value in message["updates"].items() if widget else ():
                target = widget if name == "value" else widget["props"]
                target[name] = value
        elif kind.startswith("Gui") and "props" in message:
            self.widgets[message["uuid"]] = message
        elif kind == "SetPositionMessage":
            self.positions[message["name"]] = message["position"]


def until(found: Callable[[], Any], seconds: float = 10.0) -> Any:
    """Return what a function returns as soon as that is true, or fail."""
    end = time.monotonic() + seconds
    while not (result := found()):
        assert time.monotonic() < end, "it did not happen"
        time.sleep(0.01)
    return result
