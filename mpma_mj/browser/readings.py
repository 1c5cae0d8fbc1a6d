"""Readings of the page as HTML: numbers, responsibilities, the episode so far."""

from __future__ import annotations

import math
from collections.abc import Sequence
from html import escape

import numpy as np
from numpy.typing import NDArray

from mpma_mj.browser.live_episode import Moment
from mpma_mj.browser.simulation import LiveSimulation
from mpma_mj.kinematics import SIDES
from mpma_mj.metrics import posture_error_percent
from mpma_mj.visualization.colours import DEMONSTRATED, INK, module_colours

__all__ = ["bars_html", "status_html", "timeline_html"]

Array = NDArray[np.float64]

_POINTS = 300  # of the curves at most (choice)
_ERROR = "#c92a2a"
_FONT = "font:12px/1.35 system-ui,sans-serif"
_BAND, _CURVE = 44, 30  # heights of responsibilities and p_e, pixels


def status_html(simulation: LiveSimulation, error: str = "") -> str:
    """Return the label and the numbers of the moment that is shown, and an error, if any."""
    moment = simulation.moment
    seconds = moment.step * simulation.episode.env.control_timestep()
    pace = f"{simulation.real_time_factor:.2f} × real time" if simulation.playing else "paused"
    rows = [
        f"<b>p<sub>e</sub> {_percent(simulation.recent_error_percent)}</b> in 2 s,"
        f" {_percent(simulation.episode_error_percent)} so far",
        f"{seconds:.2f} s, step {moment.step}; {pace}",
    ]
    if moment.plant is not None:
        plant = simulation.plants[moment.plant]
        rows.append(f"plant {moment.plant + 1}: {escape(str(plant))}")
    pushes = np.linalg.norm(moment.push, axis=1)
    for side, force in zip(SIDES, pushes, strict=True):
        if force > 0.0:
            rows.append(f"push {force:.0f} N, {side} hand")
    label = escape(moment.label) or "&ndash;"
    size = 44 if len(moment.label) <= 2 else 18
    problem = f"<div style='color:{_ERROR}'>{escape(error)}</div>" if error else ""
    return (
        f"<div style='{_FONT};padding:2px 1em 0'><div style='display:flex;gap:14px;"
        f"align-items:center'><div style='font-size:{size}px;font-weight:700;line-height:1;"
        f"min-width:40px;max-width:110px;overflow:hidden'>{label}</div><div>"
        + "<br>".join(rows)
        + f"</div></div>{problem}</div>"
    )


def bars_html(responsibility: Array | None, enabled: Sequence[bool]) -> str:
    """Return a bar for each responsibility λ, in the colours of the modules.

    Args:
        responsibility: Responsibilities, shape (M,); None before the first step.
        enabled: Whether each module may control, shape (M,).
    """
    modules = len(enabled)
    shares = np.zeros(modules) if responsibility is None else np.nan_to_num(responsibility)
    rows = []
    for i, (share, on, colour) in enumerate(
        zip(shares, enabled, module_colours(modules), strict=True)
    ):
        rows.append(
            "<div style='display:flex;align-items:center;gap:6px;height:15px;"
            f"opacity:{1 if on else 0.45}'><span style='width:22px'>λ<sub>{i + 1}</sub></span>"
            "<span style='flex:1;height:10px;background:#eef0f3'><span style='display:block;"
            f"height:10px;width:{100 * share:.1f}%;background:{colour}'></span></span>"
            f"<span style='width:38px;text-align:right'>{f'{100 * share:.0f} %' if on else 'off'}"
            "</span></div>"
        )
    return f"<div style='{_FONT};padding:0 1em'>{''.join(rows)}</div>"


def timeline_html(moments: Sequence[Moment], steps: int, shown: int, *, modules: int) -> str:
    """Return the episode so far: labels, stacked responsibilities, and the error of each moment.

    Args:
        moments: Moments so far.
        steps: Steps of the whole episode.
        shown: Index of the moment that is shown.
        modules: Number of modules.
    """
    stride = math.ceil(len(moments) / _POINTS)
    some = moments[::stride]
    x = np.arange(len(some), dtype=np.float64) * stride
    error = np.array([posture_error_percent(m.posture, m.reference) for m in some])
    highest = max(1.0, float(error.max()))
    curve = _points(x, _BAND + _CURVE * (1.0 - error / highest))
    bands = "".join(_bands(x, some, modules)) if modules else ""
    height = _BAND + _CURVE
    drawing = (
        f"<svg viewBox='0 0 {steps} {height}' preserveAspectRatio='none' style='display:block;"
        f"width:100%;height:{height}px;background:#eef0f3'>{bands}"
        f"<polyline points='{curve}' fill='none' stroke='{INK}' stroke-width='1.2'"
        " vector-effect='non-scaling-stroke'/>"
        f"<line x1='{shown}' x2='{shown}' y1='0' y2='{height}' stroke='{INK}' stroke-width='1.5'"
        " vector-effect='non-scaling-stroke'/></svg>"
    )
    return (
        f"<div style='{_FONT};padding:0 1em'><div style='position:relative;height:16px'>"
        f"{''.join(_label_spans(moments, steps))}</div>{drawing}"
        f"<div style='color:{DEMONSTRATED};font-size:10px;text-align:right'>"
        f"{'λ; ' if modules else ''}p<sub>e</sub> of each step, up to {highest:.1f} %</div></div>"
    )


def _bands(x: Array, moments: Sequence[Moment], modules: int) -> list[str]:
    """Return the stacked responsibilities as polygons."""
    shares = np.zeros((len(moments), modules))
    for row, moment in zip(shares, moments, strict=True):
        if moment.responsibility is not None:
            row[: len(moment.responsibility)] = np.nan_to_num(moment.responsibility)
    edges = _BAND * (1.0 - np.minimum(np.cumsum(shares, axis=1), 1.0))
    edges = np.hstack([np.full((len(x), 1), float(_BAND)), edges])
    return [
        f"<polygon fill='{colour}' points='{_points(x, edges[:, i])}"
        f" {_points(x[::-1], edges[::-1, i + 1])}'/>"
        for i, colour in enumerate(module_colours(modules))
    ]


def _label_spans(moments: Sequence[Moment], steps: int) -> list[str]:
    """Return each stretch of a label as an element in its place."""
    spans, first = [], 0
    for i in range(1, len(moments) + 1):
        if i < len(moments) and moments[i].label == moments[first].label:
            continue
        left, width = 100.0 * first / steps, 100.0 * (i - first) / steps
        spans.append(
            f"<span style='position:absolute;left:{left:.2f}%;width:{width:.2f}%;"
            "border-left:1px solid #b8bec8;text-align:center;overflow:hidden;white-space:nowrap;"
            f"box-sizing:border-box'>{escape(moments[first].label)}</span>"
        )
        first = i
    return spans


def _points(x: Array, y: Array) -> str:
    return " ".join(f"{a:g},{b:.1f}" for a, b in zip(x, y, strict=True))


def _percent(error: float) -> str:
    return "&ndash;" if math.isnan(error) else f"{error:.2f} %"
