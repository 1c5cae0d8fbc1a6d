"""Continuation after a command that was killed: the same again, or what its message names."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from benchmarks.campaign.children import Ended, command, in_fork

__all__ = ["go_on"]

_ATTEMPTS = 4


def go_on(words: Sequence[str], folder: Path, seconds: float = 60.0) -> list[Ended]:
    """Repeat a command until it succeeds, as its messages say; return how each attempt ended.

    Args:
        words: Words of the command that was killed.
        folder: Where it was started.
        seconds: For each attempt.
    """
    now, ended = list(words), []
    for _ in range(_ATTEMPTS):
        ended.append(in_fork(lambda words=now: command(words), folder, seconds))
        if ended[-1].code == 0 or not ended[-1].is_refusal:
            break
        following = _following(words, now, ended[-1].last_line)
        if following is None or following == now:
            break
        now = following
    return ended


def _following(words: Sequence[str], refused: Sequence[str], message: str) -> list[str] | None:
    """Return the command that a message suggests, None if it suggests none."""
    if "--resume" in message and "--resume" not in refused:
        return ["imitate", "--resume", words[words.index("--out") + 1], "--no-video"]
    if "--overwrite" in message and "--overwrite" not in refused and "--resume" not in words:
        return [*words, "--overwrite"]
    return None
