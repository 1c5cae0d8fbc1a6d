"""What was found, as text."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mpma_mj.sysid.identified import (
    DETERMINED,
    LONGEST,
    REFERENCE,
    SHOWN_WINDOW,
    Estimate,
    Identified,
    Latency,
)
from mpma_mj.sysid.parameters import LATENCY, UNITS
from mpma_mj.utils.text import markdown_table

__all__ = ["as_markdown"]

_TITLES = ("parameter", "unit", "in the model", "found", "95 % interval", "remark")
_WIDEST = np.log(10.0)  # half width of an interval that is still shown


def as_markdown(found: Identified) -> str:
    """Return a table of the parameters, and sentences about what is in it."""
    rows = [*(_row(one, found) for one in found.estimates), _late(found.latency)]
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
    low, high = one.interval
    return [
        one.name,
        UNITS[one.name],
        _shown(one.model),
        _shown(one.factor * one.model),
        f"{_shown(low * one.model)} to {_shown(high * one.model)}"
        if one.half_width < _WIDEST
        else "anything",
        _remark(one, found),
    ]


def _remark(one: Estimate, found: Identified) -> str:
    if one.at_bound:
        return "not determined: as far off the model as is looked"
    if one.determined:
        return ""
    if one.ratio_determined:
        ratio = one.factor / found.factors[REFERENCE]
        width = 100.0 * np.expm1(one.ratio_half_width)
        return f"not determined, but factor over {REFERENCE}'s: {ratio:.3f} ± {width:.1f} %"
    return f"not determined to ± {100 * DETERMINED:g} %"


def _late(latency: Latency) -> list[str]:
    shown = [1000.0 * latency.timestep * steps for steps in (latency.steps, *latency.interval)]
    per_step = 1000.0 * latency.timestep * latency.per_row
    remark = f"{latency.steps / latency.per_row:.3g} × the control step of {per_step:g} ms"
    if latency.seconds >= LONGEST:
        remark += ", as long as is looked"
    elif not latency.is_integer:
        remark += f"; load() takes whole ones, latency={latency.control_steps}"
    return [LATENCY, "ms", "0", f"{shown[0]:g}", f"{shown[1]:g} to {shown[2]:g}", remark]


def _shown(values: NDArray[np.float64]) -> str:
    """Return a value, or the least and the greatest where joints differ."""
    least, greatest = f"{values.min():.4g}", f"{values.max():.4g}"
    return least if least == greatest else f"{least} … {greatest}"
