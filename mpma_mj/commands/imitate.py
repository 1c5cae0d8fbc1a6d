"""Command `mpma imitate`."""

from __future__ import annotations

import contextlib
import functools
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Generic, TypeVar

import tyro

from mpma_mj.agents.config import AgentConfig
from mpma_mj.commands.folders import hint_if_interrupted, output_folder
from mpma_mj.commands.run_options import Given, Motions, RunOptions
from mpma_mj.commands.run_video import missing_opengl, write_run_video
from mpma_mj.errors import BadOptionError
from mpma_mj.utils.text import option_name, printable, shell_word

if TYPE_CHECKING:
    from mpma_mj.training.run import Run

__all__ = ["Imitate"]

AgentT = TypeVar("AgentT", bound=AgentConfig)


@dataclass(frozen=True, kw_only=True)
class Imitate(Generic[AgentT]):
    """Train an agent to imitate a motion; save the run, figures and a video."""

    motions: Motions = ()
    options: Annotated[tyro.conf.OmitArgPrefixes[RunOptions[AgentT]], tyro.conf.arg(name="")]
    """Options that determine the result."""
    epochs: int = 30
    """Largest number of epochs, with --resume of further ones (those that an interrupted run lacks
    if not given); without --plants a run ends when it has converged."""
    out: Path | None = None
    """Folder of the run; runs/MOTION-TIME if not given."""
    video: bool = True
    """Write a video of the trained arms, which needs OpenGL."""
    overwrite: bool = False
    """Replace the run in the folder."""
    resume: Path | None = None
    """Folder of a run to resume, with its config."""
    init: Path | None = None
    """Folder of a run whose agent goes on learning in a new run, from its best epoch (with plants:
    from the latest), with its seed and arms."""
    given: Given = frozenset()

    def run(self) -> Path:
        """Train, write the results and return the folder.

        Raises:
            BadOptionError: An option differs from the config of the run that is resumed, or does
                not apply.
        """
        self._check_resumed()
        missing_gl = missing_opengl() if self.video else None
        from mpma_mj.motions.built_in import file_stem
        from mpma_mj.training import run
        from mpma_mj.training.initial_state import begin_from
        from mpma_mj.training.run_folder import RunFolder
        from mpma_mj.utils.progress import show_epochs

        epochs = self.epochs if self.resume is None or "epochs" in self.given else None
        with contextlib.ExitStack() as stack:
            if self.resume is not None:
                folder = RunFolder(self.resume, self.options.outside)
                stack.enter_context(folder.locked())
                train = functools.partial(run.resume, folder, epochs)
            else:
                config = self.options.run_config(self.motions, "imitate")
                if self.init is not None:
                    config = begin_from(config, self.init, self.given)
                single = len(config.motions) == 1
                stem = file_stem(config.motions[0]) if single else "repertoire"
                folder = RunFolder(stack.enter_context(output_folder(self.out, stem)))
                train = functools.partial(
                    run.train, config, self.epochs, folder=folder, overwrite=self.overwrite
                )
            resume = f"to resume: mpma imitate --resume {shell_word(folder.path)}"
            resume += "" if self.video else " --no-video"
            new_epochs: list[dict[str, float]] = []
            with (
                hint_if_interrupted(resume, lambda: self.resume is not None or bool(new_epochs)),
                show_epochs(epochs) as show,
            ):

                def on_epoch(row: dict[str, float]) -> None:
                    new_epochs.append(row)
                    show(row)

                trained = train(on_epoch=on_epoch)
            if not new_epochs:
                print(f"{printable(str(folder.path))}: {_why_no_epoch(trained, folder.path)}")
            with hint_if_interrupted(resume):
                trained.write_figures(folder)
                _print_summary(trained)
                if missing_gl is not None:
                    print(missing_gl, file=sys.stderr)
                elif self.video:
                    write_run_video(folder)
            return folder.path

    def _check_resumed(self) -> None:
        """Check that no option contradicts the config of the run that is resumed."""
        if self.resume is None:
            return
        from mpma_mj.training.run_folder import RunFolder

        given_too = {
            "--overwrite": self.overwrite,
            "--out": self.out is not None,
            "--init": self.init is not None,
        }
        if any(given_too.values()):
            named = ", ".join(name for name, given in given_too.items() if given)
            raise BadOptionError(f"--resume continues in the folder of the run; leave {named} out")
        saved = RunFolder(self.resume, self.options.outside).read_config().options()
        motions = self.motions or ("ymca",)  # compared only if given
        given = self.options.run_config(motions, "imitate").options()
        typed = self.given | ({"motions"} if self.motions else set())
        for name in sorted(typed & given.keys()):
            if given[name] != saved.get(name):
                flag = name if name == "motions" else f"--{option_name(name)}"
                raise BadOptionError(
                    f"{flag} is {_text(given[name])}, but the run to resume has"
                    f" {_text(saved.get(name))}; leave it out, or start a new run"
                )


def _why_no_epoch(run: Run, path: Path) -> str:
    """Return why a resumed run has no new epoch."""
    if run.summary["converged"] and run.config.env.plants is None:
        remedy = f"to train its agent further: mpma imitate MOTION --init {shell_word(path)}"
        return f"has converged, so no epoch was added; {remedy}"
    return "has all its epochs, so no epoch was added; --epochs adds some"


def _text(value: object) -> str:
    """Return a value of an option as text."""
    return " ".join(map(str, value)) if isinstance(value, tuple) else str(value)


def _print_summary(run: Run) -> None:
    """Print the summary of a run in one line."""
    from mpma_mj.agents.registry import agent_class

    summary, of_plants = run.summary, run.config.env.plants is not None
    epochs = f"{summary['epochs']} epoch{'s' if summary['epochs'] > 1 else ''}"
    state = "converged" if summary["converged"] else "not converged"
    if of_plants:  # a run that goes on, whatever has converged
        head = f"trained for {epochs}; in the latest"
    else:
        head = f"{state} after {epochs}; best epoch {summary['best_epoch']:.0f}"
    results = [f"p_e {summary['p_e_percent']:.2f} %"]
    if "learner_acts" in summary:  # others vary less from episode to episode
        results = [f"learner's {results[0]} in one episode"]
        experts = [row["p_e_percent"] for row in run.history.rows if not row["learner_acts"]]
        results += [f"expert's {p_e:.2f} %" for p_e in experts[-1:]]  # none with --init
    if "feedback_ratio" in summary:
        results.append(f"feedback ratio {summary['feedback_ratio']:.3f}")
    if summary.get("plants", 1.0) > 1.0 and not agent_class(run.config.agent_name).observes_plant:
        results.append(f"{summary['plants']:.0f} plants found")
    if "dominant_module" in summary:
        modules = (f"{k} → {v or '–'}" for k, v in summary["dominant_module"].items())
        results.append(f"label → dominant module: {', '.join(modules)}")
    print(f"{head}: {', '.join(results)}")
