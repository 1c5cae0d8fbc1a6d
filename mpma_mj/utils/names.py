"""Names of files and labels as text that can be shown."""

from __future__ import annotations

import re

__all__ = ["printable"]

# Control characters, and what stands in a `str` for bytes of a file's name that are no UTF-8: a
# lone surrogate, which no font has and no text file can hold.
_UNPRINTABLE = re.compile(r"[\x00-\x1f\x7f-\x9f\ud800-\udfff]")


def printable(name: str) -> str:
    r"""Return a name with escapes, such as \n or \udcff, for what cannot be shown."""
    return _UNPRINTABLE.sub(lambda found: found[0].encode("unicode_escape").decode(), name)
