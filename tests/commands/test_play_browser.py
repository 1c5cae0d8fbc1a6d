"""`mpma play --browser`: its options, its errors, and the process that serves the page."""

import signal
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.conftest import Refused

MODULE = [sys.executable, "-m", "mpma_mj", "play"]


@pytest.fixture
def serve() -> Iterator[Callable[[list[str]], Any]]:
    """Return a function that starts the command, and returns the process and its first line."""
    pytest.importorskip("viser")
    started: list[subprocess.Popen[str]] = []

    def serve(words: list[str]) -> tuple[subprocess.Popen[str], str]:
        pipe = subprocess.PIPE
        process = subprocess.Popen([*MODULE, *words], stdout=pipe, stderr=pipe, text=True)
        started.append(process)
        assert process.stdout is not None
        return process, process.stdout.readline()

    yield serve
    for process in started:
        process.kill()
        process.communicate()


def answer(url: str) -> bytes:
    """Return how the page's address answers a browser that asks for it."""
    host, port = url.strip().removeprefix("http://").split(":")
    with socket.create_connection((host, int(port)), timeout=10) as connection:
        connection.sendall(f"GET / HTTP/1.1\r\nHost: {host}\r\n\r\n".encode())
        return connection.recv(4096)


@pytest.mark.parametrize("sent", ["SIGINT", "SIGTERM"])
def test_a_run_is_served_until_it_is_interrupted(
    small_run: Path, serve: Callable[[list[str]], Any], sent: str
) -> None:
    process, url = serve([str(small_run), "--browser", "--port", "8740"])
    assert url.startswith("http://127.0.0.1:87")
    assert b"200 OK" in answer(url)
    number = getattr(signal, sent)
    process.send_signal(number)
    out, err = process.communicate(timeout=30)
    assert (out, err) == ("", "mpma: interrupted\n")
    assert process.returncode == 128 + number


def test_a_motion_is_followed_on_the_next_free_port(serve: Callable[[list[str]], Any]) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        _, url = serve(["ymca", "--browser", "--port", str(port)])
        assert int(url.rsplit(":", 1)[1]) > port
        assert b"200 OK" in answer(url)


def test_open_page_is_warned_of(serve: Callable[[list[str]], Any]) -> None:
    process, url = serve(["ymca", "--browser", "--host", "0.0.0.0", "--port", "8740"])
    assert url.startswith(f"http://{socket.gethostname()}:")
    process.send_signal(signal.SIGINT)
    err = process.communicate(timeout=30)[1]
    assert "warning: 0.0.0.0 is open: all who reach this machine can watch and control" in err
    assert "leave --host out" in err


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--host", "127.0.0.1"], "--host is for the page; give --browser"),
        (["--port", "8080"], "--port is for the page"),
        (["--browser", "--out", "dance.mp4"], "--browser writes no file; leave --out out"),
        (["--browser", "--size", "640x480"], "--size is not for the page; leave it out"),
        (["--browser", "--camera", "side"], "--camera is not for the page"),
    ],
)
def test_options_that_contradict_are_one_line(
    refused: Refused, words: list[str], message: str
) -> None:
    refused(["play", "ymca", *words], message)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--port", "0"], "--port is 0; expected a whole number from 1 to 65535"),
        (["--host", "203.0.113.7"], "--host is '203.0.113.7'; expected an address of this machine"),
    ],
)
def test_no_address_of_this_machine_is_one_line(
    refused: Refused, words: list[str], message: str
) -> None:
    pytest.importorskip("viser")
    refused(["play", "ymca", "--browser", *words], message)


def test_what_is_no_run_and_a_damaged_run_are_one_line(
    refused: Refused, small_run: Path, tmp_path: Path
) -> None:
    pytest.importorskip("viser")
    refused(["play", "nothing", "--browser"], "no run or motion 'nothing'")
    refused(["play", str(tmp_path), "--browser"], str(tmp_path))
    (tmp_path / "config.json").write_bytes((small_run / "config.json").read_bytes()[:100])
    refused(["play", str(tmp_path), "--browser"], "config.json")
    refused(["play", str(small_run), "--browser", "--tempo", "0.5"], "leave --tempo out")


def test_without_viser_it_says_what_installs_it(
    refused: Refused, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "viser", None)
    refused(["play", "ymca", "--browser"], "pip install 'mpma-mj[web]'")
