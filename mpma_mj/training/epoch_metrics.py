"""Metrics of an epoch, computed from its trace."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from mpma_mj import metrics
from mpma_mj.trace import Trace

__all__ = ["EpochMetrics", "epoch_metrics", "part_metrics", "tracking_error"]

Array = NDArray[np.float64]
EpochMetrics = dict[str, float]


def epoch_metrics(site_positions: Callable[[Array], Array], trace: Trace) -> EpochMetrics:
    """Return the metrics of an epoch by name; see `mpma_mj.metrics` for their definitions.

    Args:
        site_positions: Positions of the arms' sites in postures; `PhysicsArms.site_positions`.
        trace: Trace of one run; metrics of modules need an agent that has some.
    """
    posture, reference = trace.posture[1:], trace.reference[1:]
    measures = part_metrics(trace, np.ones(len(trace), bool)) | {
        "mpkpe_m": metrics.mpkpe(site_positions(posture), site_positions(reference)),
        "mean_reward": float(np.mean(trace.reward)),
    }
    if trace.modules is not None:
        responsibility, context = trace.modules.responsibility, trace.context[:-1]
        measures["nmi"] = metrics.nmi(responsibility, context)
        measures["modules_used"] = metrics.modules_used(responsibility, context)
    return measures


def part_metrics(trace: Trace, part: NDArray[np.bool_]) -> EpochMetrics:
    """Return those metrics by name that a part of an epoch has, too.

    Args:
        trace: Trace of one run; metrics of modules need an agent that has some.
        part: Which steps count, shape (T,).
    """
    posture, reference = trace.posture[1:][part], trace.reference[1:][part]
    measures = {"p_e_percent": metrics.posture_error_percent(posture, reference)}
    if trace.modules is not None:
        responsibility = trace.modules.responsibility[part]
        predicted = np.einsum("tm,tmd->td", responsibility, trace.modules.predictions[part])
        prior = trace.modules.prior[part]
        measures |= {
            "prediction_error_percent": metrics.posture_error_percent(predicted, posture),
            "rp_error_percent": metrics.rp_error_percent(prior, responsibility),
        }
    if trace.feedback is not None:
        feedback, action = trace.feedback[part], trace.action[part]
        measures["feedback_ratio"] = metrics.feedback_ratio(feedback, action)
    if trace.learned is not None:
        measures["learned_share"] = metrics.learned_share(trace.learned[part], trace.action[part])
    return measures


def tracking_error(trace: Trace) -> float:
    """Return p_e of an epoch of one run, percent."""
    return metrics.posture_error_percent(trace.posture[1:], trace.reference[1:])
