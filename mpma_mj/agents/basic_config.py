"""Configs of agents without networks, and the base of all configs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from mpma_mj.utils.validation import Bounds, check_fields

__all__ = [
    "EXPERT_EPOCHS",
    "AgentConfig",
    "BCConfig",
    "DAggerConfig",
    "DMPConfig",
    "FeedbackOnlyConfig",
    "OpenLoopConfig",
    "ProMPConfig",
    "RandomConfig",
    "ResolvedRateConfig",
]

EXPERT_EPOCHS = 3
"""Epochs in which the expert of `bc` and `dagger` learns: a default MPMA converges in them."""


@dataclass(frozen=True, kw_only=True)
class AgentConfig:
    """Config of an agent that has nothing to set; base of all others."""

    def __post_init__(self) -> None:
        """Check the fields against their bounds.

        Raises:
            BadOptionError: A value is of another type, or out of bounds.
        """
        check_fields(self)

    @property
    def least_epochs(self) -> int:
        """Number of epochs before which a run has no result."""
        return 1

    @property
    def compensates_latency(self) -> bool:
        """Whether the agent can use the commands that are under way."""
        return False


@dataclass(frozen=True, kw_only=True)
class RandomConfig(AgentConfig):
    """Config of random actions, which have nothing to set."""


@dataclass(frozen=True, kw_only=True)
class OpenLoopConfig(AgentConfig):
    """Config of the open loop, which has nothing to set."""


@dataclass(frozen=True, kw_only=True)
class FeedbackOnlyConfig(AgentConfig):
    """Config of the feedback controller, which has nothing to set."""


@dataclass(frozen=True, kw_only=True)
class ResolvedRateConfig(AgentConfig):
    """Config of the resolved-rate controller, which has nothing to set."""


@dataclass(frozen=True, kw_only=True)
class BCConfig(AgentConfig):
    """Config of behaviour cloning.

    Attributes:
        expert_episodes: Episodes of the expert from which the policy learns, after the 3 epochs in
            which the expert itself learns; the policy acts in the epochs after these.
    """

    expert_episodes: Annotated[int, Bounds(1, 1000)] = 20

    @property
    def least_epochs(self) -> int:
        """Number of epochs with the first in which the policy acts alone."""
        return EXPERT_EPOCHS + self.expert_episodes + 1


@dataclass(frozen=True, kw_only=True)
class DAggerConfig(BCConfig):
    """Config of DAgger, in which the expert only labels all episodes but the first.

    Attributes:
        expert_episodes: Episodes that the expert labels, after the 3 epochs in which it learns.
    """


@dataclass(frozen=True, kw_only=True)
class ProMPConfig(AgentConfig):
    """Config of a probabilistic movement primitive.

    Attributes:
        demonstrations: Number of demonstrations that it learns from, one in each of as many epochs;
            in the epochs after these it executes the learned movement.
    """

    demonstrations: Annotated[int, Bounds(2, 1000)] = 20

    @property
    def least_epochs(self) -> int:
        """Number of epochs with the first in which the primitive is executed."""
        return self.demonstrations + 1


@dataclass(frozen=True, kw_only=True)
class DMPConfig(ProMPConfig):
    """Config of a dynamic movement primitive.

    Attributes:
        demonstrations: Number of demonstrations that it learns from, one in each of as many epochs;
            in the epochs after these it executes the learned movement.
    """
