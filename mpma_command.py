"""Entry point of the command `mpma`, outside of the package, whose import takes a while."""

import os
import signal
from types import FrameType
from typing import NoReturn

_ENDING = ("SIGINT", "SIGTERM", "SIGHUP")
_USUAL = (signal.SIG_DFL, signal.default_int_handler)  # signals that are ignored stay so


def main() -> int:
    """Run the command line; a signal ends it in one line also while it is imported."""
    numbers = [n for n in signal.Signals if n.name in _ENDING and signal.getsignal(n) in _USUAL]
    before = {number: signal.signal(number, _end) for number in numbers}
    from mpma_mj import cli

    for number, handler in before.items():
        signal.signal(number, handler)
    return cli.main()


def _end(number: int, _: FrameType | None) -> NoReturn:
    # Nothing has begun that would have to be ended, and code in C may lose an exception.
    os.write(2, b"mpma: interrupted\n")
    os._exit(128 + number)
