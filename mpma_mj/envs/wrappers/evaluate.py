"""How well arms track, whoever moves them."""

from __future__ import annotations

import dm_env
import numpy as np
from numpy.typing import NDArray

from mpma_mj import metrics
from mpma_mj.envs.wrappers.wrapper import Wrapper

__all__ = ["Evaluate"]

Array = NDArray[np.float64]


class Evaluate(Wrapper):
    """Measures every episode that is danced to its end, and changes nothing.

    Put it outermost, so that it sees a `FeedbackAssist`, if there is one.

    Attributes:
        episode_metrics: For each episode that ended, by name: `p_e_percent`, `mpkpe_m` and
            `mean_reward` (see `metrics`); `steps`, how long it was; `terminated`, whether it ended
            before the demonstration did, as when the simulation diverges; and `feedback_ratio`
            where `FeedbackAssist` is at work. An episode that is left by `reset` does not count.
    """

    def __init__(self, env: dm_env.Environment) -> None:
        """Wrap an environment, which may be a wrapper itself."""
        super().__init__(env)
        self.episode_metrics: list[dict[str, float]] = []
        self._steps: list[dict[str, Array]] = []

    def _begun(self, timestep: dm_env.TimeStep) -> None:
        self._steps = []

    def _stepped(self, action: Array, timestep: dm_env.TimeStep) -> None:
        step = {
            "posture": self._env.physics.posture(),  # what is observed may have noise
            "reference": timestep.observation["reference"].copy(),
            "reward": np.array(timestep.reward),
        }
        if hasattr(self._env, "last_feedback"):
            step |= {"feedback": self._env.last_feedback, "action": self._env.last_action}
        self._steps.append(step)
        if timestep.last():
            self.episode_metrics.append(self._measures() | {"terminated": timestep.discount == 0})

    def _measures(self) -> dict[str, float]:
        course = {name: np.stack([step[name] for step in self._steps]) for name in self._steps[0]}
        posture, reference = course["posture"], course["reference"]
        sites = self._env.physics.site_positions
        measures = {
            "p_e_percent": metrics.posture_error_percent(posture, reference),
            "mpkpe_m": metrics.mpkpe(sites(posture), sites(reference)),
            "mean_reward": float(np.mean(course["reward"])),
            "steps": len(posture),
        }
        if "feedback" in course:
            ratio = metrics.feedback_ratio(course["feedback"], course["action"])
            measures["feedback_ratio"] = ratio
        return measures
