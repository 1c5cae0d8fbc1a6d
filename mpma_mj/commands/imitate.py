"""Command `mpma imitate`."""

from __future__ import annotations

import contextlib
import dataclasses
import functools
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Generic, Self, TypeVar

import tyro

from mpma_mj.agents.config import AgentConfig
from mpma_mj.commands.folders import hint_at_resuming, output_folder
from mpma_mj.commands.play import missing_opengl, write_run_video
from mpma_mj.commands.run_options import Motions, RunOptions, typed_options
from mpma_mj.errors import BadOptionError
from mpma_mj.utils.text import option_name

if TYPE_CHECKING:
    from mpma_mj.training.run import Run

__all__ = ["Imitate"]

AgentT = TypeVar("AgentT", bound=AgentConfig)


@dataclass(frozen=True, kw_only=True)
class Imitate(Generic[AgentT]):
    """Train an agent to imitate a motion; save the run, figures and a video."""

    motions: Motions = ()
    """"ymca", or a recording: C3D, BVH, AMC, TRC, TSV, CSV, npz; several, or a folder, form a
    repertoire that is learned together."""
    options: Annotated[tyro.conf.OmitArgPrefixes[RunOptions[AgentT]], tyro.conf.arg(name="")]
    """Options that determine the result."""
    epochs: int = 30
    """Largest number of epochs, with --resume of further epochs; without plants training
    ends when the run has converged."""
    out: Path | None = None
    """Folder of the run; runs/MOTION-TIME if not given."""
    video: bool = True
    """Write a video of the trained arms; needs OpenGL."""
    overwrite: bool = False
    """Replace the run in the folder."""
    resume: Path | None = None
    """Folder of a run to resume, with its config."""
    init: Path | None = None
    """Folder of a run with whose agent the new run begins, in the state of its best epoch (with
    plants: after the latest); agent, seed and arms are those of that run."""
    given: Annotated[frozenset[str], tyro.conf.Fixed, tyro.conf.Suppress] = frozenset()
    """Options that the command line contains, by their names in Python."""

    def run(self) -> Path:
        """Train, write the results and return the folder."""
        missing_gl = missing_opengl() if self.video else None
        from mpma_mj.training import run
        from mpma_mj.training.initial_state import begin_from
        from mpma_mj.training.run_folder import RunFolder
        from mpma_mj.utils.progress import show_epochs

        with contextlib.ExitStack() as stack:
            if self.resume is not None:
                folder = RunFolder(self.resume, self.options.outside)
                stack.enter_context(folder.locked())
                train = functools.partial(run.resume, folder, self.epochs)
            else:
                config = self.options.run_config(self.motions, "imitate")
                if self.init is not None:
                    config = begin_from(config, self.init, self.given)
                single = len(config.motions) == 1
                stem = Path(config.motions[0]).stem if single else "repertoire"
                folder = RunFolder(stack.enter_context(output_folder(self.out, stem)))
                train = functools.partial(
                    run.train, config, self.epochs, folder=folder, overwrite=self.overwrite
                )
            resume = f"mpma imitate --resume {folder.path}"
            with (
                hint_at_resuming(lambda: folder.can_go_on, resume),
                show_epochs(self.epochs) as show,
            ):
                trained = train(on_epoch=show)
            trained.write_figures(folder)
            _print_summary(trained)
            if missing_gl is not None:
                print(missing_gl, file=sys.stderr)
            elif self.video:
                write_run_video(folder)
            return folder.path

    def with_words(self, words: Sequence[str]) -> Self:
        """Return the command with the options that a command line contains as given.

        Args:
            words: Words of the command line; only options that they contain are compared with
                those of an earlier run.

        Raises:
            BadOptionError: An option differs from the config of the run that is resumed, or does
                not apply.
        """
        command = dataclasses.replace(self, given=frozenset(typed_options(words)))
        command._check_resumed()
        return command

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
                raise BadOptionError(
                    f"{option_name(name)} is {_text(given[name])}, but the run to resume has"
                    f" {_text(saved.get(name))}; leave it out, or start another run"
                )


def _text(value: object) -> str:
    """Return a value of an option as text."""
    return " ".join(map(str, value)) if isinstance(value, tuple) else str(value)


def _print_summary(run: Run) -> None:
    """Print the summary of a run in one line."""
    from mpma_mj.agents.registry import agent_class

    summary, of_plants = run.summary, run.config.env.plants is not None
    state = "converged" if summary["converged"] else "not converged"
    epochs = f"{summary['epochs']} epoch{'s' if summary['epochs'] > 1 else ''}"
    results = [f"p_e {summary['p_e_percent']:.2f} %"]
    if "feedback_ratio" in summary:
        results.append(f"feedback ratio {summary['feedback_ratio']:.3f}")
    if summary.get("plants", 1.0) > 1.0 and not agent_class(run.config.agent_name).observes_plant:
        results.append(f"{summary['plants']:.0f} plants found")
    if "dominant_module" in summary:
        modules = (f"{k} → {v or '–'}" for k, v in summary["dominant_module"].items())
        results.append(f"label → dominant module: {', '.join(modules)}")
    which = f"{'latest' if of_plants else 'best'} epoch {summary['best_epoch']:.0f}"
    print(f"{state} after {epochs}; {which}: {', '.join(results)}")
