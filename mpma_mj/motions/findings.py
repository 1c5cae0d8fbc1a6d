"""What was found in a recording, and what was done to it."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, field
from pathlib import Path

from mpma_mj.errors import RecordingWarning

__all__ = ["Findings"]


@dataclass
class Findings:
    """Lines for whoever wants to know what became of their recording.

    Attributes:
        steps: What was found or done, in the order of doing.
        warnings: What may be wrong, each with what was used instead.
    """

    steps: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)

    def note(self, step: str) -> None:
        """Add a step."""
        self.steps.append(step)

    def warn(self, warning: str) -> None:
        """Add a warning."""
        self.warnings.append(warning)

    def tell(self, source: str | Path) -> None:
        """Let Python show the warnings, each with the file that it is about."""
        for warning in self.warnings:
            warnings.warn(f"{source}: {warning}", RecordingWarning, stacklevel=3)
