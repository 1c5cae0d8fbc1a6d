"""Values of named options, in a module that is fast to import."""

from __future__ import annotations

from typing import Literal

__all__ = ["TWO_ARM", "Arms", "BackendName", "ContextSignal", "EfferenceCopy", "Models", "RuleName"]

Arms = Literal["physics", "kinematic"]
RuleName = Literal["weighted", "gated"]
BackendName = Literal["processes", "ray"]
Models = Literal["joint", "posture"]
EfferenceCopy = Literal["total", "module"]
ContextSignal = Literal["labels", "nothing", "constant", "shuffled", "halves"]

TWO_ARM = "two_arm"
"""Name of the package's own robot."""
