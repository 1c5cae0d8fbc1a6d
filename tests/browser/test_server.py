"""Addresses of the page, and raw handshakes with its server."""

import socket
import threading
from collections.abc import Iterator

import pytest

from mpma_mj.browser.server import Address, find_address, is_own_origin, open_server
from mpma_mj.errors import BadOptionError, MpmaError

UPGRADE = (
    "GET / HTTP/1.1\r\nHost: {host}\r\nUpgrade: {upgrade}\r\nConnection: Upgrade\r\n"
    "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n"
    "Sec-WebSocket-Protocol: viser-v{version}\r\n{origin}\r\n"
)


@pytest.fixture(scope="module")
def address() -> Iterator[Address]:
    pytest.importorskip("viser")
    address = find_address("127.0.0.1", 8700)
    with open_server(address):
        yield address


def status(address: Address, *, host: str, origin: str | None, upgrade: str = "websocket") -> int:
    """Return the status with which a handshake is answered."""
    import viser

    line = "" if origin is None else f"Origin: {origin}\r\n"
    text = UPGRADE.format(host=host, origin=line, upgrade=upgrade, version=viser.__version__)
    with socket.create_connection((address.host, address.port), timeout=5) as connection:
        connection.sendall(text.encode())
        return int(connection.recv(4096).split()[1])


@pytest.mark.parametrize("name", ["127.0.0.1", "localhost", socket.gethostname().lower()])
@pytest.mark.parametrize("tunnelled", [False, True])
def test_own_page_connects_also_through_a_tunnel(
    address: Address, name: str, tunnelled: bool
) -> None:
    host = f"{name}:{9999 if tunnelled else address.port}"
    assert status(address, host=host, origin=f"http://{host}") == 101


@pytest.mark.parametrize(
    "origin",
    [
        "http://example.com",
        "http://127.0.0.1:1",
        "http://127.0.0.1",
        "http://127.0.0.1:{port}.example.com",
        "null",
        "file://",
        "http://[",
        None,
    ],
)
def test_foreign_page_is_refused(address: Address, origin: str | None) -> None:
    host = f"127.0.0.1:{address.port}"
    origin = origin and origin.format(port=address.port)
    assert status(address, host=host, origin=origin) == 403


def test_name_that_its_owner_points_to_this_machine_is_refused(address: Address) -> None:
    host = f"rebound.example.com:{address.port}"
    assert status(address, host=host, origin=f"http://{host}") == 403


@pytest.mark.parametrize("upgrade", ["WebSocket", "h2c, websocket"])
def test_spelling_of_the_upgrade_opens_no_way_around(address: Address, upgrade: str) -> None:
    host = f"127.0.0.1:{address.port}"
    assert status(address, host=host, origin="http://example.com", upgrade=upgrade) == 403


def test_page_itself_is_sent_to_all_who_ask(address: Address) -> None:
    with socket.create_connection((address.host, address.port), timeout=5) as connection:
        connection.sendall(f"GET / HTTP/1.1\r\nHost: {address.host}\r\n\r\n".encode())
        assert connection.recv(4096).split()[1] == b"200"


def test_nothing_is_printed_and_no_tunnel_is_opened(capfd: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("viser")
    with open_server(find_address("127.0.0.1", 8700)) as server:
        assert server.request_share_url() is None
        assert server._share_tunnel is None
    assert capfd.readouterr() == ("", "")
    assert not [t for t in threading.enumerate() if "background_worker" in t.name]


def test_server_that_would_let_other_pages_connect_does_not_open(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    viser = pytest.importorskip("viser")
    monkeypatch.setattr(viser.ViserServer, "__init__", lambda *_, **__: None)
    opened = open_server(find_address("127.0.0.1", 8700))
    with pytest.raises(MpmaError, match="would let pages of others connect"), opened:
        pytest.fail("it was opened")


def test_who_connects_and_is_no_browser_is_not_reported(
    capfd: pytest.CaptureFixture[str],
) -> None:
    pytest.importorskip("viser")
    address = find_address("127.0.0.1", 8700)
    host = f"127.0.0.1:{address.port}"
    with open_server(address):
        for sent in (b"\x00\xff garbage\r\n\r\n", b"GET / HTTP/1.1\r\n", b""):
            with socket.create_connection((address.host, address.port), timeout=5) as connection:
                connection.sendall(sent)
        assert status(address, host=host, origin="http://example.com") == 403
        assert status(address, host=host, origin=f"http://{host}") == 101
    assert capfd.readouterr() == ("", "")


def test_taken_port_gives_way_to_the_next_free_one() -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        assert find_address("127.0.0.1", port).port > port


@pytest.mark.parametrize("host", ["203.0.113.7", "no.such.host.invalid", "a" * 70, "1.2.3", ""])
def test_address_of_another_machine_is_refused(host: str) -> None:
    with pytest.raises(BadOptionError, match="an address of this machine"):
        find_address(host, 8700)


@pytest.mark.parametrize("port", [0, -1, 65536])
def test_port_is_a_port(port: int) -> None:
    with pytest.raises(BadOptionError, match="from 1 to 65535"):
        find_address("127.0.0.1", port)


def test_only_this_machine_can_connect_unless_it_is_opened() -> None:
    assert not find_address("127.0.0.1", 8700).is_open
    assert not find_address("localhost", 8700).is_open
    opened = find_address("0.0.0.0", 8700)
    assert opened.is_open
    assert opened.url == f"http://{socket.gethostname()}:{opened.port}"
    assert Address("::1", "::1", 8700).url == "http://[::1]:8700"


def test_origin_of_an_encrypted_proxy_is_own_only_under_its_host() -> None:
    assert is_own_origin("https://127.0.0.1:9", "127.0.0.1:9")
    assert not is_own_origin("https://127.0.0.1:9", "127.0.0.1:8")
