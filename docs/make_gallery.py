"""Pictures of the gallery: a loop of each dance, trained by the command on its page.

python docs/make_gallery.py [NAME ...]     # all, or the pictures of these names

The page, `docs/gallery.md`, is the list: each picture `pictures/gallery/NAME.webp` is followed by
its command in a block of `sh`.
"""

from __future__ import annotations

import re
import shlex
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from make_pictures import every, write_clip

from mpma_mj.cli import main as mpma
from mpma_mj.training.run_folder import RunFolder
from mpma_mj.visualization.scene import Scene
from mpma_mj.visualization.video import episode_frames

PAGE = Path(__file__).parent / "gallery.md"
PICTURES = PAGE.parent / "pictures" / "gallery"

_ENTRY = re.compile(r"\]\(pictures/gallery/([\w-]+)\.webp\)\s+```sh\n(mpma .*)\n```")
_SIZE = 300, 270  # pixels, of which the lowest tenth is the strip
_LARGEST = 115_000  # bytes; the quality of a loop sinks until it is smaller
_EVERY = 2  # steps a frame: 10 frames a second at 20 Hz


class Entry(NamedTuple):
    """A dance of the gallery: the name of its picture, and the words of its command."""

    name: str
    words: list[str]


def entries(page: str) -> list[Entry]:
    """Return the dances of the page."""
    return [Entry(name, shlex.split(command)[1:]) for name, command in _ENTRY.findall(page)]


def main(names: Sequence[str]) -> None:
    """Make the pictures of these names, all if none is given."""
    found = entries(PAGE.read_text())
    unknown = set(names) - {entry.name for entry in found}
    if unknown:
        sys.exit(f"{PAGE}: no picture {min(unknown)}")
    for entry in found:
        if not names or entry.name in names:
            with tempfile.TemporaryDirectory() as folder:
                run = Path(folder) / "run"
                if mpma([*entry.words, "--no-video", "--out", str(run)]):
                    sys.exit(f"{entry.name}: its command failed")
                write_loop(PICTURES / f"{entry.name}.webp", run)


def write_loop(path: Path, run: Path) -> None:
    """Write the first repetition of a run's dance, as a clip that repeats."""
    folder = RunFolder(run)
    motion = folder.read_motion()
    scene = Scene(folder.read_trace(), motion, folder.read_config().env)
    frames = every(episode_frames(scene), slice(0, len(motion), _EVERY))
    path.parent.mkdir(parents=True, exist_ok=True)
    for quality in (70, 60, 50, 40, 30, 20):
        write_clip(path, frames, _SIZE, quality)
        if path.stat().st_size <= _LARGEST:
            break
    print(f"{path}: {path.stat().st_size / 1000:.0f} kB, quality {quality}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
