"""Pages that are served in a thread of the test."""

import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from mpma_mj.browser.episode_factory import EpisodeFactory
from mpma_mj.browser.server import Address, find_address, open_server
from mpma_mj.browser.simulation import LiveSimulation
from mpma_mj.training.run_folder import RunFolder


@dataclass
class Stage:
    """A page and its simulation, which is stepped in a thread of its own."""

    simulation: LiveSimulation
    page: Any
    address: Address
    viewer: Callable[[], Any]


@contextmanager
def served(simulation: LiveSimulation) -> Iterator[Stage]:
    pytest.importorskip("viser")
    from mpma_mj.browser.page import Page
    from tests.browser.viewer import Viewer

    address, stop = find_address("127.0.0.1", 8720), threading.Event()
    with ExitStack() as stack:
        page = Page(stack.enter_context(open_server(address)), simulation)
        thread = threading.Thread(target=simulation.run_until, args=(stop, page.draw))
        thread.start()
        stack.callback(thread.join)
        stack.callback(stop.set)

        def viewer() -> Viewer:
            new = Viewer(address)
            stack.callback(new.close)
            return new

        yield Stage(simulation, page, address, viewer)


@pytest.fixture
def stage(small_run: Path) -> Iterator[Stage]:
    with served(LiveSimulation(EpisodeFactory.of_run(RunFolder(small_run)))) as stage:
        yield stage
