"""Names that options may take; apart from all else so that they cost nothing to import."""

from __future__ import annotations

from typing import Literal

__all__ = ["Arms", "BackendName", "ContextSignal", "EfferenceCopy", "RuleName"]

Arms = Literal["physics", "kinematic"]
RuleName = Literal["weighted", "gated"]
BackendName = Literal["processes", "ray"]
EfferenceCopy = Literal["total", "module"]
ContextSignal = Literal["labels", "nothing", "constant", "shuffled", "halves"]
