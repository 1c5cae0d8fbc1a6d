"""Names of files and labels as printable text."""

from __future__ import annotations

import re

__all__ = ["printable"]

# Control characters; and lone surrogates, which stand for bytes of a file's name that are not UTF-8
# and cannot be drawn or encoded.
_UNPRINTABLE = re.compile(r"[\x00-\x1f\x7f-\x9f\ud800-\udfff]")


def printable(name: str) -> str:
    r"""Return a name with escapes, such as \n or \udcff, for characters that cannot be printed."""
    return _UNPRINTABLE.sub(lambda found: found[0].encode("unicode_escape").decode(), name)
