"""Spaces in which a pair of models works: what the models sense, command and predict."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.base import AgentSpec, Observation
from mpma_mj.agents.config import JOINTS, POSTURE, PairedConfig
from mpma_mj.feedback import followed
from mpma_mj.utils.clipping import clip

__all__ = ["Before", "JointSpace", "ModelSpace", "PostureSpace", "model_space", "module_action"]

Array = NDArray[np.float64]
Before = tuple[Array, Array]  # joint angles and action of the step before
Examples = tuple[Array, Array, NDArray[np.bool_]]

_IMPOSSIBLE = 0.7  # entries of a residual from which an example counts as an outlier (choice)


class ModelSpace(ABC):
    """What inverse and forward models receive and return; "..." is (), (R,) or (T,).

    Attributes:
        state_size: Length of the proprioceptive state s.
        inverse_inputs: Length of the inverse models' input.
        outputs: Length of the forward models' output.
    """

    state_size: int
    inverse_inputs: int
    outputs: int

    def __init__(self, spec: AgentSpec) -> None:
        """Keep the description of the arms."""
        self.spec = spec

    @abstractmethod
    def state(self, observation: Observation, before: Before | None) -> Array:
        """Return the proprioceptive state s, shape (..., S).

        Args:
            observation: Observation of the step.
            before: Joint angles, rad, and action of the step before, each of shape (..., 8); None
                in the first step of an episode.
        """

    @abstractmethod
    def commands(self, observation: Observation) -> tuple[Array, Array | None]:
        """Return the commands of a step that need no model.

        Returns:
            Feedback action u_fb, shape (..., 8), and the command that the inverse models' output is
            added to, shape (..., 8); None where the output is the command.
        """

    @abstractmethod
    def inverse_input(self, state: Array, target: Array, command: Array | None) -> Array:
        """Return the inverse models' input, shape (..., D).

        Args:
            state: Proprioceptive state, shape (..., S).
            target: Posture to be reached next, shape (..., 12).
            command: Command that their output is added to, shape (..., 8); None if there is none.
        """

    def forward_input(self, copy: Array, state: Array) -> Array:
        """Return the forward models' input, shape (..., D) or (..., M, D).

        Args:
            copy: Efference copy, shape (..., 8) for all modules alike or (..., M, 8).
            state: Proprioceptive state, shape (..., S).
        """
        if copy.ndim > state.ndim:
            state = np.broadcast_to(state[..., None, :], (*copy.shape[:-1], state.shape[-1]))
        return np.concatenate([copy, state], axis=-1)

    @abstractmethod
    def predicted_posture(self, outputs: Array, joint_angles: Array) -> Array:
        """Return the postures that forward models predict.

        Args:
            outputs: Outputs of the forward models, shape (..., M, K).
            joint_angles: Joint angles q from which they predict, shape (..., 8), rad.

        Returns:
            Postures, shape (..., M, 12).
        """

    @abstractmethod
    def outcome(self, before: Array, after: Array, posture: Array) -> Array:
        """Return what forward models should have predicted.

        Args:
            before: Joint angles q_t, shape (..., 8), rad.
            after: Joint angles q_{t+1}, shape (..., 8), rad.
            posture: Posture x_{t+1}, shape (..., 12).

        Returns:
            Target, shape (..., K).
        """

    def hindsight(self, steps: Observation, *, by_angles: bool) -> Examples | None:
        """Return exact examples of the inverse: what was reached is taken for the target.

        Args:
            steps: Steps of an episode, by name: `state`, `joint_angles`, `action`, `next_posture`
                and `next_joint_angles`, each of shape (T, ...).
            by_angles: Whether joint angles are followed, not postures.

        Returns:
            Inputs of the inverse models, shape (T, D); their targets u - u_fb(q_t, x_{t+1}), shape
            (T, 8); and which examples can be learned from, shape (T,). None where inverse models
            learn from the epoch itself.
        """
        return None


class PostureSpace(ModelSpace):
    """Models of the paper: from postures to commands, from commands to postures.

        inverse  [x ; sin q ; cos q ; x'_{t+1}] → u
        forward  [u ; x ; sin q ; cos q] → x̂_{t+1}

    The joint angles are ours; see `PairedConfig.proprioception`.
    """

    outputs = POSTURE

    def __init__(self, spec: AgentSpec, *, proprioception: bool) -> None:
        """Choose what models receive.

        Args:
            spec: Description of the arms.
            proprioception: Whether models receive the joint angles, too.
        """
        super().__init__(spec)
        self._proprioception = proprioception
        self.state_size = POSTURE + (2 * JOINTS if proprioception else 0)
        self.inverse_inputs = self.state_size + POSTURE

    def state(self, observation: Observation, before: Before | None) -> Array:
        """Return the posture and, if configured, sine and cosine of the joint angles."""
        if not self._proprioception:
            return observation["posture"]
        angles = observation["joint_angles"]
        return np.concatenate([observation["posture"], np.sin(angles), np.cos(angles)], axis=-1)

    def commands(self, observation: Observation) -> tuple[Array, Array | None]:
        """Return the feedback action; the inverse models' output is the command."""
        reference = followed(observation, "reference")
        return self.spec.feedback(observation["joint_angles"], reference), None

    def inverse_input(self, state: Array, target: Array, command: Array | None) -> Array:
        """Return state and target."""
        return np.concatenate([state, target], axis=-1)

    def predicted_posture(self, outputs: Array, joint_angles: Array) -> Array:
        """Return the outputs."""
        return outputs

    def outcome(self, before: Array, after: Array, posture: Array) -> Array:
        """Return the posture that was reached."""
        return posture


class JointSpace(ModelSpace):
    """Models in joint space: from moves to residual commands, from commands to moves (ours).

        m_t = u_fb(q_t, x'_{t+1})                            resolved-rate command
        s_t = [x_t ; sin q_t ; cos q_t ; q̇_t / v]            proprioceptive state
        inverse  [s_t ; x'_{t+1} ; m_t] → residual on m_t
        forward  [u_t ; s_t] → move,  q̂_{t+1} = q_t + Δt v move

    A plant is nearly linear in these, so that linear readouts distinguish plants; and a large ridge
    leads back to m, not to 0.
    """

    outputs = JOINTS

    def __init__(self, spec: AgentSpec, *, history: bool = False) -> None:
        """Choose what models receive.

        Args:
            spec: Description of the arms.
            history: Whether the state contains the last move and the last action, too.
        """
        super().__init__(spec)
        self._history = history
        self.state_size = POSTURE + (5 if history else 3) * JOINTS
        self.inverse_inputs = self.state_size + POSTURE + JOINTS

    def state(self, observation: Observation, before: Before | None) -> Array:
        """Return posture, sine and cosine of the joint angles, and their relative velocities."""
        angles = observation["joint_angles"]
        relative = observation["joint_velocities"] / self.spec.max_joint_speed
        parts = [observation["posture"], np.sin(angles), np.cos(angles), relative]
        if self._history and before is None:
            parts += [np.zeros_like(angles)] * 2
        elif self._history and before is not None:
            parts += [self.spec.move(before[0], angles), before[1]]
        return np.concatenate(parts, axis=-1)

    def commands(self, observation: Observation) -> tuple[Array, Array]:
        """Return feedback action and resolved-rate command, which are computed together."""
        angles = observation["joint_angles"]
        shown = np.array([followed(observation, "reference"), followed(observation, "target")])
        feedback, command = self.spec.feedback(np.array([angles, angles]), shown)
        return feedback, command

    def inverse_input(self, state: Array, target: Array, command: Array | None) -> Array:
        """Return state, target and resolved-rate command."""
        assert command is not None
        return np.concatenate([state, target, command], axis=-1)

    def predicted_posture(self, outputs: Array, joint_angles: Array) -> Array:
        """Return the postures of the joint angles after the predicted moves."""
        angles = joint_angles[..., None, :] + self.spec.control_timestep * (
            self.spec.max_joint_speed * outputs
        )
        return self.spec.kinematics.posture(angles)

    def outcome(self, before: Array, after: Array, posture: Array) -> Array:
        """Return the move, [q_{t+1} - q_t] / (Δt v)."""
        return self.spec.move(before, after)

    def hindsight(self, steps: Observation, *, by_angles: bool) -> Examples:
        """Return examples of residual commands; see `ModelSpace`."""
        reached = steps["next_joint_angles" if by_angles else "next_posture"]
        command = self.spec.feedback(steps["joint_angles"], reached)
        inputs = self.inverse_input(steps["state"], steps["next_posture"], command)
        residual = steps["action"] - command
        return inputs, residual, np.abs(residual).max(axis=1) < _IMPOSSIBLE


def module_action(outputs: Array, command: Array | None) -> Array:
    """Return the actions u^i of inverse models, shape (..., M, 8).

    Args:
        outputs: Outputs of the inverse models, shape (..., M, 8).
        command: Command that they are added to, shape (..., 8); None if there is none.
    """
    action = clip(outputs)
    return action if command is None else clip(command[..., None, :] + action)


def model_space(config: PairedConfig, spec: AgentSpec) -> ModelSpace:
    """Return the space in which an agent's models work."""
    if config.models == "joint":
        return JointSpace(spec, history=config.history)
    return PostureSpace(spec, proprioception=config.proprioception)
