"""Workers of commands that train many runs."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from mpma_mj.commands.folders import free_folder, hint_if_interrupted
from mpma_mj.commands.run_video import missing_opengl
from mpma_mj.options import BackendName
from mpma_mj.utils.text import shell_word

if TYPE_CHECKING:
    from mpma_mj.experiments.study import Study

__all__ = ["StudyWorkers", "Workers"]


@dataclass(frozen=True, kw_only=True)
class Workers:
    """Workers that train.

    Attributes:
        backend: Processes of this machine, or workers of a Ray cluster.
        workers: Number of parallel workers; as many as there are processors if not given.
        address: HOST:PORT of the head of a Ray cluster, or "auto" for the cluster of this machine;
            a new cluster is started if not given.
    """

    backend: BackendName = "processes"
    workers: int | None = None
    address: str | None = None

    def run(self, study: Study, out: Path | None, stem: str) -> Path:
        """Run what is missing of a study, print its table and return its folder.

        Args:
            study: The study.
            out: The folder; a new one, named by the stem and the time, if not given.
            stem: Beginning of the name of a new folder.
        """
        from mpma_mj.experiments.folder import HEADER
        from mpma_mj.experiments.study import Study as Base
        from mpma_mj.experiments.study import run_study
        from mpma_mj.utils.progress import show_frames

        has_video = type(study).write_video is not Base.write_video
        missing_gl = missing_opengl() if has_video else None
        folder = out or free_folder(stem)
        resume = f"to resume: the same command with --out {shell_word(folder)}"
        with hint_if_interrupted(resume, (folder / HEADER).exists):
            video = show_frames if has_video and missing_gl is None else None
            print(run_study(study, folder, **vars(self), video=video))
        if missing_gl is not None:
            print(missing_gl, file=sys.stderr)
        return folder


StudyWorkers = Annotated[tyro.conf.OmitArgPrefixes[Workers], tyro.conf.arg(name="worker")]
