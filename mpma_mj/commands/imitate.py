"""`mpma imitate`."""

from __future__ import annotations

import contextlib
import functools
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Generic, TypeVar

import tyro

from mpma_mj.agents.config import AgentConfig
from mpma_mj.commands.dance_video import missing_opengl, write_dance_video
from mpma_mj.commands.folders import output_folder
from mpma_mj.commands.run_options import RunOptions, typed_options
from mpma_mj.errors import BadOptionError
from mpma_mj.training.config import RunConfig
from mpma_mj.utils.option_names import option_name

if TYPE_CHECKING:
    from mpma_mj.training.run_folder import RunFolder

__all__ = ["Imitate"]

AgentT = TypeVar("AgentT", bound=AgentConfig)


@dataclass(frozen=True, kw_only=True)
class Imitate(Generic[AgentT]):
    """Train the arms on a movement, save the run, make figures and a video."""

    motions: Annotated[tuple[str, ...], tyro.conf.Positional, tyro.conf.arg(metavar="MOTION")] = ()
    """"ymca", or a recording: C3D, BVH, AMC, TRC, TSV, CSV, npz; several, or a folder, are a
    repertoire that is learned together."""
    options: tyro.conf.OmitArgPrefixes[RunOptions[AgentT]]
    """What determines the result."""
    epochs: int = 30
    """Most epochs to train, with --resume most further ones; it ends when it has converged."""
    out: Path | None = None
    """Folder of the run; runs/MOTION-TIME if not given."""
    video: bool = True
    """Make a video of the trained arms; needs OpenGL."""
    overwrite: bool = False
    """Replace the run that is in the folder."""
    resume: Path | None = None
    """Folder of a run to go on with; its own settings hold."""

    def run(self) -> Path:
        """Do it and return the folder."""
        missing_gl = missing_opengl() if self.video else None
        from mpma_mj.training import run
        from mpma_mj.training.run_folder import RunFolder
        from mpma_mj.utils.progress import show_epochs
        from mpma_mj.visualization.figures import write_figures

        with contextlib.ExitStack() as stack:
            if self.resume is not None:
                folder = RunFolder(self.resume, self.options.outside)
                stack.enter_context(folder.locked())
                train = functools.partial(run.resume, folder, self.epochs)
            else:
                config = self._config()
                path = stack.enter_context(output_folder(self.out, _stem(config.motions)))
                folder = RunFolder(path)
                train = functools.partial(
                    run.start, config, folder, self.epochs, overwrite=self.overwrite
                )
            with _hint_at_resuming(folder), show_epochs(self.epochs) as show:
                trained = train(on_epoch=show)
            write_figures(folder.figures, trained.trace, trained.motion)
            _print_summary(trained.summary)
            if missing_gl is not None:
                print(missing_gl, file=sys.stderr)
            elif self.video:
                write_dance_video(folder, "front")
            return folder.path

    def check_resumed(self, words: Sequence[str]) -> None:
        """Refuse options that contradict the run that goes on.

        Args:
            words: What was typed; options that were left out contradict nothing.
        """
        if self.resume is None:
            return
        from mpma_mj.training.dataset import expand_folders
        from mpma_mj.training.run_folder import RunFolder

        if self.overwrite or self.out is not None:
            raise BadOptionError(
                "--resume goes on in the run's own folder; drop --overwrite, --out"
            )
        saved = RunFolder(self.resume, self.options.outside).read_config().options()
        given = self.options.run_config(expand_folders(self.motions)).options()
        typed = typed_options(words) | ({"motions"} if self.motions else set())
        for name in sorted(typed & given.keys()):
            if given[name] != saved.get(name):
                raise BadOptionError(
                    f"{option_name(name)} is {_shown(given[name])}, but the run to resume has"
                    f" {_shown(saved.get(name))}; leave it out, or start another run"
                )

    def _config(self) -> RunConfig:
        from mpma_mj.training.dataset import expand_folders

        if not self.motions:
            raise BadOptionError("no motion given; try: mpma imitate ymca")
        motions = expand_folders(self.motions)
        return self.options.run_config(motions)


@contextlib.contextmanager
def _hint_at_resuming(folder: RunFolder) -> Iterator[None]:
    """Say where an interrupted run can be gone on with, if an epoch of it is saved."""
    try:
        yield
    except KeyboardInterrupt:
        if folder.can_go_on:
            print(f"mpma: to go on: mpma imitate --resume {folder.path}", file=sys.stderr)
        raise


def _shown(value: object) -> str:
    return " ".join(value) if isinstance(value, tuple) else str(value)


def _stem(motions: Sequence[str]) -> str:
    return Path(motions[0]).stem if len(motions) == 1 else "repertoire"


def _print_summary(summary: dict[str, Any]) -> None:
    state = "converged" if summary["converged"] else "not converged"
    epochs = f"{summary['epochs']} epoch{'s' if summary['epochs'] > 1 else ''}"
    results = [f"p_e {summary['p_e_percent']:.2f} %"]
    if "feedback_ratio" in summary:
        results.append(f"feedback ratio {summary['feedback_ratio']:.3f}")
    if "dominant_module" in summary:
        modules = (f"{k} → {v or '–'}" for k, v in summary["dominant_module"].items())
        results.append(f"label → dominant module: {', '.join(modules)}")
    print(f"{state} after {epochs}; best epoch {summary['best_epoch']:.0f}: {', '.join(results)}")
