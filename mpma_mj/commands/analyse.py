"""Command `mpma analyse`."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from mpma_mj.commands.folders import locked_runs, write_result
from mpma_mj.commands.run_options import Outside, OutsideClasses, RunFolders
from mpma_mj.errors import BadOptionError
from mpma_mj.utils.text import did_you_mean, printable

if TYPE_CHECKING:
    from mpma_mj.training.run_folder import RunFolder

__all__ = ["Analyse", "with_analysis"]


@dataclass(frozen=True)
class Modules:
    """Specialisation of the modules: shares, information, synergies, repetition.

    Writes modules.json and figures/modules.png to the folder of each run.
    """

    run_folders: RunFolders
    """Folders of runs."""

    def run(self) -> Path:
        """Analyse the runs and return the path of the last figure."""
        # A trace is read without the classes from outside that made it.
        with locked_runs(self.run_folders, None, "analyse") as folders:
            from mpma_mj.analysis.modules import analyse_modules
            from mpma_mj.analysis.modules_report import as_markdown, write_figure
            from mpma_mj.training.checkpoints import read_module_trace
            from mpma_mj.utils.progress import show_range

            for folder in folders:
                demonstration, trace = read_module_trace(folder)
                motion = demonstration.motion
                analysis = analyse_modules(
                    trace,
                    motion.labels,
                    demonstration.period,
                    lambda factors: show_range(factors, "looking for synergies"),
                    demonstration.kinematics.joint_names,
                )
                write_result(folder.results_of("modules"), motion.name, analysis.as_json())
                picture = folder.figures / "modules.png"
                write_figure(picture, analysis, motion)
                title = f"{printable(str(folder.path))}\n\n" if len(folders) > 1 else ""
                print(f"{title}{as_markdown(analysis)}\n")
            return picture


@dataclass(frozen=True)
class Lesion:
    """Lesions: drop each module, and each pair of modules.

    Reports the errors that result and the modules that take over, and writes lesion.json and
    figures/lesion.png to the folder of each run.
    """

    run_folders: RunFolders
    """Folders of runs that differ in their seeds only."""
    fine_tune: int = 3
    """Epochs of fine-tuning with the remaining modules; 0 for none."""

    outside: Outside = OutsideClasses()
    """Code from outside the package with which runs were trained."""

    def run(self) -> Path:
        """Evaluate all lesions and return the path of the last figure."""
        if self.fine_tune < 0:
            raise BadOptionError(
                option="fine_tune", value=self.fine_tune, expected="0 or more epochs"
            )
        with locked_runs(self.run_folders, self.outside, "analyse") as folders:
            from mpma_mj.analysis.lesion import Lesions, apply_lesion, possible_lesions
            from mpma_mj.analysis.lesion_report import matrix, summary, write_figure
            from mpma_mj.training.checkpoints import TrainedAgents, read_module_trace
            from mpma_mj.utils.progress import show_range

            _check_comparable(folders)
            runs = []
            for folder in folders:
                read_module_trace(folder)  # raises for modules without output
                trained = TrainedAgents.of_run(folder)
                runs.append((folder, trained, possible_lesions(trained)))
            results = []
            for folder, trained, possible in runs:
                title = f"{folder.path.name}: dropping modules"
                steps = show_range(range(len(possible)), title)
                lesions = tuple(
                    apply_lesion(trained, possible[step], self.fine_tune) for step in steps
                )
                result = Lesions(trained.motion.labels, lesions, self.fine_tune)
                results.append(result)
                write_result(folder.results_of("lesion"), trained.motion.name, result.as_json())
                picture = folder.figures / "lesion.png"
                write_figure(picture, result, trained.motion.name)
            if len(results) == 1:
                print(matrix(results[0]) + "\n")
            print(summary(results))
            return picture


def _check_comparable(folders: Sequence[RunFolder]) -> None:
    """Check that runs differ in their seeds only, so that they can be summarised.

    Raises:
        BadOptionError: A run is given twice, or differs in more than its seed.
    """
    from mpma_mj.experiments.batching import without_seed

    first = folders[0]
    configs = [folder.read_config() for folder in folders]
    for number, (folder, config) in enumerate(zip(folders, configs, strict=True)):
        if config in configs[:number]:
            raise BadOptionError(f"{folder.path}: is given twice; leave one out")
        if without_seed(config) != without_seed(configs[0]):
            raise BadOptionError(
                f"{folder.path}: differs from {first.path} in more than its seed",
                remedy="analyse each separately",
            )


@dataclass(frozen=True)
class FreeRunning:
    """Free-running: continue without the demonstration, with the context alone.

    In its place agents receive their own prediction, or that of a reservoir that has learned the
    demonstration. Reports for how long and how precisely they continue, and writes
    free_running.json and figures/free_running.png to the folder of each run.
    """

    run_folders: RunFolders
    """Folders of runs."""

    beat: float | None = None
    """Length of the parts into which the context of that reservoir divides the motion, s; its
    labels are the context if not given."""

    outside: Outside = OutsideClasses()
    """Code from outside the package with which runs were trained."""

    def run(self) -> Path:
        """Run all agents without demonstration and return the path of the last figure."""
        with locked_runs(self.run_folders, self.outside, "analyse") as folders:
            from mpma_mj.analysis.free_running import ANTICIPATION, check_beat, run_freely
            from mpma_mj.analysis.free_running_report import (
                FreeRunMeasures,
                as_markdown,
                measure,
                write_figure,
            )
            from mpma_mj.training.checkpoints import read_module_trace
            from mpma_mj.utils.progress import show_range

            for folder in folders:
                demonstration, _ = read_module_trace(folder)  # raises for modules without output
                if self.beat is not None:
                    check_beat(demonstration.period, demonstration.motion.rate, self.beat)
            results: dict[str, FreeRunMeasures] = {}
            for number in show_range(range(len(folders)), "running without demonstration"):
                folder = folders[number]
                free, motion = run_freely(folder, self.beat)
                measures = {name: measure(run) for name, run in free.items()}
                results |= {f"{folder.path}, {name}": found for name, found in measures.items()}
                content = {name: dataclasses.asdict(found) for name, found in measures.items()}
                write_result(
                    folder.results_of("free_running"), motion.name, {"beat_s": self.beat} | content
                )
                picture = folder.figures / "free_running.png"
                write_figure(picture, free[ANTICIPATION], motion)
            print(as_markdown(results))
            return picture


_ANALYSES = ("modules", "lesion", "free-running")


@dataclass(frozen=True)
class Analyse:
    """Analyse trained runs: modules, lesion or free-running; modules if not given.

    mpma analyse RUN... [modules|lesion|free-running]
    """

    analysis: tyro.conf.OmitArgPrefixes[
        tyro.conf.OmitSubcommandPrefixes[
            Annotated[Modules, tyro.conf.subcommand("modules")]
            | Annotated[Lesion, tyro.conf.subcommand("lesion")]
            | Annotated[FreeRunning, tyro.conf.subcommand("free-running")]
        ]
    ]

    def run(self) -> Path:
        """Run the analysis and return the path of the last figure."""
        return self.analysis.run()


def with_analysis(words: Sequence[str]) -> list[str]:
    """Return the words of a command line with the analysis before the runs.

    Args:
        words: Words after `mpma analyse`, with the analysis before or after the runs, or without.

    Raises:
        BadOptionError: There are no words, or one that is no path is similar to an analysis.
    """
    if not words:
        raise BadOptionError(f"no run given; try: mpma analyse runs/ymca [{'|'.join(_ANALYSES)}]")
    if words[0] in ("--help", "-h"):
        return [*words]
    for place, word in enumerate(words):
        if word in _ANALYSES:
            return [word, *words[:place], *words[place + 1 :]]
    for word in words:
        remedy = did_you_mean(word, _ANALYSES)
        if remedy and not Path(word).exists():
            expected = ", ".join(_ANALYSES)
            raise BadOptionError(f"no analysis '{word}'; expected one of {expected}", remedy=remedy)
    return [_ANALYSES[0], *words]
