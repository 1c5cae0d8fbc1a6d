"""Ways in which files break: cut off, changed bytes and digits, lines and cells out of place."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable

import numpy as np

__all__ = ["mangle"]

Mangle = Callable[[bytes, np.random.Generator], bytes]

_HEADER = 700  # bytes, where damage hurts most
_OFTEN = 0.25  # share of the damage that is there
_BLOCK = 512  # bytes, the largest block that is damaged
_OF_TABLES = "swapped columns"
_CELL = re.compile(r"[^\s,;<>\"\[\]{}:]+")


def mangle(data: bytes, rng: np.random.Generator, *, is_table: bool) -> tuple[str, bytes]:
    """Damage a file in one way.

    Args:
        data: The file.
        rng: Random numbers.
        is_table: Whether it is opened as a spreadsheet, in which columns may be moved.

    Returns:
        What was done, and the damaged file, which differs from the other.
    """
    is_text = data.isascii() and b"\0" not in data
    kinds = list((_OF_ALL | (_OF_TEXT if is_text else _OF_BLOCKS)).values())
    while True:
        ways = list(kinds[rng.integers(len(kinds))].items())
        name, way = ways[rng.integers(len(ways))]
        damaged = way(data, rng)
        if damaged != data and (is_table or name != _OF_TABLES):
            return name, damaged


def _place(size: int, rng: np.random.Generator) -> int:
    """Return a random place, often in the header."""
    return int(rng.integers(min(size, _HEADER) if rng.random() < _OFTEN else size))


def _cut(data: bytes, rng: np.random.Generator) -> bytes:
    return data[: rng.integers(1, len(data))]


def _changed_bytes(data: bytes, rng: np.random.Generator) -> bytes:
    changed = bytearray(data)
    for _ in range(rng.choice([1, 1, 2, 4])):
        changed[_place(len(data), rng)] = int(rng.integers(256))
    return bytes(changed)


def _zeros(data: bytes, rng: np.random.Generator) -> bytes:
    start = _place(len(data), rng)
    end = min(len(data), start + int(rng.integers(1, _BLOCK)))
    return data[:start] + bytes(end - start) + data[end:]


def _lost_block(data: bytes, rng: np.random.Generator) -> bytes:
    start = _place(len(data), rng)
    return data[:start] + data[start + int(rng.integers(1, _BLOCK)) :]


def _doubled_block(data: bytes, rng: np.random.Generator) -> bytes:
    start = _place(len(data), rng)
    end = start + int(rng.integers(1, _BLOCK))
    return data[:end] + data[start:end] + data[end:]


def _swapped_blocks(data: bytes, rng: np.random.Generator) -> bytes:
    size = int(rng.integers(1, _BLOCK))
    first, second = sorted(_place(max(1, len(data) - size), rng) for _ in range(2))
    if second < first + size:
        return data
    a, b = data[first : first + size], data[second : second + size]
    return data[:first] + b + data[first + size : second] + a + data[second + size :]


def _digit(data: bytes, rng: np.random.Generator) -> bytes:
    places = [m.start() for m in re.finditer(rb"\d", data)]
    near = [place for place in places if place < _HEADER]
    place = rng.choice(near if near and rng.random() < _OFTEN else places)
    return data[:place] + str(rng.integers(10)).encode() + data[place + 1 :]


def _lines(change: Callable[[list[str], int, np.random.Generator], None]) -> Mangle:
    """Return a way that changes the list of lines at a random one."""

    def way(data: bytes, rng: np.random.Generator) -> bytes:
        lines = data.decode().splitlines(keepends=True)
        near = data[:_HEADER].count(b"\n") + 1
        line = rng.integers(min(near, len(lines)) if rng.random() < _OFTEN else len(lines))
        change(lines, int(line), rng)
        return "".join(lines).encode()

    return way


def _delete(lines: list[str], line: int, rng: np.random.Generator) -> None:
    del lines[line]


def _double(lines: list[str], line: int, rng: np.random.Generator) -> None:
    lines.insert(line, lines[line])


def _swap(lines: list[str], line: int, rng: np.random.Generator) -> None:
    other = int(rng.choice([min(line + 1, len(lines) - 1), rng.integers(len(lines))]))
    lines[line], lines[other] = lines[other], lines[line]


def _swap_cells(lines: list[str], line: int, rng: np.random.Generator) -> None:
    count = len(_CELL.findall(lines[line]))
    if count > 1:
        first, second = rng.choice(count, 2, replace=False)
        lines[line] = _swapped(lines[line], int(first), int(second))


def _swap_columns(lines: list[str], line: int, rng: np.random.Generator) -> None:
    counts = [len(_CELL.findall(text)) for text in lines]
    usual = Counter(counts).most_common(1)[0][0]
    if usual < 4:
        return
    first, second = rng.choice(usual, 2, replace=False)
    for i, count in enumerate(counts):
        if count == usual:
            lines[i] = _swapped(lines[i], int(first), int(second))


def _swapped(line: str, first: int, second: int) -> str:
    """Return a line of which two cells have changed places."""
    cells = list(_CELL.finditer(line))
    a, b = cells[min(first, second)], cells[max(first, second)]
    return line[: a.start()] + b[0] + line[a.end() : b.start()] + a[0] + line[b.end() :]


def _line_ends(data: bytes, rng: np.random.Generator) -> bytes:
    return data.replace(b"\n", [b"\r\n", b"\r", b"\n\n", b" \n"][rng.integers(4)])


def _encoding(data: bytes, rng: np.random.Generator) -> bytes:
    if rng.random() < 0.5:
        letter = rng.choice(["\u00b5", "\u00e9", "\u00a0"]).encode("latin-1")
        place = _place(len(data), rng)
        return data[:place] + letter + data[place:]
    return data.decode().encode(str(rng.choice(["utf-16", "utf-16-be", "utf-8-sig", "utf-32"])))


# Kinds, which are equally frequent, and the ways of each.
_OF_ALL: dict[str, dict[str, Mangle]] = {
    "end": {"cut": _cut},
    "bytes": {"changed bytes": _changed_bytes},
    "zeros": {"zeros": _zeros},
}
_OF_BLOCKS: dict[str, dict[str, Mangle]] = {
    "blocks": {
        "lost block": _lost_block,
        "doubled block": _doubled_block,
        "swapped blocks": _swapped_blocks,
    }
}
_OF_TEXT: dict[str, dict[str, Mangle]] = {
    "digits": {"digit": _digit},
    "lines": {
        "deleted line": _lines(_delete),
        "doubled line": _lines(_double),
        "swapped lines": _lines(_swap),
    },
    "cells": {"swapped cells": _lines(_swap_cells), _OF_TABLES: _lines(_swap_columns)},
    "line ends": {"line ends": _line_ends},
    "encoding": {"encoding": _encoding},
}
