"""Colours shared by all figures and videos."""

from __future__ import annotations

__all__ = ["DEMONSTRATED", "INK", "PAPER", "hex_to_rgb", "module_colours"]

PAPER, INK = "#ffffff", "#20242c"
DEMONSTRATED = "#9aa0ab"

# Palette of Okabe & Ito, distinguishable with colour vision deficiency.
_MODULES = ("#0072b2", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#d55e00", "#f0e442", "#7f7f7f")


def module_colours(modules: int) -> list[str]:
    """Return a colour for each module; colours repeat after the eighth."""
    return [_MODULES[i % len(_MODULES)] for i in range(modules)]


def hex_to_rgb(colour: str) -> tuple[int, int, int]:
    """Return the red, green and blue of "#rrggbb", each 0 to 255."""
    red, green, blue = bytes.fromhex(colour.removeprefix("#"))
    return red, green, blue
