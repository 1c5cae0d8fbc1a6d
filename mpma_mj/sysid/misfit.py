"""How far simulated arms are from a log, as the parameters are varied."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import mujoco
import numpy as np
from numpy.typing import NDArray

from mpma_mj.sysid.parameters import changed
from mpma_mj.sysid.simulate import FeatureReplay

__all__ = ["Misfit"]

Array = NDArray[np.float64]

_VELOCITY = (
    0.1  # s; weight of velocities beside angles: noise of 0.01 rad/s is as 0.001 rad (choice)
)
_STEP = 1e-4  # of a parameter's logarithm, for derivatives


class Misfit:
    """Differences between a replay and its log, over logarithms of factors on parameters."""

    def __init__(
        self,
        model: mujoco.MjModel,
        replay: FeatureReplay,
        names: Sequence[str],
        tick: Callable[[], None] = lambda: None,
    ) -> None:
        """Take what is compared.

        Args:
            model: The arms with the parameters whose factors are 1.
            replay: The windows of the log.
            names: The P parameters that are varied.
            tick: Called after each simulation of all windows.
        """
        self._model = model
        self._replay = replay
        self._names = names
        self._tick = tick

    def residual(self, logs: Array, latency: int) -> Array:
        """Return angles and weighted velocities, simulated less logged, shape (W, 2 R · 8).

        The mean over a window of each joint's angle is taken out: a velocity servo carries on what
        is wrong with the angle from which it starts, which noise makes of the log's.

        Args:
            logs: Logarithms of the factors, shape (P,).
            latency: Physics steps until a command acts.
        """
        factors = dict(zip(self._names, np.exp(logs).tolist(), strict=True))
        angle, velocity = self._replay.simulate(changed(self._model, factors), latency)
        self._tick()
        angle_there, velocity_there = self._replay.measured()
        off = angle - angle_there
        off -= off.mean(axis=1, keepdims=True)
        both = np.concatenate([off, _VELOCITY * (velocity - velocity_there)], axis=1)
        return both.reshape(len(both), -1)

    def jacobian(self, logs: Array, latency: int) -> Array:
        """Return the residual's derivatives, shape (W · 2 R · 8, P).

        Where an actuator reaches its greatest force, the simulated movement jumps: MuJoCo's
        implicit integrator leaves a saturated actuator's damping out. A difference across a jump
        is no derivative. Of the differences forwards and backwards the smaller one is taken, as
        limiters of slopes do.
        """
        here = self.residual(logs, latency)
        columns = []
        for step in _STEP * np.eye(len(logs)):
            forwards = (self.residual(logs + step, latency) - here).ravel()
            backwards = (here - self.residual(logs - step, latency)).ravel()
            smaller = np.where(np.abs(forwards) < np.abs(backwards), forwards, backwards)
            columns.append(smaller / _STEP)
        return np.stack(columns, axis=1)
