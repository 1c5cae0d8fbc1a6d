"""Make the pictures of the README from a trained run.

python docs/make_pictures.py runs/ymca
"""

from __future__ import annotations

import itertools
import shutil
import sys
from pathlib import Path

import numpy as np
from PIL import Image

from mpma_mj.training.run_folder import RunFolder
from mpma_mj.training.video import dance_frames

PICTURES = Path(__file__).parent / "pictures"


def main(run: Path) -> None:
    """Write a clip of one pass through the movement, and copies of the figures."""
    folder = RunFolder(run)
    trace, motion = folder.read_trace(), folder.read_motion()
    clip = [
        np.asarray(Image.fromarray(frame).resize((480, 432), Image.Resampling.LANCZOS))
        for frame in itertools.islice(dance_frames(trace, motion), 0, len(motion), 2)
    ]
    PICTURES.mkdir(exist_ok=True)
    first, *rest = map(Image.fromarray, clip)
    first.save(
        PICTURES / "ymca.webp",
        save_all=True,
        append_images=rest,
        duration=round(2000 / motion.rate),
        loop=0,
        quality=85,
    )
    for figure in folder.figures.glob("*.png"):
        shutil.copy(figure, PICTURES / figure.name)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
