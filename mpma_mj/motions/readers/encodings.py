"""Encodings of text files, recognised by their first bytes."""

from __future__ import annotations

import codecs
import re

__all__ = ["encoding_of"]

_BYTE_ORDER_MARKS = {
    codecs.BOM_UTF8: "utf-8-sig",
    codecs.BOM_UTF16_LE: "utf-16",
    codecs.BOM_UTF16_BE: "utf-16",
}
_SHIFT_JIS = "cp932"
_ENCODINGS = ("utf-8", _SHIFT_JIS, "latin-1")  # in which text without a mark is looked for
_JAPANESE = re.compile("[\u3041-\u30ff左右]")


def encoding_of(head: bytes) -> str | None:
    """Return the name of the encoding of text; None of what is no text.

    Args:
        head: The first bytes of a file, which may end within a letter.
    """
    marked = (name for mark, name in _BYTE_ORDER_MARKS.items() if head.startswith(mark))
    if (name := next(marked, None)) is not None:
        return name
    return None if b"\0" in head else next(name for name in _ENCODINGS if _is_in(head, name))


def _is_in(text: bytes, encoding: str) -> bool:
    """Return whether bytes, which may end within a letter, are text of an encoding.

    Letters of Latin script may make Chinese signs in Shift-JIS, but hardly kana, nor left or right.
    """
    try:
        letters = codecs.getincrementaldecoder(encoding)().decode(text)
    except UnicodeDecodeError:
        return False
    return encoding != _SHIFT_JIS or _JAPANESE.search(letters) is not None
