"""What can be put around an environment, for agents of any kind."""

from mpma_mj.envs.wrappers.base import Wrapper
from mpma_mj.envs.wrappers.evaluate import Evaluate, GymEvaluate
from mpma_mj.envs.wrappers.feedback_assist import FeedbackAssist
from mpma_mj.envs.wrappers.gym_feedback_assist import GymFeedbackAssist, VectorFeedbackAssist
from mpma_mj.envs.wrappers.record_video import RecordVideo

__all__ = [
    "Evaluate",
    "FeedbackAssist",
    "GymEvaluate",
    "GymFeedbackAssist",
    "RecordVideo",
    "VectorFeedbackAssist",
    "Wrapper",
]
