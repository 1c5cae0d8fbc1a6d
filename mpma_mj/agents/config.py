"""Settings of the networks that agents with pairs of models have in common."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.base import Observation
from mpma_mj.errors import BadOptionError
from mpma_mj.utils.validation import is_boolean, is_integer, is_number

__all__ = ["JOINTS", "POSTURE", "NetworkConfig"]

Array = NDArray[np.float64]

JOINTS = 8
"""Length of an action."""

POSTURE = 12
"""Length of a posture."""


@dataclass(frozen=True)
class NetworkConfig:
    """Settings of the networks.

    Attributes:
        modules: Number of pairs, M.
        nodes: Neurons of each reservoir, N.
        proprioception: Whether inverse and forward models also sense the joint angles. A posture
            can be held in two ways, and what a joint velocity does depends on which: an arm
            that was raised through straight forward has turned over. False is the paper's.
        spectral_radius: Spectral radius of the reservoirs; the paper's 0.1.
        reservoir_noise: Noise level ν of the reservoirs; the paper's 0.2.
        ridge: Ridge ρ of readouts that are fitted, per step. A small one tracks best; with 0.1 or
            more the dance goes on without its demonstration, see docs/attractors.md (choice).

    Raises:
        BadOptionError: A setting is outside what it may be.
    """

    modules: int = 4
    nodes: int = 200
    proprioception: bool = True
    spectral_radius: float = 0.1
    reservoir_noise: float = 0.2
    ridge: float = 1e-4

    def __post_init__(self) -> None:
        """Check the settings; of what is true or false also a subclass's."""
        for name, most in {"modules": 1000, "nodes": 20000}.items():
            count = getattr(self, name)
            if not (is_integer(count) and 1 <= int(count) <= most):
                raise BadOptionError(f"{name} is {count!r}; expected a whole number, 1 to {most}")
        for name in ("spectral_radius", "reservoir_noise"):
            value = getattr(self, name)
            if not (is_number(value) and 0.0 <= float(value) < 1.0):
                raise BadOptionError(f"{name} is {value!r}; expected 0 or more, below 1")
        if not (is_number(self.ridge) and 0.0 < float(self.ridge) <= 1e6):
            raise BadOptionError(f"ridge is {self.ridge!r}; expected above 0, at most 1e6")
        for setting in fields(self):
            value = getattr(self, setting.name)
            if isinstance(setting.default, bool) and not is_boolean(value):
                raise BadOptionError(f"{setting.name} is {value!r}; expected True or False")

    @property
    def state_size(self) -> int:
        """Length of what `sense` returns."""
        return POSTURE + (2 * JOINTS if self.proprioception else 0)

    def proprioceptive_state(self, observation: Observation) -> Array:
        """Return what the models know of the arms: posture and, if set, joint angles."""
        if not self.proprioception:
            return observation["posture"]
        angles = observation["joint_angles"]
        return np.concatenate([observation["posture"], np.sin(angles), np.cos(angles)], axis=-1)
