"""A dance in a window: of a trained run, or of arms that follow a recording ideally."""

from __future__ import annotations

import contextlib
import queue
from collections.abc import Callable
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from mpma_mj.context import active_label
from mpma_mj.envs.physics import PhysicsArms
from mpma_mj.envs.viewer import ArmViewer
from mpma_mj.motions import Motion
from mpma_mj.motions.reading import Reading
from mpma_mj.trace import Trace
from mpma_mj.visualization.player import KEYS, Player

__all__ = ["Dance", "play"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Dance:
    """What is shown at each of T steps.

    Attributes:
        joint_angles: Joint angles of the robot, shape (T, 8), rad.
        reference: Demonstrated postures, shape (T, 12).
        times: Times that are told, shape (T,), s.
        labels: What is danced, T names; "" for nothing.
        rate: Steps per second, Hz.
    """

    joint_angles: Array
    reference: Array
    times: Array
    labels: tuple[str, ...]
    rate: float

    @classmethod
    def of_run(cls, trace: Trace, motion: Motion) -> Dance:
        """Return the epoch that a run has kept.

        Args:
            trace: Signals of the epoch.
            motion: The movement that was imitated.
        """
        return cls(
            joint_angles=trace.joint_angles,
            reference=trace.reference,
            times=np.arange(len(trace.joint_angles)) / motion.rate,
            labels=_names(trace.context, motion),
            rate=motion.rate,
        )

    @classmethod
    def of_reading(cls, reading: Reading) -> Dance:
        """Return the robot in exactly the demonstrated postures, at the recording's times.

        Args:
            reading: What was read.
        """
        motion = reading.motion
        return cls(
            joint_angles=motion.joint_angles,
            reference=motion.posture,
            times=reading.times,
            labels=_names(motion.context, motion),
            rate=motion.rate,
        )


def play(dance: Dance, *, instead: str, on_open: Callable[[], None]) -> None:
    """Show a dance over and over, until the user closes the window.

    Args:
        dance: What is shown, at its own rate.
        instead: What the user is told to do where there can be no window.
        on_open: Called once, when the window is there.

    Raises:
        RenderingError: There is no display, or it does not draw.
    """
    physics = PhysicsArms.make()
    player = Player(len(dance.joint_angles))
    pressed: queue.SimpleQueue[int] = queue.SimpleQueue()  # keys come from the window's thread
    viewer = ArmViewer(physics, 1.0 / dance.rate, instead=instead, on_key=pressed.put)
    with contextlib.closing(viewer):
        on_open()
        while viewer.is_open:
            physics.data.qpos[:] = dance.joint_angles[player.step]
            mujoco.mj_kinematics(physics.model.ptr, physics.data.ptr)
            told = _told(dance, player)
            viewer.show(dance.reference[player.step], above=told, below=KEYS)
            # Before going on: an arrow counts from what was seen when it was pressed.
            while not pressed.empty():
                player.press(pressed.get())
            player.advance()


def _told(dance: Dance, player: Player) -> dict[str, str]:
    return {
        "time": f"{dance.times[player.step]:.2f} s",
        "step": f"{player.step} / {player.steps - 1}" + ", paused" * player.paused,
        "label": dance.labels[player.step],
    }


def _names(context: Array, motion: Motion) -> tuple[str, ...]:
    return tuple("" if i < 0 else motion.labels[i] for i in active_label(context))
