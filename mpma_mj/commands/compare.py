"""Command `mpma compare`."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Generic, TypeVar

import tyro

from mpma_mj.agents.config import AgentConfig
from mpma_mj.commands.folders import hint_if_interrupted, results_folder, write_tables
from mpma_mj.commands.run_options import Given, Motions, RunOptions
from mpma_mj.commands.run_video import missing_opengl
from mpma_mj.errors import BadOptionError
from mpma_mj.training.config import RunConfig, versions

if TYPE_CHECKING:
    from mpma_mj.experiments.compare import Transfer
    from mpma_mj.experiments.compare_robots import OnRobot
    from mpma_mj.motions import Motion

__all__ = ["Compare"]

AgentT = TypeVar("AgentT", bound=AgentConfig)
R = TypeVar("R")

_FIGURES = ("transfer.png", "episodes.png")
_VIDEOS = ("episodes.mp4", "overlaid.mp4", "overlaid.png")
_OF_ROBOTS = ("robots.mp4", "robots.png")


@dataclass(frozen=True, kw_only=True)
class Compare(Generic[AgentT]):
    """Train on ideal arms, simulated arms and simulated arms without weight; evaluate on each.

    Or on several robots, as mpma compare ymca --robots two_arm h1 openarm: tables of what each
    can do and of what its agents learn, and all of them side by side.
    """

    motions: Motions = ()
    runs: int = 5
    """Runs on each kind of arms, with seeds from 0."""
    options: Annotated[tyro.conf.OmitArgPrefixes[RunOptions[AgentT]], tyro.conf.arg(name="")]
    """Options that determine the result."""
    robots: tuple[str, ...] = ()
    """Robots to compare, in place of kinds of arms; each is trained and evaluated with the options
    given."""
    epochs: int = 30
    """Largest number of epochs of a run; it ends when it has converged."""
    fine_tune: int = 3
    """Epochs of fine-tuning on the arms of the evaluation."""
    workers: int | None = None
    """Number of parallel processes; as many as there are processors if not given."""
    video: bool = True
    """Write videos of all arms next to each other, and of heavy over ideal ones; needs OpenGL."""
    out: Path | None = None
    """Folder of tables, figures and video, where they replace earlier ones; runs/compare-TIME if
    not given."""
    given: Given = frozenset()

    def run(self) -> Path:
        """Run the comparison and return its folder."""
        if self.robots:
            return self._compare_robots()
        missing_gl = missing_opengl() if self.video else None
        from mpma_mj.experiments.batching import seeds
        from mpma_mj.experiments.compare import compare, jobs
        from mpma_mj.experiments.compare_report import (
            as_csv,
            as_markdown,
            write_episodes,
            write_transfer,
        )
        from mpma_mj.training.dataset import read_motions

        config = self.options.run_config(self.motions, "compare")
        motion = read_motions(config)
        spec = jobs(seeds(config, self.runs), motion, epochs=self.epochs, fine_tune=self.fine_tune)
        with results_folder(self.out, "compare") as folder:
            transfers = self._done(compare, spec)
            self._begin(folder, config, fine_tune=self.fine_tune)
            write_transfer(folder / "transfer.png", transfers, self.fine_tune)
            write_episodes(folder / "episodes.png", transfers, motion)
            write_tables(
                folder, "compare", as_markdown(transfers, self.fine_tune), as_csv(transfers)
            )
            if missing_gl is not None:
                print(missing_gl, file=sys.stderr)
            elif self.video:
                audio = config.reading.audio
                _write_videos(folder, transfers, motion, None if audio is None else Path(audio))
            return folder

    def _compare_robots(self) -> Path:
        """Compare robots and return the folder."""
        if "fine_tune" in self.given:
            problem = "is for kinds of arms: on a robot there is nothing else to tune to"
            remedy = "leave it out, or leave {robots} out"
            raise BadOptionError(problem, option="fine_tune", remedy=remedy)
        missing_gl = missing_opengl() if self.video else None
        from mpma_mj.experiments.compare_robots import compare_robots, robot_jobs
        from mpma_mj.experiments.compare_robots_report import as_csv, as_markdown

        config = self.options.run_config(self.motions, "compare")
        jobs = robot_jobs(config, self.robots, runs=self.runs, epochs=self.epochs)
        with results_folder(self.out, "compare") as folder:
            results = self._done(compare_robots, jobs)
            self._begin(folder, config, robots=list(self.robots))
            write_tables(folder, "compare", as_markdown(results), as_csv(results))
            if missing_gl is not None:
                print(missing_gl, file=sys.stderr)
            elif self.video:
                audio = config.reading.audio
                _draw_robots(folder, results, None if audio is None else Path(audio))
            return folder

    def _done(self, compare: Callable[..., list[R]], jobs: Sequence[Any]) -> list[R]:
        """Do jobs in parallel and show the progress."""
        from mpma_mj.experiments.backend import open_backend
        from mpma_mj.utils.progress import show_runs

        with (
            hint_if_interrupted("nothing is saved: a comparison is written at its end"),
            open_backend("processes", self.workers, None) as backend,
            show_runs(len(jobs) * self.runs, 0, "training and evaluating") as show,
        ):
            return compare(jobs, backend, lambda name: show(self.runs, f"trained on {name}"))

    def _begin(self, folder: Path, config: RunConfig, **own: Any) -> None:
        """Write what is compared, and remove what an earlier comparison has drawn."""
        from mpma_mj.utils.data_files import FORMAT, write_json

        content = {"format": FORMAT, "config": config.to_json(), "versions": versions()}
        # Not config.json, which identifies a run.
        numbers = {"runs": self.runs, "epochs": self.epochs}
        write_json(folder / "compare.json", content | numbers | own)
        for name in (*_FIGURES, *_VIDEOS, *_OF_ROBOTS):
            (folder / name).unlink(missing_ok=True)


def _draw_robots(folder: Path, results: Sequence[OnRobot], sound: Path | None) -> None:
    """Write a video and a picture of the first seed on all robots next to each other."""
    from mpma_mj.experiments.compare_robots_report import first_episodes
    from mpma_mj.experiments.compare_video import write_postures, write_side_by_side
    from mpma_mj.utils.progress import show_frames

    episodes = first_episodes(results)
    if episodes:  # otherwise all have diverged, as the table shows
        motion = results[0].motion
        video, picture = (folder / name for name in _OF_ROBOTS)
        write_side_by_side(video, episodes, motion, show_frames, sound)
        write_postures(picture, episodes, motion)


def _write_videos(
    folder: Path, transfers: Sequence[Transfer], motion: Motion, sound: Path | None
) -> None:
    """Write videos of the first seed: all arms next to each other, and heavy over ideal ones."""
    from mpma_mj.experiments.compare_report import first_episodes
    from mpma_mj.experiments.compare_video import overlaid, write_overlaid, write_side_by_side
    from mpma_mj.utils.progress import show_frames

    episodes = first_episodes(transfers)
    side_by_side, video, picture = (folder / name for name in _VIDEOS)
    if episodes:  # otherwise all have diverged, as the table shows
        write_side_by_side(side_by_side, episodes, motion, show_frames, sound)
    if scene := overlaid(episodes, motion, sound):
        write_overlaid(video, picture, scene, show_frames)
