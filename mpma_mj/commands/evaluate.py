"""Command `mpma stress`."""

from __future__ import annotations

import contextlib
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from mpma_mj.commands.folders import output_folder, write_tables
from mpma_mj.commands.run_options import Outside, OutsideClasses
from mpma_mj.errors import BadOptionError, WorkerError

if TYPE_CHECKING:
    from mpma_mj.experiments.robustness import Found
    from mpma_mj.experiments.robustness_results import Results

__all__ = ["Stress"]

_DEFAULT_AGENTS: tuple[str, ...] = (
    *("mpma", "single", "mosaic", "hammer"),
    *("resolved_rate", "feedback_only"),
)
_ADAPT_EPOCHS = 10
_ADAPTED = ("adapt.csv", "adapt.png")


@dataclass(frozen=True)
class Stress:
    """Stress test: evaluate a trained run and other agents under disturbances."""

    run_folder: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="RUN")]
    """Folder of a run; its config applies to all agents."""
    agents: tuple[str, ...] = ()
    """Agents for comparison, or paths of classes such as my_agents.py:MyAgent; mpma, single,
    mosaic, hammer, resolved_rate and feedback_only if not given."""
    runs: int = 10
    """Runs of each of these agents, with seeds from that of the run up; 0 for the run alone."""
    epochs: int = 30
    """Largest number of epochs of their training, which ends when a run has converged."""
    disturbances: tuple[str, ...] = ()
    """Some of payload, strength, gravity, latency, noise, pushes, tempo, mirrored, locked, unseen;
    all if not given."""
    levels: tuple[str, ...] = ()
    """Levels of a single disturbance, in place of the default ones."""
    unseen: tuple[str, ...] = ()
    """Recordings that were not trained, in place of synthetic motions."""
    adapt: bool = False
    """Fine-tune the agents in each condition, and report the epochs until p_e is under 1 %."""
    adapt_epochs: int | None = None
    """Largest number of epochs of fine-tuning with --adapt; 10 if not given."""
    workers: int | None = None
    """Number of parallel processes; as many as there are processors if not given."""
    out: Path | None = None
    """Folder of tables and figures, where they replace earlier ones; RUN/stress/stress-TIME if not
    given."""

    outside: Outside = OutsideClasses()
    """Code from outside the package with which runs were trained."""

    def run(self) -> Path:
        """Run the stress test and return its folder."""
        from mpma_mj.experiments.backend import open_backend

        self._check_numbers()
        agents = self._chosen_agents()
        adapts = (self.adapt_epochs or _ADAPT_EPOCHS) if self.adapt else 0
        with (
            contextlib.ExitStack() as stack,
            open_backend("processes", self.workers, None) as backend,
        ):
            # Workers start while these modules are imported.
            from mpma_mj.agents.registry import agent_class
            from mpma_mj.evaluation.conditions import trials
            from mpma_mj.evaluation.disturbances import DISTURBANCES
            from mpma_mj.experiments.backend import get_done
            from mpma_mj.experiments.robustness import THIS_RUN, jobs
            from mpma_mj.experiments.robustness_results import Results
            from mpma_mj.training.checkpoints import TrainedAgents
            from mpma_mj.training.run_folder import open_runs
            from mpma_mj.utils.progress import show_runs

            (folder,) = open_runs([self.run_folder], **vars(self.outside))
            if self.out is None:
                stack.enter_context(folder.locked())
            own = TrainedAgents.of_run(folder)
            if self.adapt and not agent_class(own.configs[0].agent_name).fine_tunable:
                raise BadOptionError(
                    f"{folder.path}: its agent is {own.configs[0].agent_name}, which learns nothing"
                    " more; leave --adapt out"
                )
            names = self.disturbances or tuple(DISTURBANCES)
            spec = trials(names, self.levels, self.unseen, own)
            works = jobs(own, agents, self.runs, self.epochs, spec, adapts, backend.workers)
            out = stack.enter_context(output_folder(self.out, "stress", folder.stress))
            found: list[Found] = []
            with show_runs(sum(work.size for work in works), 0, "trying", "trials") as show:
                for work, done in get_done(works, backend):
                    if done is None:
                        raise WorkerError(
                            f"a worker that tried {work.agent} died repeatedly (memory?); take"
                            " fewer --workers, or fewer --runs"
                        )
                    found += done
                    show(work.size, work.agent)
            results = Results(found, [*agents, THIS_RUN], adapts)
            return _write(results, out)

    def _check_numbers(self) -> None:
        if self.adapt_epochs is not None and not self.adapt:
            raise BadOptionError("adapt-epochs is given without --adapt; add that, or leave it out")
        for name, least in (("runs", 0), ("epochs", 1), ("adapt_epochs", 1)):
            value = getattr(self, name)
            if value is not None and value < least:
                option = name.replace("_", "-")
                raise BadOptionError(f"{option} is {value}; expected at least {least}")

    def _chosen_agents(self) -> tuple[str, ...]:
        """Return the agents that are trained for comparison.

        Raises:
            BadOptionError: Agents are named but not trained, or one cannot be fine-tuned.
        """
        if self.runs == 0:
            if self.agents:
                raise BadOptionError("runs is 0, so no agents are trained; drop --agents or --runs")
            return ()
        if not self.agents:
            return _DEFAULT_AGENTS
        from mpma_mj.agents.registry import agent_class

        for agent in self.agents:
            if self.adapt and not agent_class(agent).fine_tunable:
                raise BadOptionError(
                    f"{agent} learns nothing more; leave it out of --agents, or --adapt out"
                )
        return tuple(dict.fromkeys(self.agents))


def _write(results: Results, folder: Path) -> Path:
    """Write tables and figures in place of earlier ones, and print the tables."""
    from mpma_mj.experiments.robustness_figure import write_figure
    from mpma_mj.experiments.robustness_table import as_csv, as_markdown, courses_as_csv
    from mpma_mj.utils.atomic_files import write_text

    write_figure(folder / "stress.png", results, results.agents, results.p_e, "p_e, %")
    if not results.adapts:
        for name in _ADAPTED:
            (folder / name).unlink(missing_ok=True)
    else:
        write_text(folder / "adapt.csv", courses_as_csv(results))
        label = f"p_e after {results.adapts} epochs of fine-tuning, %"
        write_figure(folder / "adapt.png", results, results.learners, results.p_e_after, label)
    write_tables(folder, "stress", as_markdown(results), as_csv(results))
    return folder
