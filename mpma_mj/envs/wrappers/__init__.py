"""Wrappers of environments: assistance, metrics, videos."""

from mpma_mj.envs.wrappers.base import Wrapper
from mpma_mj.envs.wrappers.evaluate import Evaluate, GymEvaluate
from mpma_mj.envs.wrappers.feedback_assist import (
    FeedbackAssist,
    GymFeedbackAssist,
    VectorFeedbackAssist,
)
from mpma_mj.envs.wrappers.record_video import RecordVideo

__all__: list[str] = [
    "Evaluate",
    "FeedbackAssist",
    "GymEvaluate",
    "GymFeedbackAssist",
    "RecordVideo",
    "VectorFeedbackAssist",
    "Wrapper",
]
