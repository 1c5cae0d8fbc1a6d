"""Result of an identification, as data, JSON and a Markdown table."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpma_mj.kinematics import JOINT_NAMES
from mpma_mj.sysid.parameters import LATENCY, REFERENCE, UNITS
from mpma_mj.utils.data_files import FORMAT
from mpma_mj.utils.text import markdown_table

__all__ = [
    "FARTHEST",
    "LONGEST",
    "SHOWN_WINDOW",
    "Estimate",
    "Identified",
    "Latency",
    "as_markdown",
    "is_determined",
]

Array = NDArray[np.float64]

FARTHEST = 4.0
"""Greatest factor on a parameter, and inverse of the least (choice)."""
LONGEST = 0.3
"""Longest latency, s (choice)."""
SHOWN_WINDOW = 1.0
"""Length of the windows over which errors are reported, s (choice)."""

_DETERMINED = 0.2  # half width of the 95 % interval, as a part of the parameter (choice)
_EDGE = 0.99  # part of the range of a search from which on its end is meant
_WIDEST = math.log(10.0)  # half width of an interval that is still shown
_TITLES = ("parameter", "unit", "in the model", "found", "95 % interval", "remark")


def is_determined(half_width: float) -> bool:
    """Return whether a parameter with this half width of its interval is determined."""
    return half_width <= math.log1p(_DETERMINED)


@dataclass(frozen=True, eq=False)
class Estimate:
    """Estimate of a parameter.

    Attributes:
        name: The parameter.
        model: Its values in the model, one for each joint, or one mass.
        factor: Factor on these.
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
        with np.errstate(over="ignore"):  # where the log contains no information
            low, high = self.factor * np.exp([-self.half_width, self.half_width])
        return float(low), float(high)

    @property
    def at_bound(self) -> bool:
        """Whether the search ended at its bound."""
        return abs(math.log(self.factor)) > _EDGE * math.log(FARTHEST)

    @property
    def determined(self) -> bool:
        """Whether the log determines the parameter."""
        return is_determined(self.half_width) and not self.at_bound

    @property
    def ratio_determined(self) -> bool:
        """Whether the log determines at least its ratio to `REFERENCE`."""
        found = is_determined(self.ratio_half_width) and not self.at_bound
        return found and self.name != REFERENCE

    def as_json(self) -> dict[str, Any]:
        """Return the parameter's part of `identified.json`."""
        return {
            "unit": UNITS[self.name],
            "model": self.model.tolist(),
            "found": (self.factor * self.model).tolist(),
            "factor": self.factor,
            "interval": list(self.interval),
            "determined": self.determined,
            "ratio_determined": self.ratio_determined,
        }


@dataclass(frozen=True)
class Latency:
    """Estimate of the time from a command to its effect.

    Attributes:
        seconds: The latency, s.
        half_width: Half width of its 95 % interval, s; at least half a physics step.
        control_step: Time from row to row of the log, s.
    """

    seconds: float
    half_width: float
    control_step: float

    @property
    def interval(self) -> tuple[float, float]:
        """95 % interval, s."""
        return max(0.0, self.seconds - self.half_width), self.seconds + self.half_width

    @property
    def control_steps(self) -> int:
        """The nearest whole number of control steps, as the environment's `latency` takes it."""
        return round(self.seconds / self.control_step)

    @property
    def is_integer(self) -> bool:
        """Whether it may be a whole number of control steps."""
        return abs(self.control_steps * self.control_step - self.seconds) <= self.half_width


@dataclass(frozen=True, eq=False)
class Identified:
    """Result of an identification.

    Attributes:
        estimates: Estimates of the parameters that the model has.
        missing: Parameters that are 0 in the model, which no factor changes.
        latency: Estimate of the latency.
        times: Times that are compared, shape (W, R), s: R of each of W windows.
        logged: Joint angles in the log, shape (W, R, 8), rad.
        before: The same, simulated with the model's own parameters and no latency.
        after: The same, simulated with the estimates.
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
        """Whether only ratios of some parameters are determined."""
        return any(one.ratio_determined and not one.determined for one in self.estimates)

    def rms(self, simulated: Array) -> Array:
        """Return the root mean square error of each joint's angle, shape (8,), rad."""
        return np.sqrt(((simulated - self.logged) ** 2).mean(axis=(0, 1)))

    def rms_of_all(self, simulated: Array) -> float:
        """Return the root mean square error of all angles, rad."""
        return float(np.sqrt((self.rms(simulated) ** 2).mean()))

    def as_json(self) -> dict[str, Any]:
        """Return the content of `identified.json`."""
        before, after = (
            dict(zip(JOINT_NAMES, self.rms(simulated).tolist(), strict=True))
            for simulated in (self.before, self.after)
        )
        return {
            "format": FORMAT,
            "parameters": {one.name: one.as_json() for one in self.estimates},
            "zero_in_the_model": list(self.missing),
            "latency": {
                "seconds": self.latency.seconds,
                "interval": list(self.latency.interval),
                "control_steps": self.latency.control_steps,
            },
            "rms_before": before,
            "rms_after": after,
        }


def as_markdown(found: Identified) -> str:
    """Return a table of the estimates, and sentences about them."""
    rows = [*(_row(one, found) for one in found.estimates), _latency_row(found.latency)]
    before, after = (np.degrees(found.rms_of_all(s)) for s in (found.before, found.after))
    sentences = [
        f"RMS error of the angles over windows of {SHOWN_WINDOW:g} s: {before:.3g}° before,"
        f" {after:.3g}° with what was found."
    ]
    if found.scale_is_open:
        sentences.append(
            f"Ratios to {REFERENCE} are determined, their common scale is not, and is as in the"
            " model: only actuators at their greatest force show it, so command faster changes, or"
            " weigh the forearm."
        )
    if found.missing:
        sentences.append(
            f"{', '.join(found.missing)}: 0 in the model, and left so; a model with a guess above"
            " 0 has it fitted."
        )
    return "\n".join([markdown_table(_TITLES, rows), "", *sentences])


def _row(one: Estimate, found: Identified) -> list[str]:
    low, high = (_span(bound * one.model) for bound in one.interval)
    interval = f"{low} to {high}" if one.half_width < _WIDEST else "anything"
    own, estimated = _span(one.model), _span(one.factor * one.model)
    return [one.name, UNITS[one.name], own, estimated, interval, _remark(one, found)]


def _remark(one: Estimate, found: Identified) -> str:
    if one.at_bound:
        return "not determined: as far off the model as is looked"
    if one.determined:
        return ""
    if one.ratio_determined:
        ratio = one.factor / found.factors[REFERENCE]
        width = 100.0 * math.expm1(one.ratio_half_width)
        return f"not determined, but factor over {REFERENCE}'s: {ratio:.3f} ± {width:.1f} %"
    return f"not determined to ± {100 * _DETERMINED:g} %"


def _latency_row(latency: Latency) -> list[str]:
    found, low, high = (f"{1000.0 * s:.4g}" for s in (latency.seconds, *latency.interval))
    steps = latency.seconds / latency.control_step
    remark = f"{steps:.3g} × the control step of {1000.0 * latency.control_step:g} ms"
    if latency.seconds >= _EDGE * LONGEST:
        remark += ", as long as is looked"
    elif not latency.is_integer:
        remark += f"; load() takes whole ones, latency={latency.control_steps}"
    return [LATENCY, "ms", "0", found, f"{low} to {high}", remark]


def _span(values: Array) -> str:
    """Return a value, or the least and the greatest where joints differ."""
    least, greatest = f"{values.min():.4g}", f"{values.max():.4g}"
    return least if least == greatest else f"{least} … {greatest}"
