"""Trained agents and demonstrations of saved runs, independent of their training."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.base import Agent
from mpma_mj.envs.demonstration import Demonstration
from mpma_mj.envs.load import arm_limits, check_same_robot
from mpma_mj.envs.vector_env import VectorImitationEnv
from mpma_mj.errors import CheckpointError, RunFolderError, placeholder
from mpma_mj.metrics import posture_error_percent
from mpma_mj.motions import Motion
from mpma_mj.trace import Trace
from mpma_mj.training.config import RunConfig
from mpma_mj.training.factory import agent_of
from mpma_mj.training.run_folder import RunFolder
from mpma_mj.utils.data_files import TRAIN_AGAIN
from mpma_mj.utils.text import shell_word

__all__ = ["TrainedAgents", "demonstrated", "load_state", "read_module_trace"]

Array = NDArray[np.float64]

# Largest difference of a demonstration without noise, percent; other motions differ by ten times
# as much (choice).
_TOLERANCE = 1.0


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
        state, row = folder.read_best(config)
        demonstration, _ = demonstrated(folder)
        state = {name: array[None] for name, array in state.items()}
        return cls(
            (config,), demonstration.motion, state, np.array([int(row["epoch"])]), folder.path
        )

    def agent(self, envs: VectorImitationEnv) -> Agent:
        """Return the agents for R environments.

        Raises:
            CheckpointError: The state does not fit the config.
        """
        agent = agent_of(self.configs[0], envs, self.seeds)
        source = None if self.source is None else RunFolder(self.source).checkpoint("best")
        return load_state(agent, self.state, source)


def load_state(agent: Agent, state: Mapping[str, Array], source: Path | None) -> Agent:
    """Load a state into an agent, and return the agent.

    Args:
        agent: The agent.
        state: State of an agent of the same kind, as `state_dict` returns it.
        source: File from which it was read, for errors; None if it was not read.

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
        return agent
    raise CheckpointError(f"{source or 'trained agent'}: {problem}", remedy=TRAIN_AGAIN)


def demonstrated(folder: RunFolder) -> tuple[Demonstration, Trace]:
    """Return the demonstration of a run, and the trace of its best epoch.

    Raises:
        RunFolderError: There is no run.
        CheckpointError: The folder is damaged, or its motion is not the one of the trace.
        BadOptionError: The robot has changed.
    """
    config, trace, motion = folder.read_config(), folder.read_trace(), folder.read_motion()
    options = dataclasses.replace(config.env, reference_noise=0.0)
    limits = arm_limits(config.env)
    check_same_robot(motion.angles_of, limits.kinematics.name, of_run=True)
    demonstration = Demonstration(motion, options, limits.max_speed, limits.kinematics)
    moments, expected = len(trace.posture), demonstration.steps + 1
    if moments != expected:
        raise CheckpointError(
            f"{folder.path / 'trace.npz'}: has {moments} moments, but {motion.name} repeated"
            f" {config.env.repeats} times has {expected}",
            remedy=TRAIN_AGAIN,
        )
    reference = demonstration.episode(0, 0).reference[:expected]
    difference = posture_error_percent(trace.reference, reference)
    same_context = np.array_equal(trace.context, demonstration.context)
    largest = np.max(config.env.reference_noise)
    if not same_context or difference > 100.0 * largest + _TOLERANCE:
        raise CheckpointError(
            f"{folder.path / 'checkpoint' / 'motion.npz'}: {motion.name} is not the motion of"
            " trace.npz",
            remedy=f"restore the motion of the run, or {TRAIN_AGAIN}",
        )
    return demonstration, trace


def read_module_trace(folder: RunFolder) -> tuple[Demonstration, Trace]:
    """Return the demonstration of a run, and the trace of its best epoch with motor output.

    Raises:
        RunFolderError: There is no run, or its modules have no output yet.
        CheckpointError: The run is damaged, or has no modules.
    """
    demonstration, trace = demonstrated(folder)
    if trace.modules is None:
        raise CheckpointError(f"{folder.path}: its agent has no modules; choose a run of MPMA")
    if not np.any(trace.modules.module_actions):
        raise RunFolderError(
            f"{folder.path}: its modules have no output in the best epoch",
            remedy=f"continue with mpma imitate {placeholder('resume', shell_word(folder.path))}",
        )
    return demonstration, trace
