"""Metrics of an epoch, as pure functions of its signals."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import special

from mpma_mj.context import active_label

__all__ = [
    "active_modules",
    "dominant_module",
    "error_over_time",
    "feedback_ratio",
    "learned_share",
    "module_number",
    "modules_used",
    "mpkpe",
    "nmi",
    "phase_lag",
    "posture_error_percent",
    "repeatability",
    "rp_error_percent",
    "sharing_entropy",
    "tracking_errors",
    "usage_entropy",
]

Array = NDArray[np.float64]

# From the paper: a module is active during a letter if λ > 0.1 for at least 25 % of its steps.
_ACTIVE_LEVEL, _ACTIVE_SHARE = 0.1, 0.25

_LONGEST_LAG = 0.5  # largest lag of the search, s (choice)

_TINY = np.finfo(np.float64).tiny  # where every module is switched off

_CONSTANT = 1e-12  # variances below this are rounding errors


def posture_error_percent(posture: Array, other: Array) -> float:
    """Return the mean absolute difference of two sequences of postures, in percent of the range.

        100 · mean_{t,d} |x_t - x'_t| / 2

    Between performance and demonstration this is p_e, between performance and the predictions of
    the forward models the prediction error. The range of a coordinate is [-1, 1], of width 2. The
    paper does not define p_e (choice).

    Args:
        posture: Postures x, shape (T, 12).
        other: Postures x', shape (T, 12).
    """
    return float(50.0 * np.mean(np.abs(posture - other)))


def error_over_time(posture: Array, other: Array) -> Array:
    """Return the posture error of each moment.

    Args:
        posture: Postures x, shape (T, 12).
        other: Postures x', shape (T, 12).

    Returns:
        Error, shape (T,), percent of the range.
    """
    return 50.0 * np.abs(posture - other).mean(axis=1)


def rp_error_percent(prior: Array, responsibility: Array) -> float:
    """Return the mean error of the responsibility predictors, in percent.

        100 · mean_{t,i} |p^i / Σp - λ^i|

    Args:
        prior: Outputs p of the predictors, shape (T, M), above 0.
        responsibility: Responsibilities λ, shape (T, M).
    """
    share = prior / np.maximum(prior.sum(axis=1, keepdims=True), _TINY)
    return float(100.0 * np.mean(np.abs(share - responsibility)))


def feedback_ratio(feedback: Array, action: Array) -> float:
    """Return the share of the feedback controller in the action, Σ|K u_fb| / Σ|u|.

    Args:
        feedback: Feedback commands times their gain, K u_fb, shape (T, 8).
        action: Actions u, shape (T, 8).

    Returns:
        The ratio; 0 if all actions are 0.
    """
    total = float(np.sum(np.abs(action)))
    return float(np.sum(np.abs(feedback))) / total if total > 0 else 0.0


def learned_share(learned: Array, action: Array) -> float:
    """Return the share of what was learned in the action, Σ|L Σ_i λ^i (u^i - m)| / Σ|u|.

    Args:
        learned: What learning adds to the action, shape (T, 8).
        action: Actions u, shape (T, 8).

    Returns:
        The ratio; 0 if all actions are 0.
    """
    return feedback_ratio(learned, action)


def active_modules(responsibility: Array, context: Array) -> list[int]:
    """Count the modules that are active during each label.

    Args:
        responsibility: Responsibilities λ, shape (T, M).
        context: Context, shape (T, C); the largest entry is the active label.

    Returns:
        For each of the C labels the number of modules with λ > 0.1 for at least 25 % of its
        steps.
    """
    label = active_label(context)
    active = responsibility > _ACTIVE_LEVEL
    return [
        int(np.sum(active[label == c].mean(axis=0) >= _ACTIVE_SHARE)) if (label == c).any() else 0
        for c in range(context.shape[1])
    ]


def dominant_module(responsibility: Array, context: Array) -> list[int]:
    """Return the dominant module of each label, which most often has the largest λ.

    Args:
        responsibility: Responsibilities λ, shape (T, M).
        context: Context, shape (T, C).

    Returns:
        Indices from 0; -1 for a label that does not occur.
    """
    label, dominant = active_label(context), responsibility.argmax(axis=1)
    modules = responsibility.shape[1]
    return [
        int(np.bincount(dominant[label == c], minlength=modules).argmax())
        if (label == c).any()
        else -1
        for c in range(context.shape[1])
    ]


def module_number(index: int) -> int | None:
    """Return the number of a module in tables, figures and files, from 1; None for -1."""
    return index + 1 if index >= 0 else None


def modules_used(responsibility: Array, context: Array) -> int:
    """Return the number of modules that are dominant in at least one label."""
    return len(set(dominant_module(responsibility, context)) - {-1})


def nmi(responsibility: Array, context: Array) -> float:
    """Return the normalised mutual information of label and dominant module.

        I(label; module) / H(label)

    in steps that have a label (Cover & Thomas 2006, chapter 2).

    Args:
        responsibility: Responsibilities λ, shape (T, M).
        context: Context, shape (T, C).

    Returns:
        1 where the module determines the label; 0 where they are independent, or there is only
        one label.
    """
    label, dominant = active_label(context), responsibility.argmax(axis=1)
    labelled = label >= 0
    joint = np.zeros((context.shape[1], responsibility.shape[1]))
    np.add.at(joint, (label[labelled], dominant[labelled]), 1.0 / max(1, labelled.sum()))
    labels, modules = joint.sum(axis=1), joint.sum(axis=0)
    entropy = special.entr(labels).sum()
    if entropy < _CONSTANT:
        return 0.0
    information = special.rel_entr(joint, labels[:, None] * modules).sum()
    return max(0.0, float(information / entropy))


def sharing_entropy(responsibility: Array) -> float:
    """Return the mean normalised entropy of the responsibilities of a step.

        mean_t H(λ_t) / log M,   H(λ) = -Σ_i λ^i log λ^i

    Args:
        responsibility: Responsibilities λ, shape (T, M), each row sums to 1.

    Returns:
        0 where each step has one responsible module, 1 where all share equally; 0 for one module.
    """
    return float(np.mean(_entropy(responsibility)))


def usage_entropy(responsibility: Array) -> float:
    """Return the normalised entropy of the mean responsibilities, H(mean_t λ_t) / log M.

    Args:
        responsibility: Responsibilities λ, shape (T, M), each row sums to 1.

    Returns:
        0 where one module is always responsible, 1 where all are used equally; never less than
        the sharing entropy. 0 for one module.
    """
    return float(_entropy(responsibility.mean(axis=0)))


def _entropy(shares: Array) -> Array:
    """Return the entropy of shares along the last axis, divided by its maximum."""
    count = shares.shape[-1]
    if count == 1:
        return np.zeros(shares.shape[:-1])
    return special.entr(shares).sum(axis=-1) / np.log(count)


def repeatability(signal: Array, period: int) -> float:
    """Return the mean correlation between successive repetitions of a signal.

    Args:
        signal: Signal, shape (T, ...).
        period: Steps of one repetition.

    Returns:
        Mean correlation over all channels that vary; the last repetition may be incomplete. NaN
        if there is only one repetition, or no channel varies.
    """
    channels = signal.reshape(len(signal), -1)
    correlations = []
    for start in range(0, len(channels) - period - 1, period):
        after = channels[start + period : start + 2 * period]
        before = channels[start : start + len(after)]
        before, after = before - before.mean(axis=0), after - after.mean(axis=0)
        scale = np.sqrt(np.mean(before**2, axis=0) * np.mean(after**2, axis=0))
        varies = scale > _CONSTANT
        correlations.extend(np.mean(before * after, axis=0)[varies] / scale[varies])
    return float(np.mean(correlations)) if correlations else float("nan")


def mpkpe(sites: Array, demonstrated_sites: Array) -> float:
    """Return the mean per-keypoint position error of elbows and wrists.

    Args:
        sites: Positions, shape (T, 2, 3, 3), m: arm; shoulder, elbow, wrist; xyz.
        demonstrated_sites: Positions of the same arms in the demonstrated postures, same shape, m.

    Returns:
        Mean distance, m.
    """
    offset = (sites - demonstrated_sites)[:, :, 1:]
    return float(np.mean(np.linalg.norm(offset, axis=-1)))


def tracking_errors(posture: Array, reference: Array, keypoints: Array) -> dict[str, float]:
    """Return both measures of how well an episode tracks its demonstration.

    Args:
        posture: True postures after each step, shape (T, 12).
        reference: Demonstrated postures after each step, shape (T, 12).
        keypoints: Matrix that takes postures to positions of elbows and wrists, shape (12, 12), m.

    Returns:
        `p_e_percent`, see `posture_error_percent`, and `mpkpe_m`, `mpkpe` but for rounding.
    """
    # Every episode of a learner is measured, so this takes a tenth of the time of `mpkpe`.
    offset = ((posture - reference) @ keypoints).reshape(-1, 4, 3)
    return {
        "p_e_percent": posture_error_percent(posture, reference),
        "mpkpe_m": float(np.mean(np.sqrt(np.vecdot(offset, offset)))),
    }


def phase_lag(posture: Array, reference: Array, timestep: float) -> float:
    """Return the lag of one sequence of postures behind another, by cross-correlation.

        argmax_τ Σ_t x̃(t + τ) · x̃'(t) / (|x̃| |x̃'|)        x̃ without its mean over time

    Only the overlap of both sequences counts. The maximum is interpolated between steps by a
    parabola through the largest correlation and its two neighbours.

    Args:
        posture: Postures x, shape (T, 12).
        reference: Postures x', shape (T, 12).
        timestep: Duration of a step, s.

    Returns:
        Lag, s, up to half a second; negative if x is ahead. NaN if a sequence is constant.
    """
    most = min(max(1, round(_LONGEST_LAG / timestep)), len(posture) - 2)
    correlation = np.array([_correlation(posture, reference, k) for k in range(-most, most + 1)])
    if not np.isfinite(correlation).all():
        return float("nan")
    best = int(correlation.argmax())
    shift = 0.0
    if 0 < best < 2 * most:
        before, top, after = correlation[best - 1 : best + 2]
        bend = before - 2.0 * top + after
        shift = 0.5 * float((before - after) / bend) if bend < 0.0 else 0.0
    return (best - most + shift) * timestep


def _correlation(signal: Array, reference: Array, lag: int) -> float:
    """Return the correlation of a signal with a reference at a lag in steps, over all channels."""
    count = len(signal) - abs(lag)
    x, y = signal[max(lag, 0) :][:count], reference[max(-lag, 0) :][:count]
    x, y = x - x.mean(axis=0), y - y.mean(axis=0)
    scale = np.linalg.norm(x) * np.linalg.norm(y)
    return float(np.vdot(x, y) / scale) if scale > _CONSTANT else float("nan")
