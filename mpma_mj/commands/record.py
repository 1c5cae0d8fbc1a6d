"""Command `mpma record`."""

from __future__ import annotations

import contextlib
import dataclasses
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Generic, TypeVar

import tyro

from mpma_mj.agents.config import AgentConfig
from mpma_mj.commands.run_options import MOTION, Given, RunOptions, Source
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.errors import BadOptionError
from mpma_mj.motions.options import given
from mpma_mj.utils.folder_lock import finish_changes, locked

if TYPE_CHECKING:
    import gymnasium

    from mpma_mj.agents import Agent
    from mpma_mj.training.config import RunConfig

__all__ = ["Record"]

AgentT = TypeVar("AgentT", bound=AgentConfig)

_OWN = {"out", "episodes", "overwrite"}  # options that are none of training
_EPOCHS = 30  # as of `mpma imitate`


@dataclass(frozen=True, kw_only=True)
class Record(Generic[AgentT]):
    """Record episodes of an expert as a Minari dataset, for offline learners.

    Observations are those of TwoArmImitationFlat-v0; minari.MinariDataset("dataset/data") opens
    the dataset, and makes the environment again.
    """

    source: Annotated[
        Source,
        tyro.conf.arg(help=f"Folder of a run; or {MOTION}: an agent that learns is trained first."),
    ]
    out: Path
    """Folder of the dataset; as minari.load_dataset finds it, if it is
    ~/.minari/datasets/NAME-v0."""
    episodes: int = 20
    """Number of episodes, each with noise of its own."""
    overwrite: bool = False
    """Replace the dataset in the folder."""
    options: Annotated[tyro.conf.OmitArgPrefixes[RunOptions[AgentT]], tyro.conf.arg(name="")]
    """Options of the training, where the source is a motion."""
    given: Given = frozenset()

    def run(self) -> Path:
        """Train the agent if need be, record the dataset and return its folder."""
        from mpma_mj.training.expert_dataset import check_dataset, write_dataset

        with locked(self.out):
            check_dataset(self.out, self.episodes, overwrite=self.overwrite)
            config = self._config()
            seed = config.seed + 1  # noise that the training did not begin with
            with contextlib.closing(_environment(config)) as env:
                return write_dataset(env, self._agent(config), self.episodes, self.out, seed=seed)

    @property
    def _is_run(self) -> bool:
        from mpma_mj.motions.built_in import built_in

        if built_in(self.source):
            return False
        finish_changes(Path(self.source))
        return (Path(self.source) / "config.json").is_file()

    def _config(self) -> RunConfig:
        """Return the config of the run, or of the training."""
        from mpma_mj.training.run_folder import RunFolder

        options = self.options
        if not self._is_run:
            return options.run_config((self.source,), "record")
        named = {"agent": options.agent, "rule": getattr(options.config, "rule", None)}
        allowed = {name for name, value in named.items() if value in options.outside}
        for name in sorted(self.given - _OWN - allowed):
            raise BadOptionError(
                f"{self.source} is a trained run, which has its own agent, environment and seed",
                remedy=f"leave {{{name}}} out",
            )
        return RunFolder(Path(self.source), options.outside).read_config()

    def _agent(self, config: RunConfig) -> Agent:
        """Return the expert: that of the run, or one that is trained, or one that needs not be."""
        from mpma_mj.agents.registry import agent_class
        from mpma_mj.training.dataset import read_motions
        from mpma_mj.training.factory import agent_of, make_environments
        from mpma_mj.training.run import load_agent, train
        from mpma_mj.utils.progress import show_epochs

        if self._is_run:
            named = self.options.outside
            agent = next((path for path in named if path == config.agent_name), None)
            rule = next((path for path in named if path != config.agent_name), None)
            return load_agent(self.source, agent=agent, rule=rule)
        if agent_class(config.agent_name).trainable:
            epochs = max(_EPOCHS, config.agent.least_epochs)
            with show_epochs(epochs) as show:
                return train(config, epochs, on_epoch=show).agent
        env = make_environments(config, config.seed, read_motions(config))
        return agent_of(config, env, config.seed)


def _environment(config: RunConfig) -> gymnasium.Env[Any, Any]:
    """Return the environment of a run, made of what a dataset can keep.

    Raises:
        BadOptionError: There are several motions, or options of reading.
    """
    if len(config.motions) > 1 or given(config.reading):
        raise BadOptionError(
            "a dataset keeps the name or path of one motion, without options of reading it",
            remedy="write it as one file, mpma play MOTION {out=motion.npz}, and train on that",
        )
    import gymnasium

    from mpma_mj.training.config_json import plain

    options = {
        field.name: plain(getattr(config.env, field.name))
        for field in dataclasses.fields(config.env)
        if getattr(config.env, field.name) != getattr(EnvironmentOptions(), field.name)
    }
    if config.env.plants is not None:
        options["plants"] = [plant.given() for plant in config.env.plants]
    return gymnasium.make("mpma_mj:TwoArmImitationFlat-v0", motion=config.motions[0], **options)
