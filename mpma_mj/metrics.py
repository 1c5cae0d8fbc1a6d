"""The measures of an epoch, as pure functions of what was recorded."""

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
    "module_number",
    "modules_used",
    "mpkpe",
    "nmi",
    "phase_lag",
    "posture_error_percent",
    "repeatability",
    "rp_error_percent",
    "sharing_entropy",
    "usage_entropy",
]

Array = NDArray[np.float64]

# From the paper: a module is active during a letter if λ > 0.1 for at least 25 % of it.
_ACTIVE_LEVEL, _ACTIVE_SHARE = 0.1, 0.25

_LONGEST_LAG = 0.5  # s, that is looked for (choice)

_CONSTANT = 1e-12  # a variance under it is rounding


def posture_error_percent(posture: Array, other: Array) -> float:
    """Return the mean distance of two courses of postures, in percent of the range.

        100 · mean_{t,d} |x_t - x'_t| / 2

    With the demonstration as the other it is p_e, with the forward models' predictions the
    prediction error. The range of a coordinate, [-1, 1], is 2 wide; the paper does not say how
    it defines p_e (choice).

    Args:
        posture: Postures x, shape (T, 12).
        other: Postures x', shape (T, 12).
    """
    return float(50.0 * np.mean(np.abs(posture - other)))


def error_over_time(posture: Array, other: Array) -> Array:
    """Return the same of each moment, shape (T,), percent, of courses of shape (T, 12)."""
    return 50.0 * np.abs(posture - other).mean(axis=1)


def rp_error_percent(prior: Array, responsibility: Array) -> float:
    """Return how far the responsibility predictors are from the responsibilities.

        100 · mean_{t,i} |p^i / Σp - λ^i|

    Args:
        prior: Outputs p of the predictors, shape (T, M), above 0.
        responsibility: Responsibilities λ, shape (T, M).
    """
    share = prior / prior.sum(axis=1, keepdims=True)
    return float(100.0 * np.mean(np.abs(share - responsibility)))


def feedback_ratio(feedback: Array, action: Array) -> float:
    """Return the feedback controller's share, Σ|K u_fb| / Σ|u|; both of shape (T, 8)."""
    total = float(np.sum(np.abs(action)))
    return float(np.sum(np.abs(feedback))) / total if total > 0 else 0.0


def active_modules(responsibility: Array, context: Array) -> list[int]:
    """Count the modules that are active during each label.

    Args:
        responsibility: Responsibilities λ, shape (T, M).
        context: Context, shape (T, C); the largest entry says which label is danced.

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
    """Return for each label the index of the module that most often has the largest λ.

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
    """Return the number of a module as it is printed, drawn and written: from 1; None for -1."""
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
        1 where the module determines the label, 0 where it is independent of it, or there is one
        label.
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
    """Return how evenly modules share a step, on average.

        mean_t H(λ_t) / log M,   H(λ) = -Σ_i λ^i log λ^i

    Args:
        responsibility: Responsibilities λ, shape (T, M), each row sums to 1.

    Returns:
        0 where one module at a time has all of it, 1 where all have the same; 0 for one module.
    """
    return float(np.mean(_entropy(responsibility)))


def usage_entropy(responsibility: Array) -> float:
    """Return how evenly modules are used in the whole, H(mean_t λ_t) / log M.

    Args:
        responsibility: Responsibilities λ, shape (T, M), each row sums to 1.

    Returns:
        0 where one module does all, 1 where all do as much; never less than the sharing entropy.
        0 for one module.
    """
    return float(_entropy(responsibility.mean(axis=0)))


def _entropy(shares: Array) -> Array:
    """Return the entropy of shares along the last axis, over the most that it can be."""
    count = shares.shape[-1]
    if count == 1:
        return np.zeros(shares.shape[:-1])
    return special.entr(shares).sum(axis=-1) / np.log(count)


def repeatability(signal: Array, period: int) -> float:
    """Return how alike a signal is from repetition to repetition.

    Args:
        signal: Signal, shape (T, ...).
        period: Steps of one repetition.

    Returns:
        Mean correlation between successive repetitions over all channels that vary; the last
        may be cut short. NaN where there is only one, or nothing varies.
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
        sites: Where the arms are, shape (T, 2, 3, 3), m: arm; shoulder, elbow, wrist; xyz.
        demonstrated_sites: Where the demonstrated posture puts them on the same arms.

    Returns:
        Mean distance, m.
    """
    offset = (sites - demonstrated_sites)[:, :, 1:]
    return float(np.mean(np.linalg.norm(offset, axis=-1)))


def phase_lag(posture: Array, reference: Array, timestep: float) -> float:
    """Return how far a course of postures runs behind another, by cross-correlation.

        argmax_τ Σ_t x̃(t + τ) · x̃'(t) / (|x̃| |x̃'|)        x̃ without its mean over time

    Of both only what overlaps counts. Between steps a parabola through the three highest
    correlations gives the place of the maximum.

    Args:
        posture: Postures x, shape (T, 12).
        reference: Postures x', shape (T, 12).
        timestep: Time of a step, s.

    Returns:
        Lag, s, up to half a second; below 0 where x runs ahead. NaN where nothing moves.
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
    """Return the correlation of a signal, so many steps later, with a reference; all channels."""
    count = len(signal) - abs(lag)
    x, y = signal[max(lag, 0) :][:count], reference[max(-lag, 0) :][:count]
    x, y = x - x.mean(axis=0), y - y.mean(axis=0)
    scale = np.linalg.norm(x) * np.linalg.norm(y)
    return float(np.vdot(x, y) / scale) if scale > _CONSTANT else float("nan")
