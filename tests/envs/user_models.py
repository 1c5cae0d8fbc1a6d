"""Models of users, made from the arms of the package."""

from __future__ import annotations

from pathlib import Path

from mpma_mj.robots.robot_file import read_robot

OURS = read_robot("two_arm").model.read_text(encoding="utf-8")


def edited(path: Path, *changes: tuple[str, str]) -> Path:
    """Write the package's arms with some text replaced, each once at least."""
    text = OURS
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    path.write_text(text, encoding="utf-8")
    return path
