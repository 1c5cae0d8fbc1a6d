"""Traces: every signal of an episode, of one run or of a batch of runs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.base import MODULE_SIGNALS, ModuleSignals
from mpma_mj.arm_kinematics import ArmKinematics
from mpma_mj.errors import StateError
from mpma_mj.utils.saved_arrays import Expected, array_problem

__all__ = ["OBSERVED", "SIGNALS", "Trace", "trace_problem"]

Array = NDArray[np.float64]

OBSERVED = ("posture", "reference", "context", "joint_angles", "joint_velocities")
"""Names of the signals of the T + 1 moments, also in files."""

_ROUNDING = 1e-6  # far above rounding errors, far below what a picture shows

_OPTIONAL = ("feedback", "learned", "plant", "latency")

SIGNALS = (*OBSERVED, "action", "reward")
"""Names of the signals that every trace has."""

_UNIT = 1.0 + 1e-6  # with rounding errors
_IN_FILE = {
    "posture": Expected(("moments", 12), _UNIT),
    "reference": Expected(("moments", 12), _UNIT),
    "context": Expected(("moments", "labels"), _UNIT),
    "joint_angles": Expected(("moments", 8)),
    "joint_velocities": Expected(("moments", 8)),
    "action": Expected(("steps", 8), _UNIT),
    "reward": Expected(("steps",)),
    "feedback": Expected(("steps", 8)),
    "learned": Expected(("steps", 8)),
    "plant": Expected(("steps",), kinds="iu"),
    "latency": Expected(("steps",), kinds="iu"),
    "responsibility": Expected(("steps", "modules"), _UNIT),
    "prior": Expected(("steps", "modules"), _UNIT),
    "module_actions": Expected(("steps", "modules", 8)),
    "predictions": Expected(("steps", "modules", 12)),
}


def trace_problem(arrays: Mapping[str, NDArray[Any]]) -> str:
    """Return what is wrong with the signals of a run in a file, to follow its name, or ""."""
    modules = MODULE_SIGNALS if any(name in arrays for name in MODULE_SIGNALS) else ()
    optional = (name for name in _OPTIONAL if name in arrays)
    names = (*SIGNALS, *modules, *optional)
    problem = array_problem(arrays, {name: _IN_FILE[name] for name in names})
    if not problem and len(arrays["posture"]) != len(arrays["action"]) + 1:
        problem = f"has {len(arrays['action'])} steps for {len(arrays['posture'])} moments"
    return problem


@dataclass(frozen=True, eq=False, repr=False)
class Trace:
    """Signals of an episode of T steps; "…" is () for one run, (R,) for a batch of runs.

    Attributes:
        posture: True postures of the arms, without observation noise, shape (T + 1, …, 12).
        reference: Demonstrated postures, shape (T + 1, …, 12).
        context: Context, shape (T + 1, …, C).
        joint_angles: Observed joint angles, shape (T + 1, …, 8), rad.
        joint_velocities: Observed joint velocities, shape (T + 1, …, 8), rad/s.
        action: Actions, shape (T, …, 8), in [-1, 1].
        reward: Rewards, shape (T, …).
        feedback: Feedback command times its gain, shape (T, …, 8); None for an agent without
            feedback controller.
        learned: What learning adds to the action, shape (T, …, 8); None where nothing is learned.
        modules: Signals of the modules; None for an agent without modules.
        plant: Index of the plant that each action met, shape (T, …); None in an environment
            without plants.
        latency: Latency that each action met, shape (T, …), control steps; None in an environment
            where it is one number.
    """

    posture: Array
    reference: Array
    context: Array
    joint_angles: Array
    joint_velocities: Array
    action: Array
    reward: Array
    feedback: Array | None = None
    learned: Array | None = None
    modules: ModuleSignals | None = None
    plant: NDArray[np.intp] | None = None
    latency: NDArray[np.intp] | None = None

    def __repr__(self) -> str:
        """Return the size of the trace, in place of all its numbers."""
        modules = self.modules.responsibility.shape[-1] if self.modules is not None else 0
        return f"Trace({len(self)} steps, {modules} modules)"

    def __len__(self) -> int:
        """Return the number of steps, T."""
        return len(self.action)

    def true_joint_angles(self, kinematics: ArmKinematics) -> Array:
        """Return joint angles of the true postures, shape (T + 1, …, 8), rad.

        Where the observed ones have no noise, these are they.

        Args:
            kinematics: Kinematics of the arms.
        """
        observed = kinematics.posture(self.joint_angles)
        noisy = np.abs(observed - self.posture).max(axis=-1, keepdims=True) > _ROUNDING
        return np.where(
            noisy, kinematics.angles(self.posture, near=self.joint_angles), self.joint_angles
        )

    def with_modules(self) -> ModuleSignals:
        """Return the signals of the modules.

        Raises:
            StateError: The agent has no modules.
        """
        if self.modules is None:
            raise StateError("the trace is of an agent without modules")
        return self.modules

    def of_run(self, run: int) -> Trace:
        """Return the trace of one run of a batch, without modules that it does not have."""
        signals = self.to_arrays().items()
        own = {name: np.ascontiguousarray(array[:, run]) for name, array in signals}
        trace = Trace.from_arrays(own)
        return trace if trace.modules is None else replace(trace, modules=trace.modules.present())

    def cut(self, first: int, last: int) -> Trace:
        """Return the trace of the steps from one to before another."""
        signals = self.to_arrays().items()
        return Trace.from_arrays({n: a[first : last + (n in OBSERVED)] for n, a in signals})

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Return all signals by name, as they are written to files."""
        arrays = {name: getattr(self, name) for name in SIGNALS}
        if self.modules is not None:
            arrays |= vars(self.modules)
        optional = {name: getattr(self, name) for name in _OPTIONAL}
        return arrays | {name: one for name, one in optional.items() if one is not None}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, Any]) -> Trace:
        """Return the trace with signals as returned by `to_arrays`.

        Raises:
            KeyError: A signal is missing.
        """
        modules = None
        if any(name in arrays for name in MODULE_SIGNALS):
            modules = ModuleSignals(**{name: arrays[name] for name in MODULE_SIGNALS})
        signals = {name: arrays[name] for name in SIGNALS}
        optional: dict[str, Any] = {name: arrays.get(name) for name in _OPTIONAL}
        return cls(**signals, **optional, modules=modules)
