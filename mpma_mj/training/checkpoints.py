"""Trained agents, independent of the environments of their training."""

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
    """Agents of a batch of runs, in the states of their best epochs.

    Attributes:
        configs: Config of each of the R runs; they differ in their seeds only.
        motion: Motion of the training.
        state: State of the agents, arrays by name, shape (R, ...).
        epochs: Number of the best epoch of each run, from 1, shape (R,).
        source: Folder from which they were read; None if they were trained in this process.
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
        """Return the agent of a run's best epoch, as a batch of one.

        Raises:
            MpmaError: There is no run, it is damaged, or its motion is not the one of its trace.
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
            CheckpointError: The state does not fit the config.
        """
        agent = agent_of(self.configs[0], envs, self.seeds)
        load_state(agent, self.state, self.source)
        return agent


def load_state(agent: Agent, state: Mapping[str, Array], source: Path | None) -> None:
    """Load a state into an agent.

    Args:
        agent: The agent.
        state: State of an agent of the same kind, as `state_dict` returns it.
        source: Folder from which it was read, for errors; None if it was not read.

    Raises:
        CheckpointError: The state lacks an array, or has one of another shape.
    """
    try:
        agent.load_state_dict(state)
    except KeyError as error:
        problem = f"lacks {error.args[0]}"
    except ValueError:
        problem = "does not fit its config"
    else:
        return
    raise CheckpointError(
        f"{source or 'trained agent'}: the checkpoint {problem}", remedy="train again"
    )
