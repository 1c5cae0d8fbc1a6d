"""Agents that have learned, apart from where they did."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.base import Agent
from mpma_mj.envs.vector_env import VectorImitationEnv
from mpma_mj.errors import CheckpointError
from mpma_mj.motions import Motion
from mpma_mj.training.config import RunConfig
from mpma_mj.training.demonstration_check import demonstrated
from mpma_mj.training.factory import agent_of
from mpma_mj.training.run_folder import RunFolder

__all__ = ["TrainedAgents", "load_state"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class TrainedAgents:
    """Agents side by side as they were in their best epochs.

    Attributes:
        configs: Settings of the R runs, which differ in their seeds only.
        motion: What they have learned to imitate.
        state: What each has learned, arrays by name, shape (R, ...).
        epochs: Number of the best epoch of each, from 1, shape (R,).
        source: Folder from which they were read; None where they were trained here.
    """

    configs: tuple[RunConfig, ...]
    motion: Motion
    state: dict[str, Array]
    epochs: NDArray[np.int_]
    source: Path | None = None

    @property
    def seeds(self) -> list[int]:
        """Seed of each run."""
        return [config.seed for config in self.configs]

    @classmethod
    def of_run(cls, folder: RunFolder) -> TrainedAgents:
        """Return the agent of a run's kept epoch, as one side by side with none.

        Raises:
            MpmaError: There is no run, it is damaged, or its movement is not the one it danced.
        """
        config = folder.read_config()
        state, epoch = folder.read_best(config)
        demonstration, _ = demonstrated(folder)
        return cls(
            configs=(config,),
            motion=demonstration.motion,
            state={name: array[None] for name, array in state.items()},
            epochs=np.array([epoch]),
            source=folder.path,
        )

    def agent(self, envs: VectorImitationEnv) -> Agent:
        """Return the agents for R environments.

        Raises:
            CheckpointError: What was learned does not fit the settings.
        """
        agent = agent_of(self.configs[0], envs, self.seeds)
        load_state(agent, self.state, self.source)
        return agent


def load_state(agent: Agent, state: Mapping[str, Array], source: Path | None) -> None:
    """Give an agent what another has learned.

    Args:
        agent: The agent.
        state: What the other's `state_dict` returned.
        source: Folder from which it was read, for errors; None where it was not read.

    Raises:
        CheckpointError: It is not of such an agent.
    """
    try:
        agent.load_state_dict(state)
    except KeyError as error:
        lack = f"lacks {error.args[0]}"
    except ValueError:
        lack = "does not fit its settings"
    else:
        return
    raise CheckpointError(f"{source or 'trained agent'}: the checkpoint {lack}; train anew")
