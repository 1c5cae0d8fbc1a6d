"""What was found in a recording, and what was done to it."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, field
from pathlib import Path

from mpma_mj.errors import RecordingWarning

__all__ = ["ImportReport"]


@dataclass
class ImportReport:
    """Lines for whoever wants to know what became of their recording.

    Attributes:
        steps: What was found or done, in the order of doing.
        doubts: What may be wrong, each with what was used instead.
    """

    steps: list[str] = field(default_factory=list)
    doubts: list[RecordingWarning] = field(default_factory=list)

    @property
    def warnings(self) -> list[str]:
        """What may be wrong, as text for users of Python."""
        return [str(doubt) for doubt in self.doubts]

    def note(self, step: str) -> None:
        """Add a step."""
        self.steps.append(step)

    def warn(self, warning: str, *, remedy: str = "") -> None:
        """Add a warning.

        Args:
            warning: What may be wrong, and what was used instead.
            remedy: How to mend it; `{name}` and `{name=value}` stand for options.
        """
        self.doubts.append(RecordingWarning(warning, remedy=remedy))

    def tell(self, source: str | Path) -> None:
        """Let Python show the warnings, each with the file that it is about."""
        for doubt in self.doubts:
            warnings.warn(doubt.with_context(source), stacklevel=3)
