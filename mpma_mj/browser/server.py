"""Server of the page: its address, and who may connect."""

from __future__ import annotations

import contextlib
import errno
import importlib
import io
import ipaddress
import logging
import socket
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from http import HTTPStatus
from typing import Any
from urllib.parse import urlsplit

from mpma_mj.errors import BadOptionError, MpmaError
from mpma_mj.visualization.viser_arms import require_web

__all__ = [
    "PORT",
    "THIS_MACHINE",
    "Address",
    "find_address",
    "is_own_origin",
    "open_server",
]

THIS_MACHINE, PORT = "127.0.0.1", 8080
"""Address that only this machine reaches, and port, unless others are given."""

_PORTS = 100  # that are tried, from the requested one on (choice)
_HIGHEST_PORT = 65535


@dataclass(frozen=True)
class Address:
    """Address at which the page is served.

    Attributes:
        host: Number of the network interface, such as 127.0.0.1.
        name: Name that browsers of this machine or, if it is open, of others can be given.
        port: Port, free a moment ago.
    """

    host: str
    name: str
    port: int

    @property
    def url(self) -> str:
        """Address to type into a browser."""
        return f"http://{f'[{self.name}]' if ':' in self.name else self.name}:{self.port}"

    @property
    def is_open(self) -> bool:
        """Whether other machines can connect."""
        return not ipaddress.ip_address(self.host).is_loopback


def find_address(host: str, port: int) -> Address:
    """Return an address that can be bound, with the first free port from one on.

    It is tried, as viser never returns where an address is not this machine's.

    Args:
        host: Name or number of this machine, or of one of its network interfaces.
        port: First port.

    Raises:
        BadOptionError: It is no address of this machine, or no port is free.
    """
    if not 1 <= port <= _HIGHEST_PORT:
        expected = f"a whole number from 1 to {_HIGHEST_PORT}"
        raise BadOptionError(option="port", value=port, expected=expected)
    expected = "an address of this machine: 127.0.0.1, or 0.0.0.0 to let other machines connect"
    bad_host = BadOptionError(option="host", value=host, expected=expected)
    try:
        family, _, _, _, (number, *_) = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
    except (OSError, UnicodeError):  # no such name
        raise bad_host from None
    for candidate in range(port, min(port + _PORTS, _HIGHEST_PORT + 1)):
        try:
            socket.create_server((str(number), candidate), family=family).close()
        except OSError as error:
            if error.errno == errno.EADDRINUSE:
                continue
            if error.errno == errno.EACCES:
                expected = "a port from 1024 on, as lower ones are reserved"
                raise BadOptionError(option="port", value=port, expected=expected) from None
            raise bad_host from None
        anywhere = ipaddress.ip_address(number).is_unspecified
        return Address(str(number), socket.gethostname() if anywhere else str(number), candidate)
    raise BadOptionError(f"no port from {port} on is free", remedy="give another {port}")


def is_own_origin(origin: str | None, host: str | None) -> bool:
    """Return whether a request was made by a page that this server has sent.

    Any page in the world may connect to the machine of the browser that shows it. Browsers send the
    origin of the page: requests of this server's page have its own host there. Names other than
    this machine's are refused, since their owners can point them to this machine; numbers are not.
    That holds through tunnels too, whose ports differ from the server's.

    Args:
        origin: Header `Origin` of the request.
        host: Header `Host` of the request.
    """
    if origin is None or host is None:
        return False
    try:
        parts = urlsplit(origin)
        name = parts.hostname
    except ValueError:
        return False
    if parts.scheme not in ("http", "https") or not name or parts.netloc != host:
        return False
    if name in ("localhost", socket.gethostname().lower()):
        return True
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


@contextlib.contextmanager
def open_server(address: Address) -> Iterator[Any]:
    """Serve an empty page until the context ends.

    Only pages of its own may connect, and nothing is sent to other servers. What viser prints is
    dropped.

    Args:
        address: As `find_address` returned it.

    Yields:
        The `viser.ViserServer`.

    Raises:
        MpmaError: viser is not installed, or would let pages of others connect.
    """
    require_web()
    import viser

    class Server(viser.ViserServer):
        """Server that opens no tunnel to the public, which a page could request."""

        def request_share_url(self, verbose: bool = True) -> str | None:
            return None

    with contextlib.redirect_stdout(io.StringIO()), _own_pages_only():
        server = Server(address.host, address.port, verbose=False)
    # It reports every connection of something else than a browser, with a traceback.
    logger = logging.getLogger("websockets.server")
    level = logger.level
    try:
        logger.setLevel(logging.CRITICAL)
        with warnings.catch_warnings():
            # For widgets of a viewer who has just left; they are removed a moment later.
            warnings.filterwarnings("ignore", message="Queued a .* on a closed connection")
            yield server
    finally:
        logger.setLevel(level)
        with contextlib.redirect_stdout(io.StringIO()):
            server.stop()


@contextlib.contextmanager
def _own_pages_only() -> Iterator[None]:
    """Make servers that are started in this context refuse the pages of other sites.

    viser 1.1 has no option for it, so that its call of `serve` in websockets is completed here.

    Raises:
        MpmaError: There was no such call.
    """
    module: Any = importlib.import_module("websockets.asyncio.server")
    serve, guarded = module.serve, []

    def guarded_serve(*args: Any, process_request: Any, **options: Any) -> Any:
        def process(connection: Any, request: Any) -> Any:
            headers = request.headers
            if "Upgrade" in headers and not is_own_origin(
                headers.get("Origin"), headers.get("Host")
            ):
                return connection.respond(HTTPStatus.FORBIDDEN, "Not a page of this server.\n")
            return process_request(connection, request)

        guarded.append(process)
        return serve(*args, process_request=process, **options)

    module.serve = guarded_serve
    try:
        yield
    finally:
        module.serve = serve
    if not guarded:
        raise MpmaError(
            "the viser that is installed would let pages of others connect",
            remedy="pip install 'viser>=1.1,<1.2'",
        )
