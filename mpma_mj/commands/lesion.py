"""Command `mpma lesion`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from mpma_mj.commands.folders import locked_runs, write_result
from mpma_mj.commands.run_options import Outside, OutsideClasses, RunFolders
from mpma_mj.errors import BadOptionError

if TYPE_CHECKING:
    from mpma_mj.training.run_folder import RunFolder

__all__ = ["Lesion"]


@dataclass(frozen=True)
class Lesion:
    """Lesions: remove each module, and each pair of modules, of trained runs.

    Reports the errors that result and the modules that take over, and writes lesion.json and
    figures/lesion.png to the folder of each run.
    """

    run_folders: RunFolders
    """Folders of runs."""
    retrain: int = 3
    """Epochs of fine-tuning with the remaining modules; 0 for none."""

    outside: Outside = OutsideClasses()
    """Code from outside the package with which runs were trained."""

    def run(self) -> Path:
        """Evaluate all lesions and return the path of the last figure."""
        from mpma_mj.analysis.danced import read_danced
        from mpma_mj.training.checkpoints import TrainedAgents
        from mpma_mj.trials.lesion import Lesions, dance_without, what_can_be_lost
        from mpma_mj.trials.lesion_figure import write_figure
        from mpma_mj.trials.lesion_table import matrix, summary
        from mpma_mj.utils.progress import show_range

        if self.retrain < 0:
            raise BadOptionError(f"retrain is {self.retrain}; expected 0 or more epochs")
        with locked_runs(self.run_folders, self.outside, "lesion") as folders:
            _check_comparable(folders)
            runs = []
            for folder in folders:
                read_danced(folder)  # raises for modules without output
                trained = TrainedAgents.of_run(folder)
                runs.append((folder, trained, what_can_be_lost(trained)))
            results = []
            for folder, trained, losses in runs:
                title = f"{folder.path.name}: switching modules off"
                steps = show_range(range(len(losses)), title)
                lesions = [dance_without(trained, losses[step], self.retrain) for step in steps]
                result = Lesions(trained.motion.labels, tuple(lesions), self.retrain)
                results.append(result)
                write_result(folder.lesion, trained.motion.name, result.as_json())
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
            raise BadOptionError(f"{folder.path}: is there twice; leave one out")
        if without_seed(config) != without_seed(configs[0]):
            raise BadOptionError(
                f"{folder.path}: differs from {first.path} in more than its seed, so that they"
                " cannot be summarised together; run the command for each"
            )
