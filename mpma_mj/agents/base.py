"""Base class of all agents, and the signals of an episode that they record."""

from __future__ import annotations

import functools
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.config import AgentConfig
from mpma_mj.arm_kinematics import TWO_ARMS, ArmKinematics
from mpma_mj.errors import StateError
from mpma_mj.feedback import feedback_action
from mpma_mj.kinematics import wrap

if TYPE_CHECKING:
    import dm_env

__all__ = [
    "MODULE_SIGNALS",
    "Agent",
    "AgentSignals",
    "AgentSpec",
    "ModuleSignals",
    "Observation",
    "Seeds",
]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ModuleSignals:
    """Signals of M modules in the T steps of an episode.

    Attributes:
        responsibility: Responsibilities λ, shape (T, ..., M), that sum to 1.
        prior: Priors p, shape (T, ..., M); NaN of modules of plants that only other runs of a
            batch recruited.
        module_actions: Actions u^i of the inverse models, shape (T, ..., M, 8).
        predictions: Predicted next postures x̂^i, shape (T, ..., M, 12).
    """

    responsibility: Array
    prior: Array
    module_actions: Array
    predictions: Array

    def map(self, change: Callable[[Array], Array]) -> ModuleSignals:
        """Return the signals after a change of each."""
        return ModuleSignals(**{name: change(getattr(self, name)) for name in MODULE_SIGNALS})

    def present(self) -> ModuleSignals:
        """Return the signals of one run without modules of plants that only others recruited.

        These come last. A module that is switched off, or never has control, stays.
        """
        count = int(np.isfinite(self.prior[:1]).sum())
        return self.map(lambda signal: np.ascontiguousarray(signal[:, :count]))


@dataclass(frozen=True, eq=False)
class AgentSignals:
    """Signals of the T steps of an episode.

    Attributes:
        feedback: The feedback controller's part of the action, K u_fb, shape (T, ..., 8); None
            where there is none.
        learned: What learning adds to the action, shape (T, ..., 8): L Σ_i λ^i (u^i - m) with the
            resolved-rate command m of joint models, m = 0 of others; None where nothing is learned.
        modules: Signals of modules; None of an agent without.
    """

    feedback: Array | None = None
    learned: Array | None = None
    modules: ModuleSignals | None = None


MODULE_SIGNALS = tuple(field.name for field in fields(ModuleSignals))
"""Names of the signals of modules."""

Observation = Mapping[str, Array]
Seeds = int | Sequence[int]


@dataclass(frozen=True, eq=False)
class AgentSpec:
    """Description of arms and observations.

    Attributes:
        context_size: Size of the observation's context, C.
        max_joint_speed: Joint speeds that action 1 commands, shape (8,), rad/s.
        control_timestep: Time between two actions, s.
        latency: Control steps from an action to its effect; None where it is drawn from a range
            and unknown.
        longest_latency: Largest latency, control steps.
        lookahead: Number of targets in the observation `lookahead`; 0 where there is none.
        kinematics: Kinematics of the arms.
    """

    context_size: int
    max_joint_speed: Array
    control_timestep: float
    latency: int | None = 0
    longest_latency: int = 0
    lookahead: int = 0
    kinematics: ArmKinematics = TWO_ARMS

    def feedback(self, joint_angles: Array, reference: Array) -> Array:
        """Return the feedback controller's action, u_fb, before its gain; see `feedback_action`."""
        limits = self.max_joint_speed, self.control_timestep
        return feedback_action(joint_angles, reference, *limits, self.kinematics)

    @functools.cached_property
    def largest_move(self) -> Array:
        """Largest move of the joints in a step, Δt v, shape (8,), rad."""
        return self.control_timestep * self.max_joint_speed

    def move(self, before: Array, after: Array) -> Array:
        """Return the arms' move in units of the largest, wrap(q_{t+1} - q_t) / (Δt v).

        Args:
            before: Joint angles q_t, shape (..., 8), rad.
            after: Joint angles q_{t+1}, shape (..., 8), rad.
        """
        return wrap(after - before) / self.largest_move


class Agent(ABC):
    """An agent that acts in episodes and learns between them.

    A loop calls `reset`, then `act` and `observe` in turn until the episode ends, then `learn`.
    Agents receive observations and return actions, and have no access to an environment. A
    subclass has to define `act`; one that learns, `learn` and both `state_dict` methods as well.

    One agent may stand for a batch of R independent runs: observations, actions, signals and
    state then have an axis R, and each run goes as it would alone. Below, "..." is () or (R,).

    Attributes:
        config_type: Class of the agent's config.
        trainable: Whether it learns.
        fine_tunable: Whether a trained one can learn on.
        has_modules: Whether several modules share control.
        observes_plant: Whether it receives the plant that is on, which no observation contains.
        config: Config.
        spec: Description of arms and observations.
        seed: Seed of everything random, or one for each run, shape (R,).
    """

    config_type: ClassVar[type[AgentConfig]] = AgentConfig
    trainable: bool = False
    fine_tunable: bool = False
    has_modules: bool = False
    observes_plant: bool = False

    def __init__(self, config: AgentConfig, spec: AgentSpec, *, seed: Seeds = 0) -> None:
        """Keep config, spec and seed.

        Args:
            config: Config, of the class `config_type`.
            spec: Description of arms and observations.
            seed: Seed of everything random; several are a batch of runs.
        """
        self.config, self.spec, self.seed = config, spec, seed

    def reset(self, episode: int) -> None:  # noqa: B027, a hook
        """Begin an episode; its random numbers depend on the seed and on its number alone."""

    def observe_plant(self, plant: NDArray[np.intp] | None) -> None:  # noqa: B027, a hook
        """Receive the index of the plant that is on, (...), before each action; None without."""

    @abstractmethod
    def act(self, observation: Observation) -> Array:
        """Return the action, shape (..., 8), in [-1, 1]."""

    def observe(self, timestep: dm_env.TimeStep) -> None:  # noqa: B027, a hook
        """Receive the outcome of the action."""

    def learn(self) -> dict[str, Array]:
        """Learn from the episode that ended; return values to log by name, each of shape (...)."""
        return {}

    def signals(self) -> AgentSignals:
        """Return the signals of the episode so far."""
        return AgentSignals()

    def select_runs(self, runs: NDArray[np.intp]) -> None:
        """Continue with some runs of a batch only, from the next reset.

        Args:
            runs: Their indices, shape (R',).

        Raises:
            StateError: The agent has a state for each run, and does not define this method.
        """
        if self.state_dict():
            raise StateError(
                f"{type(self).__name__} has a state for each run of a batch, and {len(runs)} of"
                " them continue; define select_runs, which selects the states of these runs"
            )

    def state_dict(self) -> dict[str, Array]:
        """Return copies of all arrays that learning changes, by name; runs are the first axis."""
        return {}

    def load_state_dict(self, state: Mapping[str, Array]) -> None:  # noqa: B027, a hook
        """Continue from the arrays that `state_dict` returned."""
