"""What a log tells about the arms' model, from the log to the result."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpma_mj.envs.model_validation import check_geometry
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.envs.physics import PhysicsArms
from mpma_mj.kinematics import JOINT_NAMES
from mpma_mj.sysid.check import check_log
from mpma_mj.sysid.fit import FARTHEST, fit
from mpma_mj.sysid.latency import latency_interval
from mpma_mj.sysid.log import RobotLog
from mpma_mj.sysid.misfit import Misfit
from mpma_mj.sysid.parameters import UNITS, changed, values
from mpma_mj.sysid.simulate import FeatureReplay, threads
from mpma_mj.sysid.uncertainty import evidence
from mpma_mj.utils.atomic_files import FORMAT

__all__ = [
    "DETERMINED",
    "LONGEST",
    "REFERENCE",
    "SHOWN_WINDOW",
    "Estimate",
    "Identified",
    "Latency",
    "identify",
]

Array = NDArray[np.float64]

LONGEST = 0.3
"""Longest latency that is looked for, s (choice)."""
DETERMINED = 0.2
"""A parameter is determined if its 95 % interval is no wider than ± this part of it (choice)."""
REFERENCE = "forearm_mass"
"""The parameter over which ratios are: a forearm can be weighed."""

_WINDOW = 0.25  # s; of the fit (choice: where actuators saturate, longer ones go astray)
_FEWEST_ROWS = 3  # of such a window
_COARSE = 60  # windows of the search, and of other latencies (choice)
SHOWN_WINDOW = 1.0
"""Length of the windows over which errors are told, s (choice)."""


@dataclass(frozen=True, eq=False)
class Estimate:
    """What was found for a parameter.

    Attributes:
        name: The parameter.
        model: Its values in the model, one for each joint, or one mass.
        factor: What they have to be multiplied by.
        half_width: Half width of the factor's 95 % interval, as a logarithm.
        ratio_half_width: The same of the factor over that of `REFERENCE`.
    """

    name: str
    model: Array
    factor: float
    half_width: float
    ratio_half_width: float

    @property
    def interval(self) -> tuple[float, float]:
        """Least and greatest factor of the 95 % interval."""
        with np.errstate(over="ignore"):  # where the log says nothing
            low, high = self.factor * np.exp([-self.half_width, self.half_width])
        return float(low), float(high)

    @property
    def determined(self) -> bool:
        """Whether the log determines it."""
        return self.half_width <= math.log1p(DETERMINED) and not self.at_bound

    @property
    def ratio_determined(self) -> bool:
        """Whether the log determines at least its ratio to `REFERENCE`."""
        within = self.ratio_half_width <= math.log1p(DETERMINED)
        return self.name != REFERENCE and within and not self.at_bound

    @property
    def at_bound(self) -> bool:
        """Whether it is as far from the model as is looked."""
        return abs(math.log(self.factor)) > 0.99 * FARTHEST


@dataclass(frozen=True)
class Latency:
    """How late commands act.

    Attributes:
        steps: Physics steps.
        low: Least number of steps that fits as well.
        high: Greatest number of steps that fits as well.
        timestep: Length of a physics step, s.
        per_row: Physics steps from row to row of the log, which is a control step.
    """

    steps: int
    low: int
    high: int
    timestep: float
    per_row: int

    @property
    def interval(self) -> tuple[float, float]:
        """What may be the latency, physics steps: half a step more than what fits as well."""
        return max(0.0, self.low - 0.5), self.high + 0.5

    @property
    def seconds(self) -> float:
        """The latency, s."""
        return self.steps * self.timestep

    @property
    def control_steps(self) -> int:
        """The nearest whole number of control steps, as the environment's `latency` takes it."""
        return round(self.steps / self.per_row)

    @property
    def is_integer(self) -> bool:
        """Whether it is a whole number of control steps."""
        return self.steps == self.control_steps * self.per_row


@dataclass(frozen=True, eq=False)
class Identified:
    """What was found.

    Attributes:
        estimates: The parameters that the model has.
        missing: Those that are 0 in the model, which no factor changes.
        latency: How late commands act.
        times: Times that are compared, shape (W, R), s: R of each of W windows of a second.
        logged: Joint angles in the log, shape (W, R, 8), rad.
        before: The same of arms simulated with the model's own parameters and no latency.
        after: The same with what was found.
    """

    estimates: tuple[Estimate, ...]
    missing: tuple[str, ...]
    latency: Latency
    times: Array
    logged: Array
    before: Array
    after: Array

    @property
    def factors(self) -> dict[str, float]:
        """Factor on each parameter."""
        return {one.name: one.factor for one in self.estimates}

    @property
    def scale_is_open(self) -> bool:
        """Whether there are parameters of which only the ratios are determined."""
        return any(one.ratio_determined and not one.determined for one in self.estimates)

    def rms(self, simulated: Array) -> Array:
        """Return the root mean square error of each joint's angle, shape (8,), rad."""
        return np.sqrt(((simulated - self.logged) ** 2).mean(axis=(0, 1)))

    def rms_of_all(self, simulated: Array) -> float:
        """Return the root mean square error of all angles, rad."""
        return float(np.sqrt((self.rms(simulated) ** 2).mean()))

    def as_json(self) -> dict[str, Any]:
        """Return what is written to `identified.json`."""
        parameters = {
            one.name: {
                "unit": UNITS[one.name],
                "model": one.model.tolist(),
                "found": (one.factor * one.model).tolist(),
                "factor": one.factor,
                "interval": list(one.interval),
                "determined": one.determined,
                "ratio_determined": one.ratio_determined,
            }
            for one in self.estimates
        }
        late = self.latency
        return {
            "format": FORMAT,
            "parameters": parameters,
            "zero_in_the_model": list(self.missing),
            "latency": {
                "seconds": late.seconds,
                "interval": [steps * late.timestep for steps in late.interval],
                "control_steps": late.control_steps,
            },
            "rms_before": dict(zip(JOINT_NAMES, self.rms(self.before).tolist(), strict=True)),
            "rms_after": dict(zip(JOINT_NAMES, self.rms(self.after).tolist(), strict=True)),
        }


def identify(
    log: RobotLog,
    *,
    model: str | Path | None = None,
    gravity_compensation: bool = False,
    tick: Callable[[], None] = lambda: None,
) -> Identified:
    """Find the parameters with which simulated arms do what a log shows.

    Where the log does not show their common scale, `REFERENCE` is left as in the model.

    Args:
        log: Commands and what arms did.
        model: MJCF file of arms of one's own; the package's if not given.
        gravity_compensation: Whether the arms' weight is carried for them.
        tick: Called after each simulation of the log.

    Raises:
        BadOptionError: The model cannot be read, or lacks something.
        RobotLogError: The log does not show what is to be found out.
        DivergedError: A simulation ran away.
    """
    options = EnvironmentOptions(model=model, gravity_compensation=gravity_compensation)
    physics = PhysicsArms.make(options)
    if model is not None:
        check_geometry(Path(model), physics)
    arms = physics.model.ptr
    steps = check_log(log, arms)
    longest = round(LONGEST / arms.opt.timestep)
    first = -(-longest // steps)
    own = values(arms)
    names = [name for name in UNITS if own[name].any()]
    with threads() as pool:

        def replay(length: int, most: int | None = None) -> FeatureReplay:
            begins = np.arange(first, len(log) - length, length)
            stride = 1 if most is None else max(1, len(begins) // most)
            return FeatureReplay(pool, arms, log, begins[::stride], length=length, steps=steps)

        length = max(_FEWEST_ROWS, round(_WINDOW / log.period))
        fine = Misfit(arms, replay(length), names, tick)
        coarse = Misfit(arms, replay(length, _COARSE), names, tick)
        found = fit(coarse, fine, len(names), longest)
        said = evidence(fine, found.logs, found.latency, found.scale)
        low, high = latency_interval(coarse, found, longest)
        reference, logs, widths = names.index(REFERENCE), found.logs, said.half_widths()
        if widths[reference] > math.log1p(DETERMINED):  # a common factor moves nothing
            logs = logs - logs[reference]
        factors = dict(zip(names, np.exp(logs).tolist(), strict=True))
        shown = replay(max(1, round(SHOWN_WINDOW / log.period)))
        before, _ = shown.simulate(arms, 0)
        after, _ = shown.simulate(changed(arms, factors), found.latency)
    return Identified(
        tuple(
            Estimate(name, own[name], factors[name], alone, ratio)
            for name, alone, ratio in zip(
                names,
                widths.tolist(),
                said.half_widths_over(reference).tolist(),
                strict=True,
            )
        ),
        tuple(name for name in UNITS if name not in names),
        Latency(found.latency, low, high, float(arms.opt.timestep), steps),
        log.time[shown.rows],
        log.angle[shown.rows],
        before,
        after,
    )
