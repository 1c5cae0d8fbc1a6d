"""What several tests need: a synthetic dancer on file, real recordings, a trained run."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any

import hypothesis
import numpy as np
import pytest
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from mpma_mj.cli import main
from mpma_mj.envs import gl
from mpma_mj.errors import RenderingError
from mpma_mj.kinematics import SIDES
from mpma_mj.motions import ymca
from mpma_mj.motions.import_report import ImportReport

hypothesis.settings.register_profile("steady", deadline=None, max_examples=40)
hypothesis.settings.load_profile("steady")

# The matrices are small: more threads wait for each other, the more so in parallel tests.
threadpool_limits(1, user_api="blas")

Array = NDArray[np.float64]
WriteTsv = Callable[..., Path]
Refused = Callable[..., None]
Encoder = Callable[[str], None]

DISK_FULL = """
cat > /dev/null; echo half > "$video"; echo "[mp4 @ 0x1] No space left on device" >&2; exit 228
"""
FAILED = (
    "the video was not written: ffmpeg failed: exit code 228 (No space left on device); fix that"
)

QUALISYS_NAMES = {
    f"{side}_{point}": tuple(f"{name}_{side[0].upper()}" for name in names)
    for side in SIDES
    for point, names in {
        "shoulder": ("Shoulder",),
        "elbow": ("Elbow",),
        "wrist": ("Radius", "Ulna"),
    }.items()
}


NO_TRUNK = "has no points of the trunk, so that the torso is assumed to be upright"


def pytest_configure() -> None:
    """Handle signals as at a terminal, also in the background, which ignores them."""
    usual = {signal.SIGINT: signal.default_int_handler, signal.SIGHUP: signal.SIG_DFL}
    for number, handler in usual.items():
        if signal.getsignal(number) == signal.SIG_IGN:
            signal.signal(number, handler)


def dancer(posture: Array) -> dict[str, Array]:
    """Return points, mm, of a dancer who stands, faces +x, and has arms in these postures."""
    lengths = np.array([300.0, 250.0])[:, None]
    points = {}
    for i, side in enumerate(SIDES):
        segments = posture.reshape(-1, 2, 2, 3)[:, i] * lengths
        shoulder = np.tile([0.0, 180.0 - 360.0 * i, 1400.0], (len(posture), 1))
        points[f"{side}_shoulder"] = shoulder
        points[f"{side}_elbow"] = shoulder + segments[:, 0]
        points[f"{side}_wrist"] = points[f"{side}_elbow"] + segments[:, 1]
    return points


def markers_of(points: dict[str, Array]) -> dict[str, Array]:
    """Return Qualisys-named markers whose means are the points."""
    markers = {}
    for point, names in QUALISYS_NAMES.items():
        spread = np.linspace(-20.0, 20.0, len(names)) if len(names) > 1 else [0.0]
        for name, offset in zip(names, spread, strict=True):
            markers[name] = points[point] + [0.0, 0.0, offset]
    return markers


def with_trunk(markers: dict[str, Array]) -> dict[str, Array]:
    """Return markers of arms, and those of an upright trunk."""
    frames = len(next(iter(markers.values())))
    trunk = {"Hips": [0.0, 0.0, 900.0], "Neck": [0.0, 0.0, 1400.0]}
    return markers | {name: np.tile(place, (frames, 1)) for name, place in trunk.items()}


def doubts(report: ImportReport) -> list[str]:
    """Return the warnings of a report but that of points of the arms alone."""
    return [warning for warning in report.warnings if warning != NO_TRUNK]


@pytest.fixture
def write_tsv(tmp_path: Path) -> WriteTsv:
    """Return a function that writes markers as a Qualisys export."""

    def write(
        markers: dict[str, Array] | None = None,
        *,
        rate: str = "60",
        name: str = "dance.tsv",
        edit: Callable[[str], str] = lambda text: text,
    ) -> Path:
        if markers is None:
            markers = markers_of(dancer(ymca(rate=60.0).posture))
        table = np.concatenate(list(markers.values()), axis=1)
        rows = ["\t".join("" if np.isnan(v) else f"{v:.6f}" for v in row) for row in table]
        header = [
            f"NO_OF_FRAMES\t{len(table)}",
            f"NO_OF_MARKERS\t{len(markers)}",
            f"FREQUENCY\t{rate}",
            "MARKER_NAMES\t" + "\t".join(markers),
        ]
        path = tmp_path / name
        path.write_text(edit("\n".join(header + rows) + "\n"))
        return path

    return write


@pytest.fixture(scope="session")
def mocap() -> Path:
    """Return the folder of real recordings; skip where MPMA_MOCAP does not name one."""
    folder = os.environ.get("MPMA_MOCAP")
    if folder is None:
        pytest.skip("MPMA_MOCAP does not name a folder of real recordings")
    assert Path(folder).is_dir(), f"MPMA_MOCAP={folder} is no folder"
    return Path(folder)


@pytest.fixture(scope="session")
def opengl() -> None:
    """Skip where OpenGL does not draw."""
    try:
        gl.require_backend()
    except RenderingError as error:
        pytest.skip(str(error))


@pytest.fixture
def encoder(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> Encoder:
    """Return a function that puts a shell script, whose video is "$video", in place of ffmpeg."""

    def replace(script: str) -> None:
        program = tmp_path_factory.mktemp("encoder") / "ffmpeg"
        program.write_text(f"#!/bin/sh\nfor video; do :; done\n{script}\n")
        program.chmod(0o755)
        monkeypatch.setenv("IMAGEIO_FFMPEG_EXE", str(program))

    return replace


@pytest.fixture(scope="session")
def small_run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a finished run of small networks, made by the command line."""
    folder = tmp_path_factory.mktemp("runs") / "small"
    words = f"imitate ymca --nodes 30 --modules 3 --no-video --out {folder}"
    assert main(words.split()) == 0
    return folder


@pytest.fixture
def refused(capsys: pytest.CaptureFixture[str]) -> Refused:
    """Return a function that runs a command and checks that it is refused in one line."""

    def check(words: list[str], message: str, code: int = 2, title: str = "") -> None:
        capsys.readouterr()
        assert main(words) == code
        printed: Any = capsys.readouterr()
        assert printed.out == ""
        # But for progress: lines that are indented, and perhaps a title.
        told = [line for line in printed.err.splitlines() if not line.startswith("  ")]
        (line,) = [line for line in told if not title or line != title]
        assert line.startswith("mpma: ")
        assert message in line

    return check
