"""Figure of an identification: logged and simulated angles."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from mpma_mj.kinematics import JOINT_NAMES, SIDES
from mpma_mj.sysid.report import SHOWN_WINDOW, Identified
from mpma_mj.visualization.colours import DEMONSTRATED, module_colours
from mpma_mj.visualization.figure_file import figure_file

__all__ = ["write_figure"]

_WINDOWS = 8  # that are drawn (choice)


def write_figure(path: Path, found: Identified) -> None:
    """Draw the first windows' angles, logged and simulated before and after, a joint an axis.

    Args:
        path: The PNG file.
        found: The result.
    """
    before, after = module_colours(2)[::-1]
    looks = (
        (found.logged, "in the log", {"color": DEMONSTRATED, "linewidth": 3.5}),
        (found.before, "simulated before", {"color": before, "linewidth": 1.2}),
        (found.after, "simulated with what was found", {"color": after, "linewidth": 1.2}),
    )
    with figure_file(path, 9.0, 7.6) as figure:
        axes = figure.subplots(
            len(JOINT_NAMES) // len(SIDES), len(SIDES), sharex=True, squeeze=False
        )
        for joint, (axis, name) in enumerate(zip(axes.T.ravel(), JOINT_NAMES, strict=True)):
            for angles, label, look in looks:
                lines = axis.plot(found.times[:_WINDOWS].T, angles[:_WINDOWS, :, joint].T, **look)
                lines[0].set_label(label)
            errors = (np.degrees(found.rms(s)[joint]) for s in (found.before, found.after))
            title = "{} (rms error {:.3g}° → {:.2g}°)".format(name.replace("_", " "), *errors)
            axis.set_title(title, fontsize="small", loc="left")
            axis.margins(x=0)
            axis.spines[["top", "right"]].set_visible(False)
        for axis in axes[:, 0]:
            axis.set_ylabel("angle, rad")
        for axis in axes[-1]:
            axis.set_xlabel("time, s")
        handles, labels = axes[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=3, fontsize="small")
        title = f"Every {SHOWN_WINDOW:g} s the simulated arms begin as in the log"
        figure.suptitle(title, fontsize="medium")
