"""Command `mpma evaluate`."""

from __future__ import annotations

import contextlib
import functools
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from mpma_mj.commands.folders import given_runs, results_folder, write_tables
from mpma_mj.commands.run_options import Outside, OutsideClasses, RunFolders
from mpma_mj.errors import BadOptionError
from mpma_mj.options import Arms

if TYPE_CHECKING:
    from mpma_mj.training.checkpoints import TrainedAgents

__all__ = ["Evaluate"]

_BASELINES = {"resolved rate": "resolved_rate", "feedback only": "feedback_only"}


@dataclass(frozen=True)
class Evaluate:
    """Evaluate trained runs under disturbances, on other arms and on other motions."""

    run_folders: RunFolders
    """Folders of runs with the same motion and environment."""
    disturbances: tuple[str, ...] = ()
    """Some of payload, strength, gravity, latency, noise, pushes, tempo, mirrored, locked, unseen;
    all that the arms can have if not given."""
    levels: tuple[str, ...] = ()
    """Levels of a single disturbance, in place of the default ones."""
    unseen: Annotated[tuple[str, ...], tyro.conf.arg(name="motions")] = ()
    """Recordings that were not trained, in place of synthetic motions."""
    arms: Arms = "physics"
    """Simulated arms, or arms that move ideally."""
    fine_tune: int = 0
    """Epochs of fine-tuning in each condition; 0 for none."""
    baselines: bool = True
    """Evaluate resolved-rate command and feedback controller as well, which learn nothing."""
    out: Path | None = None
    """Folder of table and figure, where they replace earlier ones; RUN/evaluations/evaluation-TIME
    if not given, or runs/evaluation-TIME for several runs."""

    outside: Outside = OutsideClasses()
    """Code from outside the package with which runs were trained."""

    def run(self) -> Path:
        """Evaluate the runs and return the folder of the results."""
        if self.fine_tune < 0:
            raise BadOptionError(
                option="fine_tune", value=self.fine_tune, expected="0 or more epochs"
            )
        folders = given_runs(self.run_folders, self.outside, "evaluate")

        from mpma_mj.evaluation.disturbances import disturbance_levels
        from mpma_mj.evaluation.robustness import Robustness, as_csv, as_markdown, evaluate_levels
        from mpma_mj.evaluation.robustness_figure import write_figures
        from mpma_mj.training.checkpoints import TrainedAgents
        from mpma_mj.training.trainer import train_agents
        from mpma_mj.utils.progress import show_range

        parent = folders[0].evaluations if len(folders) == 1 else Path("runs")
        with contextlib.ExitStack() as stack:
            if self.out is None and len(folders) == 1:  # otherwise nothing is written to a run
                stack.enter_context(folders[0].locked())
            agents = {str(folder.path): TrainedAgents.of_run(folder) for folder in folders}
            first = next(iter(agents.values()))
            _check(agents, self.fine_tune)
            levels = disturbance_levels(
                first.configs[0],
                first.motion,
                disturbances=self.disturbances,
                levels=self.levels,
                motions=self.unseen,
                arms=self.arms,
            )
            for title, name in _BASELINES.items() if self.baselines else ():
                config = first.configs[0].replace(agent=name)
                agents[title] = train_agents([config], first.motion, 1, {})
            out = stack.enter_context(results_folder(self.out, "evaluation", parent))
            results = []
            for name, trained in agents.items():
                epochs = 0 if name in _BASELINES else self.fine_tune
                progress = functools.partial(show_range, title=f"evaluating {name}")
                results += evaluate_levels(name, trained, levels, epochs, progress)
            found = Robustness(results, tuple(agents), self.fine_tune)
            write_figures(out / "evaluation.png", found)
            write_tables(out, "evaluation", as_markdown(found), as_csv(found))
            return out


def _check(agents: Mapping[str, TrainedAgents], fine_tune: int) -> None:
    """Check that the agents of runs can be evaluated together.

    Raises:
        BadOptionError: Runs differ in motion or environment, or one cannot be fine-tuned.
        CheckpointError: An agent does not fit its config, or needs code from outside.
    """
    from mpma_mj.agents.registry import agent_class
    from mpma_mj.training.factory import make_environments

    first = next(iter(agents))
    for name, trained in agents.items():
        (config,) = trained.configs
        with contextlib.closing(make_environments(config, [config.seed], trained.motion)) as envs:
            trained.agent(envs)
        for part in ("motions", "reading", "env"):
            if getattr(config, part) != getattr(agents[first].configs[0], part):
                raise BadOptionError(
                    f"{name}: differs from {first} in motion or environment",
                    remedy="evaluate each separately",
                )
        if fine_tune and not agent_class(config.agent_name).fine_tunable:
            raise BadOptionError(
                f"{name}: its agent is {config.agent_name}, which does not learn",
                remedy="leave {fine_tune} out",
            )
