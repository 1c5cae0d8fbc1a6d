"""Factory of live episodes: of a run's agent, or of the feedback controller alone."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents import FeedbackOnlyConfig
from mpma_mj.browser.live_episode import LiveEpisode
from mpma_mj.envs.interventions import Intervention
from mpma_mj.envs.load import make_environment
from mpma_mj.envs.options import FIELDS_OF_PLANTS, MASS_OPTIONS, EnvironmentOptions
from mpma_mj.motions import Motion
from mpma_mj.training.checkpoints import load_state
from mpma_mj.training.config import RunConfig
from mpma_mj.training.factory import agent_of
from mpma_mj.training.run_folder import RunFolder

__all__ = ["EpisodeFactory", "intervention_for", "other_arms"]


@dataclass(frozen=True, eq=False)
class EpisodeFactory:
    """An agent with its motion and its arms, of which episodes are made.

    Attributes:
        config: Config of the run.
        motion: Its motion.
        state: State of the agent, as `state_dict` returns it; None of one that does not learn.
        source: File from which the state was read, for errors.
    """

    config: RunConfig
    motion: Motion
    state: Mapping[str, NDArray[np.float64]] | None = None
    source: Path | None = None

    @classmethod
    def of_run(cls, folder: RunFolder) -> EpisodeFactory:
        """Return the agent of a run's best epoch.

        Raises:
            MpmaError: There is no run, or it is damaged.
        """
        config = folder.read_config()
        state, _ = folder.read_best(config)
        return cls(config, folder.read_motion(), state, folder.checkpoint("best"))

    @classmethod
    def of_motion(cls, motion: Motion, options: EnvironmentOptions | None = None) -> EpisodeFactory:
        """Return the feedback controller, by which arms follow a motion without a run."""
        env = options or EnvironmentOptions()
        return cls(RunConfig(env=env, agent=FeedbackOnlyConfig()), motion)

    def make(self, number: int, options: EnvironmentOptions | None = None) -> LiveEpisode:
        """Return an episode at its beginning.

        Args:
            number: Number of the episode, on which its noise depends.
            options: Options of the environment; those of the run if not given.

        Raises:
            MpmaError: The arms cannot follow the motion, or the state does not fit the config.
        """
        seed = self.config.seed
        env = make_environment(self.motion, options or self.config.env, seed, adjustable=True)
        agent = agent_of(self.config, env, seed)
        if self.state is not None:
            load_state(agent, self.state, self.source)
        return LiveEpisode(env, agent, number)


def other_arms(options: EnvironmentOptions) -> EnvironmentOptions:
    """Return options with the other kind of arms; ideal arms have no mass, and one plant."""
    if options.arms == "kinematic":
        return dataclasses.replace(options, arms="physics")
    defaults = EnvironmentOptions()
    changes = {name: getattr(defaults, name) for name in MASS_OPTIONS + FIELDS_OF_PLANTS}
    return dataclasses.replace(options, arms="kinematic", **changes)


def intervention_for(options: EnvironmentOptions, intervention: Intervention) -> Intervention:
    """Return what is set by hand, without a plant where arms of these options have one only."""
    return intervention if options.plants else dataclasses.replace(intervention, plant=None)
