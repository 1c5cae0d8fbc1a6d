"""Names of options on the command line."""

from __future__ import annotations

__all__ = ["as_flag", "option_name"]

_OTHERS = {"start": "from", "end": "to"}  # `from` is a keyword of Python


def option_name(field: str) -> str:
    """Return what the command line calls an option."""
    return _OTHERS.get(field, field.replace("_", "-"))


def as_flag(option: str, value: str | None) -> str:
    """Return an option as it is typed."""
    flag = f"--{option_name(option)}"
    return flag if value is None else f"{flag} {value}"
