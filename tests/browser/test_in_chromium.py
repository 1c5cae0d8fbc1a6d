"""The page in a real browser, which draws by software; `make test-web`."""

import shutil
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.browser.conftest import Stage

sync_api = pytest.importorskip("playwright.sync_api")
pytest.importorskip("viser")

from mpma_mj.browser.page import CAMERAS, FIELD_OF_VIEW, LOOK_AT  # noqa: E402
from mpma_mj.cli import main  # noqa: E402

pytestmark = pytest.mark.web

SOFTWARE = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader"]
SOFTWARE += ["--enable-unsafe-swiftshader"]


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """Return the system's Chromium, else Playwright's own."""
    found = shutil.which("chromium") or shutil.which("google-chrome")
    with sync_api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=found, args=SOFTWARE)
        yield browser
        browser.close()


@pytest.fixture
def open_tab(stage: Stage, browser: Any) -> Iterator[Callable[[], Any]]:
    context = browser.new_context(viewport={"width": 1000, "height": 560})
    context.set_default_timeout(30_000)

    def open_tab() -> Any:
        tab = context.new_page()
        tab.goto(stage.address.url)
        tab.get_by_text("real time").or_(tab.get_by_text("paused")).wait_for()
        return tab

    yield open_tab
    context.close()


def until(tab: Any, found: Callable[[], Any], seconds: float = 20.0) -> None:
    end = time.monotonic() + seconds
    while not found():
        assert time.monotonic() < end, "it did not happen"
        tab.wait_for_timeout(20)


def on_screen(tab: Any, position: Any) -> tuple[float, float]:
    """Return where a position in the scene is on the screen, seen from the front, pixels."""
    box = tab.locator("canvas").first.bounding_box()
    eye, look_at = np.array(CAMERAS["front"]), np.array(LOOK_AT)
    forward = (look_at - eye) / np.linalg.norm(look_at - eye)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    seen = position - eye
    scale = box["height"] / 2.0 / np.tan(FIELD_OF_VIEW / 2.0) / (seen @ forward)
    x = box["x"] + box["width"] / 2.0 + scale * (seen @ right)
    return x, box["y"] + box["height"] / 2.0 - scale * (seen @ np.cross(right, forward))


def test_it_plays_without_a_request_to_another_host(
    stage: Stage, open_tab: Callable[[], Any], browser: Any
) -> None:
    requests: list[str] = []
    tab = open_tab()
    tab.context.on("request", lambda request: requests.append(request.url))
    tab.context.on("console", lambda message: requests.append(message.text))
    tab.reload()
    tab.get_by_text("kinematic arms").click()  # with labels in the scene, which need a font
    until(tab, lambda: stage.simulation.compared is not None)
    before = tab.locator("canvas").first.screenshot()
    tab.wait_for_timeout(3000)
    assert tab.locator("canvas").first.screenshot() != before
    assert stage.simulation.playing
    fetched = [url for url in requests if "://" in url and url.split("://")[0] != "ws"]
    assert fetched
    own = (stage.address.url, f"blob:{stage.address.url}", "data:")
    urls = [url for url in fetched if url.startswith(("http", "blob"))]
    assert all(url.startswith(own) for url in urls), urls


def test_scrubbing_shows_the_past_in_every_tab(stage: Stage, open_tab: Callable[[], Any]) -> None:
    first, second = open_tab(), open_tab()
    until(first, lambda: len(stage.simulation.moments) > 60)
    track = first.locator(".mantine-Slider-root").first.bounding_box()  # while it plays
    first.mouse.move(track["x"] + 0.15 * track["width"], track["y"] + track["height"] / 2.0)
    first.mouse.down()
    until(first, lambda: stage.simulation.shown is not None)
    first.mouse.move(track["x"] + 0.1 * track["width"], track["y"] + track["height"] / 2.0)
    first.mouse.up()
    tenth = stage.simulation.steps / 10.0
    until(first, lambda: abs(stage.simulation.shown - tenth) < 0.5 * tenth)
    number = first.locator("input.mantine-NumberInput-input").first
    number.fill("7")
    number.press("Enter")
    for tab in (first, second):
        tab.get_by_text("step 7; paused").wait_for()
    assert stage.simulation.shown == 7


def test_module_is_switched_off_by_its_box(stage: Stage, open_tab: Callable[[], Any]) -> None:
    tab = open_tab()
    tab.get_by_role("checkbox").nth(1).click()
    until(tab, lambda: stage.simulation.enabled_modules == [True, False, True])
    tab.get_by_text("off", exact=True).wait_for()
    until(tab, lambda: stage.simulation.moment.responsibility[1] == 0.0)


def test_drag_pushes_the_hand(stage: Stage, open_tab: Callable[[], Any]) -> None:
    tab, live = open_tab(), stage.simulation
    tab.get_by_role("button", name="Pause").click()
    until(tab, lambda: not live.playing)
    tab.wait_for_timeout(1000)  # the browser draws the paused arms
    x, y = on_screen(tab, live.hand_positions[0])
    tab.mouse.move(x, y)
    tab.mouse.down()
    for i in range(10):
        tab.mouse.move(x + 12 * i, y)
        tab.wait_for_timeout(30)
    until(tab, lambda: live.dragged is not None)
    live.request(live.play)
    until(tab, lambda: np.linalg.norm(live.moment.push[0]) > 20.0)
    assert live.moment.push[0, 1] > 20.0  # to the arms' left, which is right on the screen
    tab.get_by_text("left hand").wait_for()
    tab.mouse.up()
    until(tab, lambda: not live.moment.push.any())


def test_other_tab_takes_the_controls(stage: Stage, open_tab: Callable[[], Any]) -> None:
    first, second = open_tab(), open_tab()
    assert first.get_by_role("checkbox").count()
    second.get_by_role("button", name="Take the controls").click()
    second.get_by_role("button", name="Pause").click()
    first.get_by_text("paused").wait_for()
    first.get_by_role("button", name="Take the controls").wait_for()
    assert not first.get_by_role("checkbox").count()


def test_page_of_another_origin_cannot_connect(stage: Stage, open_tab: Callable[[], Any]) -> None:
    import viser

    tab = open_tab()
    connects = """([url, protocol]) => new Promise(done => {
        const socket = new WebSocket(url, protocol);
        socket.onopen = () => done(true); socket.onerror = () => done(false);
    })"""
    address = [stage.address.url.replace("http", "ws"), f"viser-v{viser.__version__}"]
    assert tab.evaluate(connects, address)
    tab.goto("about:blank")
    assert not tab.evaluate(connects, address)


def test_a_file_plays_without_a_request(browser: Any, small_run: Path, tmp_path: Path) -> None:
    file = tmp_path / "a.html"
    assert main(["play", str(small_run), "--to", "2", "--out", str(file)]) == 0
    page = browser.new_page(viewport={"width": 640, "height": 420})
    requests: list[str] = []
    errors: list[str] = []
    page.on("request", lambda request: requests.append(request.url))
    page.on("websocket", lambda socket: requests.append(socket.url))
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.goto(file.as_uri())
    moment = page.locator("input").first
    moment.wait_for(timeout=60_000)
    pictures: set[bytes] = set()
    arms = {"x": 240, "y": 120, "width": 160, "height": 120}

    def differs() -> bool:
        before = len(pictures)
        pictures.add(page.screenshot(clip=arms, timeout=60_000))
        return len(pictures) > before

    for text in ("0.5", "1.5"):
        moment.fill(text)
        moment.press("Enter")
        until(page, differs, 60.0)
    title = page.title()
    page.close()
    assert errors == []
    assert [url for url in requests if not url.startswith(("blob:", "data:"))] == [file.as_uri()]
    assert title == "ymca"
