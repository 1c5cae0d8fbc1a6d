"""What is measured of an episode, whichever face its environment has."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mpma_mj import metrics
from mpma_mj.envs.physics import PhysicsArms

__all__ = ["EpisodeRecorder"]

Array = NDArray[np.float64]


class EpisodeRecorder:
    """The steps of an episode, as far as they are measured."""

    def __init__(self) -> None:
        """Begin without a step."""
        self._steps: list[dict[str, Array]] = []

    def add(self, physics: PhysicsArms, reference: Array, reward: float, **assist: Array) -> None:
        """Take in what a step led to.

        Args:
            physics: The arms; their true posture counts, not what is observed with noise.
            reference: Posture that is demonstrated now, shape (12,).
            reward: Reward of the step.
            **assist: Where the feedback controller assists `feedback` and `action`, each (8,).
        """
        step = {"posture": physics.posture(), "reference": reference.copy()}
        self._steps.append(step | {"reward": np.array(reward)} | assist)

    def measures(self, physics: PhysicsArms, *, terminated: bool) -> dict[str, float]:
        """Return the measures by name; see `metrics` for their definitions.

        Args:
            physics: The arms, for their lengths.
            terminated: Whether the episode ended before the demonstration did.
        """
        course = {name: np.stack([step[name] for step in self._steps]) for name in self._steps[0]}
        posture, reference = course["posture"], course["reference"]
        sites = physics.site_positions
        measures = {
            "p_e_percent": metrics.posture_error_percent(posture, reference),
            "mpkpe_m": metrics.mpkpe(sites(posture), sites(reference)),
            "mean_reward": float(np.mean(course["reward"])),
            "steps": len(posture),
        }
        if "feedback" in course:
            ratio = metrics.feedback_ratio(course["feedback"], course["action"])
            measures["feedback_ratio"] = ratio
        return measures | {"terminated": terminated}
