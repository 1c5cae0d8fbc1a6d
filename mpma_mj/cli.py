"""The command `mpma`."""

from __future__ import annotations

import contextlib
import dataclasses
import itertools
import sys
import time
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

from mpma_mj import __version__
from mpma_mj.envs.gl import require_backend
from mpma_mj.errors import BadOptionError, MpmaError, RecordingWarning, RenderingError
from mpma_mj.motions.options import option_name
from mpma_mj.training.config import ReadingArguments, RunConfig, Settings

if TYPE_CHECKING:
    from mpma_mj.training.run_folder import RunFolder

__all__ = ["main"]

_INTERRUPTED = 130  # what shells expect of a command that was stopped by Ctrl-C


@dataclass(frozen=True)
class Imitate:
    """Train the arms on a movement, save the run, make figures and a video."""

    motions: Annotated[tuple[str, ...], tyro.conf.Positional, tyro.conf.arg(metavar="MOTION")] = ()
    """"ymca", or a recording: C3D, BVH, AMC, TRC, TSV, CSV, npz; several, or a folder, are a
    repertoire that is learned together."""
    settings: tyro.conf.OmitArgPrefixes[Settings] = dataclasses.field(default_factory=Settings)
    """What decides the result."""
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
        missing_gl = _try_backend() if self.video else None
        from mpma_mj.training import imitate
        from mpma_mj.training.progress import show_epochs
        from mpma_mj.training.run_folder import RunFolder

        with show_epochs(self.epochs) as show:
            if self.resume is not None:
                folder = RunFolder(self.resume)
                summary = imitate.resume(folder, self.epochs, on_epoch=show)
            else:
                config = self._config()
                folder = RunFolder(self.out or _default_folder(config.motions))
                summary = imitate.start(
                    config, folder, self.epochs, overwrite=self.overwrite, on_epoch=show
                )
        _print_summary(summary)
        _draw_figures(folder)
        if missing_gl is not None:
            print(missing_gl, file=sys.stderr)
        elif self.video:
            _draw_video(folder, "front")
        return folder.path

    def check_resumed(self, words: Sequence[str]) -> None:
        """Refuse options that contradict the run that goes on.

        Args:
            words: What was typed; options that were left out contradict nothing.
        """
        if self.resume is None:
            return
        from mpma_mj.training.movements import expand_folders
        from mpma_mj.training.run_folder import RunFolder

        if self.overwrite or self.out is not None:
            raise BadOptionError(
                "--resume goes on in the run's own folder; drop --overwrite, --out"
            )
        saved = RunFolder(self.resume).read_config()
        flags = [word.split("=")[0].replace("_", "-") for word in words if word.startswith("--")]
        typed = {flag.removeprefix("--").removeprefix("no-") for flag in flags}
        settings = dataclasses.asdict(self.settings)
        given = {name: value for name, value in settings.items() if option_name(name) in typed}
        if self.motions:
            given["motion"] = expand_folders(self.motions)
        for name, value in given.items():
            was = saved.motions if name == "motion" else getattr(saved, name)
            if value != was:
                raise BadOptionError(
                    f"{option_name(name)} is {_shown(value)}, but the run to resume has"
                    f" {_shown(was)}; leave it out, or start another run"
                )

    def _config(self) -> RunConfig:
        from mpma_mj.training.movements import expand_folders

        if not self.motions:
            raise BadOptionError("no motion given; try: mpma imitate ymca")
        motions = expand_folders(self.motions)
        return RunConfig(motions=motions, **dataclasses.asdict(self.settings))


@dataclass(frozen=True)
class Render:
    """Make the video of a trained run, anew or from another side."""

    run_folder: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="RUN")]
    """Folder of the run."""
    camera: Literal["front", "side", "three_quarter"] = "front"
    """Where to look from."""

    def run(self) -> Path:
        """Do it and return the video's path."""
        require_backend()
        from mpma_mj.training.run_folder import RunFolder

        folder = RunFolder(self.run_folder)
        folder.read_config()
        _draw_video(folder, self.camera)
        return folder.video


@dataclass(frozen=True)
class InspectMotion:
    """Show what a recording holds and asks of the arms, as text and as a page of pictures."""

    motion: Annotated[str, tyro.conf.Positional, tyro.conf.arg(metavar="MOTION")]
    """"ymca", or a recording: C3D, BVH, AMC, TRC, TSV, CSV, npz."""
    reading: tyro.conf.OmitArgPrefixes[ReadingArguments] = dataclasses.field(
        default_factory=ReadingArguments
    )
    """How to read it."""
    picture: Path | None = None
    """Where the page of pictures goes; NAME-motion.png if not given."""
    video: bool = False
    """Make a video of arms that follow it ideally, beside the page, .mp4."""
    out: Path | None = None
    """Write the movement as an npz file, which every command reads again."""
    overwrite: bool = False
    """Replace the npz file if it is there."""

    def run(self) -> Path:
        """Do it and return the picture's path."""
        if self.video:
            require_backend()
        for option, path, ending in (("out", self.out, ".npz"), ("picture", self.picture, ".png")):
            if path is not None and path.suffix != ending:
                raise BadOptionError(f"{option} is {path}; expected a name that ends in {ending}")
        if self.out is not None and self.out.exists() and not self.overwrite:
            raise BadOptionError(f"{self.out}: is there already; --overwrite replaces it")
        from mpma_mj.envs.load import arm_limits
        from mpma_mj.motions import motion_file
        from mpma_mj.motions.read import read_with_findings
        from mpma_mj.motions.report import report_lines
        from mpma_mj.training.motion_page import write_ideal_video, write_page
        from mpma_mj.training.progress import show_frames

        reading = read_with_findings(self.motion, self.reading.reading)
        reading.findings.tell(self.motion)
        limits = arm_limits("physics")
        print("\n".join(report_lines(reading, *limits)))
        if self.out is not None:
            motion_file.write(self.out, reading.motion)
        picture = self.picture or Path(f"{reading.motion.name}-motion.png")
        write_page(picture, reading, limits[0])
        if self.video:
            write_ideal_video(picture.with_suffix(".mp4"), reading, show_frames)
            print(picture.with_suffix(".mp4"))
        return picture


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line.

    Args:
        arguments: Words after the command's name; those of the process if not given.

    Returns:
        Exit code: 0, 2 for something that the user has to mend, 1 for a run that failed.
    """
    words = list(sys.argv[1:] if arguments is None else arguments)
    if words == ["--version"]:
        print(f"mpma {__version__}")
        return 0
    command = tyro.extras.subcommand_cli_from_dict(
        {"imitate": Imitate, "motion": InspectMotion, "render": Render},
        prog="mpma",
        description="Two simulated arms learn to dance from recordings.",
        args=words,
    )
    try:
        if isinstance(command, Imitate):
            command.check_resumed(words)
        with _warnings_as_lines():
            print(command.run())
    except MpmaError as error:
        print(f"mpma: {error}", file=sys.stderr)
        return error.exit_code
    except MemoryError:
        print(
            "mpma: not enough memory; take fewer --modules, --nodes, --repeats, or less time",
            file=sys.stderr,
        )
        return 1
    except OSError as error:
        place = f"{error.filename}: " if error.filename else ""
        print(f"mpma: {place}{error.strerror or error}; check path and rights", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        hint = "; finished epochs are saved, --resume FOLDER goes on"
        print(f"mpma: interrupted{hint * isinstance(command, Imitate)}", file=sys.stderr)
        return _INTERRUPTED
    return 0


@contextlib.contextmanager
def _warnings_as_lines() -> Iterator[None]:
    """Show what may be wrong with a recording as one line each, without where in the code."""

    def show(message: Warning | str, *_: object, **__: object) -> None:
        print(f"mpma: warning: {message}", file=sys.stderr)

    with warnings.catch_warnings():
        warnings.simplefilter("always", RecordingWarning)
        warnings.showwarning = show
        yield


def _try_backend() -> str | None:
    """Look for OpenGL before training; return what to say if there is none."""
    try:
        require_backend()
    except RenderingError as error:
        return f"mpma: {error}"
    return None


def _shown(value: object) -> str:
    return " ".join(value) if isinstance(value, tuple) else str(value)


def _default_folder(motions: Sequence[str]) -> Path:
    stem = Path(motions[0]).stem if len(motions) == 1 else "repertoire"
    name = f"{stem}-{time.strftime('%Y%m%d-%H%M%S')}"
    names = itertools.chain([name], (f"{name}-{i}" for i in itertools.count(2)))
    return next(path for path in (Path("runs") / n for n in names) if not path.exists())


def _draw_figures(folder: RunFolder) -> None:
    from mpma_mj.training.figures import write_figures

    write_figures(folder.figures, folder.read_trace(), folder.read_motion())


def _draw_video(folder: RunFolder, camera: str) -> None:
    from mpma_mj.training.progress import show_frames
    from mpma_mj.training.video import write_video

    write_video(
        folder.video,
        folder.read_trace(),
        folder.read_motion(),
        camera=camera,
        progress=show_frames,
    )


def _print_summary(summary: dict[str, Any]) -> None:
    modules = ", ".join(f"{k} → {v + 1}" for k, v in summary["dominant_module"].items())
    state = "converged" if summary["converged"] else "not converged"
    epochs = f"{summary['epochs']} epoch{'s' if summary['epochs'] > 1 else ''}"
    print(
        f"{state} after {epochs}; kept epoch {summary['kept_epoch']:.0f}:"
        f" p_e {summary['p_e_percent']:.2f} %, feedback ratio {summary['feedback_ratio']:.3f},"
        f" label → dominant module: {modules}"
    )


if __name__ == "__main__":
    sys.exit(main())
